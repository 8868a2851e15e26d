"""Tools that the wrist carries instead of the gripper: an inspection probe, or a bare flange.

Lengths in m. The frame lies on the flange of the wrist, x forward. Both carry the gripper's camera.
"""

from __future__ import annotations

import math
from typing import List

from .figures import Figures
from .fittings import around, bolt_circle, gland
from .link_model import LinkModel
from .mounting import add_tool_camera
from .solids import box, cylinder, hose, prism, turned

# The adapter plate of every tool, from the flange of the wrist to its front face
ADAPTER_FRONT = 0.030
HOSE = 0.0035


def links(figures: Figures) -> List[LinkModel]:
    """Return the links of the other tools; the gripper's are in `gripper`."""
    return [_probe(figures), _flange(figures)]


def _adapter(link: LinkModel, figures: Figures) -> None:
    link.add("metal", cylinder(0.0315, 0.008, "x", (0.0055, 0, 0), 0.0, 24))
    link.add("metal", bolt_circle(4, 0.0265, "x", (0.0095, 0, 0), 0.3, 0.0026))
    plan = [(0.008, -0.027), (ADAPTER_FRONT, -0.027), (ADAPTER_FRONT, 0.027), (0.008, 0.027)]
    link.add("shell", prism(plan, 0.043, 0.005, "xy"))
    add_tool_camera(link, figures)
    link.collide_box((ADAPTER_FRONT, 0.056, 0.048), (ADAPTER_FRONT / 2, 0, 0))


def _flange(figures: Figures) -> LinkModel:
    """Return the bare flange: adapter with the bolt circle that a tool is screwed to."""
    link = LinkModel("flange_link", 0.35)
    _adapter(link, figures)
    front = figures.flange_x
    link.add(
        "dark",
        cylinder(
            0.0205,
            front - ADAPTER_FRONT + 0.002,
            "x",
            ((ADAPTER_FRONT - 0.002 + front) / 2, 0, 0),
            0.0008,
            24,
        ),
    )
    for at in around(4, 0.0145, "x", (front, 0, 0), math.pi / 4):
        link.add("metal", cylinder(0.0028, 0.0012, "x", at, 0.0, 8))
    return link


def _probe(figures: Figures) -> LinkModel:
    """Return the inspection rod: tube, sensor head with a guard, cable along the tube."""
    link = LinkModel("probe_link", 0.90)
    _adapter(link, figures)
    tip = figures.probe_x
    head = tip - 0.062
    link.add("dark", turned([(0, ADAPTER_FRONT - 0.002), (0.019, ADAPTER_FRONT - 0.002),
                             (0.019, 0.040), (0.0125, 0.056), (0.0125, 0.062), (0, 0.062)], "x",
                             segments=24))  # fmt: skip
    link.add("metal", cylinder(0.0095, head - 0.040, "x", ((head + 0.050) / 2, 0, 0), 0.0, 18))
    link.add(
        "accent", *[cylinder(0.0098, 0.010, "x", (x, 0, 0), 0.0, 18) for x in (0.110, head - 0.030)]
    )
    # Sensor head: body, window, guard of three bars, nose
    link.add("dark", turned([(0, head - 0.004), (0.0115, head - 0.004), (0.0145, head + 0.004),
                             (0.0145, head + 0.026), (0.0125, head + 0.029), (0, head + 0.029)],
                             "x", segments=20))  # fmt: skip
    link.add("glass", cylinder(0.0100, 0.026, "x", (head + 0.041, 0, 0), 0.0, 16))
    for x, y, z in around(3, 0.0122, "x", (head + 0.040, 0, 0), math.pi / 2):
        link.add("metal", box((0.030, 0.0034, 0.0034), (x, y, z), 0.0006))
    link.add("metal", turned([(0, tip - 0.011), (0.0142, tip - 0.011), (0.0142, tip - 0.006),
                              (0.0095, tip - 0.0015), (0.004, tip), (0, tip)], "x",
                              segments=20))  # fmt: skip
    start, end = (0.034, -0.0155, -0.0085), (head - 0.003, -0.0118, -0.0040)
    link.add("metal", gland(start, "x", 1, HOSE), gland(end, "x", -1, HOSE))
    path = [(start[0] + 0.006, start[1], start[2]), (0.075, -0.0135, -0.0055),
            ((0.075 + head) / 2, -0.0125, -0.0045),
            (end[0] - 0.006, end[1], end[2])]  # fmt: skip
    link.add("rubber", hose(path, HOSE, 7, 2))
    link.collide_cylinder(0.0165, tip - ADAPTER_FRONT, "x", ((tip + ADAPTER_FRONT) / 2, 0, 0))
    return link
