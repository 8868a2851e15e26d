"""Gripper: palm, and two fingers of three links each that keep their pads parallel.

Lengths in m. The palm's frame lies on the flange of the wrist, x forward; the fingers turn about z.
At zero the gripper is closed: the links of a finger lean inwards and the pads meet in the plane
y = 0. Every finger link is drawn for the left side and mirrored for the right one.
"""

from __future__ import annotations

import math
from typing import List

from manifold3d import Manifold

from ..figures import Figures
from ..fittings import Point, Vector, arc_points, bolt_circle, bolts
from ..link_model import LinkModel
from ..mounting import add_tool_camera
from ..solids import box, cylinder, prism, union, warning_stripes

# Heights: the middle link runs between the two plates of the base link, these between the lugs.
MIDDLE_HEIGHT = 0.018
PLATE_INNER = 0.0096
PLATE_THICKNESS = 0.0060
LUG_INNER = 0.0160
LUG_THICKNESS = 0.0060
LINK_WIDTH = 0.0165

PAD_LENGTH = 0.080
PAD_HEIGHT = 0.030
PAD_THICKNESS = 0.0055
# Carrier of the pad, outer face measured from the pad's face
CARRIER_DEPTH = 0.0135
RIBS = 10


def links(figures: Figures) -> List[LinkModel]:
    """Return the palm and the six links of the fingers."""
    fingers = [
        make(figures, side)
        for side in (1, -1)
        for make in (_finger_base, _finger_middle, _finger_tip)
    ]
    return [_palm(figures), *fingers]


# ---- palm


def _palm(figures: Figures) -> LinkModel:
    link = LinkModel("gripper_link", 0.8)
    pivot_x, pivot_y = figures.finger["pivot_x"], figures.finger["pivot_y"]
    link.add("metal", cylinder(0.0315, 0.008, "x", (0.0055, 0, 0), 0.0, 24))
    link.add("metal", bolt_circle(4, 0.0265, "x", (0.0095, 0, 0), 0.3, 0.0026))
    plan = [
        (0.008, -0.030),
        (0.026, -0.058),
        (0.038, -0.060),
        (0.038, 0.060),
        (0.026, 0.058),
        (0.008, 0.030),
    ]
    link.add("shell", prism(plan, 0.043, 0.006, "xy"))
    link.add("shell", box((0.018, 0.066, 0.036), (0.038, 0, 0), 0.004))
    link.add("rubber", box((0.005, 0.054, 0.026), (0.0475, 0, 0), 0.002))
    for side in (-1, 1):
        _finger_lugs(link, pivot_x, side * pivot_y)
        plate, bars = warning_stripes(0.040, 0.012, 0.0012, 0.016)
        link.add("accent", plate.rotate((-90, 0, 90)).translate((0.0285, side * 0.028, 0.0215)))
        link.add("black", bars.rotate((-90, 0, 90)).translate((0.0285, side * 0.028, 0.0215)))
    heads = [(0.0175, side * 0.030, -0.0215) for side in (-1, 1)] + [
        (0.031, side * 0.044, -0.0215) for side in (-1, 1)
    ]
    link.add("metal", bolts(heads, "z", 0.0030))
    link.add("panel", box((0.022, 0.050, 0.004), (0.026, 0, -0.0215), 0.001))

    add_tool_camera(link, figures)
    link.collide_box((0.060, 0.160, 0.050), (0.034, 0, 0))
    return link


def _finger_lugs(link: LinkModel, x: float, y: float) -> None:
    """Add the two lugs that hold a finger, and the motor below them."""
    side = math.copysign(1.0, y)
    rounded = arc_points((x, y), 0.0125, side * 1.2, -side * 1.2, 6)
    outline = [(0.026, y - side * 0.024), (0.026, y + side * 0.006),
               (x - 0.004, y + side * 0.0125), *rounded, (x - 0.006, y - side * 0.024)]  # fmt: skip
    middle = LUG_INNER + LUG_THICKNESS / 2
    link.add(
        "dark", *[prism(outline, LUG_THICKNESS, 0.0012, "xy", (0, 0, z)) for z in (-middle, middle)]
    )
    outer = LUG_INNER + LUG_THICKNESS
    link.add("metal", cylinder(0.0075, 0.005, "z", (x, y, outer), 0.0, 14))
    link.add("black", cylinder(0.0035, 0.0056, "z", (x, y, outer), 0.0, 6))
    link.add("dark", cylinder(0.0120, 0.013, "z", (x, y, -outer - 0.0055), 0.002, 14))


# ---- fingers


def _finger_base(figures: Figures, side: int) -> LinkModel:
    finger = figures.finger
    length, lean = finger["base"], finger["lean"]
    link = _finger_link("base", side, 0.08)
    outline = _bone(length, LINK_WIDTH / 2 + 0.0008, LINK_WIDTH / 2)
    middle = PLATE_INNER + PLATE_THICKNESS / 2
    plates = [prism(outline, PLATE_THICKNESS, 0.0012, "xy", (0, 0, z)) for z in (-middle, middle)]
    web = box((0.012, 0.010, 2 * PLATE_INNER + 0.002), (0.014, 0, 0), 0.0015)
    _add(link, side, lean, "metal", *plates)
    _add(link, side, lean, "dark", web)
    outer = PLATE_INNER + PLATE_THICKNESS
    heads = [cylinder(0.0055, 0.003, "z", (length, 0, z), 0.0, 12) for z in (-outer, outer)]
    _add(link, side, lean, "dark", *heads)
    shaft = cylinder(0.0060, 2 * LUG_INNER - 0.0004, "z", (0, 0, 0), 0.0, 12)
    _add(link, side, lean, "dark", shaft)
    _collide_along(link, (length + 0.010, LINK_WIDTH, 2 * outer), length, lean, side)
    return link


