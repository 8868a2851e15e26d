"""Loads, stopping and falling over."""
