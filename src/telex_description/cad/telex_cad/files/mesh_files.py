"""OBJ texts that are the same on every run: fixed decimals, vertices and faces in sorted order."""

from __future__ import annotations

from typing import Dict, List, Mapping, Tuple

import numpy as np
from manifold3d import Manifold

# Edges that turn by less look round (degrees).
SMOOTH_BELOW = 32.0
# Decimals of places (m) and normals
PLACES = 6
SHADES = 3
HEADER = "# Written by telex_description/scripts/generate_model.\n"
# Beside the meshes: rviz takes colours from it, and not from the URDF, where a mesh is an OBJ.
LIBRARY = "materials.mtl"

Face = Tuple[int, int, int]


def visual_obj(solid: Manifold, material: str) -> Tuple[str, int]:
    """Return an OBJ text of a material, with smoothed normals, and its number of triangles."""
    mesh = solid.to_mesh64()
    vertices, triangles = np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts)
    places = [_decimals(vertex, PLACES) for vertex in vertices]
    shades = [_decimals(normal, SHADES) for normal in _corner_normals(vertices, triangles)]
    place_index = {place: k + 1 for k, place in enumerate(sorted(set(places)))}
    shade_index = {shade: k + 1 for k, shade in enumerate(sorted(set(shades)))}
    faces = _sorted_faces(
        [tuple(place_index[places[k]] for k in face) for face in triangles],
        [tuple(shade_index[shades[3 * k + c]] for c in range(3)) for k in range(len(triangles))],
    )
    lines = [f"mtllib {LIBRARY}", f"usemtl {material}"]
    lines += [f"v {place}" for place in place_index] + [f"vn {shade}" for shade in shade_index]
    lines += ["f " + " ".join(f"{v}//{n}" for v, n in face) for face in faces]
    return HEADER + "\n".join(lines) + "\n", len(faces)


def _corner_normals(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return a normal for each corner of each triangle, (3 * triangles, 3).

    It is the mean of the normals of the faces at this vertex that turn from this corner's face by
    less than SMOOTH_BELOW, weighted by their angles at the vertex.
    """
    corners = vertices[triangles]
    edges = np.roll(corners, -1, axis=1) - corners
    lengths = np.maximum(np.linalg.norm(edges, axis=2, keepdims=True), 1e-12)
    directions = edges / lengths
    cosines = -np.einsum("tci,tci->tc", directions, np.roll(directions, 1, axis=1))
    angles = np.arccos(np.clip(cosines, -1.0, 1.0)).ravel()
    crossed = np.cross(edges[:, 0], edges[:, 1])
    faces = crossed / np.maximum(np.linalg.norm(crossed, axis=1, keepdims=True), 1e-18)
    at_vertex: Dict[int, List[int]] = {}
    for corner, vertex in enumerate(triangles.ravel()):
        at_vertex.setdefault(int(vertex), []).append(corner)
    normals = np.empty((3 * len(triangles), 3))
    least = np.cos(np.radians(SMOOTH_BELOW))
    for group in at_vertex.values():
        shades = faces[[corner // 3 for corner in group]]
        near = (shades @ shades.T >= least) * angles[group]
        normals[group] = near @ shades
    sizes = np.linalg.norm(normals, axis=1, keepdims=True)
    # A sliver too thin to have a direction is too thin to be seen as well.
    return np.where(sizes > 1e-9, normals / np.maximum(sizes, 1e-9), [0.0, 0.0, 1.0])


def material_library(colours: Mapping[str, Tuple[float, float, float]]) -> str:
    """Return the MTL text that the meshes name: a diffuse colour for each material."""
    entries = [
        f"newmtl {name}\nKd {_decimals(np.array(colour), 3)}\n"
        for name, colour in sorted(colours.items())
    ]
    return HEADER + "\n".join(entries)


def hull_obj(points: np.ndarray) -> str:
    """Return an OBJ text of the convex hull of points (n, 3)."""
    mesh = Manifold.hull_points(points).to_mesh64()
    corners = [_decimals(row[:3], PLACES) for row in np.asarray(mesh.vert_properties)]
    places = sorted(set(corners))
    index = {place: k + 1 for k, place in enumerate(places)}
    triangles = [tuple(index[corners[k]] for k in face) for face in mesh.tri_verts]
    lines = [f"v {place}" for place in places]
    lines += [
        "f " + " ".join(str(v) for v, _ in face) for face in _sorted_faces(triangles, triangles)
    ]
    return HEADER + "\n".join(lines) + "\n"


def _decimals(values: np.ndarray, count: int) -> str:
    # Adding 0.0 turns -0.0 into 0.0.
    return " ".join(f"{round(float(value), count) + 0.0:.{count}f}" for value in values)


def _sorted_faces(places: List[tuple], normals: List[tuple]) -> List[List[Tuple[int, int]]]:
    """Return the faces as (place, normal) corners, without those that rounding made degenerate."""
    faces: Dict[Face, List[Tuple[int, int]]] = {}
    for face, shades in zip(places, normals):
        if len(set(face)) < 3:
            continue
        first = face.index(min(face))
        turned = list(zip(face[first:] + face[:first], shades[first:] + shades[:first]))
        faces[tuple(place for place, _ in turned)] = turned
    return [faces[key] for key in sorted(faces)]
