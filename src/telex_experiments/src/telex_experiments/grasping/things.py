"""Objects of the library that are gripped, and the places where the hand takes them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Dict, List

GRAVITY = 9.81  # m/s2
PAD_FRICTION = 0.8
"""Of the shipped pads, on a surface of friction 1."""


@dataclass(frozen=True)
class Thing:
    """An object to grip.

    Attributes
    ----------
    kind : str
        Type in the library.
    mass : float
        kg.
    width : float
        Between the pads (m).
    grip : float
        Height over the object's origin at which it is taken (m).
    friction : float
        Of its surface.
    aside : float
        From its origin to the place where it is taken, along x (m).
    parameters : dict
        Of its type.
    """

    kind: str
    mass: float
    width: float
    grip: float
    friction: float = 1.0
    aside: float = 0.0
    parameters: Dict[str, Any] = field(default_factory=dict)

    @property
    def weight(self) -> float:
        """N."""
        return self.mass * GRAVITY

    @property
    def opening(self) -> float:
        """Of the pads before they close (m)."""
        return min(self.width + 0.03, 0.19)

    def force(self, share: float, friction: float = PAD_FRICTION) -> float:
        """Force of the pads (N) with which the weight is this share of what friction can carry."""
        return self.weight / (2.0 * friction * self.friction * share)

    def entry(self) -> Dict[str, Any]:
        """Entry of a scene file; its position is relative to the tool."""
        return {
            "type": self.kind,
            "name": "thing",
            "mass": self.mass,
            "position": [-self.aside, 0.0, -self.grip],
            **self.parameters,
        }


THINGS: Dict[str, Thing] = {
    "cube 3 cm": Thing("cube", 0.05, 0.03, 0.015, parameters={"edge": 0.03}),
    "cube 5 cm": Thing("cube", 0.3, 0.05, 0.025, parameters={"edge": 0.05}),
    "cube 10 cm": Thing("cube", 2.0, 0.10, 0.06, parameters={"edge": 0.10}),
    "block 10 kg": Thing("cube", 10.0, 0.10, 0.06, parameters={"edge": 0.10}),
    "briefcase": Thing("briefcase", 5.0, 0.025, 0.3925),
    "cylinder": Thing("cylinder", 1.0, 0.06, 0.09),
    # Its top has to stay clear of the palm of a hand from above, 11 cm behind the tool.
    "bottle": Thing("bottle", 0.8, 0.08, 0.095, friction=0.8, parameters={"height": 0.2}),
    "pipe": Thing("pipe", 0.7, 0.05, 0.025, parameters={"length": 0.24}),
    "sphere": Thing("sphere", 0.5, 0.08, 0.04),
    "wedge": Thing("wedge", 0.4, 0.06, 0.025, aside=0.02),
    "flat plate": Thing("plate", 1.2, 0.01, 0.055),
    # Nearer to its middle it slowly turns about the pads: 0.7 degrees and 0.17 mm in 10 s.
    "source capsule": Thing("source_capsule", 0.4, 0.04, 0.04),
}
"""The twelve of the suite; each is taken near its centre of mass, the briefcase by its handle."""


def post(height: float, width: float) -> Dict[str, Any]:
    """Entry of a slender post that carries a thing and leaves room for fingers at its sides.

    Parameters
    ----------
    height : float
        m.
    width : float
        Of the thing, between the pads (m).
    """
    size = [0.02, min(0.02, 0.6 * width), height]
    part = {"box": size, "position": [0.0, 0.0, 0.5 * height]}
    links: List[Dict[str, Any]] = [{"name": "post", "parts": [part]}]
    return {"type": "custom", "name": "post", "static": True, "links": links}
