"""Service calls in a thread of their own: nothing that drives a robot may wait for an answer."""

from __future__ import annotations

import threading
from typing import Any, Callable, Dict, Mapping, Tuple

import rospy

SERVICE_TIMEOUT = 2.0  # s


class Requests:
    """Calls services one after the other in a thread of their own.

    A newer request of the same kind takes the place of one that has not been called yet.

    Parameters
    ----------
    tell
        Takes a sentence for the operator after every call; an empty one when it was obeyed.
    """

    def __init__(self, tell: Callable[[str], None]) -> None:
        self._tell = tell
        self._lock = threading.Lock()
        self._waiting: Dict[str, Tuple[str, Any, Any]] = {}
        self._running = False

    def ask(self, what: str, name: str, kind: Any, wanted: Mapping[str, Any]) -> None:
        """Call a service.

        Parameters
        ----------
        what
            What the operator calls it, for messages.
        name, kind, wanted
            Of the service: its full name, its type, and the fields of its request.
        """
        with self._lock:
            self._waiting[what] = (name, kind, wanted)
            if self._running:
                return
            self._running = True
        threading.Thread(target=self._run, name="requests", daemon=True).start()

    def _run(self) -> None:
        while True:
            with self._lock:
                if not self._waiting:
                    self._running = False
                    return
                what = next(iter(self._waiting))
                name, kind, wanted = self._waiting.pop(what)
            self._call(what, name, kind, wanted)

    def _call(self, what: str, name: str, kind: Any, wanted: Mapping[str, Any]) -> None:
        try:
            rospy.wait_for_service(name, SERVICE_TIMEOUT)
            answer = rospy.ServiceProxy(name, kind)(**wanted)
        except rospy.ROSException:
            self._tell(f"{what}: no answer from {name}")
        except rospy.ServiceException as error:
            self._tell(f"{what}: {error}")
        else:
            self._tell("" if answer.success else str(answer.message))
