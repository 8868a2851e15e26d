"""Finding controller managers and filtering their controllers, as tools with a GUI do.

Names, arguments and results are those of upstream's module of the same name, which
rqt_controller_manager and rqt_joint_trajectory_controller use.
"""

from __future__ import annotations

from typing import Callable, Dict, Iterable, List, Optional

import rosgraph
import rospy
import rosservice
from controller_manager_msgs import msg, srv

cm_services: Dict[str, str] = {
    name: f"controller_manager_msgs/{kind}"
    for name, kind in (
        ("list_controllers", "ListControllers"),
        ("list_controller_types", "ListControllerTypes"),
        ("load_controller", "LoadController"),
        ("unload_controller", "UnloadController"),
        ("switch_controller", "SwitchController"),
        ("reload_controller_libraries", "ReloadControllerLibraries"),
    )
}
"""Names of a controller manager's services, relative to it, and their types."""

Controllers = List[msg.ControllerState]


def get_controller_managers(
    namespace: str = "/", initial_guess: Optional[List[str]] = None
) -> List[str]:
    """Find the controller managers in a namespace.

    Parameters
    ----------
    namespace : str
    initial_guess : list of str, optional
        What an earlier call returned. Of these it is only checked that they still list
        controllers, which spares the master many questions.

    Returns
    -------
    list of str
        Their namespaces, sorted; empty without a master.
    """
    candidates = _candidates(namespace)
    known = [each for each in initial_guess or () if each in candidates]
    new = [each for each in candidates if each not in known and is_controller_manager(each)]
    return sorted(known + new)


def is_controller_manager(namespace: str) -> bool:
    """Tell whether all services of a controller manager stand in a namespace, by name and type."""
    prefix = namespace.rstrip("/")
    try:
        return all(
            rosservice.get_service_type(f"{prefix}/{name}") == kind
            for name, kind in cm_services.items()
        )
    except (rosservice.ROSServiceException, rosgraph.MasterException):
        return False


def _candidates(namespace: str) -> List[str]:
    """Namespaces that list controllers: one question to the master."""
    try:
        services = rosservice.get_service_list(namespace=namespace)
    except (rosservice.ROSServiceException, rosgraph.MasterException):
        return []
    end = "/list_controllers"
    return [each[: -len(end)] or "/" for each in services if each.endswith(end)]


class ControllerManagerLister:
    """Lists the controller managers in a namespace, cheaply when it is called again and again."""

    def __init__(self, namespace: str = "/") -> None:
        self._namespace = namespace
        self._found: List[str] = []

    def __call__(self) -> List[str]:
        """Return the namespaces of the controller managers, sorted."""
        self._found = get_controller_managers(self._namespace, self._found)
        return self._found


class ControllerLister:
    """Lists the controllers of one manager over a connection that it keeps.

    Parameters
    ----------
    namespace : str
        Of the manager's services.
    """

    def __init__(self, namespace: str = "/controller_manager") -> None:
        self._service = f"{namespace}/list_controllers"
        self._proxy = self._connect()

    def _connect(self) -> rospy.ServiceProxy:
        return rospy.ServiceProxy(self._service, srv.ListControllers, persistent=True)

    def __call__(self) -> Controllers:
        """Return the controllers; none when the manager does not answer."""
        for _ in range(2):
            try:
                return list(self._proxy().controller)
            except (rospy.ServiceException, rospy.ROSException):
                # The manager may have been started anew since the last call.
                self._proxy = self._connect()
        return []


def filter_by_name(
    ctrl_list: Controllers, ctrl_name: str, match_substring: bool = False
) -> Controllers:
    """Return the controllers of this name, or whose name contains it."""
    matches = _matcher(ctrl_name, match_substring)
    return [each for each in ctrl_list if matches(each.name)]


def filter_by_type(
    ctrl_list: Controllers, ctrl_type: str, match_substring: bool = False
) -> Controllers:
    """Return the controllers of this type, or whose type contains it."""
    matches = _matcher(ctrl_type, match_substring)
    return [each for each in ctrl_list if matches(each.type)]


def filter_by_state(
    ctrl_list: Controllers, ctrl_state: str, match_substring: bool = False
) -> Controllers:
    """Return the controllers in this state, or whose state contains it."""
    matches = _matcher(ctrl_state, match_substring)
    return [each for each in ctrl_list if matches(each.state)]


def filter_by_hardware_interface(
    ctrl_list: Controllers, hardware_interface: str, match_substring: bool = False
) -> Controllers:
    """Return the controllers that use this hardware interface, or one whose name contains it."""
    matches = _matcher(hardware_interface, match_substring)
    return [
        each
        for each in ctrl_list
        if any(matches(claim.hardware_interface) for claim in each.claimed_resources)
    ]


def filter_by_resources(
    ctrl_list: Controllers,
    resources: Iterable[str],
    hardware_interface: Optional[str] = None,
    match_any: bool = False,
) -> Controllers:
    """Return the controllers that claim resources.

    Parameters
    ----------
    ctrl_list : list of ControllerState
    resources : iterable of str
    hardware_interface : str, optional
        Look only at what is claimed through it; else through any one interface.
    match_any : bool
        Whether one of `resources` suffices; else all are needed.
    """
    wanted = list(resources)
    enough = any if match_any else all
    return [
        each
        for each in ctrl_list
        if any(
            enough(resource in claim.resources for resource in wanted)
            for claim in each.claimed_resources
            if hardware_interface in (None, claim.hardware_interface)
        )
    ]


def _matcher(wanted: str, substring: bool) -> Callable[[str], bool]:
    def matches(text: str) -> bool:
        return wanted in text if substring else wanted == text

    return matches


def get_rosparam_controller_names(namespace: str = "/") -> List[str]:
    """Return the names in a namespace that may be controllers (with a ``type``), sorted."""
    prefix = f"{namespace.rstrip('/')}/"
    names = []
    for param in rospy.get_param_names():
        parts = param[len(prefix) :].split("/") if param.startswith(prefix) else []
        if len(parts) == 2 and parts[1] == "type":
            names.append(parts[0])
    return sorted(names)
