"""What the tests of the arm share: a gantry whose kinematics are plain, and its teleoperation."""

from __future__ import annotations

import math

import numpy as np

from telex_control.kinematics import make_pose, quaternion_of
from telex_teleop.arm.arm_teleop import ArmTeleop, Carrier
from telex_teleop.arm.base_pose import BasePose
from telex_teleop.arm.proximity import ProximityGuard, ProximitySettings
from telex_teleop.arm.tool_command import FrameNames
from telex_teleop.arm.tool_motion import ToolMotion
from telex_teleop.arm.tool_settings import ToolSettings
from telex_teleop.motion.axis import AxisSettings
from telex_teleop.motion.reference import MotionLimits
from telex_teleop.motion.rigid_motion import advanced
from telex_teleop.motion.speed import SpeedScale

TICK = 0.01
JOINTS = ("x", "y", "z", "yaw", "pitch", "roll")
FRAMES = FrameNames("tool", "base", "world", "tool")
SETTINGS = ToolSettings(max_linear=0.2, max_angular=0.8)
LINEAR = MotionLimits(-1.0, 1.0, 0.5, 2.0, 0.1, 0.005)
ANGULAR = MotionLimits(-1.4, 1.4, 1.5, 6.0, 0.35, 0.02)
LIMITS = (LINEAR,) * 3 + (ANGULAR,) * 3
POSES = {"home": (0.0,) * 6, "side": (0.4, -0.2, 0.1, 0.6, 0.0, 0.0)}


class Gantry:
    """Slides along x, y, z; then turns about z, y, x: inverse kinematics in closed form."""

    def __init__(self, limits=LIMITS):
        self.velocities = np.array([each.max_velocity for each in limits])
        self.lower = np.array([each.lower for each in limits])
        self.upper = np.array([each.upper for each in limits])

    def forward(self, positions):
        x, y, z, yaw, pitch, roll = positions
        (a, b, c), (d, e, f) = (
            [function(angle) for angle in (yaw, pitch, roll)] for function in (math.cos, math.sin)
        )
        return np.array(
            [
                [a * b, a * e * f - d * c, a * e * c + d * f, x],
                [d * b, d * e * f + a * c, d * e * c - a * f, y],
                [-e, b * f, b * c, z],
                [0.0, 0.0, 0.0, 1.0],
            ]
        )

    def jacobian(self, positions):
        yaw, pitch = positions[3:5]
        jacobian = np.zeros((6, 6))
        jacobian[:3, :3] = np.eye(3)
        jacobian[3:, 3] = 0.0, 0.0, 1.0
        jacobian[3:, 4] = -math.sin(yaw), math.cos(yaw), 0.0
        jacobian[3:, 5] = (
            math.cos(yaw) * math.cos(pitch),
            math.sin(yaw) * math.cos(pitch),
            -math.sin(pitch),
        )
        return jacobian

    def track(self, target, q, dt, lower, upper):
        r = target[:3, :3]
        pitch = math.asin(max(-1.0, min(1.0, -r[2, 0])))
        turned = [math.atan2(r[1, 0], r[0, 0]), pitch, math.atan2(r[2, 1], r[2, 2])]
        wanted = np.array([*target[:3, 3], *turned])
        reach = self.velocities * dt
        box = np.clip(wanted, q - reach, q + reach)
        return np.clip(box, np.maximum(lower, self.lower), np.minimum(upper, self.upper))


def tool_motion(settings=SETTINGS, limits=LIMITS):
    return ToolMotion(JOINTS, limits, (True,) * 3 + (False,) * 3, Gantry(limits), settings)


def twist(frame, *rates):
    return FRAMES.twist(frame, rates[:3], rates[3:] or (0.0, 0.0, 0.0))


def pose(frame, position, turn=(0.0, 0.0, 0.0)):
    """Pose command with the orientation of a rotation vector."""
    turned = advanced(np.eye(4), np.array([0.0, 0.0, 0.0, *turn]))
    return FRAMES.pose(frame, position, quaternion_of(turned).tolist())


def base_at(x=0.0, y=0.0, z=0.0, yaw=0.0):
    return make_pose((x, y, z), (0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)))


class Rig:
    """An `ArmTeleop` whose joints are always where their references are."""

    def __init__(self, poses=POSES, proximity=None, attach=True, **positions):
        axes = {name: AxisSettings(limits, 0.5) for name, limits in zip(JOINTS, LIMITS)}
        axes["camera"] = AxisSettings(ANGULAR, 0.5)
        self.guard = ProximityGuard(proximity or ProximitySettings())
        self.base = BasePose(0.25)
        self.core = ArmTeleop(
            axes, Carrier(JOINTS, poses), 0.28, 0.5, SpeedScale(), self.guard, self.base
        )
        if attach:
            self.core.attach(tool_motion())
        self.time = 10.0
        self.positions = {**dict.fromkeys(axes, 0.0), **positions}
        self.history = [dict(self.positions)]
        self.sent = {}
        self.run(0.7)  # it is deaf at first

    def run(self, duration, command=None, caller="/operator", each=None):
        """Go on for a while (s), with a command repeated at every joint state."""
        for _ in range(round(duration / TICK)):
            self.time = round(self.time + TICK, 6)
            if each is not None:
                each(self.time)
            if isinstance(command, str):
                self.core.receive_pose_name(command, self.time, caller)
            elif hasattr(command, "velocities"):
                self.core.receive(command, self.time, caller)
            elif command is not None:
                self.core.receive_tool(command, self.time, caller)
            self.sent = self.core.update(self.time, self.time, dict(self.positions))
            self.positions.update(self.sent)
            self.history.append(dict(self.positions))

    def cartesian(self):
        self.core.set_mode("CARTESIAN")
        return self

    @property
    def q(self):
        return np.array([self.positions[joint] for joint in JOINTS])

    @property
    def pose(self):
        return Gantry().forward(self.q)

    def state(self):
        return self.core.state(self.time)

    def path(self, since=0):
        """Positions of all joints over time, shape (ticks, joints)."""
        return np.array([[each[joint] for joint in JOINTS] for each in self.history[since:]])

    def check_limits(self):
        """Assert that no joint was ever faster, or changed its speed faster, than it may."""
        velocity = np.diff(self.path(), axis=0) / TICK
        acceleration = np.diff(velocity, axis=0) / TICK
        for index, limits in enumerate(LIMITS):
            assert np.abs(velocity[:, index]).max() <= limits.max_velocity * (1 + 1e-9)
            assert np.abs(acceleration[:, index]).max() <= limits.max_acceleration * (1 + 1e-6)
            assert self.path()[:, index].min() >= limits.lower - 1e-12
            assert self.path()[:, index].max() <= limits.upper + 1e-12
