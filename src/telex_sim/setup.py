"""Tells catkin where the Python package lives; not meant to be run by hand."""

from distutils.core import setup

from catkin_pkg.python_setup import generate_distutils_setup

setup(
    **generate_distutils_setup(
        packages=[
            "telex_sim",
            "telex_sim.cameras",
            "telex_sim.cameras.drawing",
            "telex_sim.cameras.drawing.light",
            "telex_sim.cameras.drawing.meshes",
            "telex_sim.cameras.optics",
            "telex_sim.cameras.preview",
            "telex_sim.cameras.ros",
            "telex_sim.engine",
            "telex_sim.equipment",
            "telex_sim.gas",
            "telex_sim.malfunctions",
            "telex_sim.offline",
            "telex_sim.proximity",
            "telex_sim.radiation",
            "telex_sim.radio",
            "telex_sim.rehearsal",
            "telex_sim.robot",
            "telex_sim.robot.gripper",
            "telex_sim.robot.urdf",
            "telex_sim.ros",
            "telex_sim.ros.sensors",
            "telex_sim.scene",
            "telex_sim.scene.files",
            "telex_sim.scene.library",
            "telex_sim.scene.library.accelerator",
            "telex_sim.scene.library.building",
            "telex_sim.scene.library.tasks",
            "telex_sim.scene.library.terrain",
            "telex_sim.scene.meshes",
            "telex_sim.scene.objects",
            "telex_sim.scene.textures",
            "telex_sim.stability",
            "telex_sim.tracks",
            "telex_sim.truth",
        ],
        package_dir={"": "src"},
    )
)
