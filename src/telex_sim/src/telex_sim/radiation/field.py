"""The field of point sources among shields.

A source of activity A gives the air-kerma rate Gamma A / r^2 exp(-sum mu d) at the distance r,
where d is the way of the straight ray through each shield. That is the field of photons that have
met nothing (narrow beam): those that shields and walls scatter are left out, that is, no build-up
factor is applied, and air attenuates nothing.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import List, Sequence, Tuple

import numpy as np

from .nuclides import MATERIALS, NUCLIDES, attenuation

NEAREST = 0.01
"""m; nearer to its middle no source is a point, and the rate grows no more."""
_HOUR = 3600.0
_PARALLEL = 1e-12
"""m; what a ray moves less than that along an axis does not leave the shield along it."""
_MATERIALS = sorted(MATERIALS)

Interval = Tuple[np.ndarray, np.ndarray]
"""Where rays enter and leave, as shares of their way; nothing is between where the second is less.
"""


class ShieldForm(enum.IntEnum):
    """Shapes of shields."""

    BOX = 0
    CYLINDER = 1
    SPHERE = 2


@dataclass(frozen=True)
class PointSource:
    """A source.

    Attributes
    ----------
    nuclide : str
        One of `NUCLIDES`.
    activity : float
        Bq.
    """

    nuclide: str
    activity: float


@dataclass(frozen=True)
class Shield:
    """A body that attenuates.

    Attributes
    ----------
    size : tuple of 3 floats
        BOX: half extents. CYLINDER, about z: (radius, radius, half its length). SPHERE: three
        times its radius (m).
    material : str
        One of `MATERIALS`.
    group : int
        Shields of one group and one material that overlap count once.
    """

    form: ShieldForm
    size: Tuple[float, float, float]
    material: str
    group: int


class Field:
    """Air-kerma rates of sources behind shields.

    Attributes
    ----------
    positions : numpy.ndarray
        Of the sources, shape (S, 3) (m); to be kept up to date by the caller, as the two below.
    centers : numpy.ndarray
        Of the shields, shape (N, 3) (m).
    rotations : numpy.ndarray
        From each shield's frame to the world's, shape (N, 3, 3).
    """

    def __init__(self, sources: Sequence[PointSource], shields: Sequence[Shield]) -> None:
        count = len(shields)
        self.positions = np.zeros((len(sources), 3))
        self.centers = np.zeros((count, 3))
        self.rotations = np.broadcast_to(np.eye(3), (count, 3, 3)).copy()
        # Gy m2 / h
        self._strengths = np.array(
            [NUCLIDES[s.nuclide].kerma_constant * s.activity * _HOUR for s in sources]
        )
        self._forms = np.array([shield.form for shield in shields], dtype=int)
        self._sizes = np.array([shield.size for shield in shields]).reshape(count, 3)
        self._radii = np.array([_outer_radius(shield) for shield in shields])
        materials = [_MATERIALS.index(shield.material) for shield in shields]
        self._materials = np.array(materials, dtype=int)
        alike = {pair: n for n, pair in enumerate({(s.group, s.material) for s in shields})}
        self._groups = np.array([alike[s.group, s.material] for s in shields], dtype=int)
        self._coefficients = np.array(
            [[attenuation(m, NUCLIDES[s.nuclide].energy) for m in _MATERIALS] for s in sources]
        ).reshape(len(sources), len(_MATERIALS))

    def rates(self, points: np.ndarray) -> np.ndarray:
        """Air-kerma rate at points.

        Parameters
        ----------
        points : numpy.ndarray
            In the world, shape (P, 3) (m).

        Returns
        -------
        numpy.ndarray
            Shape (P,) (Gy/h).
        """
        return self.source_rates(points).sum(axis=0)

    def source_rates(self, points: np.ndarray) -> np.ndarray:
        """Air-kerma rate of each source at points; as `rates`, of shape (S, P)."""
        ways = points[None, :, :] - self.positions[:, None, :]
        squares = np.maximum(np.einsum("spi,spi->sp", ways, ways), NEAREST**2)
        unshielded: np.ndarray = self._strengths[:, None] / squares
        if not len(self._radii) or not unshielded.size:
            return unshielded
        shielded: np.ndarray = unshielded * np.exp(-self._depths(ways))
        return shielded

    def _depths(self, ways: np.ndarray) -> np.ndarray:
        """Sum of mu d along the way of each ray; `ways`: shape (S, P, 3), from the sources."""
        sources, points = ways.shape[:2]
        rays = ways.reshape(-1, 3)
        starts = np.repeat(self.positions, points, axis=0)
        ray, shield = self._candidates(starts, rays)
        turn = self.rotations[shield]
        start = np.einsum("kji,kj->ki", turn, starts[ray] - self.centers[shield])
        way = np.einsum("kji,kj->ki", turn, rays[ray])
        enters, leaves = self._crossings(self._forms[shield], start, way, self._sizes[shield])
        ray, shield, shares = self._once(ray, shield, enters, leaves)
        mu = self._coefficients[ray // points, self._materials[shield]]
        lengths = shares * np.linalg.norm(rays, axis=1)[ray]
        return np.bincount(ray, mu * lengths, len(rays)).reshape(sources, points)

    def _candidates(self, starts: np.ndarray, rays: np.ndarray) -> Interval:
        """Rays and shields whose bounding spheres they meet: indices, of few out of all pairs."""
        to_center = np.einsum("ni,ri->rn", self.centers, rays)
        to_center -= np.einsum("ri,ri->r", starts, rays)[:, None]
        lengths = np.maximum(np.einsum("ri,ri->r", rays, rays), _PARALLEL)[:, None]
        nearest = np.clip(to_center / lengths, 0.0, 1.0)
        squares = (self.centers**2).sum(axis=1)[None, :] - 2.0 * (starts @ self.centers.T)
        squares += (starts**2).sum(axis=1)[:, None]
        squares += nearest * (nearest * lengths - 2.0 * to_center)
        # A little more than the radius: these differences of squares are rounded.
        ray, shield = np.nonzero(squares <= (1.001 * self._radii + 1e-4)[None, :] ** 2)
        return ray, shield

    def _crossings(
        self, forms: np.ndarray, start: np.ndarray, way: np.ndarray, size: np.ndarray
    ) -> Interval:
        """Where rays cross shields, in the shields' frames."""
        enters, leaves = np.zeros(len(forms)), np.ones(len(forms))
        for form, flat, round_ in _AXES:
            of = np.flatnonzero(forms == form)
            if not of.size:
                continue
            bounds: List[Interval] = []
            if flat:
                bounds.append(
                    _between_planes(start[of][:, flat], way[of][:, flat], size[of][:, flat])
                )
            if round_:
                bounds.append(_inside_round(start[of][:, round_], way[of][:, round_], size[of, 0]))
            for near, far in bounds:
                enters[of] = np.maximum(enters[of], near)
                leaves[of] = np.minimum(leaves[of], far)
        return enters, leaves

    def _once(
        self, ray: np.ndarray, shield: np.ndarray, enters: np.ndarray, leaves: np.ndarray
    ) -> Tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Shares of the rays' ways in shields, those counted once that overlap within a group."""
        met = leaves > enters
        ray, shield, enters, leaves = ray[met], shield[met], enters[met], leaves[met]
        bundle = ray * (int(self._groups.max()) + 1) + self._groups[shield]
        order = np.lexsort((enters, bundle))
        ray, shield, bundle = ray[order], shield[order], bundle[order]
        # Each bundle has a stretch of the axis of its own, so that one running maximum serves all.
        bundle = np.cumsum(np.diff(bundle, prepend=-1) != 0)
        enters, leaves = enters[order] + 2.0 * bundle, leaves[order] + 2.0 * bundle
        before = np.concatenate(([0.0], np.maximum.accumulate(leaves)[:-1]))
        return ray, shield, np.maximum(leaves - np.maximum(enters, before), 0.0)


