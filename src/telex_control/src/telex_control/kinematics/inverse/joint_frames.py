"""A chain as constant transforms between its joints, every joint about or along its frame's z axis.

The form that the compiled kinematics compute with: fixed joints, origins and directions of axes are
all in the constants, T(q) = A0 Z(q0) A1 Z(q1) ... An.
"""

from __future__ import annotations

from typing import List, Tuple

import numpy as np

from telex_control.urdf.joints import PRISMATIC

from ..chain import Chain, matrix
from ..kdl_tree import kdl_frame
from ..urdf_tree import FIXED


def joint_frames(chain: Chain) -> Tuple[np.ndarray, np.ndarray]:
    """Return the constants of a chain.

    Returns
    -------
    links : ndarray, shape (n + 1, 3, 4)
        A0 to An, without their last rows (m).
    prismatic : ndarray of bool, shape (n,)
    """
    made: List[np.ndarray] = []
    prismatic: List[bool] = []
    pending = np.eye(4)
    for joint in chain.path:
        pending = pending @ matrix(kdl_frame(joint.origin))
        if joint.kind == FIXED:
            continue
        turn = np.eye(4)
        turn[:3, :3] = _z_onto(np.array(joint.axis))
        made.append(pending @ turn)
        prismatic.append(joint.kind == PRISMATIC)
        pending = turn.T
    made.append(pending)
    return np.ascontiguousarray(np.array(made)[:, :3, :]), np.array(prismatic, dtype=bool)


def _z_onto(axis: np.ndarray) -> np.ndarray:
    """Return a rotation that takes z to `axis`, a unit vector."""
    # The coordinate axis that is farthest from it makes the best conditioned basis.
    other = np.zeros(3)
    other[np.argmin(abs(axis))] = 1.0
    x = np.cross(other, axis)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(axis, x), axis])
