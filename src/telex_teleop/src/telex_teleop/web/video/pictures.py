"""Pictures as they come from ROS and as they go to clients."""

from __future__ import annotations

import dataclasses
import functools
import threading
import time
from typing import Any, Optional, Tuple, Union

import numpy as np
import simplejpeg

from . import mjpeg

JPEG = "image/jpeg"
PNG = "image/png"

PNG_COMPRESSION = 3
"""Compression level (0 to 9) of PNG where nobody asks for another, as web_video_server has it."""

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
_MEASURED = {"32FC1": "f4", "64FC1": "f8", "16UC1": "u2", "mono16": "u2", "16SC1": "i2"}
"""Encodings of one measured value per pixel, such as depth, and their numbers."""


class UnusablePictureError(ValueError):
    """A picture that cannot be read or encoded; the text says why."""


@dataclasses.dataclass(frozen=True)
class CompressedPicture:
    """A sensor_msgs/CompressedImage.

    Attributes
    ----------
    stamp
        Its header's stamp (s), which is sim time in a simulation.
    captured
        Wall time (s since 1970) of what it shows.
    arrived
        Wall time (s since 1970) at which it came.
    """

    stamp: float
    data: bytes
    captured: float = dataclasses.field(default_factory=time.time)
    arrived: float = dataclasses.field(default_factory=time.time)


@dataclasses.dataclass(frozen=True)
class RawPicture:
    """A sensor_msgs/Image.

    Attributes
    ----------
    stamp
        Its header's stamp (s), which is sim time in a simulation.
    width, height
        Size (pixels).
    step
        Bytes of a row.
    encoding
        ROS's name of the pixel format.
    captured
        Wall time (s since 1970) of what it shows.
    big_endian
        Byte order of pixels of more than one byte.
    arrived
        Wall time (s since 1970) at which it came.
    """

    stamp: float
    width: int
    height: int
    step: int
    encoding: str
    data: bytes
    captured: float = dataclasses.field(default_factory=time.time)
    big_endian: bool = False
    arrived: float = dataclasses.field(default_factory=time.time)


Picture = Union[CompressedPicture, RawPicture]


@dataclasses.dataclass(frozen=True)
class Variant:
    """Changes that a client asks for in the pictures of a topic; None changes nothing.

    Attributes
    ----------
    width, height
        Size (pixels). Each stands alone: like web_video_server, a width without a height does not
        keep the aspect.
    quality
        JPEG quality (1 to 100), or compression level of PNG (0 to 9).
    invert
        Turn by 180 degrees.
    mime
        `JPEG` or `PNG`.
    unchanged
        Hand on compressed pictures as they are, whatever their format (type ros_compressed).
    fit
        Width and height are the most that is wanted: larger pictures are scaled down, keeping
        their aspect; others keep their size.
    """

    width: Optional[int] = None
    height: Optional[int] = None
    quality: Optional[int] = None
    invert: bool = False
    mime: str = JPEG
    unchanged: bool = False
    fit: bool = False

    @property
    def has_wishes(self) -> bool:
        """Whether it asks for more than a JPEG as it is published."""
        return not self.unchanged and self != Variant(fit=self.fit)


@dataclasses.dataclass(frozen=True)
class EncodedPicture:
    """A picture ready for a client.

    Its stamp (s), content type, bytes, and the wall times (s) of its scene and of its arrival.
    """

    stamp: float
    mime: str
    data: bytes
    captured: float = 0.0
    arrived: float = 0.0

    @functools.cached_property
    def part(self) -> bytes:
        """The picture as a part of an MJPEG stream; made once for all who watch it."""
        return mjpeg.part(self.data, self.stamp, self.mime)

    @functools.cached_property
    def size(self) -> Tuple[int, int]:
        """Width and height (pixels)."""
        return _size(self.data, self.mime)


