"""What the arm is near to: which pairs are told, how far apart they are, and what changes that."""

from __future__ import annotations

import itertools
import math
import random

import pybullet
import pytest
from std_msgs.msg import Float64

from telex_control.common.params import ConfigError, read_config
from telex_control.urdf.joints import joints, parse_urdf
from telex_sim.engine.world import World
from telex_sim.offline.simulation import shipped_config
from telex_sim.proximity.monitor import ProximityMonitor
from telex_sim.proximity.proximity_config import ProximityConfig
from telex_sim.robot.self_collision import SelfCollisionConfig

pytestmark = pytest.mark.slow

ARM = """
<robot name="arm">
  <link name="post">
    <inertial><mass value="1"/>{inertia}</inertial>
    <collision><origin xyz="-0.3 0 0"/><geometry><box size="0.2 0.2 0.2"/></geometry></collision>
  </link>
  <link name="boom"><inertial><mass value="1"/>{inertia}</inertial></link>
  <link name="tip"><inertial><mass value="1"/>{inertia}</inertial>
    <collision><geometry><sphere radius="0.05"/></geometry></collision></link>
  <joint name="swing" type="revolute"><parent link="post"/><child link="boom"/><axis xyz="0 -1 0"/>
    <limit lower="-4" upper="4" velocity="1" effort="10"/></joint>
  <joint name="slide" type="prismatic"><parent link="boom"/><child link="tip"/><axis xyz="1 0 0"/>
    <origin xyz="0.4 0 0"/><limit lower="0" upper="0.5" velocity="1" effort="10"/></joint>
</robot>
""".replace("{inertia}", '<inertia ixx="3" iyy="2" izz="3" ixy="0.5" ixz="0.2" iyz="-0.4"/>')
HEIGHT = 0.8


@pytest.fixture
def bench():
    """A boom that swings up and slides out, fixed over the floor, and a guard that looks far."""
    world = World(0.002, 50)
    client = world.client
    ground = pybullet.createMultiBody(
        0.0,
        pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=client),
        physicsClientId=client,
    )
    body = world.load_robot(ARM, lambda name: name, (0.0, 0.0, HEIGHT), 0.3, {}, fixed_base=True)
    names = {ground: "floor"}

    class Bench:
        def __init__(self):
            self.client = client
            self.body = body
            self.guard = self.make()

        def make(self, **changes):
            params = {"joints": ["swing", "slide"], "near": 1.0, "range": 2.0, **changes}
            config = read_config(ProximityConfig, params, "proximity")
            return ProximityMonitor(body, config, SelfCollisionConfig())

        def put(self, name, size, position, orientation=(0.0, 0.0, 0.0, 1.0)):
            shape = pybullet.createCollisionShape(
                pybullet.GEOM_BOX, halfExtents=[edge / 2 for edge in size], physicsClientId=client
            )
            uid = pybullet.createMultiBody(
                0.0, shape, -1, position, orientation, physicsClientId=client
            )
            names[uid] = name

        def pose(self, swing, slide, speeds=(0.0, 0.0)):
            for joint, value, speed in zip(("swing", "slide"), (swing, slide), speeds):
                pybullet.resetJointState(
                    body.uid, body.joints[joint], value, speed, physicsClientId=client
                )
            pybullet.performCollisionDetection(physicsClientId=client)

        def nearest(self, other):
            found = self.guard.measure(names.__getitem__)
            return next((pair for pair in found.pairs if pair.other == other), None)

    yield Bench()
    world.close()


# ---- distances and what changes them, against what geometry says


