"""The loop: physics, order of the steps, pace."""
