"""The command lines of ros_control's controller_manager, with its arguments and its output."""
