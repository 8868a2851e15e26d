"""What is drawn into, one for each size of picture."""

from __future__ import annotations

import moderngl
import numpy as np


class FrameTarget:
    """A colour and depth buffer, and the memory that its pixels are read into.

    Parameters
    ----------
    context
        To draw with.
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
            self._resolved = context.framebuffer([context.renderbuffer(size, 4)])
        self._pixels = np.empty((height, width, 4), dtype=np.uint8)

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
