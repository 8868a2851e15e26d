"""The brief before the start: task, what counts, controls, picture of the goal."""
