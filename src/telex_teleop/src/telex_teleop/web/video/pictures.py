"""Pictures as they come from ROS and as they go to clients."""

from __future__ import annotations

import dataclasses
from typing import Any, Optional

import numpy as np
import simplejpeg

JPEG = "image/jpeg"
PNG = "image/png"

_JPEG_MAGIC = b"\xff\xd8"
_PNG_MAGIC = b"\x89PNG\r\n\x1a\n"
_RAW_COLORSPACES = {
    "rgb8": "RGB",
    "bgr8": "BGR",
    "rgba8": "RGBA",
    "bgra8": "BGRA",
    "mono8": "GRAY",
    "8UC1": "GRAY",
    "8UC3": "BGR",
}
_CHANNELS = {"GRAY": 1, "RGB": 3, "BGR": 3, "RGBA": 4, "BGRA": 4}


class UnusablePictureError(ValueError):
    """A picture that cannot be read or encoded; the text says why."""


@dataclasses.dataclass(frozen=True)
class CompressedPicture:
    """A sensor_msgs/CompressedImage: stamp (s) and the encoded bytes."""

    stamp: float
    data: bytes


@dataclasses.dataclass(frozen=True)
class RawPicture:
    """A sensor_msgs/Image: stamp (s), sizes (pixels; step in bytes), encoding and the pixels."""

    stamp: float
    width: int
    height: int
    step: int
    encoding: str
    data: bytes


@dataclasses.dataclass(frozen=True)
class Variant:
    """What a client wants to be done to the pictures of a topic; None leaves a thing as it is.

    Each size stands alone: like web_video_server, a width without a height does not keep the
    aspect.
    """

    width: Optional[int] = None
    height: Optional[int] = None
    quality: Optional[int] = None
    invert: bool = False
    unchanged: bool = False
    """Hand on compressed pictures as they are, whatever their format (type ros_compressed)."""


@dataclasses.dataclass(frozen=True)
class EncodedPicture:
    """A picture ready for a client: stamp (s), content type and bytes."""

    stamp: float
    mime: str
    data: bytes


def encode(
    picture: CompressedPicture | RawPicture, variant: Variant, default_quality: int
) -> EncodedPicture:
    """Make the variant of a picture; a JPEG of which no change is asked keeps its bytes.

    Parameters
    ----------
    picture
        What came from ROS.
    variant
        What is asked for.
    default_quality
        JPEG quality (1 to 100) where the variant names none.

    Raises
    ------
    UnusablePictureError
        The picture is damaged or of an unknown kind.
    """
    if isinstance(picture, CompressedPicture):
        kept = _kept(picture, variant)
        if kept is not None:
            return kept
        pixels, colorspace = _decode(picture.data)
    else:
        pixels, colorspace = _pixels(picture)
    pixels = _changed(pixels, variant)
    try:
        data = simplejpeg.encode_jpeg(
            np.ascontiguousarray(pixels),
            quality=variant.quality or default_quality,
            colorspace=colorspace,
            colorsubsampling="Gray" if colorspace == "GRAY" else "420",
        )
    except ValueError as error:
        raise UnusablePictureError(f"cannot be encoded as JPEG: {error}") from error
    return EncodedPicture(picture.stamp, JPEG, data)


def _kept(picture: CompressedPicture, variant: Variant) -> Optional[EncodedPicture]:
    """Return the picture with its bytes as they are, or None where something is to be changed."""
    data = picture.data
    if data.startswith(_PNG_MAGIC):
        return EncodedPicture(picture.stamp, PNG, data) if variant.unchanged else None
    if not data.startswith(_JPEG_MAGIC):
        raise UnusablePictureError("is neither JPEG nor PNG")
    if not variant.unchanged:
        if variant.quality is not None or variant.invert:
            return None
        if (variant.width, variant.height) != (None, None) and not _has_size(data, variant):
            return None
    return EncodedPicture(picture.stamp, JPEG, data)


def _has_size(jpeg: bytes, variant: Variant) -> bool:
    """Tell whether a JPEG has the asked size already."""
    try:
        height, width = simplejpeg.decode_jpeg_header(jpeg)[:2]
    except ValueError as error:
        raise UnusablePictureError(f"is a damaged JPEG: {error}") from error
    return variant.width in (None, width) and variant.height in (None, height)


def _decode(data: bytes) -> tuple[Any, str]:
    """Return the pixels of a JPEG or PNG and their colour space."""
    if data.startswith(_JPEG_MAGIC):
        try:
            colorspace = "GRAY" if simplejpeg.decode_jpeg_header(data)[2] == "Gray" else "BGR"
            return simplejpeg.decode_jpeg(data, colorspace=colorspace), colorspace
        except ValueError as error:
            raise UnusablePictureError(f"is a damaged JPEG: {error}") from error
    pixels = _cv2().imdecode(np.frombuffer(data, np.uint8), _cv2().IMREAD_COLOR)
    if pixels is None:
        raise UnusablePictureError("is a damaged PNG")
    return pixels, "BGR"


def _pixels(picture: RawPicture) -> tuple[Any, str]:
    """Return the pixels of a raw picture, (height, width, channels), and their colour space."""
    colorspace = _RAW_COLORSPACES.get(picture.encoding)
    if colorspace is None:
        known = ", ".join(_RAW_COLORSPACES)
        raise UnusablePictureError(f"has the encoding {picture.encoding!r}; known are {known}")
    channels = _CHANNELS[colorspace]
    row = picture.width * channels
    if not row or picture.step < row or len(picture.data) != picture.step * picture.height:
        raise UnusablePictureError(
            f"has {len(picture.data)} bytes, which do not fit {picture.width} x {picture.height} "
            f"{picture.encoding} with a step of {picture.step}"
        )
    rows = np.frombuffer(picture.data, np.uint8).reshape(picture.height, picture.step)[:, :row]
    return rows.reshape(picture.height, picture.width, channels), colorspace


def _changed(pixels: Any, variant: Variant) -> Any:
    """Return the pixels resized and turned by 180 degrees as the variant asks."""
    height, width = pixels.shape[:2]
    size = (variant.width or width, variant.height or height)
    if size != (width, height):
        cv2 = _cv2()
        shrinks = size[0] * size[1] < width * height
        pixels = cv2.resize(
            pixels, size, interpolation=cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
        )
        if pixels.ndim == 2:  # OpenCV drops the channel of grey pictures
            pixels = pixels[:, :, np.newaxis]
    return pixels[::-1, ::-1] if variant.invert else pixels


def _cv2() -> Any:
    """Import OpenCV only when it is needed: most streams pass through without it."""
    import cv2

    return cv2
