"""Arm between turret and gripper: upper arm, telescope, elbow, forearm, wrist.

Lengths in m, each link in its own frame: at its joint, x along the arm, z up at zero. No hose
crosses a joint: each ends in a gland on the housing of a joint's hollow shaft, and the next
link's begins with a gland behind it.
"""

from __future__ import annotations

import math
from typing import List

from manifold3d import Manifold

from ..figures import Figures
from ..fittings import arc_points, bolt_circle, bolts, cap, clip, finned_motor, gland
from ..housings import camera_housing
from ..link_model import LinkModel
from ..mounting import mount_at
from ..solids import box, cylinder, hose, prism, turned, union, warning_stripes

# Outer tube of the telescope, and the slide in it with its play
TUBE_WIDTH = 0.058
TUBE_HEIGHT = 0.070
BORE_WIDTH = 0.047
BORE_HEIGHT = 0.058
PLAY = 0.0012
# Where the bore ends, just before the hub of the shoulder; the slide stops short of it.
BORE_END = 0.047

UPPER_HOSE = 0.0058
SLIM_HOSE = 0.0045


def links(figures: Figures) -> List[LinkModel]:
    """Return the five links of the arm."""
    return [
        _upper_arm(figures),
        _telescope(figures),
        _elbow(figures),
        _forearm(figures),
        _wrist(figures),
    ]


# ---- upper arm


def _upper_arm(figures: Figures) -> LinkModel:
    link = LinkModel("upper_arm_link", 4.5)
    mouth = figures.telescope_x
    _outer_tube(link, mouth)
    _telescope_drive(link)
    _upper_hose(link, mouth)
    link.collide_cylinder(0.046, 0.061, "y")
    link.collide_box((mouth - 0.020, 0.064, 0.078), ((mouth + 0.020) / 2, 0, 0))
    link.collide_box((0.170, 0.046, 0.034), (0.178, 0.003, 0.055))
    link.collide_box((mouth - 0.050, 0.018, 0.018), (mouth / 2 + 0.025, -0.020, 0.046))
    return link


def _outer_tube(link: LinkModel, mouth: float) -> None:
    root = 0.085
    bore = box((mouth, BORE_WIDTH, BORE_HEIGHT), (BORE_END + mouth / 2, 0, 0), 0.003)
    # Root casting: from the hub of the shoulder to the section of the tube
    link.add("dark", cylinder(0.0455, 0.061, "y", bevel=0.003, segments=24))
    rounded = arc_points((0, 0), 0.041, 0.5 * math.pi, 1.5 * math.pi, 7)
    outline = [*rounded, (root, -0.037), (root, 0.037)]
    link.add("shell", prism(outline, TUBE_WIDTH + 0.001, 0.004) - bore)
    link.add("accent", cylinder(0.0462, 0.006, "y", bevel=0.0, segments=24))

    middle = (root + mouth) / 2
    tube = box((mouth - root + 0.004, TUBE_WIDTH, TUBE_HEIGHT), (middle, 0, 0), 0.007)
    pocket = box((0.150, 0.0050, 0.034), (0.205, 0, 0), 0.0018)
    sides = [pocket.translate((0, side * TUBE_WIDTH / 2, 0)) for side in (-1, 1)]
    link.add("shell", tube - bore - union(sides))
    for side in (-1, 1):
        face = side * TUBE_WIDTH / 2
        corners = [(x, face, z) for x, z in ((0.118, -0.024), (0.118, 0.024), (0.292, 0.0))]
        link.add("metal", bolts(corners, "y", 0.0032, 0.0016))
        plate, bars = warning_stripes(0.056, 0.026, 0.001, 0.028)
        link.add("accent", plate.translate((0.335, face, 0)))
        link.add("black", bars.translate((0.335, face, 0)))

    # Clamped collars
    link.add("dark", box((0.016, 0.0625, 0.076), (root + 0.006, 0, 0), 0.005) - bore)
    collar = box((0.026, 0.066, 0.078), (mouth - 0.013, 0, 0), 0.005) - bore
    wiper = box((0.004, 0.058, 0.068), (mouth + 0.001, 0, 0), 0.001) - bore
    link.add("dark", collar)
    link.add("rubber", wiper)
    heads = [(mouth - 0.013, side * 0.033, z) for side in (-1, 1) for z in (-0.025, 0.025)]
    link.add("metal", bolts(heads, "y", 0.0036, 0.002))
    # Access cover underneath, which faces up when the arm is folded
    link.add("panel", box((0.220, 0.040, 0.005), (0.232, 0, -TUBE_HEIGHT / 2), 0.0012))
    screws = [
        (x, y, -TUBE_HEIGHT / 2 - 0.0025) for x in (0.130, 0.232, 0.334) for y in (-0.015, 0.015)
    ]
    link.add("metal", bolts(screws, "z", 0.0028))


