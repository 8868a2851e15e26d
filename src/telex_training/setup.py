"""Tells catkin where the Python package lives; not meant to be run by hand."""

from distutils.core import setup

from catkin_pkg.python_setup import generate_distutils_setup

setup(
    **generate_distutils_setup(
        packages=[
            "telex_training",
            "telex_training.briefing",
            "telex_training.classroom",
            "telex_training.command_lines",
            "telex_training.exercises",
            "telex_training.judging",
            "telex_training.judging.records",
            "telex_training.operators",
            "telex_training.operators.experts",
            "telex_training.operators.tasks",
            "telex_training.operators.terrain",
            "telex_training.progress",
            "telex_training.progress.reports",
            "telex_training.recording",
            "telex_training.rehearsal",
            "telex_training.replay",
            "telex_training.research",
            "telex_training.ros",
            "telex_training.ros.exam",
            "telex_training.ros.pages",
            "telex_training.ros.replay",
            "telex_training.ros.trial",
        ],
        package_dir={"": "src"},
    )
)
