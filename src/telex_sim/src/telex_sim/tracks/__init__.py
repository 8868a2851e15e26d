"""Tracks: belts, their drives, and the traction between belts and ground.

`law` is the friction of belts, without PyBullet; `belt_drive` the motors; `surfaces` what is
touched; `tracks` puts them together for a robot.
"""
