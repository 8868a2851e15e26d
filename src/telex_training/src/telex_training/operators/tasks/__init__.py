"""What an operator does with the robot from begin to end, one task a module."""
