"""Three tasks by keys of the page: how many presses they take, and how much sim time.

The person is a script: the experts of the exercises, and the way up the stairs by preset keys. He
sees what `by_keys` says, and a judge beside him looks at the truth.
"""

from __future__ import annotations

import math
import os
import subprocess
import time
from pathlib import Path
from typing import Any, Callable, Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple

import numpy as np
import rospy
import yaml
from std_msgs.msg import Float64
from telex_msgs.msg import TruthNames, TruthSample
from telex_msgs.srv import LoadScene

from telex_control.common.file_catalog import package_yaml
from telex_experiments.console.by_keys import ByKeys, Object
from telex_experiments.console.rig import ConsoleRig
from telex_experiments.rigs.report import PATIENCE, Figure, MeasurementError, wait_until
from telex_training.operators import driving
from telex_training.operators.experts.brief import Brief
from telex_training.operators.experts.handling_exercises import cube_to_bin
from telex_training.operators.experts.mounted_exercises import (
    CLOSED,
    stand_at_wheel,
    turn_wheel,
    wheel_from_base,
)
from telex_training.operators.handling import Hand, aimed
from telex_training.operators.port import NotManagedError
from telex_training.operators.robot_size import AXLE_HEIGHT, HALF_LENGTH
from telex_training.operators.station import Station
from telex_training.operators.terrain.stairs import Stairs

LOAD = "/telex/sim/load_scene"
SPEED = 0.35
"""Of the full speed, with which `run.sh` begins."""

_ONTO_LANDING = 0.7
"""From where the robot comes level over the landing's edge (m)."""
_AIM_FROM, _HUB = 0.25, 0.015
"""Of the tool before the wheel's plane, from where the range is read; of the hub's face (m)."""
_FOR_BEAM, _MOST_OFF = 0.15, 0.1
"""Of the fingers (rad); a range that is further off is not that of the hub (m)."""
_TRIES = 4
_PATIENCE = 3.0
"""How long a preset is tried for at least (s)."""
_TREADS = 0.04
"""By how much the robot may stand higher or lower on a landing (m)."""


class Truth:
    """What the judge sees: where the base is, where objects are, how far mechanisms have turned."""

    def __init__(self, port: ByKeys) -> None:
        self._port = port
        self._names: Optional[Any] = None
        self._sample: Optional[Any] = None
        port.robot.node.subscribe("sim/truth_names", TruthNames, self._on_names)
        port.robot.node.subscribe("sim/truth", TruthSample, self._on_sample)
        wait_until("the truth", lambda: self._names is not None and self._sample is not None)

    def _on_names(self, message: Any) -> None:
        self._names = message

    def _on_sample(self, message: Any) -> None:
        self._sample = message

    @property
    def base(self) -> Tuple[float, float, float]:
        """Place of the base (m)."""
        assert self._sample is not None
        x, y, z = self._sample.base[:3]
        return x, y, z

    def mechanism(self, name: str) -> float:
        """Position of a joint of an object, by "object/joint" (rad or m)."""
        assert self._names is not None
        assert self._sample is not None
        return float(self._sample.mechanisms[list(self._names.mechanisms).index(name)])

    def place(self, name: str) -> Tuple[float, float, float]:
        """Place of an object (m)."""
        pose = self._port.robot.object_pose(name)
        if pose is None:
            raise MeasurementError(f"nothing tells where {name} is")
        x, y, z = (float(each) for each in pose[:3, 3])
        return x, y, z


class ConsoleTask(NamedTuple):
    """What is to be done, and how one sees that it is.

    Attributes
    ----------
    scene : callable
        Returns the scene's file as it is read.
    act : callable
        Does it.
    done : callable
        Whether it is done, in truth.
    """

    scene: Callable[[], Dict[str, Any]]
    act: Callable[[Hand, Mapping[str, Object]], None]
    done: Callable[[Truth, Mapping[str, Object]], bool]


def _hall() -> Dict[str, Any]:
    return dict(package_yaml("telex_sim", "scenes", "training_hall.yaml"))


def _exercise(name: str) -> Callable[[], Dict[str, Any]]:
    def scene() -> Dict[str, Any]:
        return dict(package_yaml("telex_training", "exercises", f"{name}.yaml")["scene"])

    return scene


