"""A novice, who drives and holds preset keys, and moves no flipper by hand.

The presets go through the core of ``flipper_teleop`` with its shipped settings, as the node hands
them to it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict

from sensor_msgs.msg import JointState

from telex_control.common.file_catalog import package_yaml
from telex_control.common.params import read_config
from telex_teleop.cores import flipper_core
from telex_teleop.flippers.flipper_settings import FlipperTeleopSettings
from telex_teleop.joints.joint_settings import limits_of_present
from telex_training.operators.by_presets import PresetKeys
from telex_training.operators.port import NotManagedError

from .offline import OfflineTrial


class Novice(PresetKeys):
    """Holds one preset key at a time.

    Parameters
    ----------
    trial : OfflineTrial
        Its operator drives; the key is held at each of its looks.
    """

    def __init__(self, trial: OfflineTrial) -> None:
        super().__init__(trial.operator)
        settings = _settings()
        self._core = flipper_core(settings, limits_of_present(settings, trial.urdf)[0])
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


def _settings() -> FlipperTeleopSettings:
    values: Dict[str, Any] = {}
    for name in ("flipper_teleop.yaml", "flipper_presets.yaml"):
        values.update(package_yaml("telex_teleop", "config", name))
    return read_config(FlipperTeleopSettings, values, "flipper_teleop")


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
