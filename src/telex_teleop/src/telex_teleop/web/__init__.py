"""Servers for the operator's browser: video server and rosbridge, and what they share."""
