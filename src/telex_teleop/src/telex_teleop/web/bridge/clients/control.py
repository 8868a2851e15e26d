"""Connected clients and control of the robot; the services `bridge/...` about it."""

from __future__ import annotations

import dataclasses
import time
from typing import Any, Callable, Dict, List, Optional, Tuple

from ...tokens import MAX_NAME
from ..protocol.operations import Arguments, OperationError

_Answer = Callable[["Member", Arguments], Dict[str, Any]]

_TRIGGER = "std_srvs/Trigger"


class ControlError(OperationError):
    """The client does not hold control and cannot have it now; the text says who does."""


@dataclasses.dataclass(eq=False)
class Member:
    """A client as others see it.

    Attributes
    ----------
    id
        Tells it from the others of this bridge.
    address
        From where it is connected.
    instructor
        It may take control from others and give it to them.
    connected_since
        Wall time (s).
    name
        What it calls itself; empty until it says so.
    dropped
        How many of its commands were not obeyed.
    stop
        Ends all motion that it commands.
    call_back
        Loses its commands under way, with the reason, and whether releases of the emergency stop
        are lost as well.
    has_under_way
        Tells whether anything that it has sent is under way.
    review
        Ends what it may not use any more.
    """

    id: str
    address: str
    instructor: bool
    connected_since: float
    name: str = ""
    dropped: int = 0
    stop: Callable[[], None] = lambda: None
    call_back: Callable[[str, bool], None] = lambda reason, releases: None
    has_under_way: Callable[[], bool] = lambda: False
    review: Callable[[], None] = lambda: None

    @property
    def shown(self) -> str:
        """Its name, as messages use it."""
        return f"{self.name} (client {self.id})" if self.name else f"client {self.id}"


class Control:
    """At most one client holds control; whoever loses it stops first.

    Parameters
    ----------
    changed
        Called when anything has changed that `members` and `holder` tell.
    """

    def __init__(self, changed: Callable[[], None] = lambda: None) -> None:
        self.changed = changed
        self.holder: Optional[Member] = None
        self._members: List[Member] = []

    @property
    def members(self) -> List[Member]:
        """All clients, in order of connection."""
        return list(self._members)

    def join(self, member: Member) -> None:
        """Take in a client."""
        self._members.append(member)
        self.changed()

    def leave(self, member: Member) -> None:
        """Forget a client; control is free if it was the one that held it."""
        self._members.remove(member)
        if self.holder is member:
            self.holder = None
        self.changed()

    def require(self, member: Member) -> None:
        """Let a client command: it holds control, or gets it because nobody does.

        Raises
        ------
        ControlError
            Another one holds control.
        """
        if self.holder is None:
            self._give(member)
        elif self.holder is not member:
            raise ControlError(
                f"{self.holder.shown} holds control; it can release it, or an instructor take it"
            )

    def take(self, member: Member) -> None:
        """Give control to a client that asks for it; raises ControlError if it cannot have it."""
        if member.instructor and self.holder is not member:
            self._withdraw(member)
            self._give(member)
        else:
            self.require(member)

    def release(self, member: Member) -> None:
        """Let a client give control up; raises ControlError if it has none."""
        if self.holder is not member:
            raise ControlError(f"{member.shown} does not hold control")
        self._give(None)

    def hand_over(self, member: Member, receiver: str) -> None:
        """Let an instructor give control to the client of an id.

        Raises
        ------
        ControlError
            Who asks is no instructor.
        OperationError
            There is no such client.
        """
        if not member.instructor:
            raise ControlError("only an instructor can hand control over")
        for other in self._members:
            if other.id == receiver:
                if self.holder is not other:
                    self._withdraw(member)
                    self._give(other)
                return
        known = ", ".join(other.id for other in self._members)
        raise OperationError(f"there is no client {receiver[:80]!r}; connected are {known}")

    def rename(self, member: Member, name: str) -> None:
        """Let a client say what to call it; raises OperationError for an unreadable name."""
        if len(name) > MAX_NAME or not name.isprintable():
            raise OperationError(
                f"a name is one line of printable text, {MAX_NAME} characters at most"
            )
        member.name = name
        self.changed()

    def count_dropped(self, member: Member) -> None:
        """Note that a command of a client was not obeyed."""
        member.dropped += 1

    def call_back(self, reason: str) -> None:
        """Lose all commands that are under way to the robot, but releases of the emergency stop.

        Whose act the reason is may not be known: an operator's release, sent after his own stop or
        his own reset, is still wanted.
        """
        for member in self._members:
            member.call_back(reason, False)

    @property
    def has_under_way(self) -> bool:
        """Whether anything that a client has sent is under way."""
        return any(member.has_under_way() for member in self._members)

    def note_e_stop(self, member: Member) -> None:
        """Lose what the others have under way when a client sets the emergency stop.

        They sent it before they could know of that. The client's own release, sent after its
        stop, is still wanted.
        """
        for other in self._members:
            if other is not member:
                other.call_back(f"{member.shown} set the emergency stop", True)

    def _withdraw(self, instructor: Member) -> None:
        """Lose the commands under way of the client from which an instructor takes control."""
        if self.holder is not None:
            self.holder.call_back(f"{instructor.shown} took control", True)

    def _give(self, member: Optional[Member]) -> None:
        if self.holder is not None:
            self.holder.stop()
        self.holder = member
        self.changed()


class ControlServices:
    """Answers `bridge/...`, each client for itself; nothing here blocks.

    Parameters
    ----------
    resolve
        Gives a name its global form.
    end_exam
        Ends the list of an exam and tells whether one ran; None where nobody can be known for an
        instructor.
    """

    def __init__(
        self,
        control: Control,
        resolve: Callable[[str], str],
        end_exam: Optional[Callable[[], bool]] = None,
    ) -> None:
        self._control = control
        self._end = end_exam
        self._resolve = resolve
        offered: Dict[str, Tuple[str, Tuple[str, ...], _Answer]] = {
            "take_control": (_TRIGGER, (), self._take),
            "release_control": (_TRIGGER, (), self._release),
            "who_am_i": (_TRIGGER, (), lambda member, _: _done(member.id)),
            "hand_over": ("telex_msgs/HandOver", ("client",), self._hand_over),
            "end_exam": (_TRIGGER, (), self._end_exam),
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

    def _end_exam(self, member: Member, _: Arguments) -> Dict[str, Any]:
        if not member.instructor or self._end is None:
            raise ControlError("only an instructor, by the token, can end an exam's list")
        return _done() if self._end() else {"success": False, "message": "no exam's list holds"}

    def _set_name(self, member: Member, arguments: Arguments) -> Dict[str, Any]:
        self._control.rename(member, _text(arguments, "name"))
        return _done()

    def _time(self) -> Dict[str, Any]:
        secs, nsecs = divmod(time.time_ns(), 1000000000)
        return {"time": {"secs": secs, "nsecs": nsecs}}


def _text(arguments: Arguments, field: str) -> str:
    value = arguments.get(field, "")
    if not isinstance(value, str):
        raise OperationError(f"'{field}' must be a string")
    return value


def _done(message: str = "") -> Dict[str, Any]:
    return {"success": True, "message": message}
