"""Lead the tool along a path, and see how well the arm follows: the paper's figure 8.

Nothing here but `ros_rig` and `command_line` needs a ROS master.
"""


class FollowTrajectoryError(RuntimeError):
    """A path cannot be made, or not be followed; the message says why."""
