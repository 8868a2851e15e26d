"""Control layer: hardware interface, joint limits, controller manager and controllers.

Nothing here knows the simulator: `telex_sim` implements `hardware_interface.RobotHW`, as a driver
of the real robot would.
"""
