"""Exercise files: their reading, their checks, and the scenes that they stand in."""
