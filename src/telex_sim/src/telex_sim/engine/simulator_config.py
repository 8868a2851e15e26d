"""Configuration of the simulator and of the robots in it."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any, Dict, Mapping, Optional, Tuple

from telex_control.common.params import (
    LEAST_RATE,
    Declared,
    number,
    parameter,
    read_config,
    require,
    word,
)

from ..equipment.equipment_config import EquipmentConfig
from ..gas.sensor_config import GasSensorConfig
from ..malfunctions.battery import BatteryConfig
from ..proximity.proximity_config import ProximityConfig
from ..radiation.dosimetry import DosimetryConfig
from ..radio.radio_config import RadioConfig
from ..robot.gripper.contact_config import GripperContactConfig
from ..robot.imu_noise import ImuNoise
from ..robot.self_collision import SelfCollisionConfig
from ..scene.model import MOST_FURTHER
from ..stability.force_angle import StabilityConfig
from ..tracks.track_config import TrackConfig

TUNED_PERIOD = 0.002
"""Longest control period that the shipped gains are tuned for (s)."""

_LONGEST_STEP = 0.2
"""Wall time (s) that a step may take by the pace: requests and emergency stops wait as long."""


@dataclass(frozen=True)
class TimingConfig(Declared):
    """Step, control period and pace."""

    step_size: float = number(0.002, "Sim time of one physics step (s).", 1e-5, 0.05)
    control_period: float = number(
        0.002, "Sim time between control cycles (s); a whole multiple of the step.", maximum=0.1
    )
    real_time_factor: float = number(
        1.0,
        "Sim time per wall time, such that no step takes more than 0.2 s of it; 0 runs as fast as "
        "possible.",
        0.0,
    )
    realtime_priority: int = number(
        1,
        "Of the simulator among the machine's real-time processes, where its user may "
        "have one; 0 leaves it an ordinary process (`telex_control.common.scheduling`)."
        " With PyBullet's window, or where `real_time_factor` is 0 or above 1, it "
        "always is one.",
        0,
        99,
    )

    def check(self) -> None:
        """Check what concerns several of them; see `Declared.check`."""
        ratio = self.control_period / self.step_size
        require(
            ratio > 0.5 and abs(ratio - round(ratio)) < 1e-6,
            "control_period must be a whole multiple of step_size: "
            f"got {self.control_period} s and {self.step_size} s",
        )
        least, factor = self.step_size / _LONGEST_STEP, self.real_time_factor
        require(
            factor == 0.0 or factor >= least * (1.0 - 1e-6),
            f"real_time_factor is {factor}; with a step_size of {self.step_size} s it must be 0, "
            f"for as fast as possible, or at least {least:g}",
        )

    @property
    def steps_per_cycle(self) -> int:
        """Physics steps in one control cycle."""
        return round(self.control_period / self.step_size)


@dataclass(frozen=True)
class JointHardware(Declared):
    """The drive of one joint, beyond what the URDF says.

    Towards a soft limit the effort falls, so that a drive whose soft limits lie within its range
    cannot hold a load at the ends of it.
    """

    armature: float = number(
        0.0, "Inertia of rotor and gear, seen at the joint (kg m2); a revolute joint's only.", 0.0
    )
    overtravel: float = number(
        0.0,
        "How far beyond the URDF's limits the end stops lie, and with them the soft limits"
        " (rad, m).",
        0.0,
        1.0,
    )


@dataclass(frozen=True)
class ContactConfig(Declared):
    """What the surface of a link is like where it touches something."""

    friction: Optional[float] = number(
        None,
        "Friction coefficient on a surface of friction 1; without, that of the URDF "
        "(``<gazebo>``'s mu1 and mu2), else PyBullet's 0.5.",
        0.0,
        10.0,
    )
    stiffness: Optional[float] = number(
        None,
        "Of each contact along its normal (N/m), together with `damping`. Without, wheels have "
        "those of `HardwareConfig.wheel_contact`, other links are rigid.",
        1.0,
        1.0e9,
    )
    damping: Optional[float] = number(None, "Of each contact along its normal (N s/m).", 1.0, 1.0e9)
    spinning_friction: float = number(
        0.0,
        "Against turning about the contact's normal, on a surface of friction 1: friction torque "
        "for each newton of force (m).",
        0.0,
        1.0,
    )
    friction_anchor: bool = parameter(
        False,
        "Whether friction holds what sticks where it is, as dry friction does. Without it what is "
        "held creeps, faster the lighter it is and the harder it is pressed.",
    )

    def check(self) -> None:
        """Check what concerns several of them; see `Declared.check`."""
        require(
            (self.stiffness is None) is (self.damping is None),
            f"stiffness is {self.stiffness} and damping {self.damping}; both or neither are needed",
        )


@dataclass(frozen=True)
class WheelContactConfig(Declared):
    """How a wheel gives way where it touches something: a tyre that sinks in by some millimetres.

    A stiffer one would bear now all and now nothing on ground that four wheels do not touch alike.
    """

    stiffness: float = number(3.0e4, "Of each contact along its normal (N/m).", 1.0, 1.0e9)
    damping: float = number(1.0e3, "Of each contact along its normal (N s/m).", 1.0, 1.0e9)


@dataclass(frozen=True)
class HardwareConfig(Declared):
    """The simulated drives."""

    velocity_tolerance: float = parameter(
        1.05,
        "Factor on the URDF's velocity limit at which a drive stops accelerating; above 1, so that "
        "a joint can run at its limit.",
    )
    position_gain: float = number(
        0.2,
        "Share of a position joint's error that its motor takes away in one step.",
        maximum=1.0,
        above=0.0,
    )
    joints: Dict[str, JointHardware] = parameter(dict, "By name.")
    contacts: Dict[str, ContactConfig] = parameter(
        dict, "By link; what they leave out is the URDF's, else PyBullet's."
    )
    wheel_contact: WheelContactConfig = parameter(
        WheelContactConfig, "Of wheels, see `link_surfaces.wheels`."
    )
    imus: Dict[str, str] = parameter(
        dict,
        "Inertial sensors: name, that of its topic, and the link whose motion it measures.",
    )
    imu_noise: Dict[str, ImuNoise] = parameter(
        dict, "Errors of these sensors, by name; one that is not named is exact."
    )
    optional_joints: Tuple[str, ...] = parameter(
        (),
        "Joints that a variant of the robot may lack: `joints` and named poses may name them all "
        "the same. Any other name that is not there is a mistake.",
    )
    optional_links: Tuple[str, ...] = parameter(
        (), "Links that a variant may lack, although `contacts` names them."
    )

    def check(self) -> None:
        """Check what concerns several of them; see `Declared.check`."""
        require(
            self.velocity_tolerance >= 1.0,
            f"velocity_tolerance is {self.velocity_tolerance}; 1 or more is needed",
        )
        for name in self.imu_noise:
            require(
                name in self.imus,
                f"imu_noise/{name}: there is no such sensor; imus has: "
                f"{', '.join(self.imus) or 'none'}",
            )


@dataclass(frozen=True)
class StartConfig(Declared):
    """How a robot starts."""

    place: Optional[Tuple[float, float, float, float]] = parameter(
        None,
        "Where its root link starts: x, y, z (m) and heading (rad), in the world. "
        "Without it, the scene says where.",
    )
    beside: bool = parameter(
        False,
        "Whether a further robot starts beside the scene's start, where there is room, without "
        "`place`.",
    )
    further: int = number(
        0,
        "Which of the scene's further robots it is, from 1: `beside` has no say where the scene "
        "has a start for that one. 0: by the order in which they come.",
        0,
        MOST_FURTHER,
    )
    height: float = number(
        0.115,
        "Of the root link above the scene's ground (m), without `place`; the robot "
        "settles from there.",
        0.0,
        10.0,
    )
    pose: str = parameter("", "Name of one of `poses`; empty leaves the choice to the scene.")
    default_pose: str = parameter("", "Where the scene does not choose either.")
    poses: Dict[str, Dict[str, float]] = parameter(
        dict, "Named poses: joint positions (rad, m) by joint name; joints left out start at 0."
    )

    def check(self) -> None:
        """Check what concerns several of them; see `Declared.check`."""
        for name in ("pose", "default_pose"):
            value = getattr(self, name)
            require(
                not value or value in self.poses,
                f"{name} is '{value}'; there are: {', '.join(sorted(self.poses)) or 'none'}",
            )

    def pose_name(self, of_scene: str = "") -> str:
        """Name of the pose to start in, when the scene names `of_scene`; empty for none.

        A robot without named poses is not the one that the scene's pose is for.
        """
        return self.pose or (of_scene if self.poses else "") or self.default_pose

    @property
    def looks_for_room(self) -> bool:
        """Whether a further robot's place has to be found."""
        return self.beside and self.place is None

    def joint_positions(self, of_scene: str = "") -> Dict[str, float]:
        """Joint positions of the pose to start in."""
        name = self.pose_name(of_scene)
        return self.poses[name] if name else {}


