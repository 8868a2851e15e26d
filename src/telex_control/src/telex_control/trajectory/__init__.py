"""Joint trajectories, without ROS's wires: splines, replacement of a running one, tolerances."""
