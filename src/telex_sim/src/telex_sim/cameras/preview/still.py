"""Single pictures, outside the ``cameras`` node: for previews and tests."""

from __future__ import annotations

from typing import List, Sequence, Union

import numpy as np

from ...scene.addresses import PackagePath
from ...scene.visual_scene import VisualScene
from ..drawing.gl_context import create_context
from ..drawing.light.daylight import Lighting, unit
from ..drawing.quality import Quality
from ..drawing.renderer import Renderer
from ..optics.pinhole import PinholeCamera


def looking(eye: Sequence[float], target: Sequence[float]) -> np.ndarray:
    """Pose of an optical frame at ``eye`` that looks at ``target`` (m), its picture upright.

    Returns
    -------
    numpy.ndarray
        Shape (4, 4).

    Raises
    ------
    ValueError
        When the two are the same point.
    """
    if np.allclose(eye, target, rtol=0.0, atol=1e-9):
        raise ValueError(f"eye and target are the same point: {list(eye)}")
    forward = unit(np.subtract(target, eye))
    # Straight up or down, the top of the picture is towards +x.
    upwards = (1.0, 0.0, 0.0) if abs(forward[2]) > 0.9999 else (0.0, 0.0, 1.0)
    right = unit(np.cross(forward, upwards))
    pose = np.eye(4)
    pose[:3, :3] = np.column_stack([right, np.cross(forward, right), forward])
    pose[:3, 3] = eye
    return pose


class Still:
    """A renderer with an OpenGL context of its own; there may be several at a time.

    Parameters
    ----------
    quality, lighting, package_path
        As for `Renderer`.

    Raises
    ------
    NoContextError
        There is no way to render on this machine.
    """

    def __init__(self, quality: Quality, lighting: Lighting, package_path: PackagePath) -> None:
        self._context = create_context()
        with self._context:
            self.renderer = Renderer(self._context, quality, lighting, package_path)

    def load(self, scene: VisualScene) -> List[str]:
        """Take over a scene; returns what could not be loaded, and why."""
        with self._context:
            return self.renderer.load_scene(scene)

    def picture(
        self,
        camera: PinholeCamera,
        optical_in_world: np.ndarray,
        frames_in_world: np.ndarray,
        focus: Union[np.ndarray, Sequence[float]],
        exposure: float = 1.0,
        recast: bool = True,
    ) -> np.ndarray:
        """Take a picture.

        Parameters
        ----------
        camera, optical_in_world
            As for `Renderer.render`.
        frames_in_world, focus, recast
            As for `Renderer.place`.
        exposure
            As for `Renderer.render`.

        Returns
        -------
        numpy.ndarray
            RGB, shape (height, width, 3), uint8, rows from above.
        """
        with self._context:
            self.renderer.place(frames_in_world, np.asarray(focus, dtype=np.float64), recast)
            return self.renderer.render(camera, optical_in_world, exposure)[..., :3].copy()

    def depth(self, camera: PinholeCamera) -> np.ndarray:
        """Measure how far what the last picture shows is; see `Renderer.depth`."""
        with self._context:
            return self.renderer.depth(camera)

    def release(self) -> None:
        """Free everything."""
        self.renderer.release()
