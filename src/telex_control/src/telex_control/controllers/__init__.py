"""The controllers of this package, under the type names that ros_controllers uses."""

from __future__ import annotations

import importlib
from typing import Dict, List, Type

from ..manager.controller import Controller, ControllerInitError

_MODULES: Dict[str, str] = {
    "diff_drive_controller/DiffDriveController": "diff_drive_controller.DiffDriveController",
    "effort_controllers/GripperActionController": (
        "gripper_action_controller.EffortGripperActionController"
    ),
    "effort_controllers/JointEffortController": (
        "forward_command_controllers.JointEffortController"
    ),
    "effort_controllers/JointGroupEffortController": (
        "forward_command_controllers.JointGroupEffortController"
    ),
    "effort_controllers/JointGroupPositionController": (
        "effort_joint_group_position_controller.EffortJointGroupPositionController"
    ),
    "effort_controllers/JointPositionController": (
        "effort_joint_position_controller.EffortJointPositionController"
    ),
    "effort_controllers/JointTrajectoryController": (
        "joint_trajectory_controller.EffortJointTrajectoryController"
    ),
    "effort_controllers/JointVelocityController": (
        "effort_joint_velocity_controller.EffortJointVelocityController"
    ),
    "force_torque_sensor_controller/ForceTorqueSensorController": (
        "sensor_controllers.ForceTorqueSensorController"
    ),
    "imu_sensor_controller/ImuSensorController": "sensor_controllers.ImuSensorController",
    "joint_state_controller/JointStateController": "joint_state_controller.JointStateController",
    "position_controllers/GripperActionController": (
        "gripper_action_controller.PositionGripperActionController"
    ),
    "position_controllers/JointGroupPositionController": (
        "forward_command_controllers.JointGroupPositionController"
    ),
    "position_controllers/JointPositionController": (
        "forward_command_controllers.JointPositionController"
    ),
    "position_controllers/JointTrajectoryController": (
        "joint_trajectory_controller.PositionJointTrajectoryController"
    ),
    "telex_controllers/ParallelGripperController": (
        "parallel_gripper_controller.ParallelGripperController"
    ),
    "telex_controllers/TrackedDriveController": "tracked_drive_controller.TrackedDriveController",
    "velocity_controllers/JointGroupVelocityController": (
        "forward_command_controllers.JointGroupVelocityController"
    ),
    "velocity_controllers/JointPositionController": (
        "velocity_joint_position_controller.VelocityJointPositionController"
    ),
    "velocity_controllers/JointTrajectoryController": (
        "joint_trajectory_controller.VelocityJointTrajectoryController"
    ),
    "velocity_controllers/JointVelocityController": (
        "forward_command_controllers.JointVelocityController"
    ),
}

TYPES: Dict[str, str] = {name: f"{__name__}.{path}" for name, path in _MODULES.items()}


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
        There is no such class, it cannot be imported, or it is no controller.
    """
    module_name, _, class_name = TYPES.get(type_name, type_name).rpartition(".")
    if "/" in module_name or not module_name:
        raise ControllerInitError(
            f"controller type '{type_name}' does not exist; "
            "Use 'rosservice call controller_manager/list_controller_types' to get the available "
            "types, or give the Python path of a class (package.module.Class)"
        )
    # A package that was installed after this process began is found too.
    importlib.invalidate_caches()
    try:
        module = importlib.import_module(module_name)
    except ModuleNotFoundError as error:
        missing = error.name or module_name
        if module_name == missing or module_name.startswith(f"{missing}."):
            problem = f"there is no Python module '{missing}' on this node's PYTHONPATH"
        else:
            problem = f"its module needs '{missing}', which is not there"
        raise ControllerInitError(f"controller type '{type_name}': {problem}") from error
    except (Exception, SystemExit) as error:  # whatever a user's module does when it is imported
        raise ControllerInitError(
            f"controller type '{type_name}': its module raised {type(error).__name__} when it was "
            f"imported: {error}"
        ) from error
    found = getattr(module, class_name, None)
    if found is None:
        raise ControllerInitError(
            f"controller type '{type_name}': module '{module_name}' has no class '{class_name}'"
        )
    if not (isinstance(found, type) and issubclass(found, Controller)):
        raise ControllerInitError(
            f"controller type '{type_name}' is no subclass of telex_control.controller.Controller"
        )
    return found
