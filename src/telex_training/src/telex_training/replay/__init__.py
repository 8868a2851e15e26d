"""Recordings drawn again: what was where, when, and what happened; without ROS's nodes."""
