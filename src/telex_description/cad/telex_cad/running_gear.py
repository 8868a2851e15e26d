"""Flippers with their belts, and the drive wheels of the belts.

Lengths in m. A flipper's frame lies on its pivot, y along the axle; at zero the lower run of the
belt is flat on the floor. The front flipper points along +x, the rear one is its mirror image.
Both faces of a flipper are alike, so that left and right ones share their meshes.
"""

from __future__ import annotations

import math
from typing import Dict, List, Tuple

from manifold3d import CrossSection, Manifold

from .figures import Figures
from .link_model import LinkModel
from .solids import PROUD, box, cylinder, outline_of, prism, ring, slab, union, warning_stripes

Point = Tuple[float, float]
Corner = Tuple[float, float, float]

CLEAT_HEIGHT = 0.008
BELT_THICKNESS = 0.006
# From cleat to cleat of the same row
CLEAT_PITCH = 0.0320
# Where the side plates' faces lie, inwards of the belt's edges
PLATE_SINK = 0.0030
# From the cleats' tips inwards to the edge of the side plates
PLATE_MARGIN = 0.0185
HUB_HOLE = 0.0815
TIP_HOLE = 0.0330
# Of the collision shape: by how much a belt is lower at its edges, and the runs beside the wheels.
# The latter is more than a belt sinks in under a quarter of the robot, or two shapes would bear.
CROWN = 0.0002
RUN_SAG = 0.0025


def millimetres(length: float) -> int:
    """Return a flipper's length as the names of its files have it."""
    return round(1000 * length)


def links(figures: Figures) -> List[LinkModel]:
    """Return the standard flippers and the drive wheel."""
    length = millimetres(figures.flipper["length"])
    return [flipper(figures, "front", length), flipper(figures, "rear", length), track(figures)]


class BeltOutline:
    """Tapered stadium around both axles: the belt's side view.

    Parameters
    ----------
    hub, tip
        Radii at the cleats' tips.
    length
        Between the axles.
    """

    def __init__(self, hub: float, tip: float, length: float) -> None:
        self.hub = hub
        self.tip = tip
        drop = hub - tip
        # The tip axle lies lower than the pivot, so that the lower run is level.
        self.tip_axle: Point = (math.sqrt(length**2 - drop**2), -drop)
        # Normals of both runs; they are tangents, mirrored about the line of the axles.
        self._lower = -math.pi / 2
        self._upper = math.pi / 2 - 2 * math.asin(drop / length)

    def points(self, inwards: float, segments: int) -> List[Point]:
        """Return the corners (x, z), counterclockwise; each arc has so many segments."""
        return _arc(self.tip_axle, self.tip - inwards, self._lower, self._upper, segments) + _arc(
            (0.0, 0.0), self.hub - inwards, self._upper, self._lower + 2 * math.pi, segments
        )

    def bearing_hulls(self, half: float, segments: int) -> List[List[Corner]]:
        """Return the corners of three convex bodies that bear where a belt does.

        They are the hub, the tip and the runs between; each has one point that is lowest, in the
        middle of the belt, so that it touches a plane in one contact. PyBullet finds but one
        contact of a body with a plane in a step: of a single hull that lies flat on its whole
        length it would find now this corner and now that.

        Parameters
        ----------
        half
            Of the belt's width.
        segments
            Of the whole circle of the hub, and of the tip.
        """
        tip, lower, upper = self.tip_axle, self._lower, self._upper
        around = [lower + 2 * math.pi * k / segments for k in range(segments)]
        wheels = [((0.0, 0.0), self.hub), (tip, self.tip)]
        hulls = [
            [corner for a in around for corner in _crowned(centre, radius, a, half)]
            for centre, radius in wheels
        ]
        between = ((tip[0] / 2, tip[1] / 2), (self.hub + self.tip) / 2)
        runs = [*((centre, radius - RUN_SAG) for centre, radius in wheels), between]
        hulls.append(
            [
                corner
                for centre, radius in runs
                for a in (lower, upper)
                for corner in _crowned(centre, radius, a, half)
            ]
        )
        return hulls

    def section(self, inwards: float, segments: int = 20) -> CrossSection:
        """Return the section."""
        return outline_of(self.points(inwards, segments))

    def stations(self, inwards: float, count: int) -> List[Tuple[float, float, float]]:
        """Return evenly spaced points of the outline: x, z, direction of travel (rad)."""
        corners = self.points(inwards, 90)
        sides = list(zip(corners, corners[1:] + corners[:1]))
        lengths = [math.dist(start, end) for start, end in sides]
        spacing = sum(lengths) / count
        found: List[Tuple[float, float, float]] = []
        passed, wanted = 0.0, 0.0
        for (start, end), length in zip(sides, lengths):
            while len(found) < count and wanted < passed + length:
                part = (wanted - passed) / length
                x, z = (a + part * (b - a) for a, b in zip(start, end))
                found.append((x, z, math.atan2(end[1] - start[1], end[0] - start[0])))
                wanted += spacing
            passed += length
        return found

    def upper_run(self, x: float, inwards: float) -> float:
        """Return z of the upper run at x between the axles."""
        return (self.hub - inwards - x * math.cos(self._upper)) / math.sin(self._upper)

    def upper_slope(self) -> float:
        """Return by how much the upper run falls towards the tip (rad)."""
        return math.pi / 2 - self._upper


