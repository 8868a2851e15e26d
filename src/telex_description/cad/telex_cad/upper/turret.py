"""Turret: slewing ring, housing, fork of the shoulder, pan-tilt head of the turret camera.

Lengths in m. The turret's frame lies on the deck, on the turret axis; x forward, z up.
"""

from __future__ import annotations

import math
from typing import List

from manifold3d import Manifold

from ..figures import Figures
from ..fittings import (
    Vector,
    arc_points,
    bolt_circle,
    bolts,
    cap,
    connector,
    finned_motor,
    gland,
    row_of_boxes,
)
from ..link_model import LinkModel
from ..solids import box, cylinder, hose, prism, ring, turned, warning_stripes

# The fork: gap for the hub of the upper arm, and its cheeks. Their outer faces decide how far the
# turret stays from flippers that stand upright, so the outer cheek is as thin as it may be.
FORK_GAP = 0.063
OUTER_CHEEK = 0.008
INNER_CHEEK = 0.010

HOUSING_TOP = 0.104
HOSE = 0.006


def links(figures: Figures) -> List[LinkModel]:
    """Return the links of the turret and of its camera's head."""
    return [_turret(figures), _pan(figures), _tilt(figures)]


def _turret(figures: Figures) -> LinkModel:
    link = LinkModel("turret_link", 5.1)
    _slewing_ring(link)
    _housing(link, figures)
    _fork(link, figures)
    _shoulder_drive(link, figures)
    return link


def _slewing_ring(link: LinkModel) -> None:
    link.add("metal", cylinder(0.108, 0.010, "z", (0, 0, 0.006), 0.002, 32))
    link.add("metal", bolt_circle(10, 0.102, "z", (0, 0, 0.011), head=0.0036, height=0.0025))
    link.add("dark", turned([(0, 0.008), (0.096, 0.008), (0.096, 0.020), (0.099, 0.023),
                             (0.099, 0.034), (0.092, 0.041), (0, 0.041)], "z",
                             segments=32))  # fmt: skip
    link.add("accent", cylinder(0.0972, 0.003, "z", (0, 0, 0.0175), 0.0, 32))
    link.collide_cylinder(0.108, 0.041, "z", (0, 0, 0.0205))


def _housing(link: LinkModel, figures: Figures) -> None:
    plan = [(-0.090, -0.043), (0.086, -0.043), (0.086, 0.050), (0.052, 0.085), (-0.062, 0.085),
            (-0.090, 0.052)]  # fmt: skip
    side = [(-0.090, 0.036), (0.086, 0.036), (0.086, 0.072), (0.058, HOUSING_TOP),
            (-0.072, HOUSING_TOP), (-0.090, 0.088)]  # fmt: skip
    body = prism(plan, 0.080, 0.006, "xy", (0, 0, 0.0640)) ^ prism(side, 0.20, 0.002)
    # A seam between the tray and the lid
    seam = prism(plan, 0.0022, 0.0, "xy", (0, 0, 0.060))
    inside = prism([(0.97 * x, 0.97 * y) for x, y in plan], 0.003, 0.0, "xy", (0, 0, 0.060))
    cavity = box((0.118, 0.088, 0.044), (-0.006, 0.018, 0.068), 0.0)
    link.add("shell", body - (seam - inside) - cavity)
    link.add_inside("drive", cylinder(0.036, 0.040, "z", (0.014, 0.018, 0.068), 0.0))
    link.add_inside("electronics", box((0.040, 0.080, 0.040), (-0.044, 0.018, 0.068), 0.0))
    link.add("dark", inside)

    # Service cover on the lid
    link.add("panel", box((0.096, 0.058, 0.006), (-0.012, -0.006, HOUSING_TOP), 0.0015))
    screws = [(x, y, HOUSING_TOP + 0.003) for x in (-0.054, 0.030) for y in (-0.030, 0.018)]
    link.add("metal", bolts(screws, "z"))
    # Lifting eye and status lights
    link.add(
        "metal", ring(0.0085, 0.0045, 0.006, "y", (0.046, 0.052, HOUSING_TOP + 0.003), 0.0, 12)
    )
    link.add("lamp", cylinder(0.0028, 0.004, "z", (-0.062, 0.030, HOUSING_TOP), 0.0, 8))
    link.add("red", cylinder(0.0028, 0.004, "z", (-0.062, 0.040, HOUSING_TOP), 0.0, 8))

    # Cooling ribs on the left, stripes under them
    link.add("dark", box((0.092, 0.005, 0.040), (-0.006, 0.0842, 0.0765), 0.0012))
    link.add("dark", row_of_boxes(9, (0.0032, 0.010, 0.034), (-0.046, 0.0866, 0.0765), "x", 0.010))
    plate, bars = warning_stripes(0.092, 0.011, 0.0016, 0.022)
    link.add("accent", plate.translate((-0.006, 0.0855, 0.0475)))
    link.add("black", bars.translate((-0.006, 0.0855, 0.0475)))

    # Connector panel at the rear
    link.add("dark", box((0.005, 0.076, 0.036), (-0.0902, 0.004, 0.066), 0.0015))
    for y, radius in ((-0.018, 0.0095), (0.007, 0.0095), (0.029, 0.0075)):
        link.add("metal", connector((-0.0925, y, 0.066), "x", -1, radius))
    link.add("metal", bolts([(-0.0925, -0.030, 0.052), (-0.0925, 0.038, 0.080)], "x"))

    # Lamp strip in front, as a position light
    link.add("dark", box((0.004, 0.060, 0.016), (0.0862, 0.002, 0.0555), 0.001))
    link.add("lamp", box((0.003, 0.050, 0.006), (0.0884, 0.002, 0.0555), 0.001))

    # Seat of the camera's head
    x, y, top = figures.pan_x, figures.pan_y, figures.pan_z
    link.add(
        "dark",
        cylinder(
            0.027,
            top - HOUSING_TOP + 0.006,
            "z",
            (x, y, (top + HOUSING_TOP - 0.006) / 2),
            0.003,
            20,
        ),
    )
    link.add("metal", bolt_circle(4, 0.0222, "z", (x, y, top - 0.0005), head=0.0026))
    link.collide_box((0.184, 0.130, 0.070), (-0.003, 0.022, 0.071))
    link.collide_cylinder(0.027, top - HOUSING_TOP, "z", (x, y, (top + HOUSING_TOP) / 2))


