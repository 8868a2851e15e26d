"""Light of a scene, and the sun's view that its shadow map shows."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, Tuple

import numpy as np

from ....scene.visual_scene import Daylight, Rgb
from ..shaders import EXPOSURE

# Of red, green and blue in the brightness of a linear colour (Rec. 709).
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])

# Contrast that is left at the distance of visibility.
_CONTRAST_LEFT = 0.05

# Height up to which fog hides the sky (m).
_FOG_HEIGHT = 12.0


@dataclass(frozen=True)
class Lighting:
    """How the renderer shows a scene's light.

    Light is linear, 1 is what makes a white surface white; the two colours of the sky are sRGB, as
    they appear on a bright day.

    Attributes
    ----------
    sun
        What the sun, or a lamp 1 m away, of intensity 1 gives to a surface that faces it.
    to_fill
        Direction to a weak light without shadow that gives form to what the sun does not reach;
        of any length.
    fill, sky_ambient, ground_ambient
        Light of the fill, from straight above and from straight below, by day.
    specular
        Strength of highlights.
    zenith, horizon
        Colours of the sky; in clear air, distant things take the horizon's.
    haze_distance
        Where half of a thing's colour is lost in clear air (m).
    shadow_radius
        Half the side of the square around the robot in which the sun casts shadows (m).
    """

    sun: float = 1.12
    to_fill: Tuple[float, float, float] = (0.60, 0.50, 0.35)
    fill: Rgb = (0.16, 0.17, 0.19)
    sky_ambient: Rgb = (0.36, 0.39, 0.44)
    ground_ambient: Rgb = (0.17, 0.16, 0.15)
    specular: float = 0.22
    zenith: Rgb = (0.40, 0.57, 0.78)
    horizon: Rgb = (0.72, 0.78, 0.84)
    haze_distance: float = 50.0
    shadow_radius: float = 9.0


def light_uniforms(lighting: Lighting, daylight: Daylight) -> Dict[str, np.ndarray]:
    """Values of the shaders' uniforms that change with the scene only, by their names."""
    ambient = daylight.ambient
    # The sky is blue where the sun shines, gray where it does not.
    clear = min(1.0, luminance(daylight.sun))
    horizon, zenith = (
        (clear * color + (1.0 - clear) * luminance(color)) * min(ambient, 1.0)
        for color in (light_of_display(lighting.horizon), light_of_display(lighting.zenith))
    )
    uniforms = {
        "sun": lighting.sun * np.array(daylight.sun),
        "to_fill": unit(lighting.to_fill),
        "fill": ambient * np.array(lighting.fill),
        "sky_ambient": ambient * np.array(lighting.sky_ambient),
        "ground_ambient": ambient * np.array(lighting.ground_ambient),
        "specular": lighting.specular,
        "haze": lighting.haze_distance**-2,
        "haze_light": horizon,
        "horizon": horizon,
        "zenith": zenith,
    }
    if any(daylight.sun):
        uniforms["to_sun"] = unit(daylight.to_sun)
    if daylight.visibility > 0.0:
        # Fog shines by the light that falls into it.
        level = min(1.0, ambient + 0.25 * luminance(daylight.sun))
        # exp(-x) is exp2(-x / ln 2).
        extinction = -math.log(_CONTRAST_LEFT) / (math.log(2.0) * daylight.visibility)
        uniforms["haze"] = extinction
        uniforms["haze_light"] = level * light_of_display(daylight.fog)
        uniforms["fog_depth"] = extinction * _FOG_HEIGHT
    return {name: np.asarray(value, dtype=np.float32) for name, value in uniforms.items()}


def luminance(color: object) -> float:
    """Brightness of a linear colour."""
    return float(np.asarray(color) @ LUMINANCE)


def light_of_display(color: Rgb) -> np.ndarray:
    """Find the light that ``to_display`` in the shaders turns into this colour."""
    # No light is enough for a white of 1.
    return -np.log2(1.0 - np.square(np.minimum(color, 0.998))) / EXPOSURE


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
    to_sun: object,
    half: float,
    map_size: int,
    focus: np.ndarray,
    centers: np.ndarray,
    radii: np.ndarray,
) -> SunView:
    """Project the surroundings of a point along the sun's rays.

    Parameters
    ----------
    to_sun
        Direction to the sun, of any length.
    half
        Half the side of the square that the map shows (m).
    map_size
        Pixels along a side of the shadow map, without its margin.
    focus
        Point in the world that the map is centred on (m), shape (3,).
    centers, radii
        Bounding spheres of what casts shadows, shapes (N, 3) and (N,); the depth range holds those
        over the map.
    """
    axes = sun_axes(to_sun)
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


def sun_axes(to_sun: object) -> np.ndarray:
    """Axes of the sun's view, by rows: right, down, forward; shape (3, 3)."""
    forward = -unit(to_sun)
    sideways = np.array([0.0, 1.0, 0.0]) if abs(forward[2]) > 0.99 else np.array([0.0, 0.0, 1.0])
    right = unit(np.cross(sideways, forward))
    return np.stack([right, np.cross(forward, right), forward])


def unit(vector: object) -> np.ndarray:
    """Scale a vector to length 1."""
    array = np.asarray(vector, dtype=np.float64)
    return array / np.linalg.norm(array)
