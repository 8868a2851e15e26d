"""rosbridge v2: operations, and ROS messages as JSON."""
