"""Distances between a robot's arm and its surroundings."""
