"""Renders what the robot's cameras see, with moderngl; the ROS node ``cameras`` is around it."""
