"""Teleoperation of joints one by one, or coupled."""
