"""Obstacles for the robot's tracks, and what is measured on them.

Scripted operators (`telex_training.operators`) drive in one process with the simulation
(`offline`), as fast as that goes and always the same.
"""