def kept(picture: Picture, variant: Variant) -> Optional[EncodedPicture]:
    """Return the picture with its bytes as they are, or None where something has to be changed.

    Raises
    ------
    UnusablePictureError
        The picture is damaged or of an unknown kind.
    """
    if not isinstance(picture, CompressedPicture):
        return None
    mime = _mime(picture.data)
    if not variant.unchanged:
        if mime != variant.mime or variant.quality is not None or variant.invert:
            return None
        asked = (variant.width, variant.height)
        if asked != (None, None) and not _has_size(picture.data, mime, variant):
            return None
    return EncodedPicture(picture.stamp, mime, picture.data, picture.captured, picture.arrived)


def encode(picture: Picture, variant: Variant, default_quality: int) -> EncodedPicture:
    """Make the variant of a picture; one of which no change is asked keeps its bytes.

    Parameters
    ----------
    default_quality
        JPEG quality (1 to 100) where the variant names none.

    Raises
    ------
    UnusablePictureError
        The picture is damaged or of an unknown kind.
    """
    as_it_is = kept(picture, variant)
    if as_it_is is not None:
        return as_it_is
    if isinstance(picture, CompressedPicture):
        pixels, colorspace = _decode(picture.data, variant)
    else:
        pixels, colorspace = _pixels(picture)
    pixels = np.ascontiguousarray(_changed(pixels, variant))
    if variant.mime == PNG:
        data = _png(pixels, colorspace, variant.quality)
    else:
        data = _jpeg(pixels, colorspace, variant.quality or default_quality)
    return EncodedPicture(picture.stamp, variant.mime, data, picture.captured, picture.arrived)


def _mime(data: bytes) -> str:
    if data.startswith(_JPEG_MAGIC):
        return JPEG
    if data.startswith(_PNG_MAGIC):
        return PNG
    raise UnusablePictureError("is neither JPEG nor PNG")


def _size(data: bytes, mime: str) -> Tuple[int, int]:
    """Return width and height (pixels) of an encoded picture, without decoding it."""
    if mime == PNG:
        # The first chunk of a PNG is its header, which begins with the size.
        if len(data) < 24 or data[12:16] != b"IHDR":
            raise UnusablePictureError("is a damaged PNG")
        return int.from_bytes(data[16:20], "big"), int.from_bytes(data[20:24], "big")
    try:
        height, width = simplejpeg.decode_jpeg_header(data)[:2]
    except ValueError as error:
        raise UnusablePictureError(f"is a damaged JPEG: {error}") from error
    return width, height


def _target(size: Tuple[int, int], variant: Variant) -> Tuple[int, int]:
    """Return the size (width, height) that a variant makes of a picture's own."""
    if not variant.fit:
        return variant.width or size[0], variant.height or size[1]
    width, height = size
    scale = min(1.0, (variant.width or width) / width, (variant.height or height) / height)
    return max(1, round(width * scale)), max(1, round(height * scale))


def _has_size(data: bytes, mime: str, variant: Variant) -> bool:
    """Tell whether an encoded picture has the asked size already."""
    size = _size(data, mime)
    return _target(size, variant) == size


class _Scratch(threading.local):
    """Memory of a thread for the pixels of one picture.

    Fresh memory for each would come from the kernel, page by page, which is a tenth of decoding.
    """

    def __init__(self) -> None:
        self._bytes = np.empty(0, np.uint8)

    def take(self, size: int) -> Any:
        """Return so many bytes, good until the next call."""
        if self._bytes.size < size:
            self._bytes = np.empty(size, np.uint8)
        return self._bytes


_scratch = _Scratch()


def _decode(data: bytes, variant: Variant) -> Tuple[Any, str]:
    """Return the pixels of a JPEG or PNG, not smaller than asked, and their colour space.

    They are good until the thread decodes another picture.
    """
    mime = _mime(data)
    if mime == JPEG:
        width, height = _target(_size(data, mime), variant)
        try:
            rows, columns, kind = simplejpeg.decode_jpeg_header(data, height, width, 1)[:3]
            colorspace = "GRAY" if kind == "Gray" else "BGR"
            # JPEG decodes to half, a quarter, ... of its size in less time than to the whole. Its
            # colours have half the resolution, and will again: finer steps between them are lost.
            pixels = simplejpeg.decode_jpeg(
                data,
                colorspace=colorspace,
                fastdct=True,
                fastupsample=True,
                min_width=width,
                min_height=height,
                min_factor=1,
                buffer=_scratch.take(rows * columns * _CHANNELS[colorspace]),
            )
        except ValueError as error:
            raise UnusablePictureError(f"is a damaged JPEG: {error}") from error
        return pixels, colorspace
    pixels = _cv2().imdecode(np.frombuffer(data, np.uint8), _cv2().IMREAD_COLOR)
    if pixels is None:
        raise UnusablePictureError("is a damaged PNG")
    return pixels, "BGR"


