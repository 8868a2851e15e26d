"""Flipper presets: named sets of flipper angles, and the two ways to ask for one.

Held: a key whose client repeats the preset's name; silence is a command to stop, and the stream is
subject to the same latch as every other. As a goal: a script says once where to go and hears how it
ends. The newest of all of them wins, and ends the others.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import Collection, Dict, List, Mapping, Optional, Sequence, Set, Tuple

from telex_teleop.motion.joint_jog import InvalidCommand, require_known
from telex_teleop.motion.stream import Clocks, CommandStream

A_GOAL = "goal"
"""Stands for whoever asked for a goal, among those whose commands are obeyed."""


@dataclass(frozen=True)
class FlipperPreset:
    """A named set of angles.

    Attributes
    ----------
    name
        What operators and scripts call it.
    description
        What it is for.
    positions
        Joint to angle (rad).
    """

    name: str
    description: str
    positions: Dict[str, float]


def choose(
    presets: Mapping[str, FlipperPreset],
    name: str,
    joint_names: Sequence[str],
    known: Collection[str],
) -> Dict[str, float]:
    """Return where a preset wants the joints that were asked for.

    Parameters
    ----------
    presets
        By name.
    name
        The one that is wanted.
    joint_names
        Joints to move; empty for all of the preset.
    known
        Joints that this node moves.

    Raises
    ------
    InvalidCommand
        The preset or a joint is unknown, or none of the joints is in the preset.
    """
    preset = presets.get(name)
    if preset is None:
        there = ", ".join(presets) or "no presets"
        raise InvalidCommand(f"preset is {name[:80]!r}; this robot has {there}")
    require_known(joint_names, known)
    wanted = {
        joint: angle
        for joint, angle in preset.positions.items()
        if not joint_names or joint in joint_names
    }
    if not wanted:
        raise InvalidCommand(f"joint_names: none of them is in preset {name!r}")
    return wanted


class GoalEnd(Enum):
    """How a goal ended."""

    REACHED = "reached"
    CANCELLED = "cancelled"
    ABORTED = "aborted"


@dataclass(frozen=True)
class EndedGoal:
    """A goal that has ended.

    Attributes
    ----------
    number
        Which one, as `PresetGoals.begin` had it.
    end
        How.
    message
        Why, unless it was reached.
    remaining
        Joint to its way to the preset (rad); NaN where the joint was not measured.
    """

    number: int
    end: GoalEnd
    message: str
    remaining: Dict[str, float]


@dataclass(frozen=True)
class GoalRules:
    """When a goal has been reached, and when it is given up.

    Attributes
    ----------
    tolerance
        A joint has arrived when it is so near (rad).
    stall_time
        A goal that came no nearer by `tolerance` in this time (s of sim time) is blocked.
    """

    tolerance: float
    stall_time: float


class PresetGoals:
    """The goal that is being carried out, and those that have ended since somebody looked."""

    def __init__(self, rules: GoalRules) -> None:
        self._rules = rules
        self._number: Optional[int] = None
        self._wanted: Dict[str, float] = {}
        self._remaining: Dict[str, float] = {}
        self._ended: List[EndedGoal] = []
        self._least = math.inf
        self._stalled_for = 0.0

    @property
    def wanted(self) -> Dict[str, float]:
        """Where the present goal wants its joints (rad); empty without one."""
        return self._wanted

    def begin(self, number: int, wanted: Dict[str, float]) -> None:
        """Begin a goal; one that is under way is cancelled by it."""
        self.end(GoalEnd.CANCELLED, "a newer goal took over")
        self._number = number
        self._wanted = wanted
        self._remaining = dict.fromkeys(wanted, math.nan)
        self._least = math.inf
        self._stalled_for = 0.0

    def end(self, end: GoalEnd, message: str) -> None:
        """End the present goal, if there is one."""
        if self._number is None:
            return
        self._ended.append(EndedGoal(self._number, end, message, self._remaining))
        self._number = None
        self._wanted = {}

    def cancel(self, number: int) -> None:
        """End a goal because its client wants so."""
        if number == self._number:
            self.end(GoalEnd.CANCELLED, "cancelled by its client")

    def progress(self) -> Optional[Tuple[int, Dict[str, float]]]:
        """Return the present goal's number and the ways that remain (rad); None without one."""
        return None if self._number is None else (self._number, self._remaining)

    def take_ended(self) -> List[EndedGoal]:
        """Return, once, the goals that have ended."""
        ended, self._ended = self._ended, []
        return ended

    def watch(self, dt: float, positions: Mapping[str, float], settled: Collection[str]) -> None:
        """Take what was measured after a step.

        Parameters
        ----------
        dt
            Its length (s).
        positions
            Measured positions (rad).
        settled
            Joints whose reference rests at their goal.
        """
        if self._number is None:
            return
        rules = self._rules
        self._remaining = {joint: angle - positions[joint] for joint, angle in self._wanted.items()}
        late = {joint: way for joint, way in self._remaining.items() if abs(way) > rules.tolerance}
        if not late and all(joint in settled for joint in self._wanted):
            self.end(GoalEnd.REACHED, "")
            return
        distance = sum(abs(way) for way in self._remaining.values())
        if distance < self._least - rules.tolerance:
            self._least, self._stalled_for = distance, 0.0
            return
        self._stalled_for += dt
        if self._stalled_for > rules.stall_time:
            ways = ", ".join(f"{joint} {way:+.2f} rad" for joint, way in late.items())
            self.end(
                GoalEnd.ABORTED,
                f"no progress for {rules.stall_time:g} s, something is in the way; "
                f"left: {ways or 'nothing'}",
            )