def _fork(link: LinkModel, figures: Figures) -> None:
    x, y, z = figures.shoulder_x, figures.shoulder_y, figures.shoulder_z
    head = arc_points((x, z), 0.046, -0.10, math.pi + 0.30, 12)
    outline = [(x - 0.064, 0.042), (x + 0.050, 0.042), *head]
    faces = (y - FORK_GAP / 2 - OUTER_CHEEK / 2, y + FORK_GAP / 2 + INNER_CHEEK / 2)
    outer = prism(outline, OUTER_CHEEK, 0.002, at=(0, faces[0], 0))
    inner = prism(outline, INNER_CHEEK, 0.002, at=(0, faces[1], 0))
    # Pocket that lightens the outer cheek
    pocket = prism([(x - 0.046, 0.060), (x + 0.036, 0.060), (x + 0.028, 0.112),
                    (x - 0.034, 0.112)], 0.006, 0.001,
                    at=(0, faces[0] - OUTER_CHEEK / 2, 0))  # fmt: skip
    link.add("shell", outer - pocket, inner)
    screws = [
        (x + dx, faces[0] - 0.001, dz)
        for dx, dz in ((-0.036, 0.070), (0.028, 0.070), (-0.026, 0.102), (0.020, 0.102))
    ]
    link.add("metal", bolts(screws, "y"))

    # Foot between the cheeks; its front leaves room for the arm at the lower end of its range
    foot = [(x - 0.070, 0.030), (x + 0.016, 0.030), (x + 0.018, 0.046), (x - 0.010, 0.094),
            (x - 0.050, 0.094)]  # fmt: skip
    length = faces[1] - faces[0]
    link.add("dark", prism(foot, length - 0.001, 0.004, at=(0, sum(faces) / 2, 0)))
    link.add("dark", box((0.084, 0.074, 0.014), (x - 0.026, y + 0.002, 0.037), 0.004))

    # Bearing cap outside: flat, because it is the outermost point of the turret
    face = faces[0] - OUTER_CHEEK / 2
    link.add("dark", cap((x, face + 0.001, z), "y", -1, 0.036, 0.0035, 24))
    link.add("metal", cylinder(0.016, 0.008, "y", (x, face, z), 0.001, 14))
    link.add("metal", bolt_circle(6, 0.028, "y", (x, face - 0.0025, z), 0.2, 0.003, 0.0018))
    link.add("accent", cylinder(0.0405, 0.002, "y", (x, face - 0.0005, z), 0.0, 24))

    for middle, width in ((faces[0], OUTER_CHEEK), (faces[1], INNER_CHEEK)):
        link.collide_box((0.104, width, 0.176), (x - 0.006, middle, 0.128))
    link.collide_box((0.098, FORK_GAP, 0.064), (x - 0.020, y, 0.064))


