"""``keyboard_teleop``: the robot driven from a terminal.

`decoding`, `held`, `line`, `map`, `commands`, `screen`, `terminal` and `teleop` know no ROS;
`robot` and `node` are its ROS edge.
"""
