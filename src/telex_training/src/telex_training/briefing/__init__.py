"""What a trainee is told before the start: task, what counts, controls, picture of the goal."""
