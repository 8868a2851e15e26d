"""What the page is told of a robot: Telex, its variants, the robots of docs/examples."""

from __future__ import annotations

import functools
import re
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from telex_teleop.actions.abilities import Abilities, MovedJoint, abilities_of
from telex_teleop.actions.drawing import drawing_of
from telex_teleop.actions.fitting import fit
from telex_teleop.actions.vocabulary import Vocabulary

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[4]
CONFIG = ROOT / "src/telex_teleop/config"
DESCRIPTION = ROOT / "src/telex_description"
EXAMPLES = ROOT / "docs/examples"
CONSOLE = ROOT / "src/telex_teleop/console"
BASE, GRIPPER, TRACKS = "base_link", "gripper", "track_teleop"


def load(path):
    return yaml.safe_load(path.read_text())


@functools.lru_cache(maxsize=None)
def telex(variant="standard"):
    """Parameters of a variant, as the launch files set them."""
    script = str(DESCRIPTION / "scripts" / "robot_description")
    made = subprocess.run(
        [sys.executable, script, variant], capture_output=True, text=True, check=True
    )
    parameters = {
        "robot_description": made.stdout,
        "cameras/cameras": load(DESCRIPTION / "config/cameras.yaml")["cameras"],
        "cameras/lamps": load(DESCRIPTION / "config/lamps.yaml")["lamps"],
        "simulator/model": "telex",
        "simulator/proximity/joints": ["turret_joint"],
        "simulator/tracks/belts": {"front_left_track_joint": 0.11},
        "gripper_controller/geometry": {"base": 0.045},
    }
    for node in ("arm", "gripper", "flipper", "track"):
        parameters[f"{node}_teleop"] = load(CONFIG / f"{node}_teleop.yaml")
    parameters["arm_teleop"].update(load(DESCRIPTION / "config/poses.yaml"))
    parameters["flipper_teleop"].update(load(CONFIG / "flipper_presets.yaml"))
    return parameters


def example(name, **files):
    """Parameters of a robot of docs/examples, as own_robot.launch sets them."""
    folder = EXAMPLES / name
    simulation = load(folder / "simulation.yaml") if "simulation" in files else {}
    joints = simulation.get("proximity", {}).get("joints")
    return {
        "robot_description": (folder / f"{name}.urdf").read_text(),
        "cameras/cameras": load(folder / "cameras.yaml")["cameras"],
        "simulator/model": name,
        **({} if joints is None else {"simulator/proximity/joints": joints}),
        **{
            node: load(folder / f"{file}.yaml")
            for file, node in files.items()
            if file != "simulation"
        },
    }


ROVER = example("rover", base=TRACKS)
BENCH_ARM = example("bench_arm", arm="arm_teleop", gripper="gripper_teleop", simulation="")


def robot_of(parameters):
    problems = []
    robot = abilities_of(parameters.get, "", problems.append)
    assert problems == []
    return robot


def told(parameters):
    """What /actions.json has, with the actions by their names."""
    answer = fit(Vocabulary.read(), robot_of(parameters))
    return {**answer, "actions": {each["name"]: each for each in answer["actions"]}}


def titles(answer):
    return [each["title"] for each in answer["actions"].values()]


def modes(answer):
    return [each["name"] for each in answer["modes"]]


def views(answer):
    return {each["name"]: (each["first"][:1], each["second"][:1]) for each in answer["layouts"]}


def aids(answer):
    return {each["name"]: list(each["aids"]) for each in answer["layouts"]}


def moved(name, kind="revolute", axis=(0.0, 0.0, 1.0), place=(0.0, 0.0, 0.0)):
    return MovedJoint(name, kind, axis, place)


