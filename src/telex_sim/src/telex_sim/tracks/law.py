"""The traction law: contacts in, forces out.

PyBullet has no moving belts, so each track is a body without friction of its own, and this law
gives the friction of a surface that runs with the belt. What sticks is held by a spring and a
damper (a bristle, as of the models of Dahl and LuGre), so that a standing robot stands still on a
slope; what slips feels Coulomb friction within an ellipse, because a belt grips better along than
across. The lateral stiffness follows the square of the friction ratio: the slip then has the
direction of maximum dissipation, and not just the force its limit.

Nothing here knows of PyBullet.
"""

from __future__ import annotations

import math
from typing import List, Tuple

from telex_control.common.stateful import Stateful

Vector = Tuple[float, float, float]


Touch = Tuple[float, float, float, float, float, Vector, Vector, Vector]
"""One contact point of a track; a plain tuple, for thousands are made in a second.

Normal force (N), above 0; friction coefficients along and across the belt, above 0; velocity of the
track's body against the other along and across (m/s), without the belt's; unit vectors along and
across, and the point (m), in the world.
"""


_Figures = Tuple[float, float, float, float, float, float, float, float, float]
"""What every `pull` of a step needs: step size (s); mean slip (m/s) and greatest friction along the
belt; stiffness and damping along it and across, per load (1/m, s/m); bend across without a limit
(m), and its force over the greatest friction across.
"""


class Patch(Stateful):
    """What one face of a track has in contact with one body, or with all that stands fast.

    Attributes
    ----------
    along, across : float
        How far the bristles are bent (m).
    touches : list of Touch
        Of this step.
    forces : list of pairs of floats
        Along and across the belt, on the track, of each touch (N); of the last `pull`.
    """

    __slots__ = ("_bent", "_figures", "_softness", "across", "along", "forces", "touches")
    SAVED = ("_bent", "_softness", "across", "along")

    def __init__(self) -> None:
        self.along = 0.0
        self.across = 0.0
        self.touches: List[Touch] = []
        self.forces: List[Tuple[float, float]] = []
        self._softness = 1.0
        self._bent = (0.0, 0.0)
        self._figures: _Figures = (0.0,) * 9

    @property
    def load(self) -> float:
        """Sum of the normal forces (N)."""
        return sum(touch[0] for touch in self.touches)

    def prepare(
        self, law: TractionLaw, track_load: float, softness: Tuple[float, float], ratio: float
    ) -> None:
        """Take this step's touches in, once all of them are there.

        Parameters
        ----------
        track_load : float
            Sum of the normal forces on the track (N): the track's stiffness is shared by load.
        softness : tuple of 2 floats
            Shares of stiffness and of damping that the touched body bears, see
            `TractionLaw.softness`.
        ratio : float
            Lateral stiffness over that along the belt.
        """
        load = slip_along = slip_across = most_along = most_across = 0.0
        for share, grip_along, grip_across, along, across, _, _, _ in self.touches:
            load += share
            slip_along += share * along
            slip_across += share * across
            most_along = grip_along if grip_along > most_along else most_along
            most_across = grip_across if grip_across > most_across else most_across
        soft, step_size = softness[0], law.step_size
        if soft != self._softness:
            # The bristles keep their force, not their length, when they become softer.
            kept = self._softness / soft
            self.along *= kept
            self.across *= kept
            self._softness = soft
        stiffness = law.stiffness * soft / track_load
        damping = law.damping * softness[1] / track_load
        lateral = ratio * stiffness
        across = self.across + slip_across / load * step_size
        self._figures = (
            step_size,
            slip_along / load,
            most_along,
            stiffness,
            damping,
            lateral,
            ratio * damping,
            across,
            lateral * across / most_across,
        )

    def pull(self, speed: float) -> float:
        """Force along the belt on the track (N), if the belt runs at `speed` (m/s) in this step.

        Between `prepare` and `commit`, as often as it takes to find the speed. Fills `forces`. The
        force never decreases with the speed.
        """
        step_size, slip, grip, stiffness, damping, lateral, lateral_damping, across, b = (
            self._figures
        )
        along = self.along + (slip - speed) * step_size
        a = stiffness * along / grip
        excess = a * a + b * b
        if excess > 1.0:
            excess = math.sqrt(excess)
            along /= excess
            across /= excess
        self._bent = (along, across)
        spring_along, spring_across = stiffness * along, lateral * across
        forces: List[Tuple[float, float]] = []
        total = 0.0
        # All per load: the load cancels out of the ellipse.
        for load, grip_along, grip_across, slip_along, slip_across, _, _, _ in self.touches:
            along = spring_along + damping * (slip_along - speed)
            across = spring_across + lateral_damping * slip_across
            a, b = along / grip_along, across / grip_across
            excess = a * a + b * b
            scale = -load / math.sqrt(excess) if excess > 1.0 else -load
            along *= scale
            total += along
            forces.append((along, scale * across))
        self.forces = forces
        return total

    def commit(self) -> None:
        """Keep the bristles as the last `pull` bent them."""
        self.along, self.across = self._bent


