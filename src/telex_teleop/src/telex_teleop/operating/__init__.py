"""Common parts of the input devices: from actions to commands, and the robot's ROS edge.

`commander` and `zoom` know no ROS; `operated_robot` is the edge.
"""