def _pixels(picture: RawPicture) -> Tuple[Any, str]:
    """Return the pixels of a raw picture, (height, width, channels), and their colour space."""
    number = _MEASURED.get(picture.encoding)
    if number is not None:
        order = ">" if picture.big_endian else "<"
        kind = np.dtype(order + number)
        rows = _rows(picture, kind.itemsize)
        return _as_grey(np.ascontiguousarray(rows).view(kind)), "GRAY"
    colorspace = _RAW_COLORSPACES.get(picture.encoding)
    if colorspace is None:
        known = ", ".join([*_RAW_COLORSPACES, *_MEASURED])
        raise UnusablePictureError(f"has the encoding {picture.encoding!r}; known are {known}")
    channels = _CHANNELS[colorspace]
    rows = _rows(picture, channels)
    return rows.reshape(picture.height, picture.width, channels), colorspace


def _rows(picture: RawPicture, pixel: int) -> Any:
    """Return the bytes of a raw picture, (height, width * bytes per pixel), without padding."""
    row = picture.width * pixel
    if not row or picture.step < row or len(picture.data) != picture.step * picture.height:
        raise UnusablePictureError(
            f"has {len(picture.data)} bytes, which do not fit {picture.width} x {picture.height} "
            f"{picture.encoding} with a step of {picture.step}"
        )
    return np.frombuffer(picture.data, np.uint8).reshape(picture.height, picture.step)[:, :row]


def _as_grey(values: Any) -> Any:
    """Show measured values as grey, (height, width, 1): the largest white, no number black."""
    finite = np.where(np.isfinite(values), values, 0).astype(np.float64)
    largest = finite.max()
    scale = 255.0 / largest if largest > 0.0 else 0.0
    return np.clip(finite * scale, 0.0, 255.0).astype(np.uint8)[:, :, np.newaxis]


def _changed(pixels: Any, variant: Variant) -> Any:
    """Return the pixels resized and turned by 180 degrees as the variant asks."""
    height, width = pixels.shape[:2]
    size = _target((width, height), variant)
    if size != (width, height):
        cv2 = _cv2()
        shrinks = size[0] * size[1] < width * height
        pixels = cv2.resize(
            pixels, size, interpolation=cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
        )
        if pixels.ndim == 2:  # OpenCV drops the channel of grey pictures
            pixels = pixels[:, :, np.newaxis]
    return pixels[::-1, ::-1] if variant.invert else pixels


def _jpeg(pixels: Any, colorspace: str, quality: int) -> bytes:
    try:
        return simplejpeg.encode_jpeg(
            pixels,
            quality=quality,
            colorspace=colorspace,
            colorsubsampling="Gray" if colorspace == "GRAY" else "420",
        )
    except ValueError as error:
        raise UnusablePictureError(f"cannot be encoded as JPEG: {error}") from error


def _png(pixels: Any, colorspace: str, level: Optional[int]) -> bytes:
    cv2 = _cv2()
    if colorspace in ("RGB", "RGBA"):
        pixels = cv2.cvtColor(pixels, getattr(cv2, f"COLOR_{colorspace}2BGR"))
    elif colorspace == "BGRA":
        pixels = pixels[:, :, :3]
    level = PNG_COMPRESSION if level is None else level
    made, data = cv2.imencode(
        ".png", np.ascontiguousarray(pixels), [cv2.IMWRITE_PNG_COMPRESSION, level]
    )
    if not made:
        raise UnusablePictureError("cannot be encoded as PNG")
    return data.tobytes()


def _cv2() -> Any:
    """Import OpenCV only when it is needed: most streams pass through without it."""
    import cv2

    return cv2
