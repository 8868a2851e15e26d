"""Main function of the node joy."""

from __future__ import annotations

from typing import List

import rospy
from rospy.core import is_shutdown_requested
from sensor_msgs.msg import Joy
from std_msgs.msg import String

from telex_control.common.params import ConfigError
from telex_control.ros.node_start import init_node, until_shutdown
from telex_teleop.joy.device import find_joystick
from telex_teleop.joy.source import JoySettings, JoySource
from telex_teleop.ros.common import private_settings

DEVICE_TOPIC = "joy_device"


def joy_main() -> int:
    """Publish a joystick's state until the node is shut down.

    Returns
    -------
    int
        Exit status: 1 when its parameters are wrong.
    """
    init_node("joy", prompt=True)
    try:
        settings = private_settings(JoySettings)
    except ConfigError as error:
        rospy.logfatal(f"{rospy.get_name()} cannot start: {error}")
        return 1
    states = rospy.Publisher("joy", Joy, queue_size=1, tcp_nodelay=True)
    device = rospy.Publisher(DEVICE_TOPIC, String, queue_size=1, latch=True)

    def publish(path: str, axes: List[float], buttons: List[int]) -> None:
        message = Joy(axes=axes, buttons=buttons)
        message.header.stamp = rospy.Time.now()
        message.header.frame_id = path
        states.publish(message)

    def announce(name: str) -> None:
        device.publish(String(name))
        if name:
            rospy.loginfo(f"joystick: {name}")
        else:
            rospy.logwarn("joystick: gone")

    source = JoySource(
        settings,
        lambda: find_joystick(settings.dev, settings.dev_name),
        publish,
        announce,
        lambda why: rospy.logwarn(f"{why}; looked for again every {settings.retry_period:g} s"),
    )
    with until_shutdown():
        source.run(lambda: rospy.is_shutdown() or is_shutdown_requested())
    return 0
