"""Teleoperation of the arm: joints, tool, poses, what is near."""
