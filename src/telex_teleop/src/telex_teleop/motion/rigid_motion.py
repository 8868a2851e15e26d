"""Steps between poses; a pose is a 4x4 homogeneous transform (m)."""

from __future__ import annotations

import numpy as np

from telex_control.common.geometry.matrices import rotation_vector
from telex_control.kinematics import move_pose


def advanced(pose: np.ndarray, step: np.ndarray) -> np.ndarray:
    """Return a pose after a step.

    For steps as small as those of one control cycle it is the paper's increment, equations (2) to
    (5); the rotation vector stands for its three successive rotations, so that no order of axes is
    preferred.

    Parameters
    ----------
    pose : ndarray, shape (4, 4)
    step : ndarray, shape (6,)
        Translation (m) and rotation vector (rad) along the axes of the frame that `pose` is in.
    """
    return move_pose(pose, step.tolist(), 1.0)


def pose_error(target: np.ndarray, pose: np.ndarray) -> np.ndarray:
    """Return the step, as `advanced` takes it, that leads from a pose to a target."""
    error = np.empty(6)
    error[:3] = target[:3, 3] - pose[:3, 3]
    error[3:] = rotation_vector(target[:3, :3] @ pose[:3, :3].T)
    return error


def shortened(step: np.ndarray, longest: float, largest: float) -> np.ndarray:
    """Return a step whose translation and rotation are not longer than this (m, rad).

    The step itself, where it is not.
    """
    linear = float(np.linalg.norm(step[:3]))
    angular = float(np.linalg.norm(step[3:]))
    if linear <= longest and angular <= largest:
        return step
    made = step.copy()
    made[:3] *= min(1.0, longest / max(linear, longest))
    made[3:] *= min(1.0, largest / max(angular, largest))
    return made
