"""Maps of keys and gamepads, for the console in the browser and for other GUIs."""

from __future__ import annotations

from typing import Any, Awaitable, Callable, Dict, List, Mapping, Optional

from aiohttp import web

from ..actions.abilities import Abilities
from ..actions.fitting import fit
from ..actions.grammar import as_json
from ..actions.vocabulary import Vocabulary
from ..joy.maps import Binding, JoyMap, StickBinding

ACTIONS = "/actions.json"
"""Path of the vocabulary of actions, with their keys."""

JOY_MAP = "/joy_map.json"
"""Path of the map of a gamepad: the same file that joy_teleop reads."""


def add_maps(
    app: web.Application,
    actions: str,
    joy_map: str,
    ask: Callable[[web.Request], Awaitable[Optional[Abilities]]],
) -> None:
    """Serve the vocabulary of actions and the map of a gamepad, at `ACTIONS` and `JOY_MAP`.

    Parameters
    ----------
    actions, joy_map
        Paths of the files; empty: the shipped ones.
    ask
        Returns what can be done with the robot that a request is about; None: that is not known,
        and all that the file has is served.

    Raises
    ------
    telex_control.common.params.ConfigError
        When one cannot be read or is wrong.
    """
    pad = JoyMap.read(joy_map)
    vocabulary = Vocabulary.read(actions)

    async def fitted(request: web.Request) -> Dict[str, Any]:
        abilities = await ask(request)
        return (
            vocabulary.as_json() if abilities is None else fit(vocabulary, abilities, not actions)
        )

    async def same(_request: web.Request) -> Dict[str, Any]:
        return described

    described = describe(pad)
    _serve(app, ACTIONS, fitted)
    _serve(app, JOY_MAP, same)


def _serve(
    app: web.Application, address: str, tell: Callable[[web.Request], Awaitable[Dict[str, Any]]]
) -> None:
    async def answer(request: web.Request) -> web.Response:
        # as /config.json: a page of one's own may come from elsewhere
        headers = {"Access-Control-Allow-Origin": "*"}
        return web.json_response(await tell(request), headers=headers)

    app.router.add_get(address, answer)


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
        return {"action": as_json(binding.action), "deadzone": binding.deadzone}
    return {
        "positive": as_json(binding.positive),
        "negative": as_json(binding.negative),
        "deadzone": binding.deadzone,
        "expo": binding.expo,
        "scale": binding.scale,
    }
