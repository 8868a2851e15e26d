"""Tells catkin where the Python package lives; not meant to be run by hand."""

from distutils.core import setup

from catkin_pkg.python_setup import generate_distutils_setup

setup(
    **generate_distutils_setup(
        packages=[
            "telex_control",
            "telex_control.command_lines",
            "telex_control.controllers",
            "telex_control.follow_trajectory",
            "telex_control.kinematics",
            "telex_control.step_response",
            "telex_control.trajectory",
        ],
        package_dir={"": "src"},
    )
)
