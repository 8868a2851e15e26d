"""The services of a controller manager, as a program calls them that does not run it."""

from __future__ import annotations

from typing import Any, List, Sequence

import rospy
from controller_manager_msgs import msg, srv

STRICT = srv.SwitchControllerRequest.STRICT
BEST_EFFORT = srv.SwitchControllerRequest.BEST_EFFORT

_REMIND_AFTER = 5.0
"""Wall time (s) of waiting for a service after which a warning says so."""


class ControllerManagerClient:
    """Calls the services ``controller_manager/*``; each call waits until its service is there.

    Parameters
    ----------
    namespace : str
        Of the robot; relative to this node's when it does not begin with a slash.

    Raises
    ------
    rospy.ServiceException
        From every call: the manager has gone, or refused to answer.
    rospy.ROSInterruptException
        From every call: this node is shut down while it waits.
    """

    def __init__(self, namespace: str = "") -> None:
        namespace = namespace.rstrip("/")
        self.prefix = f"{namespace}/controller_manager" if namespace else "controller_manager"

    def list_controllers(self) -> List[msg.ControllerState]:
        """All loaded controllers in load order."""
        return list(self._call("list_controllers", srv.ListControllers).controller)

    def list_controller_types(self) -> List[str]:
        """Type names of controllers that can be loaded."""
        return list(self._call("list_controller_types", srv.ListControllerTypes).types)

    def load(self, name: str) -> bool:
        """Load a controller; the manager's log says why, if it fails."""
        return bool(self._call("load_controller", srv.LoadController, name).ok)

    def unload(self, name: str) -> bool:
        """Unload a controller that does not run."""
        return bool(self._call("unload_controller", srv.UnloadController, name).ok)

    def switch(self, start: Sequence[str], stop: Sequence[str], strictness: int = STRICT) -> bool:
        """Stop and start controllers in one control cycle."""
        answer = self._call(
            "switch_controller", srv.SwitchController, list(start), list(stop), strictness, False, 0
        )
        return bool(answer.ok)

    def reload_libraries(self, force_kill: bool) -> bool:
        """Import the classes of controllers anew; `force_kill` unloads all controllers first."""
        service = "reload_controller_libraries"
        return bool(self._call(service, srv.ReloadControllerLibraries, force_kill).ok)

    def _call(self, name: str, kind: Any, *arguments: Any) -> Any:
        service = f"{self.prefix}/{name}"
        try:
            rospy.wait_for_service(service, timeout=_REMIND_AFTER)
        except rospy.ROSInterruptException:
            raise
        except rospy.ROSException:
            rospy.logwarn(
                "waiting for the service %s; is the simulator running, and is this its namespace?",
                rospy.resolve_name(service),
            )
            rospy.wait_for_service(service)
        return rospy.ServiceProxy(service, kind)(*arguments)