def test_the_floor_is_as_far_as_geometry_says_and_its_gradient_is_the_lever(bench):
    swing, slide = -0.6, 0.2
    bench.pose(swing, slide, speeds=(-0.5, 0.1))
    pair = bench.nearest("floor")
    reach = 0.4 + slide
    assert pair.link == "tip"
    assert pair.place.distance == pytest.approx(HEIGHT + reach * math.sin(swing) - 0.05, abs=1e-6)
    expected = (reach * math.cos(swing), math.sin(swing))
    assert pair.place.gradient == pytest.approx(expected, abs=1e-6)
    assert pair.closing_speed == pytest.approx(0.5 * expected[0] - 0.1 * expected[1], abs=1e-6)
    # In the frame of the root link, which is turned by the heading.
    assert pair.place.normal == pytest.approx((0.0, 0.0, 1.0), abs=1e-6)
    place = (reach * math.cos(swing), 0.0, reach * math.sin(swing) - 0.05)
    assert pair.place.point == pytest.approx(place, abs=1e-5)


def test_a_box_beside_the_way_is_met_at_the_nearest_point(bench):
    # A wall across the boom's axis, which the slide approaches and the swing leaves as it is.
    yaw = pybullet.getQuaternionFromEuler((0.0, 0.0, 0.3))
    bench.put("wall", (0.1, 2.0, 2.0), (math.cos(0.3), math.sin(0.3), HEIGHT), yaw)
    bench.pose(0.0, 0.3)
    pair = bench.nearest("wall")
    assert pair.place.distance == pytest.approx(1.0 - 0.05 - 0.7 - 0.05, abs=1e-5)
    assert pair.place.gradient == pytest.approx((0.0, -1.0), abs=1e-4)
    assert pair.place.normal == pytest.approx((-1.0, 0.0, 0.0), abs=1e-4)


def test_inside_of_something_the_way_out_is_still_told(bench):
    bench.put("table", (4.0, 4.0, 0.1), (0.0, 0.0, HEIGHT - 0.1))
    bench.pose(0.0, 0.0)
    bench.pose(-0.025, 0.0)
    pair = bench.nearest("table")
    depth = 0.4 * math.sin(0.025)
    assert pair.place.distance == pytest.approx(-depth, abs=1e-4)
    assert pair.place.gradient[0] == pytest.approx(0.4, abs=1e-3)


def test_the_own_base_counts_and_the_slide_cannot_change_what_it_is_square_to(bench):
    bench.pose(math.pi / 2, 0.0)
    pair = bench.nearest("post")
    corner = math.hypot(0.2, 0.3)
    assert pair.link == "tip"
    # Bullet rounds edges a little.
    assert pair.place.distance == pytest.approx(corner - 0.05, abs=1e-3)
    assert pair.place.gradient == pytest.approx((-0.4 * 0.2 / corner, 0.3 / corner), abs=1e-3)


def test_what_rests_tells_only_what_is_near_and_what_moves_looks_ahead(bench):
    bench.guard = bench.make(near=0.05, horizon=0.4, range=0.6)
    bench.pose(-0.6, 0.2)
    assert bench.nearest("floor") is None
    bench.pose(-0.6, 0.2, speeds=(-2.0, 0.0))
    assert bench.nearest("floor").place.distance == pytest.approx(0.411, abs=1e-3)
    bench.pose(0.6, 0.2, speeds=(-20.0, 0.0))
    assert bench.nearest("floor") is None, "beyond the range"


def test_own_distances_follow_every_motion_although_they_are_not_always_taken_anew(bench):
    bench.guard = bench.make(near=0.15, horizon=0.0)
    worst = 0.0
    seen = 0
    for step in range(400):
        swing = 1.0 + 2.0 * math.sin(0.021 * step)
        slide = 0.1 + 0.1 * math.cos(0.037 * step)
        bench.pose(swing, slide)
        true = pybullet.getClosestPoints(
            bench.body.uid, bench.body.uid, 0.15, 1, -1, physicsClientId=bench.client
        )
        pair = bench.nearest("post")
        assert bool(true) == (pair is not None) or abs(true[0][8] - 0.15) < 0.003
        if true and pair:
            seen += 1
            error = abs(pair.place.distance - true[0][8])
            worst = max(worst, error / max(true[0][8], 0.01))
    assert seen > 40
    assert worst < 0.03


