"""Tiers of quality, by what renders."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict

AUTO = "auto"

# Names by which OpenGL's renderers on the CPU go.
_SOFTWARE_RENDERERS = ("llvmpipe", "softpipe", "swrast", "swr")


@dataclass(frozen=True)
class Quality:
    """A tier of quality.

    Attributes
    ----------
    samples
        Of multisampling per pixel; 0 for none.
    edge_smoothing
        Whether edges are softened in the finished picture instead.
    shadow_map_size
        Pixels along each side of each of the sun's two shadow maps.
    shadow_detail
        What is smaller need not show in shadows (m).
    shadow_lookups
        In the shadow map for each pixel of a picture.
    shadow_softness
        Half the width of the soft edges of shadows, in pixels of the map.
    anisotropy
        Of textures that are seen at a slant; 1 for none.
    lamps
        Most that can light one picture.
    lamp_shadows
        Most lamps that throw shadows.
    lamp_map_size
        Pixels along each side of a lamp's shadow map.
    lamp_lookups
        In the shadow map of each lamp for each pixel of a picture.
    """

    samples: int
    edge_smoothing: bool
    shadow_map_size: int
    shadow_detail: float
    shadow_lookups: int
    shadow_softness: float
    anisotropy: float
    lamps: int
    lamp_shadows: int
    lamp_map_size: int
    lamp_lookups: int


TIERS: Dict[str, Quality] = {
    # Of the 14 ms that llvmpipe takes for 640x480, each shadow look-up is one and smoothing half of
    # one; four samples would double the whole, and so would an anisotropy of 4. Look-ups of single
    # pixels of the map take as long: four of them are needed for one that is the mean of four. One
    # look-up is enough because each pixel and its neighbours look to opposite sides.
    "software": Quality(
        samples=0,
        edge_smoothing=True,
        shadow_map_size=1024,
        # A pixel of the map is as large.
        shadow_detail=0.008,
        shadow_lookups=1,
        shadow_softness=0.5,
        anisotropy=1.0,
        lamps=4,
        lamp_shadows=6,
        lamp_map_size=512,
        lamp_lookups=1,
    ),
    "gpu": Quality(
        samples=4,
        edge_smoothing=False,
        shadow_map_size=2048,
        shadow_detail=0.0,
        shadow_lookups=12,
        shadow_softness=2.5,
        anisotropy=8.0,
        lamps=12,
        lamp_shadows=12,
        lamp_map_size=1024,
        lamp_lookups=6,
    ),
}

# For single pictures, where time does not matter.
STILL = Quality(
    samples=4,
    edge_smoothing=False,
    shadow_map_size=4096,
    shadow_detail=0.0,
    shadow_lookups=16,
    shadow_softness=3.0,
    anisotropy=16.0,
    lamps=16,
    lamp_shadows=16,
    lamp_map_size=1024,
    lamp_lookups=8,
)


def is_card(gl_renderer: str) -> bool:
    """Whether a graphics card draws, by what OpenGL says that it runs on."""
    name = gl_renderer.lower()
    return not any(renderer in name for renderer in _SOFTWARE_RENDERERS)


def choose_quality(wanted: str, gl_renderer: str) -> Quality:
    """Tier by its name, or for "auto" by what OpenGL says that it runs on.

    Raises
    ------
    ValueError
        When there is no such tier.
    """
    if wanted == AUTO:
        return TIERS["gpu" if is_card(gl_renderer) else "software"]
    if wanted not in TIERS:
        raise ValueError(f"quality '{wanted}' is unknown, expected {AUTO}, {' or '.join(TIERS)}")
    return TIERS[wanted]