class TestTelex:
    def test_has_all_that_the_file_has(self):
        answer, whole = fit(Vocabulary.read(), robot_of(telex())), Vocabulary.read().as_json()
        assert answer["actions"] == whole["actions"]
        assert answer["modes"] == whole["modes"]
        assert answer["lengths"] == whole["lengths"]
        assert aids(answer) == aids(whole)
        assert aids(answer)["DRIVE"] == ["guide lines"]

    def test_layouts_have_cameras_by_their_roles(self):
        assert views(told(telex())) == {
            "DRIVE": (("front",), ("mast",)),
            "ARM": (("turret",), ("gripper",)),
            "LOOK": (("turret",), ("front",)),
        }

    def test_the_page_knows_its_gripper_and_its_sides(self):
        facts = robot_of(telex()).as_json()
        assert facts["gripper"]["name"] == "gripper"
        assert facts["gripper"]["geometry"] == {"base": 0.045}
        assert facts["odometry"] == "track_controller/odom"
        assert set(facts["sides"]["left"]) == {
            *("front_left_flipper_joint", "rear_left_flipper_joint"),
            *(f"left_finger_{part}_joint" for part in ("base", "middle", "tip")),
        }
        assert len(facts["sides"]["right"]) == 5

    def test_the_page_knows_what_it_stands_on_and_its_tool(self):
        controllers = load(ROOT / "src/telex_control/config/telex_controllers.yaml")
        parameters = {**telex(), "track_controller": controllers["track_controller"]}
        axles = [f"{e}_{s}_track_joint" for s in ("left", "right") for e in ("front", "rear")]
        assert drawing_of(parameters.get, "", pytest.fail) == {
            "tracks": {"axles": axles, "radius": 0.11, "half_width": 0.2},
            "tool": "tool_link",
        }

    def test_a_variant_without_telescope_has_no_keys_for_it(self):
        answer = told(telex("six_axis"))
        lacking = set(told(telex())["actions"]) - set(answer["actions"])
        assert {name for name in lacking if not name.startswith("lamps:")} == {
            "telescope:in",
            "telescope:out",
        }

    def test_a_probe_cannot_grasp(self):
        answer = told(telex("inspection"))
        lacking = set(told(telex())["actions"]) - set(answer["actions"])
        assert {"gripper:close", "gripper:open"} <= lacking
        assert not [name for name in answer["actions"] if name.startswith("gripper:")]
        assert robot_of(telex("inspection")).as_json()["gripper"] is None
        assert modes(answer) == ["DRIVE", "JOINT", "CARTESIAN", "CAMERA"]

    def test_a_carrier_looks_at_itself_and_turns_a_lamp(self):
        answer = told(telex("carrier"))
        assert views(answer) == {
            "DRIVE": (("front",), ("mast",)),
            "ARM": (("mast",), ()),
            "LOOK": (("mast",), ("front",)),
        }
        assert aids(answer)["LOOK"] == []
        assert not [title for title in titles(answer) if "zoom" in title or "gripper clos" in title]


class TestRover:
    def test_drives_and_does_nothing_else(self):
        answer = told(ROVER)
        assert modes(answer) == ["DRIVE"]
        kinds = {each["does"]["kind"] for each in answer["actions"].values()}
        assert kinds == {"drive", "command"}
        commands = {each["does"].get("name") for each in answer["actions"].values()}
        assert not commands & {"mode", "drive mode", "camera mode", "frame", "hold tool"}
        assert {"e-stop", "stop", "slower", "faster", "help", "guide lines"} <= commands
        assert not commands & {"aim line", "finger gap", "contact marks", "zoom factor", "horizon"}

    def test_sees_ahead_and_back(self):
        assert views(told(ROVER)) == {"DRIVE": (("bow",), ("stern",))}

    def test_tells_where_its_wheels_are_measured(self):
        facts = robot_of(ROVER).as_json()
        assert facts["odometry"] == "wheel_controller/odom"
        assert facts["moves"] == {"arm": [], "gripper": [], "flipper": []}
        assert drawing_of(ROVER.get, "", pytest.fail) == {}

    def test_the_description_tells_of_its_wheels_what_their_controller_does_not(self):
        left, right = (
            [f"{end}_{side}_wheel_joint" for end in ("front", "rear")] for side in ("left", "right")
        )
        controller = {"left_wheel": left, "right_wheel": right}
        joints = [*left, *right]

        def tracks(controller, warn=pytest.fail):
            found = drawing_of({**ROVER, "wheel_controller": controller}.get, "", warn)
            return found.get("tracks")

        wheels = {"axles": joints, "radius": 0.16, "half_width": 0.29}
        assert tracks(controller) == wheels
        told = {**controller, "wheel_radius": 0.15, "wheel_separation": 0.5}
        assert tracks(told) == {"axles": joints, "radius": 0.15, "half_width": 0.25}
        assert tracks({**told, "wheel_radius": float("nan")})["radius"] == 0.16
        for wrong in ("wheels", {"left_wheel": [], "right_wheel": right}):
            assert tracks(wrong) is None
        problems = []
        assert tracks({**controller, "left_wheel": "none_joint"}, problems.append) is None
        assert problems == ["no guide lines: robot_description has no wheel joint 'none_joint'"]