# ---- configuration


@pytest.mark.parametrize(
    ("params", "named"),
    [
        ({"rate": -1.0}, "rate is -1"),
        ({"near": 0.0}, "near is 0"),
        ({"horizon": -0.1}, "horizon is -0.1"),
        ({"near": 0.3, "range": 0.2}, "range is 0.2; it must be at least 0.3"),
        ({"range": math.nan}, "range is nan"),
        ({"most_pairs": 0}, "most_pairs is 0"),
        ({"joints": ["a", "b", "a"]}, "joint 'a' is named twice"),
        ({"joints": ["a"], "fingers": [["b"], ["a"]]}, "joint 'a' is named twice"),
        ({"stop": 1.0}, "stop is unknown"),
    ],
)
def test_wrong_figures_are_refused_by_name(params, named):
    with pytest.raises(ConfigError, match=named):
        read_config(ProximityConfig, params, "proximity")


def test_joints_that_no_variant_has_are_refused():
    config = ProximityConfig(joints=("a", "telescope"), fingers=(("f",), ("g",)))
    config.check_joints(["a", "f", "g"], ["telescope"])
    with pytest.raises(ConfigError, match="proximity/joints: the robot has no movable joint 'a'"):
        config.check_joints(["f", "g"], ["telescope"])
    with pytest.raises(ConfigError, match=r"proximity/fingers\[1\].*'g'"):
        config.check_joints(["a", "f"], ["telescope"])


def test_joints_in_the_wrong_order_are_refused(bench):
    with pytest.raises(ConfigError, match="'tip' does not carry 'boom'"):
        bench.make(joints=["slide", "swing"])


def test_a_robot_without_an_arm_is_near_to_nothing(bench):
    assert bench.make(joints=[]).measure(str) == ((), ())


# ---- the shipped robot


@pytest.fixture(scope="module")
def described(urdf):
    return joints(parse_urdf(urdf))


class Arm:
    """The shipped robot, put into postures without motion."""

    def __init__(self, offline):
        self.offline = offline
        self.simulation = offline.simulation
        self.robot = self.simulation.robots[0]
        self.body = self.robot.body

    def pose(self, positions):
        for joint, value in positions.items():
            pybullet.resetJointState(
                self.body.uid, self.body.joints[joint], value, physicsClientId=self.body.client
            )
        pybullet.performCollisionDetection(physicsClientId=self.body.client)

    def measure(self):
        return self.simulation.proximity(self.robot)


def key(pair):
    return pair.link, pair.other


def nearest(near):
    found = {}
    for pair in near.pairs:
        found.setdefault(key(pair), pair.place.distance)
    return found


def test_gradients_of_the_shipped_robot_are_those_of_its_distances(robot, described):
    arm = Arm(robot(proximity__near=0.15, proximity__most_pairs=500))
    config = arm.robot.config
    names = arm.robot.proximity.joints
    assert len(names) == 7

    def look(pose):
        arm.pose(pose)
        # A guard of its own: distances that are really taken anew.
        return ProximityMonitor(arm.body, config.proximity, config.self_collision).measure(str)

    rng = random.Random(6)
    compared, step = 0, 2e-4
    while compared < 150:
        pose = {name: rng.uniform(described[name].lower, described[name].upper) for name in names}
        here = look(pose)
        for joint in rng.sample(range(len(names)), 2):
            name = names[joint]
            ahead = nearest(look({**pose, name: pose[name] + step}))
            behind = nearest(look({**pose, name: pose[name] - step}))
            for pair, distance in nearest(here).items():
                if pair not in ahead or pair not in behind or distance < -0.01:
                    continue
                slopes = [(ahead[pair] - distance) / step, (distance - behind[pair]) / step]
                # Where another edge becomes the nearest, the distance has a kink.
                if abs(slopes[0] - slopes[1]) > 0.005:
                    continue
                told = next(each for each in here.pairs if key(each) == pair).place.gradient
                assert told[joint] == pytest.approx(sum(slopes) / 2, abs=0.01), pair
                compared += 1