_AXES: Tuple[Tuple[ShieldForm, List[int], List[int]], ...] = (
    (ShieldForm.BOX, [0, 1, 2], []),
    (ShieldForm.CYLINDER, [2], [0, 1]),
    (ShieldForm.SPHERE, [], [0, 1, 2]),
)
"""Of each form: along which axes planes bound it, and in which a circle or sphere does."""


def _outer_radius(shield: Shield) -> float:
    x, y, z = shield.size
    if shield.form is ShieldForm.SPHERE:
        return x
    if shield.form is ShieldForm.CYLINDER:
        return float(np.hypot(x, z))
    return float(np.sqrt(x * x + y * y + z * z))


def _between_planes(start: np.ndarray, way: np.ndarray, half: np.ndarray) -> Interval:
    way = np.where(np.abs(way) < _PARALLEL, _PARALLEL, way)
    first, second = (-half - start) / way, (half - start) / way
    return np.minimum(first, second).max(axis=1), np.maximum(first, second).min(axis=1)


def _inside_round(start: np.ndarray, way: np.ndarray, radius: np.ndarray) -> Interval:
    a = np.maximum((way * way).sum(axis=1), _PARALLEL**2)
    b = (start * way).sum(axis=1)
    # Of the point of the ray that is nearest to the axis: free of the rounding of b * b - a * c.
    across = start - (b / a)[:, None] * way
    room = radius**2 - (across * across).sum(axis=1)
    root = np.sqrt(np.maximum(room, 0.0) / a)
    near, far = -b / a - root, -b / a + root
    return near, np.where(room > 0.0, far, near)