def _finger_middle(figures: Figures, side: int) -> LinkModel:
    finger = figures.finger
    length, lean = finger["middle"], finger["lean"]
    link = _finger_link("middle", side, 0.12)
    half = MIDDLE_HEIGHT / 2
    bar = prism(_bone(length, 0.0078, 0.0070), MIDDLE_HEIGHT, 0.0015, "xy")
    grooves = [box((0.044, 0.0060, 0.005), (length / 2, 0, z), 0.0008) for z in (-half, half)]
    _add(link, side, lean, "dark", bar - union(grooves))
    _add(
        link,
        side,
        lean,
        "accent",
        *[
            box((0.038, 0.0042, 0.002), (length / 2, 0, z), 0.0)
            for z in (-half + 0.002, half - 0.002)
        ],
    )
    _collide_along(link, (length, 0.0150, MIDDLE_HEIGHT), length, lean, side)
    return link


def _finger_tip(figures: Figures, side: int) -> LinkModel:
    """Return the pad with its carrier; the frame lies at the pivot, the pad towards -y (left)."""
    finger = figures.finger
    link = _finger_link("tip", side, 0.10)
    face = finger["pivot_y"] - (finger["base"] + finger["middle"]) * math.sin(finger["lean"])
    centre = finger["pad_x"]
    rear, front = centre - PAD_LENGTH / 2, centre + PAD_LENGTH / 2
    # Room for the middle link, which swings through the rear of the pad as the finger opens
    slot = box((0.052, 0.060, MIDDLE_HEIGHT + 0.002), (-0.0165, 0, 0), 0.0)

    outline = [(rear - 0.001, PAD_THICKNESS - 0.0005), (front + 0.002, PAD_THICKNESS - 0.0005),
               (front + 0.002, 0.0085), (front - 0.012, CARRIER_DEPTH),
               (rear + 0.006, CARRIER_DEPTH), (rear - 0.001, 0.0095)]  # fmt: skip
    carrier = prism(outline, PAD_HEIGHT, 0.0012, "xy")
    eyes = prism(
        [(-0.008, 0.008), (0.012, 0.008), *arc_points((0, face), 0.0075, 0.3, math.pi - 0.2, 7)],
        PAD_HEIGHT,
        0.001,
        "xy",
    )
    _add_tip(link, side, face, "metal", (carrier + eyes) - slot)
    pad = box((PAD_LENGTH, 0.0035, PAD_HEIGHT - 0.002), (centre, PAD_THICKNESS - 0.00175, 0), 0.0)
    pitch = PAD_LENGTH / RIBS
    ribs = [
        box((0.6 * pitch, 0.0030, PAD_HEIGHT - 0.002), (rear + (k + 0.5) * pitch, 0.0015, 0), 0.0)
        for k in range(RIBS)
    ]
    _add_tip(link, side, face, "rubber", union([pad, *ribs]) - slot)
    pins = [
        cylinder(0.0042, 0.002, "z", (0, face, z), 0.0, 12)
        for z in (-PAD_HEIGHT / 2, PAD_HEIGHT / 2)
    ]
    _add_tip(link, side, face, "dark", *pins)
    heads = [(x, CARRIER_DEPTH, z) for x, z in ((front - 0.022, 0.0085), (front - 0.040, -0.0085))]
    _add_tip(link, side, face, "dark", bolts(heads, "y", 0.0022, 0.0012))
    length = front - rear + 0.004
    link.collide_box(
        (length, CARRIER_DEPTH, PAD_HEIGHT), (centre, side * (CARRIER_DEPTH / 2 - face), 0)
    )
    return link


def _finger_link(part: str, side: int, mass: float) -> LinkModel:
    return LinkModel(f"{'left' if side > 0 else 'right'}_finger_{part}_link", mass)


def _bone(length: float, start: float, end: float) -> List[Point]:
    """Return the outline of a link with round ends about its two pivots; start, end: radii."""
    return [
        *arc_points((length, 0), end, -0.5 * math.pi, 0.5 * math.pi, 6),
        *arc_points((0, 0), start, 0.5 * math.pi, 1.5 * math.pi, 6),
    ]


def _add(link: LinkModel, side: int, lean: float, material: str, *solids: Manifold) -> None:
    """Add solids that are drawn along x, turned inwards by `lean` (rad)."""
    for solid in solids:
        link.add(material, solid.rotate((0, 0, -side * math.degrees(lean))))


def _add_tip(link: LinkModel, side: int, face: float, material: str, *solids: Manifold) -> None:
    """Add solids that are drawn with the face of the pad at y = 0 and the finger at y > 0."""
    for solid in solids:
        placed = solid.translate((0, -face, 0))
        link.add(material, placed if side > 0 else placed.mirror((0, 1, 0)))


def _collide_along(link: LinkModel, size: Vector, length: float, lean: float, side: int) -> None:
    """Add a box whose middle lies half-way between the two pivots of a link."""
    x, y = 0.5 * length * math.cos(lean), -side * 0.5 * length * math.sin(lean)
    link.collide_box(size, (x, y, 0), (0, 0, -side * lean))
