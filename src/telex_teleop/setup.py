"""Tells catkin where the Python package lives; not meant to be run by hand."""

from distutils.core import setup

from catkin_pkg.python_setup import generate_distutils_setup

setup(
    **generate_distutils_setup(
        packages=[
            "telex_teleop",
            "telex_teleop.actions",
            "telex_teleop.arm",
            "telex_teleop.flippers",
            "telex_teleop.joints",
            "telex_teleop.joy",
            "telex_teleop.keyboard",
            "telex_teleop.motion",
            "telex_teleop.operating",
            "telex_teleop.ros",
            "telex_teleop.tracks",
            "telex_teleop.web",
            "telex_teleop.web.bridge",
            "telex_teleop.web.bridge.clients",
            "telex_teleop.web.bridge.link",
            "telex_teleop.web.bridge.protocol",
            "telex_teleop.web.bridge.services",
            "telex_teleop.web.bridge.topics",
            "telex_teleop.web.exam",
            "telex_teleop.web.line",
            "telex_teleop.web.link",
            "telex_teleop.web.transforms",
            "telex_teleop.web.video",
            "telex_teleop.web.video.late",
            "telex_teleop.web.video.websocket",
        ],
        package_dir={"": "src"},
    )
)
