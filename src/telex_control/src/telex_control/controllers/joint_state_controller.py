"""``joint_state_controller/JointStateController``: publishes all joint states."""

from __future__ import annotations

from dataclasses import dataclass
from typing import List

from sensor_msgs.msg import JointState

from ..common.params import ConfigError, read_config, require_text
from ..common.periodic import Periodic
from ..hardware.hardware_interface import JointStateHandle, JointStateInterface, RobotHW
from ..manager.controller import Controller
from ..ros.node_handle import NodeHandle
from ..ros.sim_time import stamp


@dataclass(frozen=True)
class ExtraJoint:
    """A joint that the robot does not measure, published with a fixed state."""

    name: str
    position: float = 0.0
    velocity: float = 0.0
    effort: float = 0.0

    def __post_init__(self) -> None:
        require_text(self, "name")


class JointStateController(Controller):
    """Publishes ``joint_states`` in the robot's namespace.

    Parameters: ``publish_rate`` (Hz, required; 0: never), ``joints`` (names, in the order wanted;
    all by default, in alphabetical order), ``extra_joints`` (a list of {name, position, velocity,
    effort}: joints that no sensor measures).
    """

    parameters = frozenset(("extra_joints", "joints", "publish_rate"))
    SAVED_PARTS = ("_timer",)

    def init(self, hw: RobotHW, root: NodeHandle, node: NodeHandle) -> None:
        """Take the state handles; state handles claim nothing."""
        self._timer = Periodic(node.positive_param("publish_rate", zero=True))
        states = hw.get(JointStateInterface)
        names = node.param("joints", list, states.names())
        self._handles: List[JointStateHandle] = [states.get_handle(name) for name in names]
        self._extra: List[ExtraJoint] = []
        for index, params in enumerate(node.param("extra_joints", list, [])):
            full_name = f"{node.resolve('extra_joints')}[{index}]"
            try:
                extra = read_config(ExtraJoint, params, full_name)
            except ConfigError as error:
                # As upstream: the states of all others are worth more.
                node.logger.error("%s; the entry is left out", error)
                continue
            if extra.name in [*names, *(each.name for each in self._extra)]:
                node.logger.warning(
                    "parameter %s: joint '%s' has a state already; it is left out",
                    full_name,
                    extra.name,
                )
                continue
            self._extra.append(extra)
        extras = self._extra
        self._names = [handle.name for handle in self._handles] + [each.name for each in extras]
        self._extra_positions = [each.position for each in extras]
        self._extra_velocities = [each.velocity for each in extras]
        self._extra_efforts = [each.effort for each in extras]
        # The topic belongs to the robot, its life to the controller's own handle.
        self._publisher = node.advertise(root.resolve("joint_states"), JointState)

    def starting(self, time: float) -> None:
        """Publish in the first cycle."""
        self._timer.restart()

    def update(self, time: float, period: float) -> None:
        """Publish when it is due."""
        if not self._timer.is_due(time):
            return
        handles = self._handles
        message = JointState()
        message.header.stamp = stamp(time)
        message.name = self._names
        message.position = [handle.position for handle in handles] + self._extra_positions
        message.velocity = [handle.velocity for handle in handles] + self._extra_velocities
        message.effort = [handle.effort for handle in handles] + self._extra_efforts
        self._publisher.publish(message)
