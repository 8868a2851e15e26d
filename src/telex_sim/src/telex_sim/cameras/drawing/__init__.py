"""Draws a scene as a camera without faults would see it, with OpenGL."""
