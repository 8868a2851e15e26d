"""Training on the simulator."""
