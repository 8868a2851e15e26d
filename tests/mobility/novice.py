"""A novice, who drives and holds preset keys, and moves no flipper by hand.

The presets go through the core of ``flipper_teleop`` with its shipped settings, as the node hands
them to it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict

import yaml
from sensor_msgs.msg import JointState

from telex_control.params import read_config
from telex_sim.offline import package_file
from telex_teleop.flipper_settings import FlipperTeleopSettings
from telex_teleop.flipper_teleop import FlipperTeleop
from telex_teleop.limits import limits_from_urdf

from .offline import Trial
from .scripted_operator import NotManagedError, Operator
from .stairs import SLOW, SPEED, Stairs, stand_on_landing
from .step import Step, beyond, stand_on_top

STEADY = 0.25  # m/s
_PATIENCE = 1.5
"""How long a novice looks at a robot that does not come on (s)."""


class Novice:
    """Holds one preset key at a time.

    Parameters
    ----------
    trial : Trial
        Its operator drives; the key is held at each of its looks.
    """

    def __init__(self, trial: Trial) -> None:
        self.operator: Operator = trial.operator
        settings = _settings()
        axes = settings.axes(limits_from_urdf(trial.urdf, settings.joints))
        self._core = FlipperTeleop(
            axes=axes,
            presets=settings.preset_table(axes),
            goal_rules=settings.goal_rules(),
            command_timeout=settings.command_timeout,
            longest_step=settings.longest_step,
            speed=settings.speed_scale(),
        )
        self._key = ""
        self._now = 0.0
        trial.node.subscribe("joint_states", JointState, self._on_joint_states)
        # A new node is deaf at first.
        self.operator.wait(3.0 * settings.command_timeout)

    def _on_joint_states(self, message: Any) -> None:
        self._now = message.header.stamp.to_sec()
        measured = dict(zip(message.name, message.position))
        positions = {joint: measured[joint] for joint in self._core.measured_joints}
        references = self._core.update(self._now, self._now, positions)
        self.operator.move(
            **{joint[: -len("_joint")]: angle for joint, angle in references.items()}
        )

    def hold(self, preset: str) -> None:
        """Hold a preset's key from now on; empty: let go of it."""
        if self._key and preset != self._key:
            self._core.hold_preset("", (), self._now)
        self._key = preset

    def look(self) -> None:
        """Repeat the key that is held."""
        if self._key:
            self._core.hold_preset(self._key, (), self._now)

    def until(self, reached: Any, timeout: float, what: str) -> None:
        """Go on until something is reached; see `Operator.until`."""
        self.operator.until(reached, timeout, what, self.look)

    def wait(self, seconds: float) -> None:
        """Go on for so much sim time (s)."""
        end = self.operator.time + seconds
        self.until(lambda: self.operator.time >= end, 2.0 * seconds, "the time")

    def work_on(self, reached: Any, timeout: float, what: str, *presets: str) -> None:
        """Go on with the first of some presets, and with the next where the robot hangs."""
        operator, turn = self.operator, 0
        best, since = operator.pose.x, operator.time

        def try_next() -> None:
            nonlocal best, since, turn
            if operator.pose.x > best + 0.02:
                best, since = operator.pose.x, operator.time
            elif operator.time - since > _PATIENCE:
                turn, since = turn + 1, operator.time
                self.hold(presets[turn % len(presets)])
            self.look()

        self.hold(presets[0])
        operator.until(reached, timeout, what, try_next)


def _settings() -> FlipperTeleopSettings:
    values: Dict[str, Any] = {}
    for name in ("flipper_teleop.yaml", "flipper_presets.yaml"):
        values.update(yaml.safe_load(package_file("telex_teleop", "config", name).read_text()))
    return read_config(FlipperTeleopSettings, values, "flipper_teleop")


def climb_step(novice: Novice, step: Step) -> None:
    """Climb a step of 50 cm by presets.

    Raises
    ------
    NotManagedError
    """
    operator = novice.operator
    novice.hold("approach")
    operator.keep_lane(STEADY)
    novice.until(lambda: operator.pose.rise > 0.35, 20.0, "the nose up by 20 deg")
    novice.hold("flat")
    novice.until(lambda: beyond(operator, step) > -0.15, 15.0, "the front over the edge")
    novice.work_on(
        lambda: beyond(operator, step) > 0.35 and abs(operator.pose.rise) < 0.3,
        20.0,
        "the rear up",
        "climb",
        "flat",
    )
    novice.hold("drive")
    stand_on_top(operator, step, novice.look)


def climb_stairs(novice: Novice, stairs: Stairs) -> None:
    """Climb stairs onto the landing by presets.

    Raises
    ------
    NotManagedError
    """
    operator = novice.operator
    novice.hold("approach")
    operator.keep_lane(STEADY)
    novice.until(lambda: operator.pose.rise > 0.25, 20.0, "the front on the first step")
    novice.hold("flat")
    novice.until(lambda: operator.pose.x > stairs.crest - 0.32, 40.0, "the crest")
    novice.work_on(
        lambda: operator.pose.x > stairs.crest + 0.3 and abs(operator.pose.rise) < 0.2,
        25.0,
        "over the crest",
        "climb",
        "flat",
    )
    novice.hold("drive")
    stand_on_landing(operator, stairs, novice.look)


def descend_stairs(novice: Novice, stairs: Stairs) -> None:
    """Go on from the landing down to the floor by presets.

    Raises
    ------
    NotManagedError
    """
    operator = novice.operator
    novice.hold("descend")
    operator.keep_lane(SLOW)
    novice.until(lambda: operator.pose.rise < -0.30, 25.0, "the front over the edge")
    novice.hold("flat")
    novice.until(lambda: operator.pose.x > stairs.end - 0.55, 40.0, "the last steps")
    novice.hold("approach")
    operator.keep_lane(SPEED)
    novice.until(
        lambda: operator.pose.x > stairs.end + 0.7 and abs(operator.pose.rise) < 0.15,
        15.0,
        "on the floor",
    )
    operator.stop()
    novice.wait(0.4)


@dataclass(frozen=True)
class Keypress:
    """What a preset's key did.

    Attributes
    ----------
    rate : float
        Of a flipper while the key was held (rad/s).
    coasted : float
        How far it went on after the release (rad).
    left : float
        What was left of its way (rad).
    """

    rate: float
    coasted: float
    left: float


def press_and_release(novice: Novice) -> Keypress:
    """Hold the key of a preset that is far away, and let go of it on the way."""
    operator = novice.operator

    def angle() -> float:
        return operator.joint("front_left_flipper")

    novice.hold("folded")
    novice.wait(0.6)
    before = angle()
    novice.wait(0.4)
    rate = (angle() - before) / 0.4
    novice.hold("")
    released = angle()
    novice.wait(2.0)
    coasted = angle() - released
    if abs(rate) < 0.1:
        raise NotManagedError(f"the flippers do not move with the key; {operator.where()}")
    return Keypress(rate, coasted, _settings_angle("folded") - angle())


def _settings_angle(preset: str) -> float:
    found = next(each for each in _settings().presets if each.name == preset)
    return found.positions["front_left_flipper_joint"]
