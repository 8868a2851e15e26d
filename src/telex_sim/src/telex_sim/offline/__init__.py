"""The simulation without a ROS master."""
