"""Joysticks and gamepads: the source `joy` of sensor_msgs/Joy, and `joy_teleop`, which obeys it.

`events`, `pacing`, `pads`, `maps` and `core` know neither ROS nor a device; `device` is the edge to
Linux, `source_node` and `teleop_node` are those to ROS.
"""
