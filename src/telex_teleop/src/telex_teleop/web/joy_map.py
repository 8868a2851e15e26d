"""The map of a gamepad for the console in the browser: the same file that joy_teleop reads."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any, Dict, List, Mapping

from aiohttp import web

from ..joy.files import shipped_file
from ..joy.maps import Binding, JoyMap, StickBinding
from ..operating.actions import (
    TOOL_AXES,
    Action,
    Command,
    Drive,
    Jog,
    Lamps,
    Preset,
    Side,
    Tool,
    ToPose,
    Zoom,
)

ADDRESS = "/joy_map.json"
"""Where the map is served."""

_KINDS = {
    Jog: "jog",
    Drive: "drive",
    Side: "side",
    Preset: "preset",
    Tool: "tool",
    ToPose: "pose",
    Zoom: "zoom",
    Lamps: "lamps",
}


def add_joy_map(app: web.Application, path: str) -> None:
    """Serve the map of a file at `ADDRESS`.

    Parameters
    ----------
    app
    path
        Of the file; empty: the shipped one.

    Raises
    ------
    telex_control.common.params.ConfigError
        When it cannot be read or is wrong.
    """
    described = describe(JoyMap.read(path or shipped_file("twin_stick.yaml")))

    async def answer(_request: web.Request) -> web.Response:
        return web.json_response(described)

    app.router.add_get(ADDRESS, answer)


def describe(joy_map: JoyMap) -> Dict[str, Any]:
    """Return a map as JSON has it: for each mode what every control does, without and with shift.

    Returns
    -------
    dict
        ``enable``, ``shift`` (names of buttons) and ``modes``: ``name``, ``arm_mode``, ``plain``
        and ``shifted``, each from the name of a control to ``deadzone`` and either ``action`` (of
        a button) or ``positive``, ``negative``, ``expo`` and ``scale`` (of a stick's axis).
    """
    modes: List[Dict[str, Any]] = [
        {
            "name": mode.name,
            "arm_mode": mode.arm_mode,
            "plain": _layer(joy_map.bindings(mode, False)),
            "shifted": _layer(joy_map.bindings(mode, True)),
        }
        for mode in joy_map.modes
    ]
    return {"enable": joy_map.enable, "shift": joy_map.shift, "modes": modes}


def _layer(bindings: Mapping[str, Binding]) -> Dict[str, Any]:
    return {name: _binding(binding) for name, binding in bindings.items()}


def _binding(binding: Binding) -> Dict[str, Any]:
    if not isinstance(binding, StickBinding):
        return {"action": describe_action(binding.action), "deadzone": binding.deadzone}
    return {
        "positive": describe_action(binding.positive),
        "negative": describe_action(binding.negative),
        "deadzone": binding.deadzone,
        "expo": binding.expo,
        "scale": binding.scale,
    }


def describe_action(action: Action) -> Dict[str, Any]:
    """Return an action as JSON has it: its ``kind`` and what it moves."""
    if isinstance(action, Command):
        return {"kind": "command", "name": action.value}
    values = asdict(action)
    if isinstance(action, Tool):
        values["axis"] = TOOL_AXES[action.axis]
    return {"kind": _KINDS[type(action)], **values}
