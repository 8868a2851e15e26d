"""A single step, of a block or of loose pallets: approach, wall, edge, top."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable, Dict, List, Optional, Sequence

from ..port import NotManagedError
from ..robot_size import AXLE_HEIGHT
from ..scripted_operator import FlipperAngles, Operator

SPEED, PULLING = 0.25, 0.60  # m/s

# Flippers for a step of TALL; for lower ones in proportion, but APPROACH.
TALL = 0.5  # m
LOW_APPROACH, APPROACH = (0.35, 0.30), (1.10, 0.30)
AT_WALL = ((1.00, 0.30), (0.80, 0.30), (1.20, 0.30))
"""Rear flippers flat on the floor would keep a load in front from rising."""
OVER_EDGE = (0.34, -0.20)
LEVER = (-0.50, -1.10)
PULL = ((0.10, -0.90), (0.20, -1.35), (-0.40, -1.30))
TOP = (0.30, 0.40)


@dataclass(frozen=True)
class Step:
    """A step up along x.

    Attributes
    ----------
    height : float
        m.
    friction : float
        Of it and of the floor.
    pallets : int
        How many loose pallets it is made of; 0 for a block that stands fast.
    edge : float
        Where it rises (m).
    """

    height: float = 0.5
    friction: float = 1.0
    pallets: int = 0
    edge: float = 0.0

    @property
    def length(self) -> float:
        """Of its top along x (m)."""
        return 1.2 if self.pallets else 3.0

    def objects(self) -> List[Dict[str, Any]]:
        """Entries of a scene file."""
        position = [self.edge + 0.5 * self.length, 0.0, 0.0]
        if self.pallets:
            return [
                {
                    "type": "pallet_stack",
                    "name": "step",
                    "position": position,
                    "count": self.pallets,
                    "height": self.height / self.pallets,
                    "friction": self.friction,
                }
            ]
        return [
            {
                "type": "platform",
                "name": "step",
                "position": position,
                "length": self.length,
                "width": 2.0,
                "height": self.height,
                "friction": self.friction,
            }
        ]


def climb(operator: Operator, step: Step) -> None:
    """Climb from the floor onto the top, and on until all four hubs stand there.

    Raises
    ------
    NotManagedError
    """
    mount(operator, step)
    operator.keep_lane(SPEED)
    operator.flippers(*TOP)
    stand_on_top(operator, step)


def stand_on_top(
    operator: Operator, step: Step, meanwhile: Optional[Callable[[], None]] = None
) -> None:
    """Drive on until all four hubs stand on the top, and stop there; see `Operator.until`."""
    operator.until(lambda: beyond(operator, step) > 0.6, 6.0, "on the top", meanwhile)
    operator.stop()
    operator.wait(0.4)
    if operator.pose.z < step.height + AXLE_HEIGHT - 0.03:
        raise NotManagedError(f"does not stand on the top; {operator.where()}")


def mount(operator: Operator, step: Step, first: Sequence[FlipperAngles] = ()) -> None:
    """Climb from the floor until the hull is over the edge, still with way on.

    The rear hub is the hard part: it meets the edge from the side, and only a swing that the
    flippers give it while the front pulls brings it up.

    Parameters
    ----------
    first : sequence of FlipperAngles
        What is tried before `PULL` to bring up the rear.

    Raises
    ------
    NotManagedError
    """
    tall = step.height / TALL

    def lower(angles: FlipperAngles) -> FlipperAngles:
        return (tall * angles[0], tall * angles[1])

    front = LOW_APPROACH[0] + tall * (APPROACH[0] - LOW_APPROACH[0])
    operator.keep_lane(SPEED)
    operator.work_on(
        lambda: beyond(operator, step) > -0.48 or operator.pose.rise > 0.2,
        [(front, APPROACH[1]), lower(AT_WALL[1])],
        20.0,
        "the wall",
    )
    operator.work_on(
        lambda: operator.pose.rise > 0.35 * tall or beyond(operator, step) > -0.20,
        [lower(angles) for angles in AT_WALL],
        15.0,
        "the front up the wall",
    )
    operator.flippers(*lower(OVER_EDGE))
    operator.until(lambda: beyond(operator, step) > -0.15, 8.0, "the front over the edge")
    operator.flippers(*lower(LEVER))
    operator.until(lambda: beyond(operator, step) > 0.02, 10.0, "half over the edge")
    operator.keep_lane(PULLING)
    operator.work_on(
        lambda: beyond(operator, step) > 0.35 and abs(operator.pose.rise) < 0.3,
        [*first, *(lower(angles) for angles in PULL)],
        15.0,
        "the rear up",
    )


def beyond(operator: Operator, step: Step) -> float:
    """How far base_link is past the edge (m)."""
    return operator.pose.x - step.edge
