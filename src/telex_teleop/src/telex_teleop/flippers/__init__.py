"""Teleoperation of the flippers, and their presets."""
