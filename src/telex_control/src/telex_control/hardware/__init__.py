"""Handles, claims and joint limits between controllers and a robot."""
