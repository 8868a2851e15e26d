"""Makes an OpenGL context without a display."""

from __future__ import annotations

from typing import Any, Dict

import moderngl

NEEDED_PACKAGES = "libegl1 libgl1 libgl1-mesa-dri"

# OpenGL 3.3, the first with everything that the shaders use.
_GL_VERSION = 330


class NoContextError(RuntimeError):
    """There is no way to render on this machine; the message says what to install."""


def create_context(device: int = 0) -> moderngl.Context:
    """Make an OpenGL context on EGL, owned by the calling thread.

    Parameters
    ----------
    device
        Number of EGL's device: on a machine with several graphics cards, which one.

    Raises
    ------
    NoContextError
        When EGL or a driver is missing.
    """
    egl: Dict[str, Any] = {"backend": "egl", "device_index": device}
    try:
        return moderngl.create_context(require=_GL_VERSION, standalone=True, **egl)
    except Exception as error:  # glcontext raises nothing more specific
        raise NoContextError(
            f"cannot make an OpenGL {_GL_VERSION / 100:.1f} context on EGL device {device}"
            f" ({error}); without a graphics card, install Mesa's renderer:"
            f" apt-get install {NEEDED_PACKAGES}"
        ) from error
