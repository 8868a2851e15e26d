"""Clients of the bridge: their rights, control of the robot, and what goes to them."""
