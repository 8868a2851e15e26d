"""The controllers of this package, under the type names that ros_controllers uses."""

from __future__ import annotations

import importlib
from typing import Dict, List, Type

from ..controller import Controller, ControllerInitError

TYPES: Dict[str, str] = {
    "diff_drive_controller/DiffDriveController": (
        "telex_control.controllers.diff_drive_controller.DiffDriveController"
    ),
    "effort_controllers/JointPositionController": (
        "telex_control.controllers.effort_joint_position_controller.JointPositionController"
    ),
    "joint_state_controller/JointStateController": (
        "telex_control.controllers.joint_state_controller.JointStateController"
    ),
}


def type_names() -> List[str]:
    """Type names of the controllers of this package, sorted."""
    return sorted(TYPES)


def controller_class(type_name: str) -> Type[Controller]:
    """Find a controller class.

    Parameters
    ----------
    type_name : str
        A name of `type_names`, or the Python path of a class, e.g. ``my_package.module.MyClass``.

    Raises
    ------
    ControllerInitError
        There is no such class, or it is no controller.
    """
    path = TYPES.get(type_name, type_name)
    module_name, _, class_name = path.rpartition(".")
    if not module_name:
        raise ControllerInitError(
            f"controller type '{type_name}' does not exist; "
            "Use 'rosservice call controller_manager/list_controller_types' to get the available "
            "types, or give the Python path of a class (package.module.Class)"
        )
    try:
        found = getattr(importlib.import_module(module_name), class_name)
    except (ImportError, AttributeError) as error:
        raise ControllerInitError(f"controller type '{type_name}': {error}") from error
    if not (isinstance(found, type) and issubclass(found, Controller)):
        raise ControllerInitError(
            f"controller type '{type_name}' is no subclass of telex_control.controller.Controller"
        )
    return found
