"""Grasp state of a gripper, from the contacts of its pads."""