class TestArmOnAFixedBase:
    def test_its_joints_have_the_keys_of_the_arm(self):
        actions = told(BENCH_ARM)["actions"].values()
        jogs = [each for each in actions if each["does"].get("node") == "arm"]
        assert [(each["title"], each["cap"], each["does"]["sign"]) for each in jogs] == [
            ("waist left", "J", 1),
            ("waist right", "L", -1),
            ("upper up", "I", -1),
            ("upper down", "K", 1),
            ("lower up", "U", -1),
            ("lower down", "O", 1),
            ("wrist turn left", "P", 1),
            ("wrist turn right", ";", -1),
            ("wrist bend up", "N", -1),
            ("wrist bend down", "M", 1),
            ("hand turn left", "[", 1),
            ("hand turn right", "'", -1),
        ]

    def test_its_poses_and_its_hand_have_keys(self):
        answer = told(BENCH_ARM)
        poses = [each for each in answer["actions"].values() if each["does"]["kind"] == "pose"]
        assert [(each["label"], each["cap"]) for each in poses] == [("rest", "Z"), ("reach", "X")]
        close = answer["actions"]["gripper:close"]
        assert close["does"]["joints"] == ("hand",)
        assert {"near_jaw_joint", "hand"} <= set(answer["lengths"])

    def test_nothing_drives(self):
        answer = told(BENCH_ARM)
        assert modes(answer) == ["JOINT", "CARTESIAN"]
        assert views(answer) == {"ARM": (("post",), ("hand",))}
        assert not {"drive", "side", "preset", "zoom", "lamps"} & {
            each["does"]["kind"] for each in answer["actions"].values()
        }
        commands = {each["does"].get("name") for each in answer["actions"].values()}
        assert not commands & {"drive mode", "camera mode", "hold tool", "guide lines", "plan"}
        assert {"mode", "frame", "proximity guard"} <= commands
        assert robot_of(BENCH_ARM).as_json()["odometry"] is None

    def test_without_a_report_of_what_is_near_there_is_no_guard(self):
        unguarded = {**BENCH_ARM, "simulator/proximity/joints": None}
        assert "guard" not in told(unguarded)["actions"]


LIFT = '<limit lower="0" upper="0.5" effort="900" velocity="0.1"/>'
COLUMNS = {
    "mimic": f'{LIFT}<mimic joint="lift_joint"/>',
    "no limits": '<limit effort="900" velocity="0.1"/>',
}


