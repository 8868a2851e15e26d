"""Robot and apparatus, put to their start through the simulator's services."""

from __future__ import annotations

import threading
from typing import Any, Callable, Mapping, Optional

import rospy
from std_srvs.srv import Empty
from telex_msgs.msg import SimStatus
from telex_msgs.srv import Delete, LoadScene, Spawn

from .channels import hear_decoded

_PATIENCE = 20.0
"""Wall time that a call of the simulator may take (s); a large scene takes seconds."""
_TOLD = 3.0
"""Wall time in which the simulator's status tells of a reset (s)."""


class ApparatusError(RuntimeError):
    """The scene, the robot or an object cannot be put to the start; the message says why."""


class Apparatus:
    """Loads scenes, resets them, and draws objects anew.

    Parameters
    ----------
    on_status : callable
        Told each status of the simulator, in a thread of ROS.

    Attributes
    ----------
    busy : threading.Lock
        To be held by who loads or resets: one at a time.
    """

    def __init__(self, on_status: Callable[[SimStatus], None]) -> None:
        self._on_status = on_status
        self.busy = threading.Lock()
        self._status: Optional[SimStatus] = None
        self._news = threading.Condition()
        self._subscriber = hear_decoded("sim/status", SimStatus, self._take)

    @property
    def status(self) -> Optional[SimStatus]:
        """The simulator's newest status."""
        return self._status

    def _take(self, message: SimStatus) -> None:
        with self._news:
            self._status = message
            self._news.notify_all()
        self._on_status(message)

    def load(self, scene: str) -> int:
        """Load a scene from its text; returns the simulator's number of resets after it.

        Raises
        ------
        ApparatusError
        """
        before = self._resets()
        answer = self._call("sim/load_scene", LoadScene, world=scene)
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
                self._call("sim/spawn", Spawn, name=name, object=entry, folder=""),
            ):
                if not answer.success:
                    raise ApparatusError(answer.message)
        return resets

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

    def _call(self, service: str, kind: Any, **request: Any) -> Any:
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
        thread.join(_PATIENCE)
        if not answers:
            raise ApparatusError(
                f"{rospy.resolve_name(service)} has not answered for {_PATIENCE:g} s"
            )
        if isinstance(answers[0], Exception):
            raise ApparatusError(f"{rospy.resolve_name(service)}: {answers[0]}")
        return answers[0]

    def close(self) -> None:
        """Hear no more."""
        self._subscriber.unregister()