def test_cached_distances_are_those_of_a_fresh_look(robot, described):
    arm = Arm(robot(proximity__near=0.08, proximity__most_pairs=200, start__pose="stow"))
    names = arm.robot.proximity.joints
    rng = random.Random(3)
    pose = {name: arm.offline.positions()[name] for name in names}
    flippers = [name for name in described if "flipper" in name]
    compared = 0
    for _ in range(60):
        for name in names:
            value = pose[name] + rng.uniform(-0.2, 0.2) * described[name].velocity
            pose[name] = min(max(value, described[name].lower), described[name].upper)
        arm.pose({**pose, **{name: rng.uniform(0.0, 0.3) for name in flippers}})
        told = nearest(arm.measure())
        fresh = ProximityMonitor(
            arm.body, arm.robot.config.proximity, arm.robot.config.self_collision
        )
        for pair, distance in nearest(fresh.measure(lambda uid: "floor")).items():
            if distance < 0.07:
                assert told[pair] == pytest.approx(distance, rel=0.1, abs=1e-4), pair
                compared += 1
    assert compared > 100


def test_neighbours_and_parts_of_the_hand_are_no_pairs(robot):
    arm = Arm(robot(proximity__near=0.2, proximity__most_pairs=500))
    pairs = {frozenset(key(pair)) for pair in arm.measure().pairs}
    assert pairs
    hand = [link for link in arm.body.links if "finger" in link or link == "gripper_link"]
    for links in (
        ("wrist_link", "gripper_link"),
        ("turret_link", "telescope_link"),
        ("turret_link", "base_link"),
        *itertools.combinations(hand, 2),
    ):
        assert frozenset(links) not in pairs


CRATE = """
description: for the test
objects: [{type: crate, name: crate, position: [0.45, 0.6, 0.8], static: true}]
"""


@pytest.mark.parametrize(
    ("pose", "moved", "joint", "way", "other"),
    [
        ("look_front", {"turret": 2.8, "elbow": 0.35}, "elbow", 1.0, "base_link"),
        ("floor_pick", {}, "turret", 1.0, "front_left_flipper_link"),
        ("ready", {"wrist_pitch": -1.2}, "wrist_pitch", -1.0, "forearm_link"),
        ("ready", {"shoulder": 0.55}, "shoulder", 1.0, "floor"),
        ("look_front", {"turret": 0.8}, "turret", 1.0, "crate"),
    ],
)
def test_driven_into_something_the_pair_is_named_before_it_touches(
    robot, tmp_path, pose, moved, joint, way, other
):
    """The controllers lead the arm towards hull, flipper, itself, floor and crate."""
    scene = tmp_path / "crate.yaml"
    scene.write_text(CRATE)
    positions = dict(shipped_config().start.poses[pose])
    for name, change in moved.items():
        positions[f"{name}_joint"] += change
    offline = robot(
        start__poses={"near": positions},
        start__pose="near",
        world=str(scene),
        start__default_pose="",
    )
    arm = Arm(offline)
    offline.run(0.3)  # until it no longer settles on its tracks
    command = offline.node.advertise(f"/{joint}_position_controller/command", Float64)
    reference = offline.positions()[f"{joint}_joint"]
    index = arm.robot.proximity.joints.index(f"{joint}_joint")
    found = None
    for _ in range(60):
        reference += way * 0.02 * 0.25
        command.publish(Float64(reference))
        offline.run(0.02)
        near = [pair for pair in arm.measure().pairs if pair.closing_speed > 0.01]
        found = next((pair for pair in near if pair.place.distance < 0.018), None)
        if found:
            break
    assert found is not None
    assert found.place.distance > 0.005
    assert found.other == other
    assert found.touchable == ("finger" in found.link and other in ("floor", "crate"))
    # The way on closes, the way back opens.
    assert way * found.place.gradient[index] < -0.05


