"""Scripted operators: what the robot has to manage, driven through its ROS topics only.

`scripted_operator` holds the hands and eyes of a script, one module per manoeuvre what it does.
A script runs unchanged in one process with the simulation (`offline`), as fast as that goes and
always the same, and on a live simulator (`live`).
"""
