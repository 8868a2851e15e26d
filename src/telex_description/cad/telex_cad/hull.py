"""The hull: casting, what is inside it, and all that is fitted to it.

Lengths in m, in base_link: on the axle line, x forward, z up.
"""

from __future__ import annotations

from typing import List

from manifold3d import JoinType

from .figures import Figures
from .hull_parts import deck as hull_deck
from .hull_parts import ends as hull_ends
from .hull_parts import sides as hull_sides
from .hull_parts.deck import HATCHES
from .hull_parts.plan import HullPlan
from .link_model import LinkModel
from .solids import box, cylinder, outline_of, prism, slab, turned
from .upper import mast

WALL = 0.005
# To the left, where batteries and electronics stand
BALANCE = 0.048
# Round seat of the turret in the deck
SEAT_RADIUS = 0.113


def links(figures: Figures) -> List[LinkModel]:
    """Return the hull."""
    plan = HullPlan(figures, LinkModel("base_link", figures.hull["mass"]))
    _casting(plan)
    _inner_parts(plan)
    for module in (hull_sides, hull_deck, hull_ends, mast):
        module.add(plan)
    return [plan.link]


def _casting(plan: HullPlan) -> None:
    """Add the hollow body with its recesses, and the seat of the turret."""
    width = 2 * plan.side
    section = outline_of(plan.profile())
    body = prism(plan.profile(), width, 0.006)
    body -= slab(section.offset(-WALL, JoinType.Miter), width - 2 * WALL)
    for y in (-1, 1):
        body -= box((0.312, 0.012, 0.096), (0, y * plan.side, 0.083), 0.0)
    plan.link.add("hull", body)
    for y in (-1, 1):
        floor = box((0.312, WALL, 0.096), (0, y * (plan.side - 0.0085), 0.083), 0.0)
        plan.link.add("panel", floor)
        # Sills above and below the recess
        for z in (0.030, 0.136):
            plan.link.add("hull", box((0.322, 0.007, 0.006), (0, y * plan.side, z), 0.0015))
        stripe = box((0.300, 0.0016, 0.010), (0, y * (plan.side + 0.0002), 0.012), 0.0)
        plan.link.add("accent", stripe)
    deck, rim = plan.deck, SEAT_RADIUS
    outside = [(0.080, 0.070), (rim, 0.124), (rim, deck - 0.0015), (rim - 0.0015, deck), (0, deck)]
    inside = [(0, deck - WALL), (rim - WALL, deck - WALL), (rim - WALL, 0.126), (0.074, 0.070)]
    seat = turned([*outside, *inside], "z", (plan.figures.turret_x, 0, 0), 44)
    plan.link.add("hull", seat)
    plan.link.collide_hull([(x, y, z) for x, z in plan.profile() for y in (-plan.side, plan.side)])


def _inner_parts(plan: HullPlan) -> None:
    """Add what weighs but is not seen: batteries, flipper and track drives, electronics.

    What can stand aside makes up for the arm, whose upper part hangs to the right of the turret:
    belts that bear alike on both sides turn the robot in place; others drive it off.
    """
    for x in HATCHES:
        at = (x - 0.010, BALANCE, 0.055)
        plan.link.add_inside("battery", box((0.125, 0.150, 0.108), at, 0.0))
    pivot = plan.figures.flipper["pivot_x"]
    for x in (-1, 1):
        for y in (-1, 1):
            plan.link.add_inside(
                "drive", cylinder(0.036, 0.085, "y", (x * (pivot - 0.02), y * 0.080, 0.0))
            )
    plan.link.add_inside("electronics", box((0.150, 0.150, 0.096), (0.150, BALANCE, 0.040), 0.0))
    plan.link.add_inside("drive", cylinder(0.060, 0.050, "z", (plan.figures.turret_x, 0, 0.125)))
