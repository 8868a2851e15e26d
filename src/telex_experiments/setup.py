"""Tells catkin where the Python package lives; not meant to be run by hand."""

from distutils.core import setup

from catkin_pkg.python_setup import generate_distutils_setup

setup(
    **generate_distutils_setup(
        packages=[
            "telex_experiments",
            "telex_experiments.cameras",
            "telex_experiments.classroom",
            "telex_experiments.console",
            "telex_experiments.grasping",
            "telex_experiments.mobility",
            "telex_experiments.mobility.balance",
            "telex_experiments.paper",
            "telex_experiments.paper.experiments",
            "telex_experiments.paper.tasks",
            "telex_experiments.rigs",
            "telex_experiments.training",
        ],
        package_dir={"": "src"},
    )
)
