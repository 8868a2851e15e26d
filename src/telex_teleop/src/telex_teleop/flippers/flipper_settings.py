"""Parameters of the flippers' node, beside those of every joint node."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, Mapping, Tuple

from telex_control.common.params import Declared, number, parameter, require, required, word
from telex_teleop.flippers.presets import FlipperPreset, GoalRules
from telex_teleop.joints.joint_settings import JointTeleopSettings
from telex_teleop.motion.axis import AxisSettings


@dataclass(frozen=True)
class PresetSettings(Declared):
    """One flipper preset."""

    name: str = word(required, "What operators and scripts call it.")
    positions: Dict[str, float] = parameter(
        required, "Joint to angle (rad); joints that are not named stay where they are."
    )
    description: str = parameter("", "What it is for; shown to the operator.")

    def check(self) -> None:
        """Check what concerns several of them; see `Declared.check`."""
        require(
            self.name.replace("_", "").isalnum(),
            f"name is {self.name!r}; letters, digits and underscores are needed",
        )
        require(
            len(self.positions) > 0, "positions is empty; an angle of at least one joint is needed"
        )


@dataclass(frozen=True)
class FlipperTeleopSettings(JointTeleopSettings):
    """Parameters of the flippers' node."""

    presets: Tuple[PresetSettings, ...] = parameter((), "In the order of their keys.")
    goal_tolerance: float = number(0.01, "See `presets.GoalRules` (rad).", maximum=0.1, above=0.0)
    stall_time: float = number(2.0, "See `presets.GoalRules` (s).", above=0.0)

    def check(self) -> None:
        """Check what concerns several of them; see `Declared.check`."""
        super().check()
        names = [preset.name for preset in self.presets]
        for index, preset in enumerate(self.presets):
            require(
                preset.name not in names[:index],
                f"presets[{index}]/name is '{preset.name}' as of one before; names must differ",
            )
            for joint in preset.positions:
                require(
                    joint in self.joints,
                    f"presets[{index}]/positions/{joint} is unknown; known are "
                    f"{', '.join(self.joints)}",
                )

    def goal_rules(self) -> GoalRules:
        """Return when a goal has been reached, and when it is given up."""
        return GoalRules(self.goal_tolerance, self.stall_time)

    def preset_table(self, axes: Mapping[str, AxisSettings]) -> Dict[str, FlipperPreset]:
        """Return the presets of a robot by name, without the joints that it lacks.

        Parameters
        ----------
        axes
            Bounds of the joints that it has.

        Raises
        ------
        telex_control.common.params.ConfigError
            When a flipper cannot get where a preset wants it.
        """
        table = {}
        for index, preset in enumerate(self.presets):
            there = {joint: at for joint, at in preset.positions.items() if joint in axes}
            for joint, angle in there.items():
                motion = axes[joint].motion
                require(
                    motion.lower <= angle <= motion.upper,
                    f"presets[{index}]/positions/{joint} is {angle:g} ({preset.name}); this robot "
                    f"needs {motion.lower:g} to {motion.upper:g}",
                )
            table[preset.name] = FlipperPreset(preset.name, preset.description, there)
        return table
