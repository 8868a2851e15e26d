"""Tells catkin where the Python package lives; not meant to be run by hand."""

from distutils.core import setup

from catkin_pkg.python_setup import generate_distutils_setup

setup(
    **generate_distutils_setup(
        packages=[
            "telex_sim",
            "telex_sim.engine",
            "telex_sim.offline",
            "telex_sim.proximity",
            "telex_sim.rehearsal",
            "telex_sim.rendering",
            "telex_sim.robot",
            "telex_sim.ros",
            "telex_sim.scene",
            "telex_sim.scene.library",
            "telex_sim.stability",
            "telex_sim.tracks",
        ],
        package_dir={"": "src"},
    )
)
