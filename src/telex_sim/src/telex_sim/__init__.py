"""PyBullet simulation of the robot: world, tracks, simulated hardware, sensors and cameras."""
