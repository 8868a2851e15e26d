"""Small robots on wheels of others' kinds: what their wheels bear, and how they turn.

Four driven wheels that skid (of Husky's size), and two driven ones between two swivel casters.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Dict, Sequence, Tuple

import numpy as np
from geometry_msgs.msg import Twist

from telex_control.common.geometry.quaternions import yaw_of
from telex_experiments.rigs.offline_rig import OfflineRig

from . import quasi_static
from .bearing import Bearing, ground_objects, springs, touched

_TICK = 0.04
_INERTIA = '<inertia ixx="{0}" iyy="{0}" izz="{0}" ixy="0" ixz="0" iyz="0"/>'


@dataclass(frozen=True)
class Wheel:
    """A wheel of a robot.

    Attributes
    ----------
    x, y : float
        Of its axle in base_link, or of its swivel's axis (m).
    radius : float
        m.
    trail : float
        Of a swivel caster (m); 0 for a wheel that is driven.
    """

    name: str
    x: float
    y: float
    radius: float
    trail: float = 0.0


@dataclass(frozen=True)
class WheeledRobot:
    """A robot on wheels.

    Attributes
    ----------
    mass : float
        Of the hull (kg).
    center : sequence of 3 floats
        Of the hull's mass, in base_link (m), which is at the height of the driven axles.
    multiplier : float
        Of the distance of the wheels, as in diff_drive_controller.
    """

    wheels: Sequence[Wheel]
    mass: float
    center: Sequence[float]
    multiplier: float = 1.0

    @property
    def driven(self) -> Sequence[Wheel]:
        """Wheels with a motor."""
        return [wheel for wheel in self.wheels if not wheel.trail]

    @property
    def urdf(self) -> str:
        """Its description."""
        x, y, z = self.center
        parts = "".join(self._driven(w) if not w.trail else self._caster(w) for w in self.wheels)
        return f"""<robot name="wheeled"><link name="base_link"><inertial>
          <origin xyz="{x} {y} {z}"/><mass value="{self.mass}"/>{_INERTIA.format(0.05 * self.mass)}
          </inertial></link>{parts}</robot>"""

    def _driven(self, wheel: Wheel) -> str:
        name = wheel.name
        return f"""{_rolling(wheel, "base_link", wheel.x, wheel.y, 0.0)}
          <transmission name="{name}_drive"><type>transmission_interface/SimpleTransmission</type>
          <joint name="{name}"><hardwareInterface>hardware_interface/VelocityJointInterface
          </hardwareInterface></joint>
          <actuator name="{name}_motor"><mechanicalReduction>1</mechanicalReduction></actuator>
          </transmission>"""

    def _caster(self, wheel: Wheel) -> str:
        name, drop = wheel.name, self.driven[0].radius - wheel.radius
        return f"""<link name="{name}_fork"><inertial><mass value="0.3"/>{_INERTIA.format(0.001)}
          </inertial></link>
          <joint name="{name}_swivel" type="continuous"><parent link="base_link"/>
          <child link="{name}_fork"/><origin xyz="{wheel.x} {wheel.y} {-drop}"/>
          <axis xyz="0 0 1"/></joint>{_rolling(wheel, f"{name}_fork", -wheel.trail, 0.0, 0.0)}"""


def _rolling(wheel: Wheel, parent: str, x: float, y: float, z: float) -> str:
    """A link that rolls (m, in its parent), 1 kg for each 6 cm of its radius."""
    name, mass = wheel.name, wheel.radius / 0.06
    return f"""<link name="{name}_link"><inertial><mass value="{mass}"/>
      {_INERTIA.format(0.5 * mass * wheel.radius**2)}</inertial><collision>
      <origin rpy="{0.5 * math.pi} 0 0"/><geometry>
      <cylinder radius="{wheel.radius}" length="{0.4 * wheel.radius}"/></geometry>
      </collision></link>
      <joint name="{name}" type="continuous"><parent link="{parent}"/><child link="{name}_link"/>
      <origin xyz="{x} {y} {z}"/><axis xyz="0 1 0"/></joint>"""


SKID_STEER = WheeledRobot(
    [
        Wheel(f"{end}_{side}", along * 0.256, across * 0.285, 0.165)
        for end, along in (("front", 1), ("rear", -1))
        for side, across in (("left", 1), ("right", -1))
    ],
    mass=46.0,
    center=(0.0, 0.0, 0.06),
    multiplier=1.875,
)
CASTERS = WheeledRobot(
    [
        Wheel("left", 0.0, 0.2, 0.1),
        Wheel("right", 0.0, -0.2, 0.1),
        Wheel("front_caster", 0.2, 0.0, 0.05, trail=0.03),
        Wheel("rear_caster", -0.2, 0.0, 0.05, trail=0.03),
    ],
    mass=25.0,
    center=(0.02, 0.01, 0.1),
)
ROBOTS = {"skid steer": SKID_STEER, "casters": CASTERS}


@dataclass(frozen=True)
class WheeledTurn:
    """A turn in place.

    Attributes
    ----------
    turned : float
        How far it came (rad).
    theory : float
        How far statics say that its wheels bring it (rad).
    farthest : float
        base_link, from where it was (m).
    """

    turned: float
    theory: float
    farthest: float


class Wheeled(OfflineRig):
    """A robot on wheels that has come to rest; close it when done.

    Parameters
    ----------
    ground : str
        Of `bearing.GROUNDS` without the slope: a diff drive has no brakes.
    step_size : float
        Of the physics (s).
    """

    def __init__(
        self, robot: WheeledRobot, ground: str = "plane", step_size: float = 0.002
    ) -> None:
        self._robot, self._ground = robot, ground
        radius = robot.driven[0].radius
        sides = {
            f"{side}_wheel": [wheel.name for wheel in robot.driven if side in wheel.name]
            for side in ("left", "right")
        }
        self._gauge = 2.0 * abs(robot.driven[0].y)
        base = {
            "type": "diff_drive_controller/DiffDriveController",
            **sides,
            "wheel_separation": self._gauge,
            "wheel_separation_multiplier": robot.multiplier,
            "wheel_radius": radius,
            "pose_covariance_diagonal": [0.001] * 6,
            "twist_covariance_diagonal": [0.001] * 6,
        }
        own: Dict[str, Any] = {
            name: {}
            for name in ("tracks", "hardware", "self_collision", "proximity", "gripper_contact")
        }
        height = radius + (0.02 if ground == "edge" else 0.0)
        super().__init__(
            {"objects": ground_objects(ground)},
            robot.urdf,
            {"controller_groups": {"actions": []}, "base": base},
            step_size,
            start={"place": (0.0, 0.0, height, 0.0)},
            timing__control_period=max(0.002, step_size),
            **own,
        )
        self._command = self.offline.node.advertise("base/cmd_vel", Twist)
        self.wait(1.5)

    def at_rest(self) -> Bearing:
        """Loads of the wheels at rest, over the weight, beside equal springs in their contacts."""
        spots, loads = self._springs()
        steps, found = 250, np.zeros(len(self._robot.wheels))
        for _ in range(steps):
            self.simulation.step()
            found += self._by_wheel(*touched(self.simulation))
        total = loads.sum()
        return Bearing(found / steps / total, self._by_wheel(spots, loads) / total)

    def _by_wheel(self, spots: np.ndarray, loads: np.ndarray) -> np.ndarray:
        places = np.array([(wheel.x, wheel.y) for wheel in self._robot.wheels])
        found = np.zeros(len(places))
        for spot, load in zip(spots, loads):
            found[np.linalg.norm(places - spot[:2], axis=1).argmin()] += load
        return found

    def drive(self, linear: float, angular: float, seconds: float) -> Tuple[float, float]:
        """Drive at speeds (m/s, rad/s), then stop.

        Returns
        -------
        turned : float
            rad.
        farthest : float
            base_link, from where it was (m).
        """
        message = Twist()
        message.linear.x, message.angular.z = linear, angular
        body = self.simulation.body
        begin, turned, farthest, last = np.array(body.base_pose()[0]), 0.0, 0.0, self._heading()
        for _ in range(round(seconds / _TICK)):
            self._command.publish(message)
            self.wait(_TICK)
            heading = self._heading()
            turned, last = turned + math.remainder(heading - last, math.tau), heading
            way = float(np.linalg.norm((np.array(body.base_pose()[0]) - begin)[:2]))
            farthest = max(farthest, way)
        self._command.publish(Twist())
        self.wait(0.6)
        return turned, farthest

    def _heading(self) -> float:
        return yaw_of(self.simulation.body.base_pose()[1])

    def turn(self, rate: float, seconds: float) -> WheeledTurn:
        """Turn in place at a rate (rad/s) that its controller is told."""
        rim = 0.5 * self._gauge * self._robot.multiplier * rate
        # Of its rim over its yaw rate: on casters, a wheel runs on a circle round base_link.
        gain = 0.5 * self._gauge
        if len(self._robot.driven) == len(self._robot.wheels):
            gain = quasi_static.turning(*self._springs(), 1.0, 1.0).belts
        turned, farthest = self.drive(0.0, rate, seconds)
        return WheeledTurn(turned, rim / gain * seconds, farthest)

    def _springs(self) -> Tuple[np.ndarray, np.ndarray]:
        """Places of its contacts, in base_link (n, 3), and loads of equal springs there (N)."""
        spots, _ = touched(self.simulation)
        stiffness = self.simulation.config.hardware.wheel_contact.stiffness
        return spots, springs(self.simulation, spots, stiffness, self._ground)