def _stairs(things: Mapping[str, Object]) -> Tuple[Stairs, Tuple[float, float, float]]:
    """The stairs of the hall, and the course along them."""
    entry = things["stairs"]
    rise, run, steps = (float(entry[name]) for name in ("rise", "run", "steps"))
    landing = float(entry.get("landing", 1.2))
    x, y = entry["position"][:2]
    return Stairs(rise, run, int(steps), landing, foot=0.0), (
        x - 0.5 * landing - run * (steps - 1),
        y,
        0.0,
    )


def _climb(hand: Hand, things: Mapping[str, Object]) -> None:
    """Drive from the hall's start to the stairs, and up onto the landing.

    Belts slip on steps, and the odometry with them: there he goes by the attitude, and by whether
    the page says that the robot is stuck.
    """
    station = hand.station
    start, course = station.pose, _stairs(things)[1]
    driving.follow(station, [(start.x, course[1])])
    driving.turn_to(station, 0.0, 0.05)
    station.enter(course)
    station.keep_lane(SPEED)
    _work_on(station, lambda: station.pose.rise > 0.25, "the front up", "approach", "drive")
    _work_on(station, lambda: station.pose.rise < 0.2, "over the crest", "flat", "climb")
    there = station.pose.x + _ONTO_LANDING
    _work_on(station, lambda: station.pose.x > there, "on the landing", "drive")
    station.rest()


def _work_on(station: Station, reached: Callable[[], bool], what: str, *presets: str) -> None:
    """Go on with a preset's key, and with the next one where the page says that it is stuck."""
    port, since, turn = station.port, station.time, 0
    assert isinstance(port, ByKeys)

    def look_on() -> None:
        nonlocal since, turn
        if port.stuck and station.time > since + _PATIENCE:
            since, turn = station.time, turn + 1
        station.hold_preset(presets[turn % len(presets)])

    station.until(reached, 60.0, what, look_on)
    station.hold_preset("")


def _stands_on_landing(truth: Truth, things: Mapping[str, Object]) -> bool:
    stairs, (foot, aside, _) = _stairs(things)
    x, y, z = truth.base
    is_there = foot + stairs.crest + HALF_LENGTH < x < foot + stairs.edge and abs(y - aside) < 0.5
    return is_there and abs(z - stairs.height - AXLE_HEIGHT) < _TREADS


def _move_cube(hand: Hand, things: Mapping[str, Object]) -> None:
    cube_to_bin(hand, Brief("", things))


def _open_valve(hand: Hand, things: Mapping[str, Object]) -> None:
    """Open the valve as the expert does, once the range to its hub has told where the robot is."""
    entry, station = things["valve"], hand.station
    port = station.port
    assert isinstance(port, ByKeys)
    stand_at_wheel(hand, entry)
    # The beam passes between open fingers only.
    _open(hand, _FOR_BEAM)
    (x, y, z), turn = wheel_from_base(hand, entry)
    before = (x - _AIM_FROM * math.cos(turn), y - _AIM_FROM * math.sin(turn))
    hand.to(aimed(*before, z, turn), tolerance=0.01)
    station.wait(0.5)
    beam = station.place_of("range_finder_link")
    expected = float(beam[:3, 0] @ (np.array((x, y, z)) - beam[:3, 3])) - _HUB
    if abs(expected - port.range) < _MOST_OFF:
        port.set_back(station.base()[:3, :3] @ beam[:3, 0] * (port.range - expected))
        station.look()
    _open(hand, CLOSED)
    turn_wheel(hand, entry)


def _open(hand: Hand, angle: float) -> None:
    """Open the gripper to an angle (rad), with the patience that a busy page asks for."""
    for tries in range(_TRIES):
        try:
            return hand.open(angle)
        except NotManagedError:
            hand.station.release("gripper_teleop")
            if tries == _TRIES - 1:
                raise
    return None


def _is_in_bin(truth: Truth, things: Mapping[str, Object]) -> bool:
    x, y, z = truth.place("cube")
    u, v = things["bin"]["position"][:2]
    return math.hypot(x - u, y - v) < 0.2 and z < float(things["bin"]["position"][2]) + 0.05


