"""Maps of a gamepad's controls: modes, layers and actions, read from YAML.

The file knows controls of the standard layout only (`pads.CONTROLS`), so that one description
serves every pad, and the browser's console as well as joy_teleop.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Dict, Iterator, List, Mapping, Optional, Tuple, Union

from telex_control.common.params import (
    ConfigError,
    require,
    require_choice,
    require_range,
    require_text,
)
from telex_teleop.actions.grammar import (
    AXIS_GRAMMAR,
    GRAMMAR,
    PAGE_ONLY,
    TERMINAL_ONLY,
    Action,
    Command,
    Lamps,
    Tool,
    parse_action,
    parse_axis,
)
from telex_teleop.files import FromFile
from telex_teleop.joy.pads import BUTTONS, STICKS, Pad

ARM_MODES = ("", "JOINT", "CARTESIAN")
# They belong to a screen with keys.
NOT_ON_A_PAD = (Command.HELP, *TERMINAL_ONLY, *PAGE_ONLY)


@dataclass(frozen=True)
class StickBinding:
    """What an axis of a stick does.

    Attributes
    ----------
    positive, negative
        Actions of its two ends.
    deadzone
        Share of the way out of the centre that counts as the centre.
    expo
        Share of the cubic part of the response: 0 is linear.
    scale
        Share of the full rate at the end of the way.
    """

    positive: Action
    negative: Action
    deadzone: float
    expo: float
    scale: float

    def shaped(self, value: float) -> float:
        """Return the demand, -scale to scale, of a deflection, -1 to 1."""
        way = (abs(value) - self.deadzone) / (1.0 - self.deadzone)
        if way <= 0.0:
            return 0.0
        demand = self.scale * ((1.0 - self.expo) * way + self.expo * way**3)
        return demand if value > 0.0 else -demand

    def demand(self, value: float) -> Tuple[Action, float]:
        """Return the action that a deflection stands for, and how far it is demanded."""
        shaped = self.shaped(value)
        return (self.positive if shaped > 0.0 else self.negative), abs(shaped)


@dataclass(frozen=True)
class ButtonBinding:
    """What a button or trigger does; a trigger demands the more the further it is pulled."""

    action: Action
    deadzone: float

    def demand(self, value: float) -> Tuple[Action, float]:
        """Return the action, and how far it is demanded."""
        return self.action, max(0.0, (value - self.deadzone) / (1.0 - self.deadzone))


Binding = Union[StickBinding, ButtonBinding]


@dataclass(frozen=True)
class Stick:
    """What an axis of a stick does, as the file has it; see `StickBinding`.

    Attributes
    ----------
    moves
        Text of the axis that it moves.
    scale
        Negative: the stick's positive end (right, down) is the negative one of the axis.
    deadzone, expo
        None: those of the map.
    """

    moves: str
    scale: float = 1.0
    deadzone: Optional[float] = None
    expo: Optional[float] = None

    def __post_init__(self) -> None:
        try:
            parse_axis(self.moves)
        except ValueError:
            raise ConfigError(f"moves is {self.moves!r}; it must be {AXIS_GRAMMAR}") from None
        require_range(self, "scale", -1.0, 1.0)
        require(
            abs(self.scale) >= 0.01,
            f"scale is {self.scale:g}; it must be at least 0.01, or at most -0.01",
        )
        _require_shape(self)

    def binding(self, deadzone: float, expo: float) -> StickBinding:
        """Return what it does, with what the map says where this is silent."""
        positive, negative = parse_axis(self.moves)
        if self.scale < 0.0:
            positive, negative = negative, positive
        return StickBinding(
            positive,
            negative,
            deadzone if self.deadzone is None else self.deadzone,
            expo if self.expo is None else self.expo,
            abs(self.scale),
        )


@dataclass(frozen=True)
class Layer:
    """What controls do.

    Attributes
    ----------
    sticks
        Name of a stick's axis to what it moves.
    buttons
        Name of a button to the text of its action.
    """

    sticks: Dict[str, Stick] = field(default_factory=dict)
    buttons: Dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in self.sticks:
            require(name in STICKS, f"sticks/{name} is unknown; known are {', '.join(STICKS)}")
        for name, text in self.buttons.items():
            require(name in BUTTONS, f"buttons/{name} is unknown; known are {', '.join(BUTTONS)}")
            try:
                action = parse_action(text)
            except ValueError:
                raise ConfigError(f"buttons/{name} is {text!r}; it must be {GRAMMAR}") from None
            require(
                action not in NOT_ON_A_PAD,
                f"buttons/{name} is {text!r}, which a gamepad does not have",
            )

    def actions(self) -> Iterator[Action]:
        """Return everything that a control does here."""
        for stick in self.sticks.values():
            yield from parse_axis(stick.moves)
        for text in self.buttons.values():
            yield parse_action(text)


@dataclass(frozen=True)
class PadMode:
    """A mode.

    Attributes
    ----------
    name
        What the operator calls it.
    arm_mode
        Mode that the arm is asked for with it: JOINT or CARTESIAN; empty: as it is.
    sticks, buttons
        See `Layer`; they go before what is common to all modes.
    shifted
        What controls do instead while the shift button is held.
    """

    name: str
    arm_mode: str = ""
    sticks: Dict[str, Stick] = field(default_factory=dict)
    buttons: Dict[str, str] = field(default_factory=dict)
    shifted: Layer = field(default_factory=Layer)

    def __post_init__(self) -> None:
        require_text(self, "name")
        require_choice(self, "arm_mode", ARM_MODES)
        actions = [*self.layer.actions(), *self.shifted.actions()]
        require(
            self.arm_mode == "CARTESIAN" or not any(isinstance(a, Tool) for a in actions),
            f"{self.name} moves the tool, and arm_mode is {self.arm_mode!r}; it must be CARTESIAN",
        )

    @cached_property
    def layer(self) -> Layer:
        """What the controls do while the shift button is not held."""
        return Layer(self.sticks, self.buttons)


@dataclass(frozen=True)
class JoyMap(FromFile):
    """What the controls of a gamepad do.

    Attributes
    ----------
    description
        For people.
    enable
        Button that must be held for anything to move (dead-man).
    modes
        In the order of the button with the action ``mode``; the first one is that of the start.
    common
        What controls do in every mode that says nothing else.
    shift
        Button that changes to the shifted layer while held; empty: none.
    deadzone
        Share (0 to 0.9) of a stick's or trigger's way that counts as its rest.
    expo
        Share (0 to 1) of the cubic part of a stick's response.
    """

    SHIPPED = "joy/twin_stick.yaml"

    description: str
    enable: str
    modes: Tuple[PadMode, ...]
    common: Layer = field(default_factory=Layer)
    shift: str = ""
    deadzone: float = 0.1
    expo: float = 0.3

    def __post_init__(self) -> None:
        require_choice(self, "enable", BUTTONS)
        require_choice(self, "shift", ("", *BUTTONS))
        require(self.shift != self.enable, f"shift is {self.shift!r}, as enable; they must differ")
        _require_shape(self)
        names = [mode.name for mode in self.modes]
        require(bool(names), "modes is empty; describe at least one")
        require(len(set(names)) == len(names), f"modes are {names}; their names must differ")
        for layer in self._layers():
            for button in (self.enable, self.shift):
                require(
                    button not in layer.buttons,
                    f"{button} does {layer.buttons.get(button)!r}, and is enable or shift as well",
                )
        require(
            Command.E_STOP in self.common.actions(),
            f"common/buttons: no button has the action {Command.E_STOP.value!r}",
        )
        require(
            len(names) == 1 or Command.MODE in self.common.actions(),
            f"common/buttons: no button has the action {Command.MODE.value!r}",
        )
        for mode in self.modes:
            for shifted in (False, True):
                bound = [
                    b.action
                    for b in self.bindings(mode, shifted).values()
                    if isinstance(b, ButtonBinding)
                ]
                for needed in (Command.E_STOP, *((Command.MODE,) if len(names) > 1 else ())):
                    require(
                        needed in bound,
                        f"modes: {mode.name} takes the last button from {needed.value!r}",
                    )

    def bindings(self, mode: PadMode, shifted: bool) -> Mapping[str, Binding]:
        """Return what each control does in a mode, with the shift button held or not."""
        layers = [self.common, mode.layer, *([mode.shifted] if shifted else [])]
        bound: Dict[str, Binding] = {}
        for layer in layers:
            for name, stick in layer.sticks.items():
                bound[name] = stick.binding(self.deadzone, self.expo)
            for name, text in layer.buttons.items():
                bound[name] = ButtonBinding(parse_action(text), self.deadzone)
        return bound

    @cached_property
    def lamps(self) -> Tuple[str, ...]:
        """Names of all lamps that a button switches."""
        lamps = [a for layer in self._layers() for a in layer.actions() if isinstance(a, Lamps)]
        return tuple(dict.fromkeys(name for action in lamps for name in action.names))

    @cached_property
    def actions(self) -> Tuple[Action, ...]:
        """Everything that the pad can do."""
        return tuple(dict.fromkeys(a for layer in self._layers() for a in layer.actions()))

    def require_on(self, pad: Pad) -> None:
        """Check that a pad has the controls without which nothing can be driven safely.

        Raises
        ------
        telex_control.common.params.ConfigError
            When it lacks one.
        """
        require(
            self.enable in pad.controls,
            f"{pad.description} has no {self.enable}, which the map has as enable",
        )
        for mode in self.modes:
            stops = [
                name
                for name, binding in self.bindings(mode, False).items()
                if isinstance(binding, ButtonBinding) and binding.action is Command.E_STOP
            ]
            require(
                any(name in pad.controls for name in stops),
                f"{pad.description} has no {' and no '.join(stops)}, which the map has as "
                f"{Command.E_STOP.value}",
            )

    def missing_on(self, pad: Pad) -> List[str]:
        """Return the controls that the map uses and the pad lacks."""
        used = [name for layer in self._layers() for name in (*layer.sticks, *layer.buttons)]
        used += [self.shift] if self.shift else []
        return [name for name in dict.fromkeys(used) if name not in pad.controls]

    def _layers(self) -> Iterator[Layer]:
        yield self.common
        for mode in self.modes:
            yield mode.layer
            yield mode.shifted


def _require_shape(config: object) -> None:
    require_range(config, "deadzone", 0.0, 0.9)
    require_range(config, "expo", 0.0, 1.0)
