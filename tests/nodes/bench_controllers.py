"""Controllers for tests of the controller manager, named by their Python path."""

from __future__ import annotations

from telex_control.hardware.hardware_interface import (
    EffortJointInterface,
    PositionJointInterface,
    VelocityJointInterface,
)
from telex_control.manager.controller import Controller

KINDS = {
    "effort": EffortJointInterface,
    "position": PositionJointInterface,
    "velocity": VelocityJointInterface,
}


class Claiming(Controller):
    """Claims what its parameter ``claims`` says: interfaces to lists of joints."""

    def init(self, hw, root, node):
        for kind, joints in node.param("claims", dict).items():
            interface = hw.get(KINDS[kind])
            for joint in joints:
                interface.get_handle(joint)

    def update(self, time, period): ...


class Failing(Claiming):
    """Raises in its third update."""

    def starting(self, time):
        self.left = 3

    def update(self, time, period):
        self.left -= 1
        if not self.left:
            raise RuntimeError("this controller is meant to fail")
