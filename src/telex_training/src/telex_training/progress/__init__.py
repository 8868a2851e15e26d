"""People's progress: an index of trials, curricula, statistics, reports; needs no ROS."""
