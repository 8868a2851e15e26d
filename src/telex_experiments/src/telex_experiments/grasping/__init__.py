"""Objects in the shipped robot's gripper: a rig that grips, lifts, shakes and carries them."""
