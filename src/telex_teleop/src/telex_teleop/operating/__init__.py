"""Common parts of the input devices: actions, their commands, and the robot's ROS edge.

`actions`, `commander` and `zoom` know no ROS; `robot` is the edge.
"""