def _telescope_drive(link: LinkModel) -> None:
    """Add the geared motor on top of the tube."""
    link.add("dark", box((0.050, 0.044, 0.026), (0.126, 0.003, 0.046), 0.005))
    link.add(
        "metal",
        bolts([(x, y, 0.059) for x in (0.108, 0.144) for y in (-0.012, 0.018)], "z", 0.0028),
    )
    link.add("dark", finned_motor((0.148, 0.008, 0.054), "x", 1, 0.0172, 0.076, 14, 4))
    link.add("metal", cylinder(0.0095, 0.008, "x", (0.226, 0.008, 0.054), 0.001, 12))
    link.add("dark", box((0.010, 0.028, 0.012), (0.212, 0.008, 0.038), 0.002))


def _upper_hose(link: LinkModel, mouth: float) -> None:
    y, height = -0.020, 0.0475
    start = (0.060, y, 0.0365)
    link.add("metal", gland(start, "z", 1, UPPER_HOSE))
    block = mouth - 0.010
    link.add("dark", box((0.020, 0.020, 0.022), (block, y, 0.0455), 0.003))
    link.add("metal", gland((block - 0.010, y, height), "x", -1, UPPER_HOSE))
    path = [(start[0], y, start[2] + 0.007), (start[0] + 0.003, y, 0.0495),
            (0.082, y - 0.001, 0.0545), (0.150, y - 0.0025, height), (0.270, y - 0.001, height),
            (block - 0.016, y, height)]  # fmt: skip
    link.add("rubber", hose(path, UPPER_HOSE, 8, 2))
    link.add(
        "metal",
        *[
            clip((x, y - 0.001, height), "x", UPPER_HOSE, (0.008, 0.010, 0.008))
            for x in (0.200, 0.310)
        ],
    )


# ---- telescope


def _telescope(figures: Figures) -> LinkModel:
    """Return the slide; its frame lies at the mouth of the outer tube."""
    link = LinkModel("telescope_link", 2.2)
    axis = figures.elbow_x
    _slide(link, BORE_END + 0.002 - figures.telescope_x, axis - 0.040)
    _end_block(link, axis)
    return link


def _slide(link: LinkModel, rear: float, front: float) -> None:
    width, height = BORE_WIDTH - 2 * PLAY, BORE_HEIGHT - 2 * PLAY
    middle, length = (rear + front) / 2, front - rear
    body = box((length, width - 0.002, height - 0.002), (middle, 0, 0), 0.005)
    link.add(
        "metal", body - box((length + 0.01, width - 0.009, height - 0.009), (middle, 0, 0), 0.0)
    )
    # Wear strips, which slide in the bore
    strip = length - 0.050
    strips = [box((strip, 0.010, height), (middle - 0.020, y, 0), 0.0) for y in (-0.011, 0.011)]
    strips.append(box((strip, width, 0.012), (middle - 0.020, 0, -0.012), 0.0))
    core = box((length, width - 0.004, height - 0.004), (middle, 0, 0), 0.0)
    link.add("panel", union(strips) - core)
    # Scale: a mark for each 20 mm, longer ones for 100 mm; the mark at the mouth is the extension
    marks = []
    face = width / 2 - 0.001
    for k in range(1, 16):
        tall = 0.014 if k % 5 == 0 else 0.009
        marks.append(box((0.0018, 0.001, tall), (-0.020 * k, -face, 0.005 + tall / 2), 0.0))
    link.add("black", *marks)
    link.collide_box((length, width, height), (middle, 0, 0))


