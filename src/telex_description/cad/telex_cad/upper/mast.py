"""Mast of the overview camera, and the antenna. Lengths in m."""

from __future__ import annotations

from ..fittings import bolts
from ..housings import camera_housing, mount
from ..hull_parts.plan import HullPlan
from ..solids import box, cylinder, hose, prism, ring, turned


def add(plan: HullPlan) -> None:
    """Add the mast of the overview camera, and the antenna."""
    _mast(plan)
    _antenna(plan)


def _mast(plan: HullPlan) -> None:
    """Add the telescoped tube on its foot, camera and cable."""
    camera = plan.figures.mast_camera
    x, y, top = camera["x"] - 0.034, camera["y"], plan.deck
    head = camera["z"] - 0.030
    plan.link.add("dark", box((0.050, 0.050, 0.010), (x, y, top + 0.004), 0.002))
    feet = [(x + a * 0.018, y + b * 0.018, top + 0.009) for a in (-1, 1) for b in (-1, 1)]
    plan.link.add("metal", bolts(feet, "z", 0.0034, 0.002))
    webs = [
        prism([(0.010, 0.006), (0.024, 0.006), (0.010, 0.040)], 0.003, 0.0)
        .rotate((0, 0, 90 * k + 45))
        .translate((x, y, top))
        for k in range(4)
    ]
    plan.link.add("dark", *webs)
    middle = top + 0.52 * (head - top)
    plan.link.add("dark", cylinder(0.0130, middle - top, "z", (x, y, (middle + top) / 2), 0.0, 20))
    plan.link.add(
        "metal", cylinder(0.0100, head - middle, "z", (x, y, (middle + head) / 2), 0.0, 18)
    )
    plan.link.add("dark", ring(0.0165, 0.0100, 0.018, "z", (x, y, middle), 0.0, 18))
    plan.link.add(
        "metal",
        cylinder(0.0026, 0.016, "y", (x, y + 0.020, middle), 0.0, 8),
        cylinder(0.0070, 0.005, "y", (x, y + 0.028, middle), 0.001, 10),
    )
    plan.link.add("accent", ring(0.0136, 0.0120, 0.014, "z", (x, y, middle - 0.040), 0.0, 20))
    seat = [(-0.014, -0.008), (0.014, -0.008), (0.020, 0.014), (-0.014, 0.014)]
    plan.link.add("dark", prism(seat, 0.022, 0.002, at=(x, y, head)))
    mount(plan.link, camera_housing(), (camera["x"], camera["y"], camera["z"]), camera["pitch"])
    cable = [
        (x - 0.022, y, top),
        (x - 0.021, y, top + 0.030),
        (x - 0.0165, y, top + 0.100),
        (x - 0.0165, y, middle - 0.03),
        (x - 0.0205, y, middle),
        (x - 0.0150, y, middle + 0.05),
        (x - 0.0145, y, head - 0.02),
        (x - 0.018, y, head + 0.010),
        (x - 0.010, y, head + 0.030),
    ]
    plan.link.add("rubber", hose(cable, 0.0034, 6, 2))
    for z in (top + 0.105, top + 0.180, head - 0.060):
        plan.link.add("metal", box((0.0140, 0.0110, 0.007), (x - 0.0155, y, z), 0.0))
    plan.link.collide_cylinder(0.018, head - top, "z", (x, y, (head + top) / 2))
    plan.link.collide_box((0.062, 0.046, 0.060), (camera["x"] - 0.026, y, camera["z"] - 0.005))


def _antenna(plan: HullPlan) -> None:
    """Add a flexible whip on its base."""
    x, y, top = -0.225, 0.116, plan.deck
    profile = [
        (0, 0),
        (0.0120, 0),
        (0.0120, 0.006),
        (0.0085, 0.010),
        (0.0085, 0.030),
        (0.0060, 0.036),
        (0.0042, 0.060),
        (0.0036, 0.340),
        (0.0052, 0.344),
        (0.0052, 0.358),
        (0.0030, 0.362),
        (0, 0.362),
    ]
    plan.link.add("rubber", turned(profile, "z", (x, y, top), 12))
    plan.link.add("metal", ring(0.0095, 0.0080, 0.008, "z", (x, y, top + 0.014), 0.0, 12))
    plan.link.collide_cylinder(0.008, 0.362, "z", (x, y, top + 0.181))
