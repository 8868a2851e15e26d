"""Equipment that a variant of the robot declares: what it measures with, and where."""