def _end_block(link: LinkModel, axis: float) -> None:
    """Add the stop block and the bearing of the elbow."""
    link.add("dark", box((0.020, 0.062, 0.070), (axis - 0.046, 0, 0), 0.004))
    link.add(
        "rubber",
        *[box((0.004, 0.010, 0.052), (axis - 0.0565, side * 0.024, 0), 0.001) for side in (-1, 1)],
    )
    rounded = arc_points((axis, 0), 0.042, -0.5 * math.pi, 0.5 * math.pi, 11)
    outline = [(axis - 0.050, -0.031), *rounded, (axis - 0.050, 0.031)]
    link.add("shell", prism(outline, 0.060, 0.005))
    heads = [(axis - 0.046, side * 0.031, z) for side in (-1, 1) for z in (-0.024, 0.024)]
    link.add("metal", bolts(heads, "y", 0.0034, 0.0018))
    # Bearing towards the elbow, cap on the other side
    link.add("dark", cap((axis, 0.028, 0), "y", 1, 0.038, 0.012))
    link.add("metal", cylinder(0.033, 0.0235, "y", (axis, 0.0405, 0), 0.0, 24))
    link.add("dark", cap((axis, -0.0285, 0), "y", -1, 0.033, 0.005))
    link.add("metal", bolt_circle(6, 0.0265, "y", (axis, -0.0335, 0), head=0.0028, height=0.0016))
    link.add("metal", cylinder(0.013, 0.004, "y", (axis, -0.0335, 0), 0.0, 14))
    # Hose from the slide into the bearing
    start, end = (axis - 0.046, -0.004, 0.035), (axis + 0.004, -0.004, 0.0415)
    for at in (start, end):
        link.add("metal", gland(at, "z", 1, SLIM_HOSE))
    path = [(start[0], start[1], start[2] + 0.006), (start[0] + 0.003, start[1], 0.052),
            (axis - 0.021, -0.004, 0.0615), (end[0] - 0.004, end[1], 0.0585),
            (end[0], end[1], end[2] + 0.006)]  # fmt: skip
    link.add("rubber", hose(path, SLIM_HOSE, 7, 2))
    link.collide_cylinder(0.042, 0.066, "y", (axis, -0.001, 0))
    link.collide_cylinder(0.034, 0.026, "y", (axis, 0.042, 0))
    link.collide_box((0.062, 0.022, 0.020), (axis - 0.021, -0.004, 0.051))


# ---- elbow


def _elbow(figures: Figures) -> LinkModel:
    link = LinkModel("elbow_link", 1.8)
    link.add("shell", cylinder(0.043, 0.066, "y", (0, 0.001, 0), 0.006, 24))
    link.add("accent", cylinder(0.0436, 0.006, "y", (0, -0.018, 0), 0.0, 24))
    link.add("dark", cap((0, 0.031, 0), "y", 1, 0.034, 0.007))
    link.add("metal", cylinder(0.014, 0.004, "y", (0, 0.038, 0), 0.0, 14))
    link.add("metal", bolt_circle(6, 0.027, "y", (0, 0.038, 0), 0.2, 0.0028, 0.0016))
    link.add("metal", cylinder(0.035, 0.004, "y", (0, -0.033, 0), 0.0, 24))

    flange = figures.forearm_roll_x
    neck = [(0.020, -0.031), (0.066, -0.028), (0.066, 0.028), (0.020, 0.031)]
    link.add("shell", prism(neck, 0.054, 0.006))
    drive = turned([(0, 0.056), (0.033, 0.056), (0.036, 0.062), (0.0325, 0.070), (0.036, 0.077),
                    (0.0345, flange - 0.013), (0.039, flange - 0.012), (0.039, flange - 0.003),
                    (0.037, flange - 0.001), (0, flange - 0.001)], "x", segments=24)  # fmt: skip
    link.add("dark", drive)
    neck_bolts = [(0.050, side * 0.027, z) for side in (-1, 1) for z in (-0.018, 0.018)]
    link.add("metal", bolts(neck_bolts, "y", 0.003))

    # Pedestal of the arm camera
    link.add(
        "dark",
        prism([(0.024, 0.026), (0.056, 0.024), (0.052, 0.068), (0.034, 0.068)], 0.024, 0.003),
    )
    mount_at(link, camera_housing(), figures.arm_camera)

    # Hose round the camera's pedestal to the drive of the roll joint
    start, end = (-0.012, 0.018, 0.0385), (0.083, 0.016, 0.0295)
    for at in (start, end):
        link.add("metal", gland(at, "z", 1, SLIM_HOSE))
    path = [(start[0], start[1], start[2] + 0.006), (start[0] + 0.003, start[1] + 0.001, 0.0515),
            (0.016, 0.022, 0.0590), (0.050, 0.022, 0.0580),
            (end[0] - 0.004, end[1] + 0.002, 0.0480),
            (end[0], end[1], end[2] + 0.006)]  # fmt: skip
    link.add("rubber", hose(path, SLIM_HOSE, 7, 2))
    link.collide_cylinder(0.043, 0.072, "y", (0, 0.002, 0))
    link.collide_box((0.060, 0.066, 0.066), (flange - 0.031, 0, 0))
    link.collide_box((0.064, 0.056, 0.078), (0.042, 0, 0.070))
    return link


