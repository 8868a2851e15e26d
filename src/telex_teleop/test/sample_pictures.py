"""Pictures of two colours, encoded or raw, for the tests of what serves them."""

from __future__ import annotations

import numpy as np
import simplejpeg

from telex_teleop.web.video.pictures import RawPicture

RED, BLUE = (220, 20, 20), (20, 20, 220)


def two_halves(width=64, height=48):
    """Left red, right blue (RGB)."""
    pixels = np.zeros((height, width, 3), np.uint8)
    pixels[:, : width // 2], pixels[:, width // 2 :] = RED, BLUE
    return pixels


def jpeg(quality=90, pixels=None):
    return simplejpeg.encode_jpeg(two_halves() if pixels is None else pixels, quality=quality)


def is_like(colour, wanted):
    return np.abs(colour.astype(int) - wanted).max() < 30


def raw(encoding, pixels, padding=0):
    rows = pixels.reshape(pixels.shape[0], -1)
    padded = np.pad(rows, ((0, 0), (0, padding)))
    step = padded.shape[1]
    return RawPicture(1.5, pixels.shape[1], pixels.shape[0], step, encoding, padded.tobytes())
