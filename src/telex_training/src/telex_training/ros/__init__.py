"""Operators' ports on a live robot, by its topics."""