# ---- forearm


def _forearm(figures: Figures) -> LinkModel:
    link = LinkModel("forearm_link", 1.6)
    axis = figures.wrist_pitch_x
    fork = axis - 0.075
    _forearm_tube(link, fork)
    _wrist_fork(link, axis, fork)
    _forearm_hose(link, axis)
    link.collide_cylinder(0.034, fork + 0.010, "x", ((fork + 0.010) / 2, 0, 0))
    link.collide_box((axis + 0.024 - fork, 0.076, 0.052), ((fork + axis + 0.024) / 2, 0.002, 0))
    link.collide_box((fork - 0.060, 0.014, 0.020), ((fork + 0.060) / 2, 0.035, 0))
    return link


def _forearm_tube(link: LinkModel, fork: float) -> None:
    link.add("metal", cylinder(0.036, 0.004, "x", (0.003, 0, 0), 0.0, 24))
    link.add("dark", cylinder(0.037, 0.014, "x", (0.011, 0, 0), 0.003, 24))
    link.add("shell", turned([(0, 0.016), (0.032, 0.016), (0.033, 0.020), (0.033, 0.060),
                              (0.0265, 0.082), (0.0265, fork - 0.024), (0, fork - 0.024)], "x",
                              segments=24))  # fmt: skip
    link.add("dark", turned([(0, fork - 0.028), (0.0285, fork - 0.028), (0.030, fork - 0.024),
                             (0.030, fork + 0.004), (0, fork + 0.004)], "x",
                             segments=24))  # fmt: skip
    for x, width in ((0.104, 0.014), (fork - 0.045, 0.014)):
        link.add("accent", cylinder(0.0269, width, "x", (x, 0, 0), 0.0, 24))
    # Covers of the electronics on the thick part
    link.add(
        "panel", *[box((0.030, 0.022, 0.004), (0.040, 0, side * 0.0325), 0.001) for side in (-1, 1)]
    )


def _wrist_fork(link: LinkModel, axis: float, fork: float) -> None:
    link.add("dark", box((0.026, 0.070, 0.050), (fork + 0.013, 0, 0), 0.006))
    rounded = arc_points((axis, 0), 0.024, -0.5 * math.pi, 0.5 * math.pi, 11)
    outline = [(fork + 0.006, -0.0225), *rounded, (fork + 0.006, 0.0225)]
    link.add(
        "dark", *[prism(outline, 0.0095, 0.002, at=(0, side * 0.02975, 0)) for side in (-1, 1)]
    )
    link.add(
        "accent",
        *[box((0.012, 0.0012, 0.030), (fork + 0.034, side * 0.0345, 0), 0.0) for side in (-1, 1)],
    )
    heads = [(fork + 0.013, side * 0.035, z) for side in (-1, 1) for z in (-0.016, 0.016)]
    link.add("metal", bolts(heads, "y", 0.0032, 0.0018))
    # Motor of the wrist on the left, bearing cap on the right
    link.add("dark", finned_motor((axis, 0.0335, 0), "y", 1, 0.0195, 0.013, 14, 1))
    link.add("metal", cylinder(0.0085, 0.004, "y", (axis, 0.0460, 0), 0.0, 12))
    link.add("metal", cylinder(0.0175, 0.004, "y", (axis, -0.0352, 0), 0.0, 16))
    link.add("dark", bolt_circle(4, 0.0125, "y", (axis, -0.0372, 0), head=0.0024, height=0.0012))