class TestArmOnAColumn:
    """Which another joint lifts, too, or of which nobody says how far it goes."""

    @pytest.fixture(params=COLUMNS.values(), ids=COLUMNS)
    def parameters(self, request):
        column = "".join(
            f'''<link name="{parent}"/><joint name="{name}_joint" type="prismatic">
            <parent link="{parent}"/><child link="{child}"/>
            <origin xyz="0.1 0 0.3" rpy="0 0 {yaw}"/><axis xyz="0 0 1"/>{limits}</joint>'''
            for parent, child, name, yaw, limits in (
                ("foot", "stage", "lift", 1.5707963267948966, LIFT),
                ("stage", "pedestal", "column", 0.0, request.param),
            )
        )
        urdf = BENCH_ARM["robot_description"].replace("</robot>", f"{column}</robot>")
        return {**BENCH_ARM, "robot_description": urdf}

    def test_its_joints_are_known_where_they_are(self, parameters):
        robot, plain = robot_of(parameters), robot_of(BENCH_ARM)
        assert [each.name for each in robot.arm] == [each.name for each in plain.arm]
        assert [each.name for each in robot.fingers] == ["near_jaw_joint", "far_jaw_joint"]
        for ours, theirs in zip((*robot.arm, *robot.fingers), (*plain.arm, *plain.fingers)):
            (x, y, z), (ahead, left, up) = theirs.place, theirs.axis
            assert ours.place == pytest.approx((0.1 - y, 0.1 + x, z + 0.6))
            assert ours.axis == pytest.approx((-left, ahead, up))

    def test_the_page_has_what_the_arm_can_do_and_no_more(self, parameters):
        answer = told(parameters)
        assert modes(answer) == ["JOINT", "CARTESIAN"]
        assert {"waist left", "hand turn right"} <= set(titles(answer))
        jogs = [each["does"] for each in answer["actions"].values()]
        moves = {each["joints"] for each in jogs if each.get("node") == "arm"}
        assert moves == {(each.name,) for each in robot_of(BENCH_ARM).arm}
        assert robot_of(parameters).as_json()["moves"]["flipper"] == []
        kinds = {each["does"]["kind"] for each in answer["actions"].values()}
        assert not kinds & {"drive", "side", "preset", "lamps"}


class TestOtherRobots:
    """Robots that are not shipped."""

    def fitted(self, **abilities):
        answer = fit(Vocabulary.read(), Abilities(**abilities))
        return {each["name"]: each for each in answer["actions"]}

    def test_more_joints_than_keys_have_buttons_all_the_same(self):
        arm = tuple(moved(f"axis_{number}") for number in range(9))
        actions = self.fitted(arm=arm)
        jogs = [each for each in actions.values() if each["does"]["kind"] == "jog"]
        assert len(jogs) == 18
        assert [each["code"] for each in jogs[-4:]] == [None] * 4
        assert all(each["button"] for each in jogs)
        assert all(each["modes"] == ["JOINT"] for each in jogs)

    def test_a_file_of_its_own_says_itself_what_there_is(self):
        robot = Abilities(arm=(moved("turret_joint"), moved("seventh_joint")))
        answer = fit(Vocabulary.read(), robot, adds=False)
        jogs = [each["name"] for each in answer["actions"] if each["does"]["kind"] == "jog"]
        assert jogs == ["turret:left", "turret:right"]

    @pytest.mark.parametrize(
        ("joint", "words"),
        [
            (moved("a", axis=(0.0, 0.0, 1.0)), [("left", 1), ("right", -1)]),
            (moved("a", axis=(0.0, 0.1, -0.9)), [("left", -1), ("right", 1)]),
            (moved("a", axis=(0.0, 1.0, 0.0)), [("up", -1), ("down", 1)]),
            (moved("a", axis=(0.0, -1.0, 0.0)), [("up", 1), ("down", -1)]),
            (moved("a", axis=(1.0, 0.0, 0.0)), [("left", -1), ("right", 1)]),
            (moved("a", "prismatic", (0.0, 0.0, -1.0)), [("in", -1), ("out", 1)]),
        ],
    )
    def test_words_follow_the_axis(self, joint, words):
        jogs = [
            each for each in self.fitted(arm=(joint,)).values() if each["does"]["kind"] == "jog"
        ]
        assert [(each["label"], each["does"]["sign"]) for each in jogs] == words

    def test_a_head_gets_the_keys_that_look_about_whichever_joint_comes_first(self):
        tilt = moved("nod_joint", axis=(0.0, -1.0, 0.0))
        pan = moved("neck_joint", axis=(0.0, 0.0, 1.0))
        actions = self.fitted(head=(tilt, pan), odometry="base/odom")
        assert actions["look:left"]["does"] == {
            "kind": "jog",
            "node": "arm",
            "joints": ("neck_joint",),
            "sign": 1,
        }
        assert actions["camera_tilt:up"]["does"]["joints"] == ("nod_joint",)
        assert actions["camera_tilt:up"]["does"]["sign"] == 1

    def test_flippers_of_other_names_are_moved_by_their_ends(self):
        flippers = [
            moved(f"{end}{side}", axis=(0.0, 1.0, 0.0), place=(x, y, 0.0))
            for end, x in (("f", 0.3), ("r", -0.3))
            for side, y in (("l", 0.2), ("r", -0.2))
        ]
        actions = self.fitted(flippers=tuple(flippers), presets=("low", "tall"))
        assert actions["front:up"]["does"]["joints"] == ("fl", "fr")
        assert actions["rear:down"]["does"]["joints"] == ("rl", "rr")
        assert {"side:left", "side:right"} <= set(actions)
        presets = [each for each in actions.values() if each["does"]["kind"] == "preset"]
        assert [(each["does"]["name"], each["cap"]) for each in presets] == [
            ("low", "1"),
            ("tall", "2"),
        ]

    def test_a_key_switches_those_of_its_lamps_that_there_are(self):
        actions = self.fitted(lamps=("front_left", "beacon", "siren", "blue", "work", "spare"))
        assert actions["lamps:front"]["does"]["names"] == ("front_left",)
        lamps = [each for each in actions.values() if each["does"]["kind"] == "lamps"]
        assert [each["does"]["names"][0] for each in lamps] == [
            *("front_left", "beacon", "siren", "blue", "work", "spare")[:4],
            *("work", "spare"),
        ]

    def test_a_robot_that_only_sees_has_the_e_stop(self):
        answer = fit(Vocabulary.read(), Abilities(cameras={"eye": ""}))
        assert [each["name"] for each in answer["layouts"]] == ["LOOK"]
        names = {each["name"] for each in answer["actions"]}
        assert {"estop", "stop", "keys"} <= names
        assert not {"mode", "camera_mode", "slower", "faster", "aids"} & names

    def test_no_key_has_two_meanings(self):
        for parameters in (telex("carrier"), ROVER, BENCH_ARM):
            answer = told(parameters)
            for mode in modes(answer):
                keys = [
                    code
                    for each in answer["actions"].values()
                    if mode in each["modes"]
                    for code in (each["code"], *each["more_codes"])
                    if code is not None
                ]
                assert len(keys) == len(set(keys))


