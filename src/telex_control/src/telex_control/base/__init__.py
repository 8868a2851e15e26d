"""Odometry, turning and braking of a mobile base."""
