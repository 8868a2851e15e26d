"""The operator's side: teleoperation nodes, keyboard, video server, bridge and console.

Everything here speaks ROS only; nothing knows that the robot is simulated.
"""
