"""Sources and shields among the objects of a scene."""

from __future__ import annotations

from typing import Dict, Iterable, List, Tuple

import numpy as np

from telex_control.common.geometry.matrices import rotation_matrix
from telex_control.common.geometry.quaternions import Pose, Vector3, compose

from ...radiation.field import Field, PointSource, Shield, ShieldForm
from ..model import Form, Geometry
from .bodies import SceneBodies

_FORMS = {
    Form.BOX: ShieldForm.BOX,
    Form.CYLINDER: ShieldForm.CYLINDER,
    Form.SPHERE: ShieldForm.SPHERE,
}
_Name = Tuple[str, str]
"""Of an object and its link."""


class SceneField:
    """The field of a scene's sources among its shields, which moves with them.

    It is of the objects that there are when it is made: when one comes or goes, or the scene is
    put back, another takes its place.
    """

    def __init__(self, objects: SceneBodies) -> None:
        self._objects = objects
        # Where sources and shields are in their links, by the links.
        self._sources: List[Tuple[_Name, Vector3]] = []
        self._shields: List[Tuple[_Name, Pose]] = []
        self._moving: List[_Name] = []
        self._poses: Dict[_Name, Pose] = {}
        sources, shields = self._find()
        self._field = Field(sources, shields)
        self._place(range(len(self._sources)), range(len(self._shields)))
        moving = set(self._moving)
        self._moving_sources = [n for n, (name, _) in enumerate(self._sources) if name in moving]
        self._moving_shields = [n for n, (name, _) in enumerate(self._shields) if name in moving]

    def _find(self) -> Tuple[List[PointSource], List[Shield]]:
        sources: List[PointSource] = []
        shields: List[Shield] = []
        group = 0
        for item in self._objects.objects():
            moving = item.model.moving_links()
            for link in item.model.links:
                name = (item.name, link.name)
                parts = [part for part in link.parts if part.shield]
                if not parts and link.source is None:
                    continue
                group += 1
                self._poses[name] = self._objects.link_pose(*name)
                if link in moving:
                    self._moving.append(name)
                if link.source is not None:
                    sources.append(PointSource(link.source.nuclide, link.source.activity))
                    self._sources.append((name, link.source.position))
                for part in parts:
                    form = _FORMS[part.geometry.form]
                    shields.append(Shield(form, _halves(part.geometry), part.shield, group))
                    self._shields.append((name, (part.position, part.orientation)))
        return sources, shields

    @property
    def empty(self) -> bool:
        """Whether there is no source."""
        return not self._sources

    def _place(self, sources: Iterable[int], shields: Iterable[int]) -> None:
        upright = (0.0, 0.0, 0.0, 1.0)
        for number in sources:
            name, point = self._sources[number]
            self._field.positions[number] = compose(self._poses[name], (point, upright))[0]
        for number in shields:
            name, place = self._shields[number]
            position, orientation = compose(self._poses[name], place)
            self._field.centers[number] = position
            self._field.rotations[number] = rotation_matrix(orientation)

    @property
    def source_positions(self) -> np.ndarray:
        """Where the sources were at the last look at the rates, shape (S, 3) (m)."""
        return self._field.positions

    def rates(self, points: np.ndarray) -> np.ndarray:
        """Air-kerma rates (Gy/h) at points of the world, shape (P, 3) (m), with all where it is."""
        return self.source_rates(points).sum(axis=0)

    def source_rates(self, points: np.ndarray) -> np.ndarray:
        """Air-kerma rates of each source; as `rates`, of shape (S, P)."""
        for name in self._moving:
            self._poses[name] = self._objects.link_pose(*name)
        self._place(self._moving_sources, self._moving_shields)
        return self._field.source_rates(points)


def _halves(geometry: Geometry) -> Vector3:
    x, y, z = geometry.size
    if geometry.form is Form.BOX:
        return 0.5 * x, 0.5 * y, 0.5 * z
    if geometry.form is Form.CYLINDER:
        return x, x, 0.5 * z
    return x, x, x