class PresetRequests:
    """The preset that is wanted now: by a key that is held, or by a goal.

    Parameters
    ----------
    command_timeout
        Age (s) at which a preset that is not repeated ends.
    rules
        Of goals.
    """

    def __init__(self, command_timeout: float, rules: GoalRules) -> None:
        self.goals = PresetGoals(rules)
        self._stream: CommandStream[Dict[str, float]] = CommandStream(command_timeout)
        self._holder = ""

    def hold(self, wanted: Dict[str, float], now: Clocks, caller: str, manual: bool) -> bool:
        """Take a preset from a key that is held; return whether it is obeyed.

        Parameters
        ----------
        wanted
            Joint to angle (rad).
        caller
            Who sent it.
        manual
            Flippers are being moved by hand: that wins, and this key needs a new press.
        """
        if manual:
            self._stream.receive(wanted, now, caller)
            self._stream.latch()
            return False
        if not self._stream.receive(wanted, now, caller):
            return False
        if self._holder != caller:
            # two keys of two operators must not take turns
            self._stream.ignore(self._holder)
            self._holder = caller
        self.goals.end(GoalEnd.ABORTED, "a preset key took over")
        return True

    def begin_goal(self, number: int, wanted: Dict[str, float]) -> None:
        """Begin a goal; keys that are held for a preset need a new press after it."""
        self._stream.latch()
        self.goals.begin(number, wanted)

    def stop(self, caller: str, reason: str) -> None:
        """Take a command to stop presets, whoever asked for them.

        It also ends the wait for the pause of `caller`; keys of others need a new press.
        """
        self._stream.end(caller)
        self._stream.latch()
        self.goals.end(GoalEnd.ABORTED, reason)

    def interrupt(self, reason: str) -> None:
        """Take a command to stop a flipper; keys that are held go on with their next message."""
        self._stream.discard()
        self.goals.end(GoalEnd.ABORTED, reason)

    def end(self, reason: str) -> None:
        """End everything; a key that goes on is ignored until it is pressed anew."""
        self._stream.latch()
        self.goals.end(GoalEnd.ABORTED, reason)

    def inhibit(self, inhibited: bool, reason: str) -> None:
        """Ignore keys while inhibited, and then those that were held meanwhile."""
        self._stream.inhibit(inhibited)
        if inhibited:
            self.goals.end(GoalEnd.ABORTED, reason)

    def wanted(self, now: Clocks) -> Dict[str, float]:
        """Return where the flippers are to go now (rad); empty for nowhere."""
        return self._stream.command(now) or self.goals.wanted

    def commanders(self, now: Clocks) -> Set[str]:
        """Return who is obeyed: the client that holds a key, `A_GOAL`, or nobody."""
        if self._stream.command(now) is not None:
            return {self._stream.obeyed}
        return {A_GOAL} if self.goals.wanted else set()

    def waiting(self, wall: float) -> bool:
        """Tell whether a key is held that needs a new press."""
        return self._stream.waiting(wall)