@dataclass(frozen=True)
class PublishConfig(Declared):
    """How often the simulator tells the world about itself (Hz of sim time)."""

    clock_rate: float = number(100.0, minimum=LEAST_RATE)
    poses_rate: float = number(60.0, minimum=LEAST_RATE)
    base_pose_rate: float = number(50.0, minimum=LEAST_RATE)
    stability_rate: float = number(20.0, minimum=LEAST_RATE)
    truth_rate: float = number(50.0, minimum=LEAST_RATE)


@dataclass(frozen=True)
class RobotConfig(Declared):
    """A simulated robot, beyond its URDF.

    Attributes
    ----------
    model : str
        Name in the scene; its frames are ``<model>/<link>``. Empty: the last part of its namespace.
    fixed_base : bool
        Whether the root link is fixed to the world, as one of the name ``world`` always is.
    battery : BatteryConfig, optional
        None: it has none, as what is fed by a cable.
    """

    model: str = ""
    fixed_base: bool = False
    hardware: HardwareConfig = field(default_factory=HardwareConfig)
    tracks: TrackConfig = field(default_factory=TrackConfig)
    start: StartConfig = field(default_factory=StartConfig)
    self_collision: SelfCollisionConfig = field(default_factory=SelfCollisionConfig)
    stability: StabilityConfig = field(default_factory=StabilityConfig)
    proximity: ProximityConfig = field(default_factory=ProximityConfig)
    gripper_contact: GripperContactConfig = field(default_factory=GripperContactConfig)
    dosimetry: DosimetryConfig = field(default_factory=DosimetryConfig)
    radio: RadioConfig = field(default_factory=RadioConfig)
    gas: GasSensorConfig = field(default_factory=GasSensorConfig)
    equipment: EquipmentConfig = field(default_factory=EquipmentConfig)
    battery: Optional[BatteryConfig] = None

    def check(self) -> None:
        """Check what concerns several of them; see `Declared.check`."""
        require("/" not in self.model, f"model is '{self.model}'; it must not contain '/'")


