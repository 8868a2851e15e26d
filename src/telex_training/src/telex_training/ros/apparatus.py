"""Robot, apparatus and the line to the operator, put to their start through services."""

from __future__ import annotations

import threading
from functools import partial
from typing import Any, Callable, Dict, Iterable, List, Mapping, Optional, Sequence, Set, Tuple

import rospy
import yaml
from std_srvs.srv import Empty
from telex_msgs.msg import LinkState, Malfunctions, SimStatus
from telex_msgs.srv import (
    Bookmark,
    ConfigureLink,
    Delete,
    ListBookmarks,
    LoadScene,
    Malfunction,
    Restore,
    Spawn,
)

from ..exercises.model import LINK_FIELDS, Failure, LineLink
from .channels import hear_decoded

_PATIENCE = 20.0
"""Wall time that a call of the simulator may take (s)."""
_TRYING = 70.0
"""The same of what the simulator tries first (s), for which it takes 50 s at most."""
_TOLD = 3.0
"""Wall time in which the simulator's status tells of a reset (s)."""


class ApparatusError(RuntimeError):
    """The scene, the robot or an object cannot be put to the start; the message says why."""


class Apparatus:
    """Loads scenes, resets them, draws objects anew, and goes back to bookmarks.

    Parameters
    ----------
    on_status : callable
        Told each status of the simulator, in a thread of ROS.
    others : sequence of str
        Namespaces of further robots, which have lines and malfunctions of their own.

    Attributes
    ----------
    busy : threading.Lock
        To be held by who loads or resets: one at a time.
    """

    def __init__(self, on_status: Callable[[SimStatus], None], others: Sequence[str] = ()) -> None:
        self._on_status = on_status
        self.busy = threading.Lock()
        self._status: Optional[SimStatus] = None
        self._news = threading.Condition()
        # By the robots' namespaces; that of the first is the node's own.
        self._links: Dict[str, LinkState] = {}
        self._links_before: Dict[str, LinkState] = {}
        self._possible: Dict[str, Set[Tuple[str, str]]] = {}
        self._subscribers = [
            hear_decoded("sim/status", SimStatus, self._take),
            *(
                hear_decoded(_of(each, topic), kind, partial(take, each))
                for each in ("", *others)
                for topic, kind, take in (
                    ("link/state", LinkState, self._take_link),
                    ("sim/malfunctions", Malfunctions, self._take_possible),
                )
            ),
        ]

    @property
    def status(self) -> Optional[SimStatus]:
        """The simulator's newest status."""
        return self._status

    def _take(self, message: SimStatus) -> None:
        with self._news:
            self._status = message
            self._news.notify_all()
        self._on_status(message)

    def _take_link(self, robot: str, message: LinkState) -> None:
        with self._news:
            self._links[robot] = message
            self._news.notify_all()

    def set_line(self, link: LineLink, others: Iterable[str] = ()) -> None:
        """Set the line to the operators; what it was is remembered the first time.

        Parameters
        ----------
        others : iterable of str
            Namespaces of further robots whose lines it is, too.

        Raises
        ------
        ApparatusError
            There is no bridge, or it refuses.
        """
        for robot in ("", *others):
            self._set_line(link, robot)

    def _set_line(self, link: LineLink, robot: str) -> None:
        with self._news:
            self._news.wait_for(lambda: robot in self._links, _TOLD)
            before = self._links.get(robot)
        if before is None and link == LineLink():
            return  # without a bridge there is no line
        if before is None:
            raise ApparatusError(
                f"the exercise asks for a line, of which nobody tells on {_of(robot, 'link/state')}"
                ": start the console's servers (console:=true)"
            )
        self._links_before.setdefault(robot, before)
        self._configure(robot, link.profile, link.fields)

    def restore_line(self) -> None:
        """Set all lines to what they were before `set_line`, if that was called.

        Raises
        ------
        ApparatusError
            The bridge does not answer, or refuses.
        """
        failed = []
        for robot, before in list(self._links_before.items()):
            profile = "" if before.profile == "fields" else before.profile
            try:
                self._configure(robot, profile, _own_figures(before))
            except ApparatusError as error:
                failed.append(str(error))
            else:
                del self._links_before[robot]
        if failed:
            raise ApparatusError("; ".join(failed))

    def _configure(self, robot: str, profile: str, fields: Mapping[str, float]) -> None:
        text = yaml.safe_dump(dict(fields)) if fields else ""
        service = _of(robot, "link/configure")
        answer = self._call(service, ConfigureLink, profile=profile, fields=text)
        if not answer.success:
            raise ApparatusError(f"link: {answer.message}")

    def _take_possible(self, robot: str, message: Malfunctions) -> None:
        self._possible[robot] = {(each.what, each.kind) for each in message.possible}

    def can_fail(self, failure: Failure, robot: str = "") -> bool:
        """Whether a robot has what shall fail, as far as the simulator has told; see `fail`."""
        possible = self._possible.get(robot)
        names = (failure.what, f"{failure.what}_joint")
        return not possible or any((name, failure.kind) in possible for name in names)

    def fail(self, failure: Failure, on: bool = True, robot: str = "") -> None:
        """Let something of a robot fail, or work again.

        Parameters
        ----------
        failure : Failure
        on : bool
        robot : str
            Namespace of a further one; empty: the first.

        Raises
        ------
        ApparatusError
        """
        answer = self._call(
            _of(robot, "sim/malfunction"),
            Malfunction,
            what=failure.what,
            kind=failure.kind,
            value=failure.value,
            on=on,
            announced=failure.announced,
        )
        if not answer.success:
            raise ApparatusError(answer.message)

    def load(self, scene: str) -> int:
        """Load a scene from its text; returns the simulator's number of resets after it.

        Raises
        ------
        ApparatusError
        """
        before = self._resets()
        answer = self._call("sim/load_scene", LoadScene, _TRYING, world=scene)
        if not answer.success:
            raise ApparatusError(answer.message)
        return self._reset_told(before)

    def reset(self, entries: Mapping[str, str]) -> int:
        """Put everything back, and draw objects anew; returns the simulator's number of resets.

        Parameters
        ----------
        entries : mapping of str to str
            YAML of the entries that are drawn anew, by their names.

        Raises
        ------
        ApparatusError
        """
        before = self._resets()
        self._call("sim/reset", Empty)
        resets = self._reset_told(before)
        for name, entry in entries.items():
            for answer in (
                self._call("sim/delete", Delete, name=name),
                self._call("sim/spawn", Spawn, _TRYING, name=name, object=entry, folder=""),
            ):
                if not answer.success:
                    raise ApparatusError(answer.message)
        return resets

    def bookmark(self, name: str, replaces: str) -> List[str]:
        """Set a bookmark, for which another may go; returns the names of all that there are.

        Raises
        ------
        ApparatusError
        """
        answer = self._call("sim/bookmark", Bookmark, name=name, replaces=replaces)
        if not answer.success:
            raise ApparatusError(answer.message)
        return list(answer.names)

    def bookmarks(self) -> List[str]:
        """Names of all bookmarks that there are.

        Raises
        ------
        ApparatusError
        """
        return list(self._call("sim/list_bookmarks", ListBookmarks).names)

    def back(self, name: str) -> int:
        """Go back to a bookmark; returns the simulator's number of resets.

        Raises
        ------
        ApparatusError
            It has ended, for one; nothing has changed then.
        """
        before = self._resets()
        answer = self._call("sim/restore", Restore, name=name)
        if not answer.success:
            raise ApparatusError(answer.message)
        return self._reset_told(before)

    def _resets(self) -> int:
        with self._news:
            self._news.wait_for(lambda: self._status is not None, _TOLD)
            if self._status is None:
                raise ApparatusError("the simulator tells nothing of itself on sim/status")
            return int(self._status.resets)

    def _reset_told(self, before: int) -> int:
        def told() -> bool:
            return self._status is not None and self._status.resets > before

        with self._news:
            if not self._news.wait_for(told, _TOLD):
                raise ApparatusError("the simulator does not tell of its reset on sim/status")
            assert self._status is not None
            return int(self._status.resets)

    def _call(self, service: str, kind: Any, patience: float = _PATIENCE, /, **request: Any) -> Any:
        """Call a service; one that hangs is given up, so that nothing waits for it."""
        answers: list = []

        def call() -> None:
            try:
                rospy.wait_for_service(service, timeout=_TOLD)
                answers.append(rospy.ServiceProxy(service, kind)(**request))
            except (rospy.ROSException, rospy.ServiceException) as error:
                answers.append(error)

        thread = threading.Thread(target=call, name=f"call {service}", daemon=True)
        thread.start()
        thread.join(patience)
        if not answers:
            raise ApparatusError(
                f"{rospy.resolve_name(service)} has not answered for {patience:g} s"
            )
        if isinstance(answers[0], Exception):
            raise ApparatusError(f"{rospy.resolve_name(service)}: {answers[0]}")
        return answers[0]

    def close(self) -> None:
        """Hear no more."""
        for subscriber in self._subscribers:
            subscriber.unregister()


def _own_figures(link: LinkState) -> Dict[str, float]:
    """Figures of a line that stay as they are; of one that follows the signal there are none."""
    figures = {key: float(getattr(link, key)) for key in LINK_FIELDS}
    # While nobody has told the signal nothing impairs such a line, and yet it is not perfect.
    follows = link.signal_known or not (link.perfect or any(figures.values()))
    return {} if follows else figures


def _of(robot: str, name: str) -> str:
    """Name inside the namespace of a robot; empty: the node's own."""
    return f"{robot}/{name}" if robot else name
