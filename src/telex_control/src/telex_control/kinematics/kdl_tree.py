"""KDL trees of robots; Debian has no kdl_parser for Python."""

from __future__ import annotations

from typing import Optional

import numpy as np
import PyKDL

from telex_control.urdf.elements import Origin
from telex_control.urdf.joints import PRISMATIC

from .urdf_tree import FIXED, LinkInertia, TreeJoint, UrdfTree


def kdl_tree(tree: UrdfTree) -> PyKDL.Tree:
    """Return the KDL tree of a robot.

    Segments have the names of the links that they carry, joints those of the URDF. As in
    kdl_parser, the inertia of the root is lost: a KDL tree begins with its root's first joints.

    Returns
    -------
    PyKDL.Tree
    """
    made = PyKDL.Tree(tree.root)
    for joint in tree.joints():
        made.addSegment(_segment(joint, tree.inertials[joint.child]), joint.parent)
    return made


def _segment(joint: TreeJoint, inertial: Optional[LinkInertia]) -> PyKDL.Segment:
    frame = kdl_frame(joint.origin)
    return PyKDL.Segment(joint.child, _kdl_joint(joint, frame), frame, _rigid_body(inertial))


def _kdl_joint(joint: TreeJoint, frame: PyKDL.Frame) -> PyKDL.Joint:
    if joint.kind == FIXED:
        return PyKDL.Joint(joint.name, PyKDL.Joint.Fixed)
    # KDL wants place and direction of the axis in the parent's frame.
    kind = PyKDL.Joint.TransAxis if joint.kind == PRISMATIC else PyKDL.Joint.RotAxis
    return PyKDL.Joint(joint.name, frame.p, frame.M * PyKDL.Vector(*joint.axis), kind)


def _rigid_body(inertial: Optional[LinkInertia]) -> PyKDL.RigidBodyInertia:
    """Inertia as KDL has it: about the centre of mass, along the axes of the link's frame."""
    if inertial is None:
        return PyKDL.RigidBodyInertia()
    frame = kdl_frame(inertial.origin)
    axes = np.array([[frame.M[row, column] for column in range(3)] for row in range(3)])
    xx, yy, zz, xy, xz, yz = inertial.inertia
    turned = axes @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ axes.T
    about_centre = PyKDL.RotationalInertia(
        turned[0, 0], turned[1, 1], turned[2, 2], turned[0, 1], turned[0, 2], turned[1, 2]
    )
    return PyKDL.RigidBodyInertia(inertial.mass, frame.p, about_centre)


def kdl_frame(origin: Origin) -> PyKDL.Frame:
    """Return a URDF origin as KDL frame."""
    return PyKDL.Frame(PyKDL.Rotation.RPY(*origin.rpy), PyKDL.Vector(*origin.xyz))
