"""Rights: who is connected, who has control of the robot, and who may do what."""
