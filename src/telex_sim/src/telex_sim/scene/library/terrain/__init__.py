"""Terrain to be driven over: slopes, stairs, gaps, fields of posts, mazes."""
