"""Light of the day, and the sun's view that its shadow map shows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple

import numpy as np

Rgb = Tuple[float, float, float]


@dataclass(frozen=True)
class Lighting:
    """Sun, sky and haze.

    Light is linear, 1 is what makes a white surface white; the two colours of the sky are sRGB, as
    they appear.

    Attributes
    ----------
    to_sun, to_fill
        Directions to the sun and to a weak light without shadow that gives form to what the sun
        does not reach; of any length.
    sun, fill, sky_ambient, ground_ambient
        Light of the sun, of the fill, from straight above and from straight below.
    specular
        Strength of highlights.
    zenith, horizon
        Colours of the sky; haze takes the horizon's.
    haze_distance
        Where half of a thing's colour is lost (m).
    shadow_radius
        Half the side of the square around the robot in which the sun casts shadows (m).
    """

    to_sun: Tuple[float, float, float] = (-0.40, -0.50, 0.80)
    to_fill: Tuple[float, float, float] = (0.60, 0.50, 0.35)
    sun: Rgb = (1.12, 1.06, 0.96)
    fill: Rgb = (0.16, 0.17, 0.19)
    sky_ambient: Rgb = (0.36, 0.39, 0.44)
    ground_ambient: Rgb = (0.17, 0.16, 0.15)
    specular: float = 0.22
    zenith: Rgb = (0.40, 0.57, 0.78)
    horizon: Rgb = (0.76, 0.81, 0.86)
    haze_distance: float = 35.0
    shadow_radius: float = 4.0


@dataclass(frozen=True)
class SunView:
    """The parallel projection along the sun's rays onto its shadow map.

    Attributes
    ----------
    clip_from_world
        Shape (4, 4).
    texel
        Side of the map's pixels in the world (m).
    """

    clip_from_world: np.ndarray
    texel: float


def sun_view(
    lighting: Lighting,
    map_size: int,
    focus: np.ndarray,
    centers: np.ndarray,
    radii: np.ndarray,
) -> SunView:
    """Project the surroundings of a point along the sun's rays.

    Parameters
    ----------
    lighting
        Gives the direction and the extent.
    map_size
        Pixels along a side of the shadow map, without its margin.
    focus
        Point in the world that the map is centred on (m), shape (3,).
    centers, radii
        Bounding spheres of what casts shadows, shapes (N, 3) and (N,); the depth range holds those
        over the map.
    """
    forward = -unit(lighting.to_sun)
    sideways = np.array([0.0, 1.0, 0.0]) if abs(forward[2]) > 0.99 else np.array([0.0, 0.0, 1.0])
    right = unit(np.cross(sideways, forward))
    axes = np.stack([right, np.cross(forward, right), forward])
    half = lighting.shadow_radius
    texel = 2.0 * half / map_size
    # Moving by whole pixels only keeps the edges of shadows from crawling as the robot drives.
    middle = np.round(axes[:2] @ focus / texel) * texel
    seen = centers @ axes.T
    over_map = (np.abs(seen[:, :2] - middle) < half + radii[:, None]).all(axis=1)
    if over_map.any():
        near = float((seen[over_map, 2] - radii[over_map]).min())
        far = float((seen[over_map, 2] + radii[over_map]).max())
    else:
        near, far = 0.0, 1.0
    scale = np.array([1.0 / half, 1.0 / half, 2.0 / (far - near)])
    origin = np.array([middle[0], middle[1], 0.5 * (near + far)])
    clip = np.eye(4)
    clip[:3, :3] = scale[:, None] * axes
    clip[:3, 3] = -scale * origin
    return SunView(clip, texel)


def unit(vector: object) -> np.ndarray:
    """Scale a vector to length 1."""
    array = np.asarray(vector, dtype=np.float64)
    return array / np.linalg.norm(array)
