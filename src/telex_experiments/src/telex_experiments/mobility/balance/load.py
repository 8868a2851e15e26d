"""A load in the gripper, held out forward."""

from __future__ import annotations

from telex_training.operators.scripted_operator import Operator

MASS = 10.0
"""kg."""

POSE = "ready"
"""Named pose to start in, from which the way to `hold_forward` is short."""

_ARM = {
    "turret": 0.0,
    "shoulder": -1.70,
    "telescope": 0.0,
    "elbow": 2.00,
    "wrist_pitch": -0.30,
}
"""Gripper level, 0.9 m before base_link and 0.7 m over it (rad, m)."""


def hold_forward(operator: Operator) -> None:
    """Bring the gripper before the hull, clear of what the flippers reach, and wait for it."""
    operator.move(**_ARM)
    operator.until(
        lambda: all(abs(operator.joint(name) - angle) < 0.02 for name, angle in _ARM.items()),
        10.0,
        "the arm forward",
    )
