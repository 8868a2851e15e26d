"""One drive between the simulated hardware and PyBullet, to test its equations of motion."""

from __future__ import annotations

from telex_control.hardware import hardware_interface
from telex_control.hardware.hardware_interface import ControllerInfo, InterfaceResources
from telex_control.ros.local_node_handle import LocalNodeHandle
from telex_control.urdf.joints import parse_urdf
from telex_sim.engine.simulator_config import HardwareConfig
from telex_sim.engine.world import World
from telex_sim.robot.robot_hw_sim import RobotHWSim

STEP = 0.002


class DriveOnBench:
    """The joint ``drive`` of a robot, commanded through one interface.

    Parameters
    ----------
    urdf
        Of the robot.
    interface
        ``Effort``, ``Velocity`` or ``Position``.
    params
        On the parameter server.
    hardware
        Of the simulated drives.
    """

    position = (0.0, 0.0, 1.0)
    fixed_base = True

    def __init__(self, urdf, interface, params=None, hardware=None):
        self.urdf = urdf
        self.world = World(STEP, 50)
        self.node = LocalNodeHandle(params or {})
        self.hw = RobotHWSim(parse_urdf(urdf), hardware or HardwareConfig())
        try:
            self.hw.init(self.node, self.node)
            self.place()
        except Exception:
            self.world.close()
            raise
        claim = InterfaceResources(f"hardware_interface::{interface}JointInterface", ("drive",))
        self.hw.do_switch([ControllerInfo("test", "test", (claim,))], [])
        kind = getattr(hardware_interface, f"{interface}JointInterface")
        self.handle = self.hw.get(kind).get_handle("drive")
        self.state = self.handle.state

    def place(self):
        self.body = self.world.load_robot(
            self.urdf, str, self.position, 0.0, {}, fixed_base=self.fixed_base
        )
        self.hw.attach(self.body)

    def run(self, command, seconds):
        for _ in range(round(seconds / STEP)):
            self.hw.read(0.0, STEP)
            self.handle.command = command
            self.hw.write(0.0, STEP)
            self.world.step()
        self.hw.read(0.0, STEP)
