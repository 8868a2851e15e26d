"""No object of the library shows two surfaces in the same place, where neither would win."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from telex_control.common.geometry.matrices import pose_matrices
from telex_sim.scene.catalog import scenes
from telex_sim.scene.files.scene_file import load_scene
from telex_sim.scene.model import Form

APART = 0.0005
"""Of parallel faces (m): less is not told apart from some metres away."""
SEEN = 5e-4
"""Area (m2) above which it is seen."""
GRID = np.array(list(itertools.product(np.linspace(-0.99, 0.99, 34), repeat=2)))


class Solid:
    """A box or a cylinder: its pose, and half its extents."""

    def __init__(self, part):
        x, y, z = part.geometry.size
        self.round = part.geometry.form is Form.CYLINDER
        self.half = np.array((x, x, 0.5 * z) if self.round else (0.5 * x, 0.5 * y, 0.5 * z))
        self.pose = pose_matrices(np.array([[*part.position, *part.orientation]]))[0]
        self.surface = part.surface

    def has(self, points, whatever=None):
        """Which points are in it; of the coordinate along the axis `whatever` nothing is asked."""
        local = np.abs((points - self.pose[:3, 3]) @ self.pose[:3, :3])
        inside = local <= self.half
        if self.round:
            inside[:, :2] = (np.hypot(local[:, 0], local[:, 1]) <= self.half[0])[:, None]
        if whatever is not None:
            inside[:, whatever] = True
        return inside.all(axis=1)

    def faces(self):
        """Axis, direction and normal of each flat face that is not looked at from below."""
        for axis in (2,) if self.round else (0, 1, 2):
            for sign in (-1.0, 1.0):
                normal = sign * self.pose[:3, axis]
                if normal[2] > -0.9:
                    yield axis, sign, normal

    def points(self, axis, sign):
        """Points all over a face, and the area that each stands for."""
        others = [index for index in range(3) if index != axis]
        local = np.zeros((len(GRID), 3))
        local[:, others] = GRID
        local[:, axis] = sign
        if self.round:
            local = local[np.hypot(*local[:, others].T) <= 1.0]
        area = 4.0 * np.prod(self.half[others]) / len(GRID)
        return local * self.half @ self.pose[:3, :3].T + self.pose[:3, 3], area


def in_one_plane(solids):
    """Pairs of faces of different surfaces that look the same way from the same plane."""
    faces = [(solid, *face) for solid in solids for face in solid.faces()]
    if not faces:
        return []
    normals = np.array([face[3] for face in faces])
    through = np.array([face[0].pose[:3, 3] + face[0].half[face[1]] * face[3] for face in faces])
    reach = np.array([np.linalg.norm(face[0].half) for face in faces])
    kinds = list(dict.fromkeys(solid.surface for solid in solids))
    kind = np.array([kinds.index(face[0].surface) for face in faces])
    between = through[None] - through[:, None]
    near = np.linalg.norm(between, axis=2) <= reach[None] + reach[:, None]
    level = np.abs(np.einsum("ijk,ik->ij", between, normals)) <= APART
    found = near & level & (normals @ normals.T > 0.999) & (kind[None] != kind[:, None])
    return [(faces[i], faces[j]) for i, j in np.argwhere(np.triu(found))]


def shared(one, other, solids):
    """Area (m2) that two faces share and that no part covers."""
    small, large = sorted((one, other), key=lambda face: np.linalg.norm(face[0].half))
    solid, axis, sign, normal = small
    points, area = solid.points(axis, sign)
    points = points[large[0].has(points, large[1])] + 0.002 * normal
    covered = np.zeros(len(points), dtype=bool)
    for solid in solids if len(points) else ():
        covered |= solid.has(points)
    return area * float((~covered).sum())


@pytest.mark.parametrize("name", [name for name in scenes() if name not in ("floor", "load_test")])
def test_no_two_surfaces_lie_in_the_same_place(name):
    fighting = []
    for item in {item.model: item for item in load_scene(scenes()[name]).objects}.values():
        for link in item.model.links:
            solids = [
                Solid(part)
                for part in link.parts
                if part.surface is not None and part.geometry.form in (Form.BOX, Form.CYLINDER)
            ]
            for one, other in in_one_plane(solids):
                area = shared(one, other, solids)
                if area > SEEN:
                    fighting.append((item.name, link.name, one[0].surface, other[0].surface, area))
    assert fighting == []
