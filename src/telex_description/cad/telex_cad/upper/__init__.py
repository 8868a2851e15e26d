"""Links above the hull: mast, turret, arm, gripper."""
