"""Core of the flippers' teleoperation: joints jogged one by one, and presets for all of them."""

from __future__ import annotations

from typing import Dict, FrozenSet, Mapping, Sequence, Set

from telex_teleop.flippers.presets import FlipperPreset, GoalEnd, GoalRules, PresetRequests, choose
from telex_teleop.joints.joint_teleop import JointTeleop
from telex_teleop.motion.axis import AxisSettings
from telex_teleop.motion.joint_jog import InvalidCommand, JogCommand
from telex_teleop.motion.speed import SpeedScale
from telex_teleop.motion.stream import Clocks


class FlipperTeleop(JointTeleop):
    """Jogs flippers, or leads them to a preset; a jog ends a preset.

    Parameters
    ----------
    axes, command_timeout, longest_step, speed
        See `JointTeleop`.
    presets
        By name.
    goal_rules
        When a goal has been reached, and when it is given up.
    """

    def __init__(
        self,
        axes: Mapping[str, AxisSettings],
        presets: Mapping[str, FlipperPreset],
        goal_rules: GoalRules,
        command_timeout: float,
        longest_step: float,
        speed: SpeedScale,
    ) -> None:
        self.presets = dict(presets)
        # before the base class, whose constructor inhibits the presets as well
        self.requests = PresetRequests(command_timeout, goal_rules)
        super().__init__(axes, command_timeout, longest_step, speed)

    @property
    def idle(self) -> bool:
        """Whether the last joint state left nothing to move, and there is no goal."""
        return super().idle and self.requests.goals.progress() is None

    def receive(self, jog: JogCommand, wall: float, caller: str = "") -> FrozenSet[str]:
        """Take a jog, which ends a preset that is under way; see `JointTeleop.receive`."""
        obeying = super().receive(jog, wall, caller)
        if obeying:
            self.requests.end("flippers were moved by hand: that takes over")
        elif any(rate == 0.0 for rate in jog.velocities.values()):
            self.requests.interrupt("stopped by an operator")
        return obeying

    def hold_preset(
        self, name: str, joint_names: Sequence[str], wall: float, caller: str = ""
    ) -> bool:
        """Take a preset from a key that is held; return whether it is obeyed.

        Parameters
        ----------
        name
            Of the preset; empty for a stop, which also ends a goal.
        joint_names
            Joints to move; empty for all.
        wall
            Time of arrival (monotonic, s).
        caller
            Who sent it; see `CommandStream`.

        Raises
        ------
        InvalidCommand
            When the preset or a joint is unknown.
        """
        if not name:
            self.requests.stop(caller, "stopped by an operator")
            return False
        wanted = choose(self.presets, name, joint_names, tuple(self.axes))
        if self._ticks.now is None:
            return False
        now = self._arrival(wall)
        manual = any(axis.commanded(now) for axis in self.axes.values())
        return self.requests.hold(wanted, now, caller, manual)

    def update(self, stamp: float, wall: float, positions: Mapping[str, float]) -> Dict[str, float]:
        """Advance to a new joint state; see `JointTeleop.update`."""
        self.end_goal_in_pause(wall)
        return super().update(stamp, wall, positions)

    def end_goal_in_pause(self, wall: float) -> None:
        """End a goal if no joint state has come for a while before `wall` (monotonic, s).

        Nobody holds a key for it: after a pause it would be motion that nobody expects.
        """
        if self._paused(wall):
            self.requests.goals.end(GoalEnd.ABORTED, "the simulation was paused")

    def begin_goal(self, number: int, name: str, joint_names: Sequence[str], wall: float) -> None:
        """Lead the flippers to a preset, without a key that is held.

        Parameters
        ----------
        number
            Names the goal in `PresetRequests.goals`.
        name, joint_names, wall
            See `hold_preset`.

        Raises
        ------
        InvalidCommand
            When the preset or a joint is unknown, or nothing is obeyed now.
        """
        wanted = choose(self.presets, name, joint_names, tuple(self.axes))
        refusal = self._inhibition(wall)
        if refusal:
            raise InvalidCommand(f"nothing is obeyed now: {refusal}")
        assert self._ticks.now is not None
        now = Clocks(wall, self._ticks.now)
        if any(axis.commanded(now) for axis in self.axes.values()):
            raise InvalidCommand("flippers are being moved by hand: that goes first")
        self.requests.begin_goal(number, wanted)

    def _references(
        self, dt: float, now: Clocks, positions: Mapping[str, float]
    ) -> Dict[str, float]:
        wanted = self.requests.wanted(now)
        references: Dict[str, float] = {}
        for name, axis in self.axes.items():
            reference = axis.update(
                dt, now, positions[name], self.speed.value, goal=wanted.get(name)
            )
            if reference is not None:
                references[name] = reference
        resting = [name for name, axis in self.axes.items() if not axis.generator.moving]
        self.requests.goals.watch(dt, positions, resting)
        return references

    def _inhibit(self) -> None:
        super()._inhibit()
        reason = "the e-stop is active" if self._e_stop else "the node has just started"
        self.requests.inhibit(self._inhibited, reason)

    def _drop(self) -> None:
        super()._drop()
        self.requests.end("the robot was put somewhere else, or out of sight")

    def _refusal(self, wall: float) -> str:
        reason = super()._refusal(wall)
        if not reason and self.requests.waiting(wall):
            reason = "the preset has ended: release its key and press it again"
        return reason

    def _commanders(self, now: Clocks) -> Set[str]:
        # Joints on their way to a preset obey it, not who jogged them before.
        return self.requests.commanders(now) or super()._commanders(now)
