"""A port to the controllers of a robot in the same process."""

from __future__ import annotations

from typing import Callable

from telex_sim.offline.robot import OfflineRobot, Pose

from ..operators.port import Command, Drive, JointTargets, Observation, Placement, Port


class OfflineControllers(Port):
    """Takes `Drive` and `JointTargets`.

    Parameters
    ----------
    advance : callable
        Lets so much sim time (s) pass.
    """

    def __init__(self, robot: OfflineRobot, advance: Callable[[float], None]) -> None:
        self._robot = robot
        self._advance = advance

    def observe(self) -> Observation:
        """See `Port.observe`."""
        robot = self._robot
        return Observation(
            time=robot.simulation.time,
            base=placement(robot.base_pose()),
            positions=robot.positions,
            velocities=robot.velocities,
        )

    def advance(self, seconds: float) -> None:
        """See `Port.advance`."""
        self._advance(seconds)

    def send(self, command: Command) -> None:
        """See `Port.send`."""
        if isinstance(command, Drive):
            self._robot.drive(command.linear, command.angular)
        elif isinstance(command, JointTargets):
            self._robot.move(command.positions)
        else:
            raise TypeError(f"the controllers take Drive and JointTargets, not {command!r}")


def placement(pose: Pose) -> Placement:
    """Return a pose as an operator sees it."""
    (x, y, z), (qx, qy, qz, qw) = pose
    return Placement((x, y, z), (qx, qy, qz, qw))
