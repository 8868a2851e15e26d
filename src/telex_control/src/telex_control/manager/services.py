"""The six services of the controller manager, with upstream's names and types."""

from __future__ import annotations

from typing import Any, List, Optional

import rospy
from controller_manager_msgs import msg, srv

from .controller_manager import ControllerManager


class ControllerManagerServices:
    """Offers a `ControllerManager` under ``controller_manager/`` in a robot's namespace.

    Parameters
    ----------
    namespace : str, optional
        Full name, without a slash at its end; by default the node's namespace.
    """

    def __init__(self, manager: ControllerManager, namespace: Optional[str] = None) -> None:
        self._manager = manager
        prefix = "" if namespace is None else f"{namespace}/"
        offered = {
            "list_controllers": (srv.ListControllers, self._list_controllers),
            "list_controller_types": (srv.ListControllerTypes, self._list_controller_types),
            "load_controller": (srv.LoadController, self._load_controller),
            "unload_controller": (srv.UnloadController, self._unload_controller),
            "switch_controller": (srv.SwitchController, self._switch_controller),
            "reload_controller_libraries": (srv.ReloadControllerLibraries, self._reload),
        }
        self._services: List[rospy.Service] = [
            rospy.Service(f"{prefix}controller_manager/{name}", kind, callback)
            for name, (kind, callback) in offered.items()
        ]

    def shutdown(self) -> None:
        """Take the services back, and let waiting callers return."""
        self._manager.close()
        for service in self._services:
            service.shutdown()

    def _list_controllers(self, request: Any) -> Any:
        return srv.ListControllersResponse(
            controller=[
                msg.ControllerState(
                    name=info.name,
                    state=state.value,
                    type=info.type,
                    claimed_resources=[
                        msg.HardwareInterfaceResources(
                            hardware_interface=claim.hardware_interface,
                            resources=list(claim.resources),
                        )
                        for claim in info.claimed_resources
                    ],
                )
                for info, state in self._manager.list_controllers()
            ]
        )

    def _list_controller_types(self, request: Any) -> Any:
        types = self._manager.list_controller_types()
        return srv.ListControllerTypesResponse(
            types=[name for name, _ in types], base_classes=[base for _, base in types]
        )

    def _load_controller(self, request: Any) -> Any:
        return srv.LoadControllerResponse(ok=self._manager.load_controller(request.name))

    def _unload_controller(self, request: Any) -> Any:
        return srv.UnloadControllerResponse(ok=self._manager.unload_controller(request.name))

    def _switch_controller(self, request: Any) -> Any:
        return srv.SwitchControllerResponse(
            ok=self._manager.switch_controller(
                request.start_controllers,
                request.stop_controllers,
                request.strictness,
                request.start_asap,
                request.timeout,
            )
        )

    def _reload(self, request: Any) -> Any:
        return srv.ReloadControllerLibrariesResponse(
            ok=self._manager.reload_controller_libraries(request.force_kill)
        )