def test_what_fingers_hold_belongs_to_the_hand_and_may_be_put_down(robot, tmp_path):
    scene = tmp_path / "cube.yaml"
    scene.write_text(
        "description: for the test\n"
        "objects: [{type: cube, name: cube, edge: 0.06, position: [0.0, 0.0, 5.0]}]\n"
    )
    offline = robot(start__pose="look_front", world=str(scene), proximity__near=0.15)
    arm = Arm(offline)
    body, client = arm.body, arm.body.client
    [cube] = arm.simulation.objects.bodies_of("cube")
    tool = body.pose("tool_link")
    fingers = ("base", "middle", "tip")
    commands = [
        (
            share,
            offline.node.advertise(f"/{side}_finger_{part}_position_controller/command", Float64),
        )
        for side in ("left", "right")
        for part, share in zip(fingers, (1.0, 1.0, -2.0))
    ]

    def close(angle, seconds):
        for share, command in commands:
            command.publish(Float64(share * angle))
        offline.run(seconds)

    close(0.3, 0.8)
    assert not any("cube" in key(pair) for pair in arm.measure().pairs)
    pybullet.resetBasePositionAndOrientation(cube, *tool, physicsClientId=client)
    pybullet.changeDynamics(cube, -1, mass=0.05, physicsClientId=client)
    offline.run(0.002)
    before = [pair for pair in arm.measure().pairs if pair.other == "cube"]
    assert any(pair.link == "gripper_link" and not pair.touchable for pair in before)
    assert all(pair.touchable for pair in before if "finger" in pair.link)
    pybullet.setGravity(0, 0, 0, physicsClientId=client)
    close(0.0, 1.0)
    after = arm.measure().pairs
    assert not any(pair.other == "cube" for pair in after), "the hand holds it"
    # Held, it is a part of the arm: what it comes near to is told, and it may be put down.
    (x, y, z), _ = pybullet.getBasePositionAndOrientation(cube, physicsClientId=client)
    plate = pybullet.createCollisionShape(
        pybullet.GEOM_BOX, halfExtents=[0.05, 0.05, 0.01], physicsClientId=client
    )
    pybullet.createMultiBody(0.0, plate, -1, (x, y, z - 0.09), physicsClientId=client)
    pybullet.performCollisionDetection(physicsClientId=client)
    below = [pair for pair in arm.measure().pairs if key(pair) == ("cube", "floor")]
    assert below
    assert all(pair.touchable for pair in below)
    assert 0.03 < below[0].place.distance < 0.05
    shoulder = arm.robot.proximity.joints.index("shoulder_joint")
    assert below[0].place.gradient[shoulder] < -0.2


def test_looking_changes_nothing(robot):
    states = []
    for look in (False, True):
        offline = robot(start__pose="floor_pick")
        command = offline.node.advertise("/shoulder_position_controller/command", Float64)
        command.publish(Float64(offline.positions()["shoulder_joint"] + 0.3))
        for _ in range(40):
            offline.run(0.02)
            if look:
                Arm(offline).measure()
        states.append(offline.simulation.link_poses())
    assert states[0] == states[1]


def test_a_reset_and_what_is_spawned_are_noticed(robot):
    offline = robot(start__pose="look_front")
    arm = Arm(offline)
    simulation = offline.simulation
    plan = simulation.plan("{type: crate, position: [1.2, 0, 0], size: [0.2, 0.2, 0.8]}", "post")
    pose = {"shoulder_joint": -1.2}
    arm.pose(pose)
    before = {pair.other for pair in arm.measure().pairs}
    simulation.spawn(plan)
    arm.pose(pose)
    offline.run(0.002)
    assert "post" not in before
    simulation.delete("post")
    offline.run(0.002)
    assert "post" not in {pair.other for pair in arm.measure().pairs}
    simulation.reset()
    arm.body = simulation.body
    assert arm.measure().positions == pytest.approx(
        [offline.positions()[name] for name in arm.robot.proximity.joints], abs=1e-6
    )
