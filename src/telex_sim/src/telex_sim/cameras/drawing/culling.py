"""Culling by bounding spheres and boxes, against views and cones of lamps."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Cones(NamedTuple):
    """Parts of balls around their tips; from half a turn on, a whole ball.

    Attributes
    ----------
    tips
        In the world (m), shape (N, 3).
    axes
        Unit vectors in the world, shape (N, 3).
    half_angles
        Between axis and edge, 0 to pi (rad), shape (N,).
    reaches
        Radii of the balls (m), shape (N,).
    """

    tips: np.ndarray
    axes: np.ndarray
    half_angles: np.ndarray
    reaches: np.ndarray


def spheres_in_world(model: np.ndarray, centers: np.ndarray) -> np.ndarray:
    """Centres of bounding spheres in the world, shape (N, 3); the model matrices are rigid."""
    return np.einsum("nij,nj->ni", model[:, :3, :3], centers) + model[:, :3, 3]


def spheres_in_view(
    clip_from_world: np.ndarray, centers: np.ndarray, radii: np.ndarray
) -> np.ndarray:
    """Which spheres touch the view's volume; a few beyond its corners may be kept as well.

    The planes are the rows' sums and differences of the clip matrix (G. Gribb, K. Hartmann,
    "Fast extraction of viewing frustum planes from the world-view-projection matrix", 2001).

    Parameters
    ----------
    clip_from_world
        Shape (4, 4), perspective or parallel.
    centers, radii
        In the world (m), shapes (N, 3) and (N,).

    Returns
    -------
    numpy.ndarray
        Shape (N,), bool.
    """
    planes = _view_planes(clip_from_world)
    distances = centers @ planes[:, :3].T + planes[:, 3]
    return (distances > -radii[:, None]).all(axis=1)


def boxes_in_view(
    clip_from_world: np.ndarray, centers: np.ndarray, axes: np.ndarray, halves: np.ndarray
) -> np.ndarray:
    """Which boxes touch the view's volume; as for `spheres_in_view`.

    Parameters
    ----------
    clip_from_world
        Shape (4, 4).
    centers
        In the world (m), shape (N, 3).
    axes
        Of the boxes in the world, by columns, shape (N, 3, 3).
    halves
        From the centres to the sides, along these axes (m), shape (N, 3).
    """
    planes = _view_planes(clip_from_world)
    along = np.abs(np.einsum("pi,nij->npj", planes[:, :3], axes))
    distances = centers @ planes[:, :3].T + planes[:, 3]
    return (distances > -np.einsum("npj,nj->np", along, halves)).all(axis=1)


def cones_in_view(clip_from_world: np.ndarray, cones: Cones) -> np.ndarray:
    """Which cones touch the view's volume, shape (N,), bool; as for `spheres_in_view`."""
    planes = _view_planes(clip_from_world)
    # How far a cone reaches along a plane's normal: its ball does where that lies within the cone,
    # otherwise the edge, or the tip.
    turned = np.arccos(np.clip(cones.axes @ planes[:, :3].T, -1.0, 1.0))
    beyond = np.maximum(turned - cones.half_angles[:, None], 0.0)
    extents = cones.reaches[:, None] * np.maximum(np.cos(beyond), 0.0)
    distances = cones.tips @ planes[:, :3].T + planes[:, 3]
    return (distances > -extents).all(axis=1)


def spheres_in_cones(centers: np.ndarray, radii: np.ndarray, cones: Cones) -> np.ndarray:
    """Which spheres touch which cones.

    Parameters
    ----------
    centers, radii
        In the world (m), shapes (M, 3) and (M,).
    cones
        N of them.

    Returns
    -------
    numpy.ndarray
        Shape (M, N), bool.
    """
    apart = centers[:, None] - cones.tips[None]
    along = np.einsum("mni,ni->mn", apart, cones.axes)
    distances = np.linalg.norm(apart, axis=2)
    beside = np.sqrt(np.maximum(distances**2 - along**2, 0.0))
    cos, sin = np.cos(cones.half_angles), np.sin(cones.half_angles)
    on_edge = np.clip(along * cos + beside * sin, 0.0, cones.reaches)
    to_edge = np.hypot(along - on_edge * cos, beside - on_edge * sin)
    within = np.arctan2(beside, along) <= cones.half_angles
    return np.where(within, distances - cones.reaches, to_edge) < radii[:, None]


def _view_planes(clip_from_world: np.ndarray) -> np.ndarray:
    """Planes around a view's volume: normals inwards of length 1, and offsets, shape (6, 4)."""
    w = clip_from_world[3]
    planes = np.concatenate([w + clip_from_world[:3], w - clip_from_world[:3]])
    return planes / np.linalg.norm(planes[:, :3], axis=1, keepdims=True)