class TractionLaw:
    """Figures of the law, for a step size.

    Parameters
    ----------
    stiffness, damping : float
        Of a track that sticks (N/m, N s/m).
    step_size : float
        s.
    """

    __slots__ = ("_bearable", "damping", "step_size", "stiffness")

    def __init__(self, stiffness: float, damping: float, step_size: float) -> None:
        self.stiffness = stiffness
        self.damping = damping
        self.step_size = step_size
        self._bearable = _BEARABLE / (damping * step_size)

    def softness(
        self, mass: float, weight: float, load: float, track_load: float
    ) -> Tuple[float, float]:
        """Shares that a loose body bears of the stiffness and damping it has a load for, at most 1.

        The forces are those of the step's beginning, so a stiff bristle would shake a light body.
        One that is pressed harder than it weighs is held from behind, and bears more stiffness; not
        more damping, for a pipe that is pressed on rolls nevertheless, and a damper that turns its
        slip round in a step only makes it faster.

        Parameters
        ----------
        mass, weight : float
            Of the body (kg, N).
        load : float
            Normal force on it (N).
        track_load : float
            On the whole track (N).
        """
        bearable = self._bearable * mass * track_load / load
        return min(1.0, bearable * max(1.0, load / weight)), min(1.0, bearable)


_BEARABLE = 0.1
"""Damping times step over mass, of one track.

An explicit damper on a free mass is stable below 2; up to four tracks touch a body, and away from
its centre it offers a quarter of its mass.
"""


def belt_directions(axle: Vector, ahead: Vector, normal: Vector) -> Tuple[int, Vector, Vector]:
    """Directions along and across the belt at a contact, and the face of the track.

    Parameters
    ----------
    axle, ahead : Vector
        Unit vectors: y axis and x axis of the track, in the world.
    normal : Vector
        Unit vector, into the track.

    Returns
    -------
    face : int
        0 where the belt runs; 1 and -1 on the flanks, by the direction of the normal.
    forward, sideways : Vector
        Unit vectors; on a flank, along the track's x axis and across it.
    """
    ax, ay, az = axle
    nx, ny, nz = normal
    x, y, z = ay * nz - az * ny, az * nx - ax * nz, ax * ny - ay * nx
    length = math.sqrt(x * x + y * y + z * z)
    face = 0
    if length < _FLANK:
        face = 1 if ax * nx + ay * ny + az * nz > 0.0 else -1
        hx, hy, hz = ahead
        away = hx * nx + hy * ny + hz * nz
        x, y, z = hx - away * nx, hy - away * ny, hz - away * nz
        length = math.sqrt(x * x + y * y + z * z)
    x, y, z = x / length, y / length, z / length
    return face, (x, y, z), (ny * z - nz * y, nz * x - nx * z, nx * y - ny * x)


_FLANK = 0.2
"""Sine of the angle between normal and axle below which the belt's flank is touched."""


def edge_share(steepness: float) -> float:
    """How much of an edge a contact is: 0 on a face, 1 on an edge.

    Parameters
    ----------
    steepness : float
        Cosine of the angle between the contact's normal and the nearest normal of a face.
    """
    if steepness >= _FACE:
        return 0.0
    return 1.0 if steepness <= _EDGE else (_FACE - steepness) / (_FACE - _EDGE)


_FACE = math.cos(math.radians(10.0))
_EDGE = math.cos(math.radians(20.0))
