"""A controller of a user's own, named by its Python path in the parameter ``type``."""

from std_msgs.msg import Float64

from telex_control.hardware.hardware_interface import EffortJointInterface
from telex_control.manager.controller import Controller


class SpringController(Controller):
    """Pulls a joint to ``command`` (rad) like a spring of ``stiffness`` (Nm/rad)."""

    parameters = frozenset(("joint", "stiffness"))

    def init(self, hw, root, node):
        self.joint = hw.get(EffortJointInterface).get_handle(node.param("joint", str))
        self.stiffness = node.positive_param("stiffness", 10.0)
        self.target = 0.0
        node.subscribe("command", Float64, self.on_command)

    def on_command(self, message):  # in another thread: it only stores
        self.target = message.data

    def starting(self, time):
        self.target = self.joint.state.position

    def update(self, time, period):
        self.joint.command = self.stiffness * (self.target - self.joint.state.position)

    def stopping(self, time):
        self.joint.command = 0.0
