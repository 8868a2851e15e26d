"""Deck of the hull: handles, battery covers, emergency stop, cables. Lengths in m."""

from __future__ import annotations

from manifold3d import CrossSection, JoinType, Manifold

from ..fittings import bolts, gland
from ..solids import PROUD, box, cylinder, hose, ring, slab, turned, warning_stripes
from .plan import HullPlan, Point

# Battery covers: middle along x, sizes
HATCHES = (-0.166, -0.012)
HATCH_LENGTH = 0.142
HATCH_WIDTH = 0.204


def add(plan: HullPlan) -> None:
    """Add what stands on the deck."""
    for y in (-1, 1):
        _handle(plan, y)
    _hatches(plan)
    _emergency_stop(plan)
    _turret_cables(plan)


def _handle(plan: HullPlan, y: int) -> None:
    """Add a carrying handle along an edge of the deck."""
    across, top = y * 0.1205, plan.deck
    ends = (-0.186, 0.008)
    path = [
        (ends[0], across, top + 0.002),
        (ends[0] + 0.004, across, top + 0.026),
        (ends[0] + 0.024, across, top + 0.038),
        (ends[1] - 0.024, across, top + 0.038),
        (ends[1] - 0.004, across, top + 0.026),
        (ends[1], across, top + 0.002),
    ]
    plan.link.add("dark", hose(path, 0.0055, 8, 2))
    grip = (ends[0] + ends[1]) / 2
    ridges = [
        (0.0075 + 0.0010 * (k % 2), -0.046 + 0.017 * (k // 2) + 0.004 * (k % 2)) for k in range(12)
    ]
    profile = [(0, -0.055), (0.0070, -0.055), *ridges, (0.0070, 0.055), (0, 0.055)]
    plan.link.add("rubber", turned(profile, "x", (grip, across, top + 0.038), 10))
    for x in ends:
        plan.link.add("metal", box((0.030, 0.022, 0.004), (x, across, top + 0.002), 0.0))
        feet = [(x + side * 0.011, across, top + 0.004) for side in (-1, 1)]
        plan.link.add("metal", bolts(feet, "z", 0.0026, 0.0014))
    plan.link.collide_box((ends[1] - ends[0] + 0.020, 0.017, 0.047), (grip, across, top + 0.0235))


def _hatches(plan: HullPlan) -> None:
    """Add the battery covers: gaskets, lids with latches, and stripes where they meet."""
    top = plan.deck
    for x in HATCHES:
        gasket = slab(_rounded(HATCH_LENGTH, HATCH_WIDTH, 0.012), 0.003, plane="xy")
        plan.link.add("rubber", gasket.translate((x, 0, top + 0.001)))
        lid = slab(_rounded(HATCH_LENGTH - 0.005, HATCH_WIDTH - 0.005, 0.010), 0.007, 0.0015, "xy")
        well = box((0.050, 0.034, 0.008), (x, 0, top + 0.0090), 0.0)
        plan.link.add("hull", lid.translate((x, 0, top + 0.0055)) - well)
        plan.link.add("metal", cylinder(0.0032, 0.050, "x", (x, 0, top + 0.0072), 0.0, 10))
        for y in (-1, 1):
            plan.link.add("hull", _ribbed_field((x, y * 0.056), top))
            _latch(plan, (x - 0.036, y * (HATCH_WIDTH / 2 - 0.003)), y)
            _latch(plan, (x + 0.036, y * (HATCH_WIDTH / 2 - 0.003)), y)
        inset_x, inset_y = HATCH_LENGTH / 2 - 0.0085, HATCH_WIDTH / 2 - 0.0085
        corners = [(x + a * inset_x, b * inset_y, top + 0.009) for a in (-1, 1) for b in (-1, 1)]
        plan.link.add("metal", bolts(corners, "z", 0.0032, 0.0016))
    plate, bars = warning_stripes(0.170, 0.008, 0.0012, 0.020)
    for material, solid in (("accent", plate), ("black", bars)):
        flat = solid.rotate((90, 0, 0)).rotate((0, 0, 90))
        plan.link.add(material, flat.translate((sum(HATCHES) / 2, 0, top + PROUD)))


def _ribbed_field(place: Point, top: float) -> Manifold:
    """Return the raised, grooved field that stiffens half of a lid."""
    x, y = place
    field = slab(_rounded(HATCH_LENGTH - 0.034, 0.056, 0.006), 0.005, 0.0015, "xy")
    field = field.translate((x, y, top + 0.0095))
    for k in range(4):
        across = y + 0.0094 * (k - 1.5)
        field -= box((HATCH_LENGTH - 0.052, 0.0035, 0.004), (x, across, top + 0.0122), 0.0)
    return field


def _latch(plan: HullPlan, place: Point, y: int) -> None:
    """Add an over-centre latch at the edge of a lid."""
    x, across = place
    top = plan.deck
    plan.link.add("metal", box((0.016, 0.013, 0.003), (x, across - y * 0.002, top + 0.0095), 0.0))
    plan.link.add("metal", box((0.012, 0.0045, 0.010), (x, across + y * 0.0045, top + 0.0055), 0.0))
    plan.link.add(
        "dark", cylinder(0.0028, 0.019, "x", (x, across + y * 0.0025, top + 0.0105), 0.0, 6)
    )


def _emergency_stop(plan: HullPlan) -> None:
    """Add the emergency stop in its collar."""
    at = (-0.262, -0.085, plan.deck)
    x, y, top = at
    plan.link.add(
        "accent",
        turned([(0, 0), (0.0215, 0), (0.0215, 0.008), (0.0195, 0.010), (0, 0.010)], "z", at, 20),
    )
    plan.link.add("dark", ring(0.0205, 0.0178, 0.007, "z", (x, y, top + 0.0130), 0.0, 20))
    plan.link.add("dark", cylinder(0.0090, 0.012, "z", (x, y, top + 0.014), 0.0, 10))
    button = [(0, 0.017), (0.0150, 0.017), (0.0166, 0.0195), (0.0166, 0.0235), (0.0125, 0.0285)]
    plan.link.add("red", turned([*button, (0, 0.0300)], "z", at, 20))
    plan.link.collide_cylinder(0.0215, 0.031, "z", (x, y, top + 0.0155))


def _turret_cables(plan: HullPlan) -> None:
    """Add two cables behind the turret, each in an arc from gland to gland."""
    top = plan.deck
    for near, far, radius in ((0.034, 0.068, 0.0048), (-0.036, -0.071, 0.0042)):
        start, end = (0.092, near), (0.074, far)
        for x, y in (start, end):
            plan.link.add("metal", gland((x, y, top), "z", 1, radius))
        path = [
            (*start, top + 0.006),
            (start[0] - 0.002, near + 0.2 * (far - near), top + 0.018),
            (end[0] + 0.002, near + 0.8 * (far - near), top + 0.018),
            (*end, top + 0.006),
        ]
        plan.link.add("rubber", hose(path, radius, 8, 2))


def _rounded(length: float, width: float, radius: float) -> CrossSection:
    """Return a rectangle with rounded corners."""
    core = CrossSection.square((length - 2 * radius, width - 2 * radius), True)
    return core.offset(radius, JoinType.Round, 2.0, 12)