TASKS: Dict[str, ConsoleTask] = {
    "stairs": ConsoleTask(_hall, _climb, _stands_on_landing),
    "cube": ConsoleTask(_exercise("cube_to_bin"), _move_cube, _is_in_bin),
    "valve": ConsoleTask(
        _exercise("valve"),
        _open_valve,
        lambda truth, things: truth.mechanism("valve/wheel_hinge") > 2.0 * math.pi,
    ),
}
"""From the hall's start onto the stairs' landing; a cube from a table into a bin; a valve opened by
a whole turn."""


def tasks(
    rig: ConsoleRig, names: Sequence[str] = (), longest_wait: float = math.inf
) -> List[Figure]:
    """Do some tasks, by default all, each from the start of its scene.

    Parameters
    ----------
    longest_wait : float
        See `Operator`.
    """
    figures: List[Figure] = []
    for name in names or TASKS:
        task = TASKS[name]
        scene = task.scene()
        rospy.wait_for_service(LOAD, PATIENCE)
        loaded = rospy.ServiceProxy(LOAD, LoadScene)(yaml.safe_dump(scene))
        if not loaded.success:
            raise MeasurementError(f"{name}: {loaded.message}")
        _set_speed()
        start = scene["start"]
        things = {each["name"]: each for each in scene["objects"] if "name" in each}
        with rig.browser() as browser:
            place = (start["x"], start["y"], float(start.get("yaw", 0.0)))
            port = ByKeys(browser, rig.page(), place, things)
            try:
                figures += _measure(name, task, port, things, longest_wait)
            finally:
                port.close()
    return figures


def _set_speed() -> None:
    """Have the keys mean what they mean after a start by `run.sh`."""
    for node in ("arm", "flipper", "gripper", "track"):
        publisher = rospy.Publisher(f"/telex/{node}_teleop/speed_scale", Float64, queue_size=1)
        wait_until(f"{node}_teleop", publisher.get_num_connections)
        publisher.publish(SPEED)
        time.sleep(0.2)


def _measure(
    name: str, task: ConsoleTask, port: ByKeys, things: Mapping[str, Object], longest_wait: float
) -> List[Figure]:
    truth = Truth(port)
    station = Station(port)
    station.longest_wait = longest_wait
    problem = ""
    began = time.monotonic()
    try:
        task.act(Hand(station), things)
    except NotManagedError as error:
        problem = str(error)
    spent = station.time
    station.release()
    port.advance(0.5)
    is_done = task.done(truth, things)
    x, y, z = truth.base
    said = "done" if is_done else f"NOT done{': ' if problem else ''}{problem}"
    print(
        f"  {name}: {said}; {sum(port.pressed.values())} key presses, {spent:.1f} s of sim time,"
        f" {time.monotonic() - began:.0f} s; the base is at {x:.2f} {y:.2f} {z:.2f} m",
        flush=True,
    )
    print(
        f"  the page let go of {port.again} more; "
        + ", ".join(f"{each} {count}" for each, count in port.pressed.most_common())
    )
    return [
        Figure(f"{name}: done", float(is_done), at_least=1.0),
        Figure(f"{name}: key presses", sum(port.pressed.values()) if is_done else math.nan),
        Figure(f"{name}: keys pressed again that the page let go of", port.again),
        Figure(f"{name}: sim time", spent if is_done else math.nan, "s"),
    ]


def environment_of(tree: Optional[str]) -> Mapping[str, str]:
    """The environment of another checkout that was set up, or of this one."""
    if tree is None:
        return os.environ
    script = Path(tree).resolve() / "env.sh"
    if not script.is_file():
        raise MeasurementError(f"--tree {tree}: {script} is not there; a checkout is needed")
    # Nothing of this checkout's own environment.
    clean = {"HOME": os.environ.get("HOME", "/"), "PATH": os.defpath + os.pathsep + "/usr/sbin"}
    done = subprocess.run(
        ["bash", "-c", f". '{script}' && env -0"], env=clean, capture_output=True, check=False
    )
    if done.returncode:
        raise MeasurementError(f"--tree {tree}: {done.stderr.decode(errors='replace').strip()}")
    pairs = (each.partition("=") for each in done.stdout.decode().split("\0") if each)
    return {key: value for key, _, value in pairs}