def _forearm_hose(link: LinkModel, axis: float) -> None:
    start, end = (0.066, 0.034, 0.0), (axis - 0.0185, 0.0400, 0.0)
    link.add("dark", box((0.018, 0.018, 0.016), (start[0] - 0.009, start[1], 0), 0.003))
    link.add("metal", gland(start, "x", 1, SLIM_HOSE))
    link.add("metal", gland(end, "x", -1, SLIM_HOSE))
    path = [(start[0] + 0.006, start[1], 0), (0.120, 0.0325, 0.001), (0.200, 0.0325, -0.001),
            (0.262, 0.0345, 0), (0.300, 0.0408, 0), (end[0] - 0.006, end[1], 0)]  # fmt: skip
    link.add("rubber", hose(path, SLIM_HOSE, 7, 2))
    for x in (0.135, 0.215):
        band = clip((0, 0, 0), "x", SLIM_HOSE, (0.008, 0.010, 0.006))
        link.add("metal", _foot_towards_axis(band).translate((x, 0.0325, 0)))


def _foot_towards_axis(band: Manifold) -> Manifold:
    """Turn a clip about x so that its foot points to -y instead of -z."""
    return band.rotate((-90, 0, 0))


# ---- wrist


def _wrist(figures: Figures) -> LinkModel:
    link = LinkModel("wrist_link", 1.0)
    flange = figures.gripper_roll_x
    link.add("metal", cylinder(0.0232, 0.047, "y", bevel=0.0, segments=24))
    link.add("dark", cylinder(0.0236, 0.012, "y", bevel=0.0, segments=24))
    neck = [
        (0.012, -0.0190),
        (0.040, -0.0230),
        (0.086, -0.0230),
        (0.086, 0.0230),
        (0.040, 0.0230),
        (0.012, 0.0190),
    ]
    body = prism(neck, 0.045, 0.006)
    pockets = [box((0.030, 0.004, 0.026), (0.056, side * 0.0225, 0), 0.0015) for side in (-1, 1)]
    link.add("shell", body - union(pockets))
    link.add("dark", turned([(0, flange - 0.032), (0.027, flange - 0.032),
                             (0.034, flange - 0.026), (0.034, flange - 0.004),
                             (0.032, flange - 0.002), (0, flange - 0.002)], "x",
                             segments=24))  # fmt: skip
    link.add("accent", cylinder(0.0343, 0.003, "x", (flange - 0.009, 0, 0), 0.0, 24))
    link.add(
        "metal",
        bolts(
            [(0.036, side * 0.0225, z) for side in (-1, 1) for z in (-0.013, 0.013)], "y", 0.0026
        ),
    )
    # Hose beside the neck: above or below it would meet the forearm at the ends of the range
    start, end = (0.050, -0.0205, 0.004), (flange - 0.030, -0.0265, 0.0)
    link.add("metal", gland(start, "y", -1, 0.0036))
    link.add("metal", gland(end, "x", -1, 0.0036))
    path = [(start[0], start[1] - 0.006, start[2]), (start[0] + 0.003, -0.0345, 0.004),
            (0.064, -0.0335, 0.001), (end[0] - 0.006, end[1], 0.0)]  # fmt: skip
    link.add("rubber", hose(path, 0.0036, 6, 2))
    link.collide_box((flange + 0.022, 0.050, 0.048), ((flange - 0.022) / 2, 0, 0))
    link.collide_cylinder(0.034, 0.028, "x", (flange - 0.016, 0, 0))
    return link