def _crowned(centre: Point, radius: float, angle: float, half: float) -> List[Corner]:
    """Corners of a cross-section of the belt: in its middle, and lower at its edges."""
    x, z = math.cos(angle), math.sin(angle)
    return [
        (centre[0] + (radius - sink) * x, y, centre[1] + (radius - sink) * z)
        for y, sink in ((0.0, 0.0), (half, CROWN), (-half, CROWN))
    ]


def _arc(centre: Point, radius: float, start: float, end: float, segments: int) -> List[Point]:
    angles = [start + (end - start) * k / segments for k in range(segments + 1)]
    return [(centre[0] + radius * math.cos(a), centre[1] + radius * math.sin(a)) for a in angles]


# ---- flipper


def flipper(figures: Figures, end: str, length: int) -> LinkModel:
    """Return a flipper of a length (mm), with its belt; end: "front" or "rear".

    One of another length weighs as much more as its solids do.
    """
    parts = _flipper_parts(figures, length / 1000)
    mass = figures.flipper["mass"]
    standard = millimetres(figures.flipper["length"])
    if length != standard:
        mass *= _weight(parts) / _weight(_flipper_parts(figures, figures.flipper["length"]))
    link = LinkModel(f"flipper_{end}_{length}", mass)
    link.belt = "rubber"
    sign = 1.0 if end == "front" else -1.0
    for material, solids in parts.items():
        merged = union(solids)
        link.add(material, merged if sign > 0 else merged.mirror((1, 0, 0)))
    half = figures.flipper["width"] / 2
    segments = int(figures.flipper["wheel_segments"])
    for corners in _outline(figures, length / 1000).bearing_hulls(half, segments):
        link.collide_hull([(sign * x, y, z) for x, y, z in corners])
    return link


def _weight(parts: Dict[str, List[Manifold]]) -> float:
    link = LinkModel("flipper", 1.0)
    for material, solids in parts.items():
        link.add(material, *solids)
    return 1.0 / link.mass_properties().density_scale


def _outline(figures: Figures, length: float) -> BeltOutline:
    return BeltOutline(figures.flipper["hub_radius"], figures.flipper["tip_radius"], length)


def _flipper_parts(figures: Figures, length: float) -> Dict[str, List[Manifold]]:
    """Return the solids of a front flipper by material. All but the belt run through both faces."""
    outline = _outline(figures, length)
    width = figures.flipper["width"]
    face = width / 2 - PLATE_SINK
    window = _Window(outline)
    parts: Dict[str, List[Manifold]] = {
        "rubber": _belt(outline, width),
        "shell": [_body(outline, window, face)],
        "metal": [
            ring(
                HUB_HOLE + 0.0085, HUB_HOLE + 0.0010, 2 * face + 0.0024, "y", bevel=0, segments=36
            ),
            *_bolts_around((0.0, 0.0), HUB_HOLE + 0.0048, 8, face + 0.0024, 0.0023),
            *_edge_bolts(outline, face),
        ],
        "dark": [],
    }
    _add_window(parts, window, face)
    _add_idler(parts, outline.tip_axle, face)
    _add_rollers(parts, outline, face)
    return parts


