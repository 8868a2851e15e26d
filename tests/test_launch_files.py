"""What launch files may not say."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml
from roslaunch.config import ROSLaunchConfig
from roslaunch.xmlloader import XmlLoader

from telex_sim.engine.simulator_config import SimulatorConfig

SOURCES = Path(__file__).resolve().parents[1] / "src"
FILES = sorted(SOURCES.glob("*/launch/*.launch"))


def test_programs_are_not_looked_for_within_quotes():
    """roslaunch takes the quote for a part of the path, and finds none of an install space."""
    assert FILES
    quoted = re.compile(r"'\$\(find \w+\)/nodes/")
    assert not [file.name for file in FILES if quoted.search(file.read_text())]


def test_a_station_takes_what_bringup_takes_with_the_same_defaults():
    """roslaunch passes on what an included file asks for only where the including one names it."""

    def arguments(package, name):
        root = ElementTree.parse(SOURCES / package / "launch" / name).getroot()
        return {
            each.get("name"): (each.get("default"), each.get("doc")) for each in root.findall("arg")
        }

    bringup = arguments("telex_teleop", "bringup.launch")
    station = arguments("telex_training", "station.launch")
    assert {name: station.get(name) for name in bringup} == bringup


ROVER = SOURCES.parent / "docs" / "examples" / "rover"
ROBOT = ("telex_sim", "robot.launch")
OWN_ROBOT = ("telex_teleop", "own_robot.launch")


class Loader(XmlLoader):
    """Makes no robot of its description, which takes its time."""

    def param_value(self, *arguments):
        *rest, command = arguments
        return super().param_value(*rest, "true" if command else command)


def loaded(launch, *arguments):
    """What a launch file makes of the rover."""
    package, name = launch
    config = ROSLaunchConfig()
    given = [f"model:={ROVER}/rover.urdf", f"controllers:={ROVER}/controllers.yaml", "ns:=rover"]
    Loader(resolve_anon=False).load(
        str(SOURCES / package / "launch" / name), config, argv=[*given, *arguments], verbose=False
    )
    assert not config.config_errors
    return config


def parameters(launch, *arguments, place="simulator"):
    """The parameters in a namespace of the rover's that a launch file sets, by name."""
    begin = f"/rover/{place}/"
    params = loaded(launch, *arguments).params
    return {name[len(begin) :]: each.value for name, each in params.items() if begin in name}


@pytest.mark.parametrize(
    ("launch", "arguments", "cleared"),
    [
        (OWN_ROBOT, [], ["/rover/"]),
        (ROBOT, [], ["/rover/"]),
        (ROBOT, ["ns:=/lab/rover/", "simulator:=/lab"], ["/lab/rover/"]),
        (ROBOT, ["simulator:=/telex"], ["/rover/"]),
        (ROBOT, ["simulator:=/rover2"], ["/rover/"]),
        # Not only this robot's.
        (ROBOT, ["simulator:=/rover"], []),
        (ROBOT, ["ns:=lab", "simulator:=/lab/telex"], []),
        (ROBOT, ["ns:=/", "name:=rover"], []),
        (ROBOT, ["ns:=/", "name:=rover", "simulator:=/telex"], []),
    ],
)
def test_a_robot_of_ones_own_finds_nothing_of_the_one_before(launch, arguments, cleared):
    """On a master that runs on, parameters outlive the nodes that they were for."""
    assert loaded(launch, *arguments).clear_params == cleared


SAID = {
    "fixed_base": True,
    "gui": True,
    "paused": True,
    "global_description": False,
    "world": "stairs",
    "self_collision": {"enabled": True},
    "start": {"place": [1.0, 2.0, 3.0, 4.0], "height": 0.3},
    "timing": {
        "real_time_factor": 0.5,
        "realtime_priority": 7,
        "step_size": 0.001,
        "control_period": 0.004,
    },
}
"""What a file of config:= may say, and arguments too; none of it is a default."""