def _shoulder_drive(link: LinkModel, figures: Figures) -> None:
    """Add the geared motor on the inner cheek, and its hose into the hollow shaft."""
    x, y, z = figures.shoulder_x, figures.shoulder_y, figures.shoulder_z
    face = y + FORK_GAP / 2 + INNER_CHEEK
    link.add("dark", finned_motor((x, face - 0.001, z), "y", 1, 0.040, 0.027, 18, 3))
    link.add("metal", bolt_circle(4, 0.0265, "y", (x, face + 0.026, z), head=0.003))
    link.add("metal", gland((x, face + 0.026, z), "y", 1, HOSE))
    start = (0.004, -0.033, HOUSING_TOP)
    link.add("metal", gland(start, "z", 1, HOSE))
    axis_end = (x, face + 0.032, z)
    link.add("rubber", _shoulder_hose(start, axis_end))
    link.collide_cylinder(0.041, 0.032, "y", (x, face + 0.015, z))


def _shoulder_hose(start: Vector, end: Vector) -> Manifold:
    x, y, z = end
    points = [
        (start[0], start[1], start[2] + 0.006),
        (start[0] - 0.002, start[1] + 0.004, start[2] + 0.024),
        (x - 0.030, y - 0.004, z - 0.026),
        (x - 0.018, y + 0.006, z - 0.008),
        (x - 0.004, y + 0.007, z - 0.0005),
        (x, y - 0.002, z),
    ]
    return hose(points, HOSE, 8, 2)


def _pan(figures: Figures) -> LinkModel:
    """Return the yoke that turns about z; its frame lies on the seat."""
    link = LinkModel("turret_camera_pan_link", 0.15)
    tilt = figures.tilt_z
    link.add("dark", cylinder(0.022, 0.022, "z", (0, 0, 0.0125), 0.002, 18))
    link.add("accent", cylinder(0.0226, 0.003, "z", (0, 0, 0.006), 0.0, 18))
    link.add("dark", box((0.030, 0.074, 0.007), (0, 0, 0.0265), 0.002))
    cheek = [(-0.015, 0.023), (0.015, 0.023), *arc_points((0, tilt), 0.0125, 0.0, math.pi, 7)]
    link.add("dark", *[prism(cheek, 0.006, 0.0015, at=(0, side * 0.034, 0)) for side in (-1, 1)])
    # Tilt motor on the left, bearing cap on the right
    link.add("dark", cylinder(0.0125, 0.010, "y", (0, 0.0405, tilt), 0.002, 16))
    link.add("metal", cylinder(0.0085, 0.003, "y", (0, -0.0375, tilt), 0.0, 12))
    link.add("metal", bolts([(0.0, 0.037, 0.040), (0.0, -0.037, 0.040)], "y", 0.0022))
    cable = [(-0.012, -0.024, 0.029), (-0.021, -0.032, 0.040), (-0.018, -0.039, 0.060),
             (-0.004, -0.0385, tilt)]  # fmt: skip
    link.add("rubber", hose(cable, 0.0024, 6, 2))
    link.collide_cylinder(0.030, 0.030, "z", (0, 0, 0.015))
    link.collide_box((0.030, 0.012, 0.056), (0, 0.038, 0.057))
    link.collide_box((0.030, 0.008, 0.056), (0, -0.036, 0.057))
    return link


def _tilt(figures: Figures) -> LinkModel:
    """Return the camera's body, which turns about y; the lens looks along x."""
    link = LinkModel("turret_camera_tilt_link", 0.25)
    front, lens = 0.027, figures.turret_camera_x
    body = prism([(-0.024, -0.013), (-0.015, -0.021), (front, -0.022), (front, 0.019),
                  (-0.015, 0.021), (-0.024, 0.013)], 0.056, 0.004)  # fmt: skip
    link.add("shell", body)
    link.add(
        "dark",
        *[box((0.0025, 0.044, 0.034), (-0.021 + 0.006 * k, 0, 0.0025), 0.0) for k in range(1, 4)],
    )
    link.add("dark", box((0.004, 0.050, 0.037), (front, 0, -0.0015), 0.0015))
    link.add("dark", ring(0.0150, 0.0112, 0.011, "x", (front + 0.004, 0, 0.0), 0.001, 18))
    link.add(
        "glass",
        turned([(0, 0), (0.0115, 0), (0.008, 0.0035), (0, 0.005)], "x", (lens - 0.0065, 0, 0), 20),
    )
    # A brow no thicker than sheet metal
    link.add("dark", box((0.022, 0.040, 0.0018), (0.029, 0, 0.0172), 0.0006))
    link.add(
        "metal", *[cylinder(0.008, 0.004, "y", (0, side * 0.029, 0), 0.0, 12) for side in (-1, 1)]
    )
    # Lamp: a bar of light under the lens
    lamp = figures.turret_lamp
    link.add(
        "lamp", box((0.003, 0.042, 0.0048), (lamp["x"] - 0.0015, lamp["y"], lamp["z"]), 0.0012)
    )
    link.collide_box((0.058, 0.056, 0.044), (0.003, 0, 0))
    link.collide_cylinder(0.016, 0.012, "x", (front + 0.005, 0, 0))
    return link
