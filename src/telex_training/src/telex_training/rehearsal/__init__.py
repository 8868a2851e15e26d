"""Operators' ports on a simulation in the same process: no ROS master, and always the same."""
