"""Malfunctions of a robot: which there can be, what they do, and its battery."""
