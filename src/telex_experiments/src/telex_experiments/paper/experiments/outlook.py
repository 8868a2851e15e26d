"""Section 6, outlook: tracks and grasping, beside the paper's way."""

from __future__ import annotations

import math
from typing import Dict, List, Optional, Tuple

from telex_experiments.grasping.holding import Hold, hold, rig_for
from telex_experiments.grasping.suite import FRICTIONS, LEAST_FORCE, Grasp, grasp
from telex_experiments.grasping.things import PAD_FRICTION, THINGS, Thing
from telex_experiments.mobility import flat
from telex_experiments.mobility import hold as standing
from telex_experiments.mobility.balance.chassis_force import ChassisForce
from telex_experiments.mobility.offline import OfflineTrial
from telex_experiments.mobility.suite import Attempted, Obstacle, all_obstacles, attempt
from telex_training.operators.terrain import slope

from ..experiment import Cell, Experiment, Figure, ReportTable, Result
from ..session import PaperSession

OBSTACLES = (
    "ramp 30 deg",
    "stairs 18x28 cm",
    "step 50 cm, mu 1.0",
    "4 loose pallets, 50 cm",
    "hurdle 30 cm",
    "hurdle 50 cm",
    "gap 40 cm",
    "stepfield hill, seed 1",
)
QUICK_OBSTACLES = ("step 50 cm, mu 1.0", "hurdle 30 cm")
_NOT_PASSED = "not passed"
SPEEDS = (0.3, 1.0)  # m/s
TURN = 0.5  # rad/s
SLOPE = math.radians(30.0)
STANDING = 4.0  # s
SPEED_ERROR, YAW_ERROR, DRIFT = 1.0, 2.0, 1.0  # %, %, mm

QUICK_THINGS = ("cube 5 cm", "cylinder")
SHARE = 0.7
"""Of Coulomb's limit, at which things are held still."""
STILL = 10.0  # s
SLIP = 0.1  # mm
LEAST_AGREEMENT = 0.9
"""Of the grasps that go as Coulomb's law says."""

Pair = Tuple[Optional[float], Optional[float]]
"""With the tracks, and in the paper's way."""


def _trial(obstacle: Obstacle, in_paper_way: bool) -> Attempted:
    with obstacle.trial() as trial:
        if in_paper_way:
            ChassisForce(trial)
        return attempt(obstacle, trial.operator)


def _speed_error(speed: float, in_paper_way: bool) -> float:
    with OfflineTrial(start={"x": math.copysign(1.5, -speed)}) as trial:
        if in_paper_way:
            ChassisForce(trial)
        return 100.0 * abs(flat.straight(trial, speed).speed / speed - 1.0)


def _yaw_error(in_paper_way: bool) -> float:
    with OfflineTrial() as trial:
        if in_paper_way:
            ChassisForce(trial)
        return 100.0 * abs(flat.turn(trial, TURN).rate / TURN - 1.0)


def _slide(in_paper_way: bool) -> float:
    """Distance that the robot slides on a slope (mm)."""
    if not in_paper_way:
        return 1e3 * standing.on_slope(SLOPE, 0.0, 1.0, STANDING)
    plane = slope.Slope(SLOPE)
    with OfflineTrial(plane.objects(), pose="look_front") as trial:
        ChassisForce(trial)
        trial.place(*plane.pose(6.0, 0.0))
        return 1e3 * standing.drift(trial, STANDING, settle=0.0)


def tracks(session: PaperSession) -> Result:
    """Let the same scripts drive over the same obstacles, by tracks and in the paper's way."""
    wanted = QUICK_OBSTACLES if session.quick else OBSTACLES
    by_name = {obstacle.name: obstacle for obstacle in all_obstacles()}
    climbed: List[List[Cell]] = []
    passed = 0
    for name in wanted:
        ours, theirs = (_trial(by_name[name], way) for way in (False, True))
        passed += ours.passed
        climbed.append([name, *(o.time if o.passed else _NOT_PASSED for o in (ours, theirs))])
        told = [f"{o.time:.1f} s" if o.passed else _NOT_PASSED for o in (ours, theirs)]
        session.say(f"{name}: tracks {told[0]}, the paper's way {told[1]}")
    driven: Dict[str, Tuple[str, float, Pair]] = {}
    for speed in SPEEDS[-1:] if session.quick else SPEEDS:
        pair = (_speed_error(speed, False), _speed_error(speed, True))
        driven[f"{speed:g} m/s on the level: speed error"] = ("%", SPEED_ERROR, pair)
    pair = (_yaw_error(False), _yaw_error(True))
    driven[f"turn at {TURN:g} rad/s: error"] = ("%", YAW_ERROR, pair)
    pair = (_slide(False), _slide(True))
    driven["stopped on 30 deg for 4 s: slides by"] = ("mm", DRIFT, pair)
    figures = [Figure("obstacles passed", passed, f"of {len(wanted)}", at_least=len(wanted))]
    figures += [
        Figure(name, float(pair[0] or 0.0), unit, at_most=most)
        for name, (unit, most, pair) in driven.items()
    ]
    return Result(
        figures=figures,
        tables=[
            ReportTable(
                "Obstacles",
                "obstacles.csv",
                ("obstacle", "tracks: s", "the paper's way: s"),
                climbed,
                "The same script in both ways. The whole of benchmarks/mobility has 29 obstacles.",
            ),
            ReportTable(
                "Driving",
                "driving.csv",
                ("what", "unit", "tracks", "the paper's way"),
                [[name, unit, *pair] for name, (unit, _, pair) in driven.items()],
            ),
        ],
        notes=[
            "The paper's way: a force and a torque on the hull by proportional control of its "
            "velocity, over tracks that slip (telex_experiments.mobility.balance.chassis_force).",
            "Computed in one process with the simulator's own loop, without ROS: the scripts "
            "publish on the controllers' topics, and see joint states and the base's pose.",
        ],
    )


