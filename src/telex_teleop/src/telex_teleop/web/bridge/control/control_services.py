"""The bridge's own services: who holds control, who is who, what time it is."""

from __future__ import annotations

import time
from typing import Any, Callable, Dict, Optional, Tuple

from ..protocol.operations import OperationError
from .clients import Control, Member

Arguments = Dict[str, Any]
_Answer = Callable[[Member, Arguments], Dict[str, Any]]

_TRIGGER = "std_srvs/Trigger"


def _text(arguments: Arguments, field: str) -> str:
    value = arguments.get(field, "")
    if not isinstance(value, str):
        raise OperationError(f"'{field}' must be a string")
    return value


class ControlServices:
    """Answers `bridge/...`, each client for itself; nothing here blocks.

    Parameters
    ----------
    control
        Who holds control.
    resolve
        Gives a name its global form.
    """

    def __init__(self, control: Control, resolve: Callable[[str], str]) -> None:
        self._control = control
        self._resolve = resolve
        offered: Dict[str, Tuple[str, Tuple[str, ...], _Answer]] = {
            "take_control": (_TRIGGER, (), self._take),
            "release_control": (_TRIGGER, (), self._release),
            "who_am_i": (_TRIGGER, (), lambda member, _: _done(member.id)),
            "hand_over": ("telex_msgs/HandOver", ("client",), self._hand_over),
            "set_name": ("telex_msgs/SetName", ("name",), self._set_name),
            "time": ("telex_msgs/GetWallTime", (), lambda *_: self._time()),
        }
        self._offered = {resolve(f"bridge/{name}"): entry for name, entry in offered.items()}

    @property
    def types(self) -> Dict[str, str]:
        """Types of the services, by their global names."""
        return {name: kind for name, (kind, _, _) in self._offered.items()}

    def fields_of(self, service: str) -> Optional[Tuple[str, ...]]:
        """Return the fields of a service's request, None if it is not one of these."""
        entry = self._offered.get(self._resolve(service))
        return None if entry is None else entry[1]

    def answer(self, service: str, member: Member, arguments: Arguments) -> Dict[str, Any]:
        """Answer a client's call."""
        answer = self._offered[self._resolve(service)][2]
        try:
            return answer(member, arguments)
        except OperationError as error:
            # These calls say themselves whether they succeeded.
            return {"success": False, "message": str(error)}

    def _take(self, member: Member, _: Arguments) -> Dict[str, Any]:
        self._control.take(member)
        return _done("you hold control")

    def _release(self, member: Member, _: Arguments) -> Dict[str, Any]:
        self._control.release(member)
        return _done("control is free")

    def _hand_over(self, member: Member, arguments: Arguments) -> Dict[str, Any]:
        self._control.hand_over(member, _text(arguments, "client"))
        return _done()

    def _set_name(self, member: Member, arguments: Arguments) -> Dict[str, Any]:
        self._control.rename(member, _text(arguments, "name"))
        return _done()

    def _time(self) -> Dict[str, Any]:
        secs, nsecs = divmod(time.time_ns(), 1000000000)
        return {"time": {"secs": secs, "nsecs": nsecs}}


def _done(message: str = "") -> Dict[str, Any]:
    return {"success": True, "message": message}
