"""The ROS side of nodes: their start, publishers, services and master."""
