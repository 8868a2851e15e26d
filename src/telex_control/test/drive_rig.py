"""What the tests of both drive controllers share: a controller on the bench, and its driver."""

from __future__ import annotations

from geometry_msgs.msg import Twist

from telex_control.manager.controller_manager import ControllerManager


class DriveRig:
    """The controller ``d`` of a robot whose hardware goes on by ``advance``.

    Parameters
    ----------
    bench
        The fixture of this name.
    hw
        Moves as it is commanded.
    description
        URDF.
    params
        The controller's; None leaves one out.
    """

    def __init__(self, bench, hw, description, params):
        own = {key: value for key, value in params.items() if value is not None}
        self.bench = bench({"robot_description": description, "d": own})
        self.node = self.bench.node
        self.bench.hw = self.hw = hw
        self.bench.manager = ControllerManager(self.hw, self.node)
        self.loaded = self.bench.manager.load_controller("d")
        self.command = self.node.advertise("d/cmd_vel", Twist)

    @property
    def controller(self):
        return self.bench.manager.controller("d")

    def start(self):
        assert self.loaded
        assert self.bench.switch(start=["d"])
        return self

    def send(self, linear, angular):
        message = Twist()
        message.linear.x, message.angular.z = linear, angular
        self.command.publish(message)

    def run(self, seconds):
        for _ in range(round(seconds / self.bench.period)):
            self.bench.cycle()
            self.hw.advance(self.bench.period)

    def drive(self, linear, angular, seconds):
        """Send commands at 20 Hz."""
        for _ in range(round(seconds * 20)):
            self.send(linear, angular)
            self.run(0.05)

    def listen(self, topic, kind):
        received = []
        self.node.subscribe(topic, kind, received.append)
        return received
