"""Pictures of a scene in which nothing has moved since they were drawn."""

from __future__ import annotations

from typing import List, NamedTuple, Optional, Tuple

import numpy as np

from ..optics.pinhole import PinholeCamera
from .stillness import is_still

# Exposures that differ by less than this share look alike.
_ALIKE = 0.005

_MOST = 16


class _Kept(NamedTuple):
    camera: PinholeCamera
    optical_in_world: np.ndarray
    exposure: float
    coarse: bool
    picture: np.ndarray

    def is_of(self, camera: PinholeCamera, optical_in_world: np.ndarray, coarse: bool) -> bool:
        """Whether the view is the same."""
        return (
            self.camera == camera
            and self.coarse == coarse
            and is_still(optical_in_world, self.optical_in_world)
        )


class KeptPictures:
    """Gives a camera its last picture again while it would be drawn alike.

    Nothing is kept while anything moves: a picture is worth its memory from the second set of poses
    on that are the same, once shadows have come to rest as well.
    """

    def __init__(self) -> None:
        self._poses: Optional[Tuple[np.ndarray, np.ndarray]] = None
        self._at_rest = self._shadows_late = False
        self._kept: List[_Kept] = []

    def forget(self) -> None:
        """Begin anew: something else than poses has changed."""
        self._poses = None
        self._kept.clear()

    def place(self, frames_in_world: np.ndarray, focus: np.ndarray, recast: bool) -> None:
        """Tell of the next set of poses; parameters are those of `Renderer.place`."""
        poses = (frames_in_world, focus)
        self._at_rest = self._poses is not None and all(map(is_still, poses, self._poses))
        if self._at_rest:
            self._shadows_late = self._shadows_late and not recast
            return
        # Compared with these until they are left for good: a slow drift adds up.
        self._poses = (frames_in_world.copy(), focus.copy())
        self._shadows_late = not recast
        self._kept.clear()

    def find(
        self,
        camera: PinholeCamera,
        optical_in_world: np.ndarray,
        exposure: float,
        coarse: bool = False,
    ) -> Optional[np.ndarray]:
        """Return the picture that `Renderer.render` would draw with these, if it is kept."""
        for kept in self._kept:
            alike = abs(exposure - kept.exposure) <= _ALIKE * kept.exposure
            if alike and kept.is_of(camera, optical_in_world, coarse):
                return kept.picture
        return None

    def keep(
        self,
        camera: PinholeCamera,
        optical_in_world: np.ndarray,
        exposure: float,
        picture: np.ndarray,
        coarse: bool = False,
    ) -> None:
        """Keep a copy of a picture, if it is worth it."""
        if not self._at_rest or self._shadows_late:
            return
        # One of the same view was exposed differently.
        others = [kept for kept in self._kept if not kept.is_of(camera, optical_in_world, coarse)]
        new = _Kept(camera, optical_in_world.copy(), exposure, coarse, picture.copy())
        self._kept = [*others, new][-_MOST:]
