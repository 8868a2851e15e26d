"""The order of a measurement: into a posture, one joint after the other, and back."""

from __future__ import annotations

import contextlib
import math
from dataclasses import dataclass
from typing import (
    Callable,
    ContextManager,
    Dict,
    Iterator,
    List,
    Mapping,
    NamedTuple,
    Optional,
    Protocol,
    Sequence,
)

from ..urdf.joints import PRISMATIC, UrdfJoint
from .analysis import StepFigures, StepRecording, analyse
from .plan import CURRENT, Plan

STREAM_PERIOD = 0.02
"""Time between the commands of a move (s)."""

LOST = 0.15
"""A joint so far from its reference after a move is held by something (rad; m: a tenth of it)."""

_PEAK = 1.875
"""Peak over mean velocity of the polynomial of fifth order from rest to rest."""


class StepError(RuntimeError):
    """The measurement cannot go on; the message says why."""


class Unit(NamedTuple):
    """How positions and efforts of a joint are shown."""

    position: str
    factor: float
    """Times a position in rad or m."""
    effort: str


def shown_unit(joint: UrdfJoint) -> Unit:
    """Return the units for a joint: degrees and Nm, or mm and N."""
    if joint.kind == PRISMATIC:
        return Unit("mm", 1000.0, "N")
    return Unit("deg", math.degrees(1.0), "Nm")


class StepRig(Protocol):
    """A robot whose joints have position controllers: in a simulator that runs, or in memory."""

    def position(self, joint: str) -> float:
        """Measured position (rad, m)."""

    def reference(self, joint: str) -> float:
        """What the joint's controller holds (rad, m)."""

    def command(self, joint: str, position: float) -> None:
        """Command a position (rad, m)."""

    def wait(self, seconds: float) -> None:
        """Let sim time pass."""

    def record(self, joint: str, target: float, seconds: float) -> StepRecording:
        """Command a position, and record until `seconds` (s) later."""

    def raw(self, joint: str) -> ContextManager[None]:
        """Have the joint follow commands as they come: without limits, without filter."""


@dataclass(frozen=True)
class StepResult:
    """One step of one joint.

    Attributes
    ----------
    raw : bool
        Whether the controller followed the step itself, or led the joint within its limits.
    """

    posture: str
    joint: UrdfJoint
    raw: bool
    recording: StepRecording
    figures: StepFigures


def fitted_step(joint: UrdfJoint, position: float, step: float) -> float:
    """Return the step, or the opposite one where its end would be beyond a position limit.

    Raises
    ------
    StepError
        Neither fits.
    """
    for each in (step, -step):
        if joint.lower <= position + each <= joint.upper:
            return each
    raise StepError(
        f"{joint.name} is at {position:.3f}; a step of {abs(step):.3f} leaves its limits, "
        f"{joint.lower:.3f} to {joint.upper:.3f}, both ways"
    )


class Runner:
    """Steps joints in postures.

    Parameters
    ----------
    joints : dict of str to UrdfJoint
        Those that have a controller.
    say : callable
        Takes a line of progress.
    """

    def __init__(
        self,
        rig: StepRig,
        plan: Plan,
        joints: Mapping[str, UrdfJoint],
        say: Callable[[str], None] = lambda line: None,
    ) -> None:
        self._rig = rig
        self._plan = plan
        self._joints = joints
        self._say = say

    def run(
        self,
        postures: Sequence[str],
        joints: Sequence[str],
        kinds: Sequence[bool] = (False, True),
        size: Optional[float] = None,
    ) -> Iterator[StepResult]:
        """Step each of `joints` in each posture; the robot is then brought back to where it was.

        It stays where it is when this is not run to its end: who breaks off wants no motion.

        Parameters
        ----------
        postures : list of str
            Names of the plan's, or `CURRENT`.
        kinds : list of bool
            False: as the controller shapes its reference; True: raw.
        size : float, optional
            Of the steps in place of the plan's, above 0 (degrees, mm).

        Raises
        ------
        ConfigError
            Before anything moves: the plan has no step for one of the joints.
        """
        for posture in postures:
            for joint in joints:
                self._plan.step(posture, joint)
        home = {joint: self._rig.reference(joint) for joint in self._joints}
        away = False
        for posture in postures:
            if posture != CURRENT:
                self._say(f"moving to posture {posture} ...")
                away = True
                self.move(self._plan.via())
                self.move(self._plan.positions(posture))
            for joint in joints:
                for raw in kinds:
                    yield self.step(posture, joint, raw, size)
        if away:
            self._say("moving back ...")
            self.move(self._plan.via())
            self.move(home)

    def move(self, positions: Mapping[str, float]) -> None:
        """Lead joints to positions together, without a jump of velocity; wait until they rest.

        Joints that the robot lacks are left out.

        Raises
        ------
        StepError
            A joint did not get there.
        """
        rig, config = self._rig, self._plan.config
        ways: Dict[str, List[float]] = {}
        duration = 0.0
        for name, target in positions.items():
            if name not in self._joints:
                continue
            start = rig.reference(name)
            ways[name] = [start, target - start]
            speed = config.speed * self._joints[name].velocity
            duration = max(duration, _PEAK * abs(target - start) / speed)
        count = max(1, math.ceil(duration / STREAM_PERIOD))
        for index in range(1, count + 1):
            share = index / count
            progress = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
            for name, (start, way) in ways.items():
                if way:
                    rig.command(name, start + way * progress)
            rig.wait(STREAM_PERIOD)
        rig.wait(config.rest_time)
        for name, (start, way) in ways.items():
            error = start + way - rig.position(name)
            if abs(error) > LOST * (0.1 if self._joints[name].kind == PRISMATIC else 1.0):
                raise StepError(
                    f"{name} is {abs(error):.3f} short of {start + way:.3f} after a move; "
                    "something holds it (the emergency stop, an obstacle, another program)"
                )

    def step(
        self, posture: str, name: str, raw: bool = False, size: Optional[float] = None
    ) -> StepResult:
        """Step one joint in the posture in which the robot is, and lead it back.

        Raises
        ------
        StepError
            There is no room for the step, or the joint did not get back.
        """
        rig, joint = self._rig, self._joints[name]
        start = rig.reference(joint.name)
        step = self._plan.step(posture, joint.name)
        if size is not None:
            step = math.copysign(size / shown_unit(joint).factor, step)
        step = fitted_step(joint, start, step)
        with rig.raw(joint.name) if raw else contextlib.nullcontext():
            recording = self._record(joint.name, start, start + step)
        self.move({joint.name: start})
        figures = analyse(recording)
        kind = "raw   " if raw else "shaped"
        self._say(
            f"{posture:10} {joint.name:28} {kind} overshoot {figures.overshoot:5.1f} %, "
            f"settled after {figures.settling_time:.2f} s"
        )
        return StepResult(posture, joint, raw, recording, figures)

    def _record(self, joint: str, start: float, target: float) -> StepRecording:
        rig, config = self._rig, self._plan.config
        # A controller that was just started holds where the joint was then.
        rig.command(joint, start)
        rig.wait(config.rest_time)
        return rig.record(joint, target, config.record_time)
