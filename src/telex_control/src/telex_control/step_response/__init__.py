"""Step responses of joints: what to step, what it yields, how it is shown.

Nothing here but `ros_session` and `command_line` needs ROS.
"""