def flat(values, begin=""):
    found = {}
    for name, value in values.items():
        nested = isinstance(value, dict)
        found.update(flat(value, f"{begin}{name}/") if nested else {f"{begin}{name}": value})
    return found


@pytest.mark.parametrize("launch", [ROBOT, OWN_ROBOT], ids=["robot", "own robot"])
class TestConfigOfARobot:
    def config(self, folder):
        file = folder / "config.yaml"
        file.write_text(yaml.safe_dump(SAID))
        return f"config:={file}"

    def test_it_keeps_its_values(self, launch, tmp_path):
        assert parameters(launch, self.config(tmp_path)) == {**flat(SAID), "model": "rover"}

    def test_arguments_that_are_given_prevail(self, launch, tmp_path):
        given = {
            "fixed_base": False,
            "gui": False,
            "paused": False,
            "global_description": True,
            "world": "floor",
            "self_collision/enabled": False,
            "timing/real_time_factor": 0.0,
            "timing/realtime_priority": 0,
            "timing/step_size": 0.002,
            "timing/control_period": 0.002,
        }
        names = {"self_collision/enabled": "self_collision"}
        arguments = [
            f"{names.get(name, name.split('/')[-1])}:={str(value).lower()}"
            for name, value in given.items()
        ]
        found = parameters(launch, self.config(tmp_path), *arguments)
        assert found == {**flat(SAID), **given, "model": "rover"}

    def test_any_argument_of_the_place_makes_one(self, launch, tmp_path):
        for argument, place in (
            ("x:=2", [2, 0.0, 0.0, 0.0]),
            ("y:=-3.5", [0.0, -3.5, 0.0, 0.0]),
            ("z:=0", [0.0, 0.0, 0, 0.0]),
            ("yaw:=0.00001", [0.0, 0.0, 0.0, 1e-5]),
        ):
            found = parameters(launch, self.config(tmp_path), argument)
            assert found["start/place"] == place, argument

    def test_without_one_it_starts_where_the_scene_says(self, launch):
        """On its ground; the rest is as the arguments say that they are by default."""
        found = parameters(launch)
        assert found == {"start/height": 0.0, "self_collision/enabled": False, "model": "rover"}
        simulator = SimulatorConfig()
        assert simulator.start.place is None
        assert (simulator.world, simulator.gui, simulator.fixed_base) == ("floor", False, False)
        timing = simulator.timing
        assert (timing.real_time_factor, timing.realtime_priority) == (1.0, 1)
        assert (timing.step_size, timing.control_period) == (0.002, 0.002)


def test_a_robot_that_is_added_starts_beside_what_is_there():
    """At the scene's start itself the simulator's first robot stands."""
    found = parameters(ROBOT, "simulator:=/telex", place="simulation")
    assert "start/place" not in found
    assert found["start/beside"] is True
    found = parameters(ROBOT, "simulator:=/telex", "x:=2", "yaw:=1.5", place="simulation")
    assert found["start/place"] == [2, 0.0, 0.0, 1.5]


@pytest.mark.parametrize(
    ("launch", "arguments", "topic"),
    [
        (OWN_ROBOT, [], "/tf"),
        (ROBOT, [], "/tf"),
        (ROBOT, ["tf:=/other/tf"], "/other/tf"),
        (ROBOT, ["simulator:=/telex"], "/rover/tf"),
        (ROBOT, ["simulator:=/telex", "ns:=/lab/rover"], "/lab/rover/tf"),
        (ROBOT, ["simulator:=/telex", "tf:=/tf"], "/tf"),
    ],
)
def test_frames_of_a_robot_beside_another_are_not_taken_for_that_ones(launch, arguments, topic):
    nodes = {node.name: node for node in loaded(launch, *arguments).nodes}
    remapped = dict(nodes["robot_state_publisher"].remap_args)
    assert remapped.get("/tf", "/tf") == topic
    assert remapped.get("/tf_static", "/tf_static") == f"{topic}_static"
    assert "add_robot" not in nodes or not nodes["add_robot"].remap_args
