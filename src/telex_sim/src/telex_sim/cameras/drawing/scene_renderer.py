"""Interface between the ``cameras`` node and a renderer."""

from __future__ import annotations

from typing import List, Mapping, Protocol

import numpy as np

from ...scene.visual_scene import VisualScene
from ..optics.pinhole import PinholeCamera


class SceneRenderer(Protocol):
    """Renders one scene for any number of cameras, in one thread.

    Attributes
    ----------
    repeats : bool
        Whether the last picture was what the view before it had shown: nothing has moved.
    """

    repeats: bool

    def load_scene(self, scene: VisualScene) -> List[str]:
        """Take over a scene; returns what could not be loaded, and why."""

    def set_lamp_levels(self, levels: Mapping[str, float]) -> None:
        """Dim the lamps that have names: 0 is off, 1 full."""

    def place(self, frames_in_world: np.ndarray, focus: np.ndarray, recast: bool = True) -> None:
        """Move everything to where it is now, and shadows as well if they are to be recast.

        Shadows matter around the focus, shape (3,).
        """

    def render(
        self,
        camera: PinholeCamera,
        optical_in_world: np.ndarray,
        exposure: float = 1.0,
        coarse: bool = False,
    ) -> np.ndarray:
        """Take a picture: RGBA, uint8, in memory that the next picture may overwrite.

        Coarse ones may do without small shapes.
        """

    def depth(self, camera: PinholeCamera) -> np.ndarray:
        """Return depths along z (m, inf for none) of the picture that was taken last."""

    def release(self) -> None:
        """Free everything."""
