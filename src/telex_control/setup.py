"""Tells catkin where the Python package lives; not meant to be run by hand."""

from distutils.core import setup

from catkin_pkg.python_setup import generate_distutils_setup

setup(
    **generate_distutils_setup(
        packages=[
            "telex_control",
            "telex_control.base",
            "telex_control.command_lines",
            "telex_control.common",
            "telex_control.common.geometry",
            "telex_control.controllers",
            "telex_control.follow_trajectory",
            "telex_control.hardware",
            "telex_control.kinematics",
            "telex_control.kinematics.inverse",
            "telex_control.laws",
            "telex_control.manager",
            "telex_control.ros",
            "telex_control.ros.rospy_fixes",
            "telex_control.step_response",
            "telex_control.trajectory",
            "telex_control.urdf",
        ],
        package_dir={"": "src"},
    )
)
