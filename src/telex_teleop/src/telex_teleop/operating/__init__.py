"""What the operator's input devices share: actions, what they command, and the robot's ROS edge.

`actions`, `commander` and `zoom` know no ROS; `robot` is the edge.
"""