class TestWhatIsWrong:
    def test_of_a_robot_without_nodes_nothing_is_known(self):
        assert abilities_of({"robot_description": "<robot/>"}.get, "", pytest.fail) is None

    def test_a_node_that_cannot_start_moves_nothing_and_is_named(self):
        problems = []
        wrong = {**BENCH_ARM, "arm_teleop": {"joints": ["waist_joint", "lost_joint"]}}
        robot = abilities_of(wrong.get, "", problems.append)
        assert robot.arm == ()
        assert len(problems) == 1
        assert "arm_teleop" in problems[0]
        assert "lost_joint" in problems[0]

    def test_a_description_that_is_none_is_named(self):
        problems = []
        assert (
            abilities_of({**ROVER, "robot_description": "<robot"}.get, "", problems.append) is None
        )
        assert problems[0].startswith("robot_description: ")


def test_no_javascript_names_a_joint_a_link_a_lamp_or_a_camera_of_telex():
    urdf = telex()["robot_description"]
    names = set(re.findall(r'<(?:joint|link) name="([^"]+)"', urdf))
    names |= set(telex()["cameras/lamps"]) - {"gripper"}  # the node, too
    # Words of directions and of nodes, which cameras are called after.
    cameras = set(telex()["cameras/cameras"]) - {"front", "rear", "arm", "gripper"}
    topics = {f"cameras/{name}" for name in telex()["cameras/cameras"]}
    pattern = re.compile(rf"\b(?:{'|'.join(sorted(names | cameras | topics))})\b")
    found = [
        f"{path.relative_to(CONSOLE)}: {match.group()}"
        for path in sorted(CONSOLE.rglob("*.js"))
        if path.parent.name != "language"  # which has words for what a robot may call its parts
        for match in pattern.finditer(path.read_text())
    ]
    assert len(names) > 50
    assert found == []
