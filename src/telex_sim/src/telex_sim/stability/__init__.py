"""Stability of a robot: tip-over margin, and whether it is stuck."""