def _belt(outline: BeltOutline, width: float) -> List[Manifold]:
    """Return the belt and its cleats: bars over half the width, staggered."""
    back = outline.section(CLEAT_HEIGHT, 16)
    back -= outline.section(CLEAT_HEIGHT + BELT_THICKNESS, 16)
    corners = outline.points(CLEAT_HEIGHT, 60)
    length = sum(math.dist(a, b) for a, b in zip(corners, corners[1:] + corners[:1]))
    count = 2 * round(length / CLEAT_PITCH)
    profile = [(-0.0080, 0.002), (-0.0050, -CLEAT_HEIGHT), (0.0050, -CLEAT_HEIGHT), (0.0080, 0.002)]
    bar = prism(profile, width / 2 - 0.0010, 0.0)
    solids = [slab(back, width - 0.0010)]
    for k, (x, z, direction) in enumerate(outline.stations(CLEAT_HEIGHT, count)):
        side = (0.5 - k % 2) * (width / 2 + 0.0010)
        turned = bar.rotate((0.0, -math.degrees(direction), 0.0))
        solids.append(turned.translate((x, side, z)))
    return solids


class _Window:
    """Opening in the side plates, tapered like the flipper."""

    def __init__(self, outline: BeltOutline) -> None:
        near, far = HUB_HOLE + 0.036, outline.tip_axle[0] - TIP_HOLE - 0.046
        low = 0.060 - outline.hub
        self._rounds = []
        for x, radius in ((near, 0.013), (far, 0.010)):
            top = outline.upper_run(x, PLATE_MARGIN + 0.024) - radius
            self._rounds += [(x, top, radius), (x, low + radius, radius)]
        self.slope = outline.upper_slope() / 2

    def section(self, inwards: float) -> CrossSection:
        """Return the section."""
        return CrossSection.batch_hull(
            [
                CrossSection.circle(radius - inwards, 16).translate((x, z))
                for x, z, radius in self._rounds
            ]
        )

    def corners(self) -> List[Point]:
        """Return the centres of the four rounded corners."""
        return [(x, z) for x, z, _ in self._rounds]


def _body(outline: BeltOutline, window: _Window, face: float) -> Manifold:
    """Return the beam with its two side plates, open for wheel, idler and window."""
    plates = outline.section(PLATE_MARGIN, 14)
    plates -= CrossSection.circle(HUB_HOLE, 32)
    plates -= CrossSection.circle(TIP_HOLE, 20).translate(outline.tip_axle)
    plates -= window.section(0.0)
    beam = outline.section(CLEAT_HEIGHT + BELT_THICKNESS + 0.0005, 10)
    beam -= CrossSection.circle(HUB_HOLE, 32)
    return slab(plates, 2 * face) + slab(beam, 2 * face - 0.018)


def _add_window(parts: Dict[str, List[Manifold]], window: _Window, face: float) -> None:
    """Close the window with sunk covers that carry warning stripes."""
    sunk = 2 * (face - 0.0050)
    parts["panel"] = [slab(window.section(0.0006), sunk)]
    corners = window.corners()
    left, right = corners[0][0], corners[2][0]
    middle = (left + right) / 2
    centre = sum(z for _, z in corners) / 4
    plate, bars = warning_stripes(right - left + 0.004, 0.026, sunk + 2 * PROUD, 0.036)
    for material, solid in (("accent", plate), ("black", bars)):
        parts[material] = [
            solid.rotate((0, math.degrees(window.slope), 0)).translate((middle, 0, centre))
        ]
    parts["metal"] += [through_bolt((x, z), sunk / 2 + 0.0014, 0.0028) for x, z in corners]