def _held(thing: Thing, anchored: bool) -> Hold:
    with rig_for(thing, anchor=anchored) as rig:
        name = rig.present(thing.entry(), max(LEAST_FORCE, thing.force(SHARE)))
        return hold(rig, name, STILL)


def grasping(session: PaperSession) -> Result:
    """Pick things up, and hold them still, with and without anchored friction."""
    names = QUICK_THINGS if session.quick else tuple(THINGS)
    picked: List[List[Cell]] = []
    agreeing, most_slip = 0, 0.0
    still: List[List[Cell]] = []
    for name in names:
        thing = THINGS[name]
        found: Dict[float, Grasp] = {each: grasp(thing, 0.0, each) for each in FRICTIONS}
        for friction, each in found.items():
            agreeing += each.agrees
            cells: List[Cell] = [name, thing.mass, friction, each.force, each.load]
            picked.append([*cells, each.predicted, each.lifted, 1e3 * each.slip])
        ours, theirs = _held(thing, True), _held(thing, False)
        most_slip = max(most_slip, 1e3 * ours.slip.distance)
        still.append(
            [
                *(name, thing.mass),
                *("lost" if each.lost else 1e3 * each.slip.distance for each in (ours, theirs)),
                *(1e3 * each.jitter for each in (ours, theirs)),
            ]
        )
        session.say(
            f"{name}: {sum(each.agrees for each in found.values())} of {len(found)} as "
            f"Coulomb's law says; slips {1e3 * ours.slip.distance:.3f} mm in {STILL:g} s"
        )
    count = len(picked)
    return Result(
        figures=[
            Figure(
                "grasps as Coulomb's law says",
                agreeing,
                f"of {count}",
                at_least=math.ceil(LEAST_AGREEMENT * count),
            ),
            Figure("things", len(names), "", at_least=len(names)),
            Figure(f"largest slip in {STILL:g} s, held still", most_slip, "mm", at_most=SLIP),
        ],
        tables=[
            ReportTable(
                "Picked and lifted",
                "grasps.csv",
                (
                    *("object", "mass kg", "pad friction", "force N", "weight / Coulomb's limit"),
                    *("held by theory", "lifted", "slip mm"),
                ),
                picked,
                "From the front; benchmarks/grasping adds two more approaches.",
            ),
            ReportTable(
                f"Held still for {STILL:g} s at {SHARE:g} of Coulomb's limit",
                "holding.csv",
                (
                    *("object", "mass kg", "slip mm", "without anchors: slip mm"),
                    *("rms speed mm/s", "without anchors: rms speed mm/s"),
                ),
                still,
                f"The lightest are gripped with {LEAST_FORCE:g} N. Without anchors: plain contact "
                "friction, as the paper's physics engine and most others have it; what is held "
                "creeps out of the hand.",
            ),
        ],
        notes=[
            "Nothing is welded to the hand: contact and friction alone hold it. The pads' friction "
            f"is {PAD_FRICTION:g}; an object is gripped with the force with which its weight is "
            f"{SHARE:g} of what that friction can carry, so that at half of the friction it must "
            "fall.",
            "Computed in one process with the simulator's own loop and controllers, without ROS.",
        ],
    )


EXPERIMENTS = (
    Experiment(
        name="outlook_tracks",
        paper="Section 6, outlook; section 4.3",
        title="Tracks, beside the paper's way",
        claim="Gazebo does not support tracked vehicles; a controller exerted forces on the robot. "
        "\u201cA better solution needs to be found to simulate the tracked wheels.\u201d",
        method="Belts with drives transmit forces at their contacts. The same scripts drive over "
        "the same obstacles with these tracks, and by force and torque on the hull.",
        bar="every obstacle passed with the tracks; speed within 1 %, turn within 2 %, slide "
        "\u2264 1 mm",
        run=tracks,
        seconds=240.0,
        quick_seconds=60.0,
        in_wall_time=False,
        groups=("outlook",),
    ),
    Experiment(
        name="outlook_grasping",
        paper="Section 6, outlook",
        title="Grasping, beside plain contact friction",
        claim="The gripping function needs to be tested on more objects that differ in shape and "
        "weight, to test the robustness of the simulator in this respect.",
        method="Twelve things are picked at two frictions of the pads and lifted, and compared "
        "with Coulomb's law; then held still, with and without anchored friction.",
        bar="9 of 10 as Coulomb's law says; slip \u2264 0.1 mm",
        run=grasping,
        seconds=200.0,
        quick_seconds=60.0,
        in_wall_time=False,
        groups=("outlook",),
    ),
)
