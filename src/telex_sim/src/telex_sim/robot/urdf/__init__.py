"""URDF for the simulation: frames that PyBullet can do without, masses, visuals."""