def _add_idler(parts: Dict[str, List[Manifold]], axle: Point, face: float) -> None:
    """Fill the hole at the tip with the wheel that the belt runs around, and its tensioner."""
    x, z = axle
    rim = TIP_HOLE - 0.0015
    parts["metal"] += [
        ring(rim, rim - 0.0075, 2 * face - 0.0030, "y", (x, 0, z), 0.0, 24),
        cylinder(0.0125, 2 * face + 0.0016, "y", (x, 0, z), 0.0, 14),
        *_bolts_around(axle, 0.0190, 4, face - 0.0030, 0.0026),
    ]
    parts["dark"].append(cylinder(rim - 0.004, 2 * face - 0.0090, "y", (x, 0, z), 0.0, 20))
    slot = x - TIP_HOLE - 0.019
    parts["dark"].append(box((0.026, 2 * face + 0.0010, 0.014), (slot, 0, z + 0.004), 0.0))
    parts["metal"] += [
        box((0.009, 2 * face + 0.0040, 0.0095), (slot + 0.004, 0, z + 0.004), 0.0),
        through_bolt((slot - 0.008, z + 0.004), face + 0.0012, 0.0022),
    ]


def _add_rollers(parts: Dict[str, List[Manifold]], outline: BeltOutline, face: float) -> None:
    """Add the rollers that carry the lower run."""
    first, last = HUB_HOLE + 0.020, outline.tip_axle[0] - TIP_HOLE - 0.012
    count = max(2, round((last - first) / 0.085))
    z = CLEAT_HEIGHT + BELT_THICKNESS + 0.0200 - outline.hub
    for k in range(count + 1):
        x = first + (last - first) * k / count
        parts["dark"].append(cylinder(0.0150, 2 * face + 0.0016, "y", (x, 0, z), 0.0, 14))
        parts["metal"].append(cylinder(0.0062, 2 * face + 0.0030, "y", (x, 0, z), 0.0, 8))


def _edge_bolts(outline: BeltOutline, face: float) -> List[Manifold]:
    """Return the bolts along the upper edge."""
    first, last = 0.075, outline.tip_axle[0] - 0.015
    count = max(3, round((last - first) / 0.075))
    places = [first + (last - first) * k / count for k in range(count + 1)]
    upper = [(x, outline.upper_run(x, PLATE_MARGIN + 0.0105)) for x in places]
    return [through_bolt(place, face + 0.0018, 0.0034) for place in upper]


def _bolts_around(
    centre: Point, radius: float, count: int, face: float, head: float
) -> List[Manifold]:
    """Return bolts on a circle that stand out to y = +-face."""
    angles = [2 * math.pi * (k + 0.5) / count for k in range(count)]
    return [
        through_bolt(
            (centre[0] + radius * math.cos(a), centre[1] + radius * math.sin(a)), face, head
        )
        for a in angles
    ]


def through_bolt(place: Point, face: float, radius: float) -> Manifold:
    """Return a hexagon bar along y through (x, z) whose ends are the heads on both faces."""
    return cylinder(radius, 2 * face, "y", (place[0], 0, place[1]), 0.0, 6)


# ---- drive wheel


def track(figures: Figures) -> LinkModel:
    """Return the drive wheel of a belt: its spokes show whether and how the belt runs."""
    half = figures.flipper["width"] / 2
    link = LinkModel("track", figures.flipper["wheel_mass"])
    rim = ring(HUB_HOLE - 0.0015, 0.0645, 2 * half - 0.0090, "y", bevel=0, segments=32)
    band = ring(0.0745, 0.0690, 2 * half - 0.0084, "y", bevel=0, segments=32)
    spoke = prism(
        [(0.020, -0.0100), (0.067, -0.0055), (0.067, 0.0055), (0.020, 0.0100)],
        2 * half - 0.013,
        0.0025,
    )
    link.add("metal", rim, *[spoke.rotate((0, 60.0 * k, 0)) for k in range(6)])
    link.add("accent", band)
    link.add("dark", cylinder(0.0250, 2 * half - 0.0050, "y", bevel=0.0020, segments=24))
    link.add("metal", *_bolts_around((0.0, 0.0), 0.0170, 6, half - 0.0010, 0.0027))
    link.add("panel", cylinder(0.0090, 2 * half, "y", bevel=0.0010, segments=14))
    return link
