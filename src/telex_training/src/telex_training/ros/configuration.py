"""Watches what must not be reconfigured while a trial runs: cameras and controllers."""

from __future__ import annotations

import threading
from typing import Any, Callable, Dict, List, Optional

import rospy
from controller_manager_msgs.srv import ListControllers
from rospy.exceptions import ROSInternalException

_PERIOD = 1.0
"""Wall time between two looks (s)."""
CAMERAS, CONTROLLERS = "parameters of the cameras", "controllers"
_OVERVIEW = "overview"
"""Camera of instructors, which no operator sees."""

Look = Callable[[], Dict[str, Any]]
"""Returns plain data by what it configures; what cannot be read now is left out."""


class Configuration:
    """Reads the operator's cameras and the controllers of a robot.

    Whether a controller runs is not looked at: operators may switch them.

    Parameters
    ----------
    namespace : str
        The robot's, with a slash at its end; empty: this one.
    """

    def __init__(self, namespace: str = "") -> None:
        self._namespace = namespace
        self._list: Optional[rospy.ServiceProxy] = None

    def __call__(self) -> Dict[str, Any]:
        """Return parameters of the cameras, the controllers loaded, and their parameters."""
        found: Dict[str, Any] = {}
        try:
            cameras = rospy.get_param(f"{self._namespace}cameras", {})
            found[CAMERAS] = {name: cameras[name] for name in cameras if name != _OVERVIEW}
            answer = self._controllers()
        except (OSError, rospy.ROSException, rospy.ServiceException, ROSInternalException):
            # Who answers may have been started anew: the next look connects again.
            self.close()
            return found
        found[CONTROLLERS] = {each.name: each.type for each in answer.controller}
        for name in found[CONTROLLERS]:
            # The master tells of changes: after the first look this asks nobody.
            found[f"parameters of {name}"] = _cached(f"{self._namespace}{name}")
        return found

    def _controllers(self) -> Any:
        """List the controllers, over one connection for all looks: a new one costs far more."""
        if self._list is None:
            name = f"{self._namespace}controller_manager/list_controllers"
            self._list = rospy.ServiceProxy(name, ListControllers, persistent=True)
        return self._list()

    def close(self) -> None:
        """Let the connection go."""
        if self._list is not None:
            self._list.close()
        self._list = None


def _cached(name: str) -> Any:
    try:
        return rospy.get_param_cached(name, {})
    except (KeyError, OSError):
        return {}


class ConfigurationWatch:
    """Looks once a second, in a thread of its own, and tells what has changed.

    Parameters
    ----------
    tell : callable
        Told the name of what was reconfigured.
    look : callable, optional
        That of `Configuration` by default.
    period : float
        Wall time between two looks (s).
    namespace : str
        See `Configuration`.
    """

    def __init__(
        self,
        tell: Callable[[str], None],
        look: Optional[Look] = None,
        period: float = _PERIOD,
        namespace: str = "",
    ) -> None:
        self._tell, self._look, self._period = tell, look, period
        self._namespace = namespace
        self._known: Dict[str, str] = {}
        self._ended = threading.Event()
        threading.Thread(target=self._run, name="configuration", daemon=True).start()

    def _run(self) -> None:
        configuration = Configuration(self._namespace)
        look = self._look or configuration
        while not self._ended.is_set():
            for name in self.changed(look()):
                self._tell(name)
            self._ended.wait(self._period)
        configuration.close()

    def changed(self, found: Dict[str, Any]) -> List[str]:
        """Return the names of what is not as it was seen last; what is new has not changed."""
        # As text, for what the cache returns is changed in place.
        now = {name: repr(_sorted(content)) for name, content in found.items()}
        changes = [name for name, text in now.items() if self._known.get(name, text) != text]
        self._known.update(now)
        return changes

    def close(self) -> None:
        """Look no longer."""
        self._ended.set()


def _sorted(content: Any) -> Any:
    if isinstance(content, dict):
        return [(key, _sorted(content[key])) for key in sorted(content)]
    return [_sorted(each) for each in content] if isinstance(content, list) else content
