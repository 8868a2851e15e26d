"""Fills numba's cache, as the set-up does.

This is ``python -m telex_control.kinematics.inverse.compile``.
"""

from __future__ import annotations

from ..chain import Chain
from .solver import IKSolver

_JOINT = """
<link name="l{i}"/>
<joint name="j{i}" type="{kind}"><parent link="l{parent}"/><child link="l{i}"/>
  <origin xyz="0.1 0.05 0.2"/><axis xyz="{axis}"/>
  <limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
"""


def main() -> None:
    """Solve once on a chain with both kinds of joints, of the solver's every kernel."""
    kinds = ("revolute", "revolute", "prismatic", "revolute", "revolute", "revolute", "revolute")
    axes = ("0 0 1", "0 1 0", "1 0 0", "0 1 0", "1 0 0", "0 1 0", "1 0 0")
    parts = [
        _JOINT.format(i=i + 1, parent=i, kind=kind, axis=axis)
        for i, (kind, axis) in enumerate(zip(kinds, axes))
    ]
    urdf = f'<robot name="arm"><link name="l0"/>{"".join(parts)}</robot>'
    IKSolver(Chain.from_urdf(urdf, "l0", f"l{len(kinds)}")).warm_up()


if __name__ == "__main__":
    main()
