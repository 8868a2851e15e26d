"""Scripted operators: programs that drive the robot as people do, free of ROS.

`port` is all that they see and do; `telex_training.ros` connects it to a live robot by topics,
`telex_training.rehearsal` to a simulation in the same process. `scripted_operator` looks, drives
and waits, `station` adds what a console offers, `handling` arm and gripper, `eye` the cameras.
"""
