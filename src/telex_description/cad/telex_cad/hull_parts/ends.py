"""Front and rear of the hull: bumper, camera behind its guard, lamps, eyes. Lengths in m."""

from __future__ import annotations

import math

from ..figures import Place
from ..fittings import bolts, connector
from ..housings import camera_housing, lamp_housing, mount
from ..solids import box, cylinder, hose, prism, ring, warning_stripes
from .plan import HullPlan


def add(plan: HullPlan) -> None:
    """Add what stands at the front and at the rear."""
    for x in (1, -1):
        _end(plan, x)
    _rear_connectors(plan)


def _end(plan: HullPlan, x: int) -> None:
    """Add what stands at the front (x = 1) or rear (x = -1)."""
    place = plan.figures.front_camera if x > 0 else plan.figures.rear_camera
    lamp = plan.figures.front_lamp if x > 0 else plan.figures.rear_lamp
    yaw = 0.0 if x > 0 else math.pi
    _bumper(plan, x)
    _camera(plan, x, place, yaw)
    _slopes(plan, x)
    nose = x * plan.nose
    for y in (-1, 1):
        _end_lamp(plan, x, y, lamp, yaw)
        # Lashing eye
        eye = ring(0.0125, 0.0070, 0.007, "y", (nose + x * 0.0085, y * 0.112, 0.040), 0.0, 12)
        foot = box((0.006, 0.018, 0.026), (nose + x * 0.002, y * 0.112, 0.040), 0.0)
        plan.link.add("metal", eye, foot)
    depth = abs(lamp["x"] - nose)
    plan.link.collide_box((depth, 0.216, 0.080), (nose + x * depth / 2, 0, 0.048))


def _bumper(plan: HullPlan, x: int) -> None:
    """Add the rubber bumper, and above it the plate that carries camera and lamps."""
    nose = x * plan.nose
    section = [(-0.001, 0.004), (0.013, 0.008), (0.013, 0.024), (-0.001, 0.028)]
    bumper = prism([(nose + x * out, z) for out, z in section], 2 * plan.side - 0.050, 0.002)
    plan.link.add("rubber", bumper)
    corners = ((-1, -1), (1, -1), (1, 0.5), (0.9, 1), (-0.9, 1), (-1, 0.5))
    plate = prism([(a * 0.106, 0.0665 + b * 0.0285) for a, b in corners], 0.006, 0.0015)
    plan.link.add("panel", plate.rotate((0, 0, 90)).translate((nose + x * 0.001, 0, 0)))
    places = [(nose + x * 0.004, a * 0.098, z) for a in (-1, 1) for z in (0.046, 0.081)]
    plan.link.add("metal", bolts(places, "x", 0.0030, 0.0014))


def _camera(plan: HullPlan, x: int, place: Place, yaw: float) -> None:
    """Add the camera on its seat, between the bars that guard it."""
    nose = x * plan.nose
    mount(plan.link, camera_housing(), (place["x"], place["y"], place["z"]), place["pitch"], yaw)
    back = place["x"] - x * 0.030
    seat = (abs(back - nose) + 0.010, 0.024, 0.020)
    plan.link.add("dark", box(seat, ((back + nose) / 2, 0, place["z"]), 0.002))
    front = place["x"] - x * 0.006
    bend = nose + 0.7 * (front - nose)
    for y in (-1, 1):
        guard = [
            (nose, y * 0.026, 0.042),
            (bend, y * 0.026, 0.043),
            (front, y * 0.025, 0.052),
            (front, y * 0.025, 0.074),
            (bend, y * 0.026, 0.086),
            (nose, y * 0.026, 0.088),
        ]
        plan.link.add("metal", hose(guard, 0.0030, 6, 1))
    depth = abs(place["x"] - nose)
    plan.link.collide_box((depth, 0.060, 0.058), (nose + x * depth / 2, 0, 0.066))


def _end_lamp(plan: HullPlan, x: int, y: int, lamp: Place, yaw: float) -> None:
    """Add a lamp in its yoke; at the rear a tail light as well."""
    nose = x * plan.nose
    radius = 0.0195 if x > 0 else 0.0150
    across, up = y * lamp["y"], lamp["z"]
    mount(plan.link, lamp_housing(radius), (lamp["x"], across, up), lamp["pitch"], yaw)
    for side in (-1, 1):
        cheek = across + side * (radius + 0.0014)
        arm = box((0.024, 0.0024, 0.009), (nose + x * 0.010, cheek, up - 0.001), 0.0)
        knob = (lamp["x"] - x * 0.010, cheek + side * 0.0020, up)
        plan.link.add("metal", arm, cylinder(0.0036, 0.0022, "y", knob, 0.0, 8))
    if x < 0:
        plan.link.add("dark", box((0.008, 0.024, 0.010), (nose - 0.0065, y * 0.040, 0.084), 0.001))
        plan.link.add("red", box((0.003, 0.021, 0.0075), (nose - 0.0100, y * 0.040, 0.084), 0.0008))


def _slopes(plan: HullPlan, x: int) -> None:
    """Add stripes on the lower slope, and non-slip pads on the upper one."""
    nose, deck, belly = plan.nose, plan.deck, plan.belly
    low = math.degrees(math.atan2(-belly, 0.040))
    plate, bars = warning_stripes(2 * plan.side - 0.040, 0.030, 0.0012, 0.044)
    for material, solid in (("accent", plate), ("black", bars)):
        slanted = solid.rotate((0, 0, 90)).rotate((0, x * (90 - low), 0))
        plan.link.add(material, slanted.translate((x * (nose - 0.0200), 0, belly / 2)))
    for y in (-1, 1):
        pad = box((0.046, 0.0200, 0.0032), bevel=0.001).rotate((0, x * 45, 0))
        plan.link.add("rubber", pad.translate((x * (nose - 0.0275), y * 0.1195, deck - 0.0275)))


def _rear_connectors(plan: HullPlan) -> None:
    """Add charging and data connectors to the rear plate."""
    for y in (-0.046, 0.046):
        at = (-plan.nose - 0.003, y, 0.051)
        plan.link.add("metal", connector(at, "x", -1, 0.0088))
