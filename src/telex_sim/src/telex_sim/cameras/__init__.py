"""Cameras of the robot: what they see (moderngl), through which optics, on which topics."""
