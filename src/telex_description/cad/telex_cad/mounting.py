"""Lamp and camera that every tool of the arm carries. Lengths in m."""

from __future__ import annotations

from .figures import Figures, Place
from .fittings import gland
from .housings import Parts, camera_housing, mount
from .link_model import LinkModel
from .solids import box, hose, prism


def lamp_bar() -> Parts:
    """Return a bar of light that looks along x; the origin is the middle of its face."""
    return {
        "dark": [box((0.014, 0.052, 0.0115), (-0.0078, 0, 0), 0.002)],
        "lamp": [box((0.003, 0.044, 0.0062), (-0.0015, 0, 0), 0.001)],
    }


def mount_at(link: LinkModel, parts: Parts, place: Place) -> None:
    """Add a housing where a place of the robot's figures says."""
    mount(link, parts, (place["x"], place["y"], place["z"]), place["pitch"])


def add_tool_camera(link: LinkModel, figures: Figures) -> None:
    """Add the gripper camera on its pedestal, the lamp below it, and its cable.

    They stand on the top of a body that reaches up to z = 0.0215 between x = 0.008 and 0.034, as
    every tool has one.
    """
    x, y, z = (figures.gripper_camera[axis] for axis in "xyz")
    pedestal = [(0.008, 0.018), (0.034, 0.018), (x - 0.012, z - 0.014), (x - 0.034, z - 0.014)]
    link.add("dark", prism(pedestal, 0.022, 0.003, at=(0, y, 0)))
    mount_at(link, camera_housing(), figures.gripper_camera)
    mount_at(link, lamp_bar(), figures.gripper_lamp)
    start, end, radius = (0.0145, 0.020, 0.0215), (0.0115, 0.0100, 0.040), 0.0030
    link.add("metal", gland(start, "z", 1, radius), gland(end, "y", 1, radius))
    path = [
        (start[0], start[1], start[2] + 0.006),
        (start[0], start[1] + 0.001, 0.034),
        (0.0125, 0.0195, 0.0395),
        (end[0], end[1] + 0.005, end[2]),
    ]
    link.add("rubber", hose(path, radius, 6, 2))
    link.collide_box((0.058, 0.048, 0.060), (0.013, 0, 0.055))
