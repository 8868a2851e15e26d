"""A class: many stations on one page of the instructor's, by their web addresses; without ROS."""
