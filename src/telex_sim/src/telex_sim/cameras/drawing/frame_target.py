"""Framebuffers, one for each size of picture."""

from __future__ import annotations

import moderngl
import numpy as np


class FrameTarget:
    """A colour and depth buffer, and the memory that its pixels are read into.

    Parameters
    ----------
    width, height
        Of the picture (pixels).
    samples
        Of multisampling; 0 for none.
    """

    def __init__(self, context: moderngl.Context, width: int, height: int, samples: int) -> None:
        size = (width, height)
        self._context = context
        self._drawn = context.framebuffer(
            [context.renderbuffer(size, 4, samples=samples)],
            context.depth_renderbuffer(size, samples=samples),
        )
        self._resolved = self._drawn
        if samples:
            self._resolved = context.framebuffer(
                [context.renderbuffer(size, 4)], context.depth_renderbuffer(size)
            )
        self._pixels = np.empty((height, width, 4), dtype=np.uint8)
        self._depths = np.empty((height, width), dtype=np.float32)

    def begin(self) -> moderngl.Framebuffer:
        """Direct drawing here, and begin with nothing."""
        self._drawn.use()
        self._drawn.clear()
        return self._drawn

    def read(self) -> np.ndarray:
        """Return the picture: RGBA, shape (height, width, 4), uint8; the next overwrites it."""
        if self._resolved is not self._drawn:
            self._context.copy_framebuffer(self._resolved, self._drawn)
        self._resolved.read_into(self._pixels, components=4)
        return self._pixels

    def lend(self, picture: np.ndarray) -> np.ndarray:
        """Return a copy of a picture of this size, in the memory that `read` returns."""
        np.copyto(self._pixels, picture)
        return self._pixels

    def read_depth(self, near: float, far: float) -> np.ndarray:
        """Return distances along the optical axis (m), of a picture that has been read.

        Of several samples of a pixel one is taken: a mean would lie between two surfaces.

        Parameters
        ----------
        near, far
            With which it was projected (m).

        Returns
        -------
        numpy.ndarray
            Shape (height, width), float32; infinite where there is nothing.
        """
        self._resolved.read_into(self._depths, components=1, attachment=-1, dtype="f4")
        # The window's depth is (1/near - 1/z) / (1/near - 1/far).
        inverse = np.float32(1.0 / near) - self._depths * np.float32(1.0 / near - 1.0 / far)
        with np.errstate(divide="ignore"):
            distances: np.ndarray = np.reciprocal(inverse)
        distances[self._depths >= 1.0] = np.inf
        return distances

    def release(self) -> None:
        """Free the memory on the graphics card."""
        for framebuffer in {self._drawn, self._resolved}:
            for attachment in (*framebuffer.color_attachments, framebuffer.depth_attachment):
                attachment.release()
            framebuffer.release()
