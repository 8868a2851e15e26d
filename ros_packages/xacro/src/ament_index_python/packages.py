"""The one function that xacro calls, answered from ROS_PACKAGE_PATH."""

from __future__ import annotations

import rospkg

_packages = rospkg.RosPack()  # which remembers what it has found


def get_package_share_directory(package_name: str) -> str:
    """Return the folder of a ROS package.

    Raises
    ------
    LookupError
        ROS_PACKAGE_PATH has no such package.
    """
    try:
        return str(_packages.get_path(package_name))
    except rospkg.ResourceNotFound:
        raise LookupError(f"ROS_PACKAGE_PATH has no package '{package_name}'") from None
