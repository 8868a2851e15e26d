"""Closest places of two bodies, and the state of a robot at which they are looked for."""

from __future__ import annotations

from typing import Collection, Dict, List, NamedTuple, Tuple

import pybullet

from telex_control.common.geometry.vectors import cross, difference

from ..engine.world import Body, Vector
from .geometry import Axis, Box, Motion, motion, slope, turned
from .links import Links
from .points import ClosestPoint


class Place(NamedTuple):
    """Two surfaces that are near to each other.

    Attributes
    ----------
    distance : float
        Below 0 when they are inside each other (m).
    point, normal : tuple of 3 floats
        The nearest point of the one that the arm moves (m), and the unit vector from the other
        towards it, in the frame of the robot's root link.
    gradient : tuple of float
        Derivatives of the distance by the arm's joints (m/rad, m/m).
    """

    distance: float
    point: Vector
    normal: Vector
    gradient: Tuple[float, ...]


class WatchedMoment:
    """A robot as it is now.

    Attributes
    ----------
    positions, velocities : list of float
        Of all joints of `Links`, those of the arm first.
    axes : list of Axis
        Of the arm's joints.
    """

    def __init__(self, body: Body, links: Links) -> None:
        states = pybullet.getJointStates(body.uid, links.joints, physicsClientId=body.client)
        self.positions: List[float] = [state[0] for state in states]
        self.velocities: List[float] = [state[1] for state in states]
        self.axes: List[Axis] = links.arm_axes()
        self._links = links
        self._boxes: Dict[int, Box] = {}
        self._base_centre = pybullet.getBasePositionAndOrientation(
            body.uid, physicsClientId=body.client
        )[0]
        self._base = pybullet.getBaseVelocity(body.uid, physicsClientId=body.client)
        self._origin, orientation = pybullet.invertTransform(*body.base_pose())
        self._turn = pybullet.getMatrixFromQuaternion(orientation)

    def box(self, link: int) -> Box:
        """Box around a link of the robot, along the world's axes."""
        if link not in self._boxes:
            self._boxes[link] = self._links.box(link)
        return self._boxes[link]

    def motions(self, joints: Collection[int], point: Vector) -> Dict[int, Motion]:
        """How each joint of the arm moves a point that all of them carry."""
        return {joint: motion(self.axes[joint], point, self.velocities[joint]) for joint in joints}

    def base_motion(self, point: Vector) -> Motion:
        """How the robot's base moves a point that rides on it."""
        velocity, turning = self._base
        u, v, w = cross(turning, difference(point, self._base_centre))
        return Motion((velocity[0] + u, velocity[1] + v, velocity[2] + w), turning)

    def place(self, closest: ClosestPoint, joints: Collection[int]) -> Place:
        """Make a place of closest points, of which `joints` of the arm move the first."""
        distance, point, normal = closest
        gradient = [0.0] * len(self.axes)
        for joint in joints:
            gradient[joint] = slope(self.axes[joint], point, normal)
        x, y, z = turned(self._turn, point)
        own_point = (x + self._origin[0], y + self._origin[1], z + self._origin[2])
        return Place(distance, own_point, turned(self._turn, normal), tuple(gradient))
