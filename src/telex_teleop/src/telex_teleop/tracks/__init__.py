"""Teleoperation of the tracks."""
