"""The robot's size (m) as an operator knows it, from ``telex_description/config/robot.xacro``."""

from __future__ import annotations

import math

AXLE_HEIGHT = 0.110
"""Of the hubs' axles, and so of base_link, over level ground; also the hubs' radius."""

PIVOT = 0.280
"""From base_link to the axle of a flipper, along x."""

HALF_LENGTH = PIVOT + AXLE_HEIGHT
"""From base_link to the foremost point of the hubs, with the flippers up."""

FLIPPER_LENGTH = 0.440
"""From a flipper's pivot to the middle of its tip."""

TIP_RADIUS = 0.070

DROOP = math.asin((AXLE_HEIGHT - TIP_RADIUS) / FLIPPER_LENGTH)
"""How far the line from axle to axle of a flipper points down at 0, flush with the floor (rad)."""

BELT_INNER, BELT_OUTER = 0.145, 0.200
"""From the robot's middle to the inner and the outer edge of the belts."""

BELLY = 0.045
"""From the axles down to the hull's lower side."""
