"""Measurements of the cameras."""
