"""Sides of the hull: flanges of the flippers, heat sink, covers, connectors. Lengths in m."""

from __future__ import annotations

from ..fittings import bolt_circle, bolts
from ..solids import box, cylinder, hose, prism, ring
from .plan import HullPlan


def add(plan: HullPlan) -> None:
    """Add what is on both sides."""
    for y in (-1, 1):
        _axles(plan, y)
    _cooling_fins(plan)
    _service_panel(plan)


def _axles(plan: HullPlan, y: int) -> None:
    """Add the flanges that carry the flippers, and their axles."""
    pivot_x, pivot_y = plan.figures.flipper["pivot_x"], plan.figures.flipper["pivot_y"]
    inner, outer = plan.side - 0.005, pivot_y - 0.025
    for x in (-pivot_x, pivot_x):
        flange = cylinder(0.0440, 0.013, "y", (x, y * (plan.side - 0.001), 0), 0.0, 20)
        face = (x, y * (plan.side + 0.0055), 0)
        plan.link.add("metal", flange, bolt_circle(6, 0.0365, "y", face, 0.2, 0.0036, 0.0018))
        middle = (x, y * (inner + outer) / 2, 0)
        plan.link.add("dark", cylinder(0.0260, outer - inner, "y", middle, 0.0, 14))


def _cooling_fins(plan: HullPlan) -> None:
    """Fill the left recess: heat sink of the drives' electronics, beside a filter grille."""
    y = plan.side - 0.0060
    plan.link.add("dark", box((0.176, 0.004, 0.084), (0.060, y, 0.083), 0.0))
    for k in range(18):
        fin = box((0.0024, 0.0090, 0.080), (-0.020 + 0.0094 * k, y + 0.0035, 0.083), 0.0)
        plan.link.add("metal", fin)
    _cover(plan, -0.092, 1, 0.116)
    slots = [
        box((0.072, 0.0012, 0.0034), (-0.092, plan.side - 0.0001, 0.064 + 0.0085 * k), 0.0)
        for k in range(5)
    ]
    plan.link.add("black", *slots)


def _service_panel(plan: HullPlan) -> None:
    """Fill the right recess: two covers, and between them connectors with a cable."""
    for x in (-0.102, 0.102):
        _cover(plan, x, -1, 0.096)
    y = -plan.side + 0.0055
    for x, z, radius in (
        (-0.026, 0.102, 0.0105),
        (0.008, 0.102, 0.0105),
        (0.034, 0.106, 0.0070),
        (0.034, 0.086, 0.0070),
    ):
        plan.link.add("metal", ring(radius, 0.6 * radius, 0.010, "y", (x, y - 0.003, z), 0.0, 12))
        plan.link.add("black", cylinder(0.62 * radius, 0.006, "y", (x, y - 0.003, z), 0.0, 12))
    cable = [
        (-0.026, y - 0.004, 0.102),
        (-0.026, y - 0.0045, 0.080),
        (-0.006, y - 0.003, 0.058),
        (0.008, y - 0.0045, 0.080),
        (0.008, y - 0.004, 0.102),
    ]
    plan.link.add("rubber", hose(cable, 0.0034, 6, 2))
    plan.link.add("accent", box((0.020, 0.0010, 0.010), (0.034, y - 0.0005, 0.058), 0.0))


def _cover(plan: HullPlan, x: float, y: int, length: float) -> None:
    """Add a bolted side cover in the recess, flush with the hull."""
    corner = [(-1, -0.8), (-0.92, -1), (0.92, -1), (1, -0.8), (1, 0.8), (0.92, 1), (-0.92, 1)]
    outline = [(a * length / 2, b * 0.042) for a, b in [*corner, (-1, 0.8)]]
    middle = (x, y * (plan.side - 0.0030), 0.083)
    plan.link.add("hull", prism(outline, 0.006, 0.0012, at=middle))
    reach = length / 2 - 0.008
    places = [(x + a * reach, y * plan.side, 0.083 + b * 0.0345) for a in (-1, 1) for b in (-1, 1)]
    plan.link.add("metal", bolts(places, "y", 0.0030, 0.0014))