@dataclass(frozen=True)
class SimulatorConfig(RobotConfig):
    """Everything that the simulator is told, and the robot that it begins with."""

    model: str = word("telex")
    world: str = word("floor", "Name of the scene, or path of its file.")
    gui: bool = parameter(False, "Open PyBullet's window.")
    solver_iterations: int = number(50, "Of PyBullet's constraint solver.", 1, 1000)
    timing: TimingConfig = field(default_factory=TimingConfig)
    publish: PublishConfig = field(default_factory=PublishConfig)

    @property
    def realtime_priority(self) -> int:
        """Of the process, 0 where it has to be an ordinary one."""
        # PyBullet's window computes without a rest, in threads of the process. And one that is to
        # be quicker than the wall would outrun the nodes that command the robot.
        rests = 0.0 < self.timing.real_time_factor <= 1.0 and not self.gui
        return self.timing.realtime_priority if rests else 0


def read_robot_config(params: Mapping[str, Any], name: str) -> RobotConfig:
    """Make the configuration of a further robot of the parameters in its namespace.

    A file of a simulator's parameters may have been loaded there: what is the simulator's own in
    it is checked and left alone.

    Parameters
    ----------
    name : str
        Where they are, for messages.

    Raises
    ------
    ConfigError
    """
    known = {each.name for each in fields(RobotConfig)}
    if isinstance(params, Mapping) and not known.issuperset(params):
        read_simulator_config(params, name)
        params = {key: value for key, value in params.items() if key in known}
    return read_config(RobotConfig, params, name)


def read_simulator_config(params: Mapping[str, Any], name: str) -> SimulatorConfig:
    """Make the configuration of a ``simulator`` node's private parameters.

    Parameters
    ----------
    name : str
        Of the node, for messages.

    Raises
    ------
    ConfigError
    """
    own = ("paused", "global_description")
    return read_config(
        SimulatorConfig, {key: value for key, value in params.items() if key not in own}, name
    )
