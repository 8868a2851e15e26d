"""Draws the scene with PyBullet's TinyRenderer, where there is no OpenGL."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, List, Mapping

import cv2
import numpy as np
import pybullet

from telex_control.common.geometry.matrices import inverse, pose_matrices, quaternion_tuple

from ...scene.addresses import AddressError, PackagePath, resolve_address
from ...scene.visual_scene import Daylight, Visual, VisualScene, VisualShape
from ..optics.pinhole import PinholeCamera
from .light.daylight import unit

# Between OpenGL's eye (x right, y up, looking against z) and the optical frame.
_EYE_FROM_OPTICAL = np.diag([1.0, -1.0, -1.0, 1.0])

# A plane is drawn as a box of this thickness (m).
_THICKNESS = 0.002

# Depth in PyBullet's buffer from which on there is nothing.
_NOWHERE = np.float32(0.9999999)

# Colour of a bright day's sky.
_SKY = np.array([138.0, 160.0, 188.0])

# What moves less than this stays where it is (m, or the sine of an angle).
_STILL = 1e-5


class TinyRenderer:
    """Renders one scene for any number of cameras, in flat colours.

    It knows no textures and no fog. Of lamps it only knows whether any burns: then light comes from
    the camera.

    A PyBullet client of its own holds the shapes, each as a body without mass that is put where the
    poses say.

    Parameters
    ----------
    package_path
        Gives the directory of a ROS package, for package:// addresses.
    shadows
        Whether the sun casts shadows, faint ones, at three times the cost.
    """

    repeats = False

    def __init__(self, package_path: PackagePath, shadows: bool = False) -> None:
        self._shadows = shadows
        self._package_path = package_path
        self._client = pybullet.connect(pybullet.DIRECT)
        self._bodies: List[int] = []
        self._frames = np.zeros(0, dtype=np.intp)
        self._frame_count = 0
        self._local = np.zeros((0, 4, 4))
        self._placed = np.zeros((0, 4, 4))
        self._daylight = Daylight()
        self._fixed_lamps = False
        self._levels: Dict[str, float] = {}
        self._depths = np.zeros((0, 0), dtype=np.float32)

    def load_scene(self, scene: VisualScene) -> List[str]:
        """Take over a scene; returns what could not be loaded, and why."""
        pybullet.resetSimulation(physicsClientId=self._client)
        number = {name: index for index, name in enumerate(scene.frames)}
        problems: List[str] = []
        shown: List[Visual] = []
        self._bodies = []
        for visual in scene.visuals:
            if visual.color[3] == 0.0:
                continue
            try:
                self._bodies.append(self._body(visual))
            except (AddressError, OSError, pybullet.error) as error:
                problems.append(f"{visual.label} is left out: {error}")
                continue
            shown.append(visual)
        self._frame_count = len(scene.frames)
        self._frames = np.array([number[visual.frame] for visual in shown], dtype=np.intp)
        poses = np.array([(*visual.position, *visual.orientation) for visual in shown])
        self._local = pose_matrices(poses.reshape(-1, 7))
        self._placed = np.full((len(shown), 4, 4), np.nan)
        self._daylight = scene.daylight
        self._fixed_lamps = any(not lamp.name for lamp in scene.lamps)
        self._levels = {lamp.name: 1.0 for lamp in scene.lamps if lamp.name}
        return problems

    def _body(self, visual: Visual) -> int:
        shape = pybullet.createVisualShape(
            rgbaColor=visual.color, physicsClientId=self._client, **self._shape(visual)
        )
        return int(
            pybullet.createMultiBody(baseVisualShapeIndex=shape, physicsClientId=self._client)
        )

    def _shape(self, visual: Visual) -> Dict[str, Any]:
        x, y, z = visual.size
        if visual.shape is VisualShape.SPHERE:
            return {"shapeType": pybullet.GEOM_SPHERE, "radius": x}
        if visual.shape is VisualShape.CYLINDER:
            return {"shapeType": pybullet.GEOM_CYLINDER, "radius": x, "length": z}
        if visual.shape is VisualShape.MESH:
            path = Path(resolve_address(visual.mesh, self._package_path))
            # PyBullet would search other directories, and say nothing of what it took.
            path.open("rb").close()
            return {
                "shapeType": pybullet.GEOM_MESH,
                "fileName": str(path),
                "meshScale": visual.size,
            }
        below = 0.0
        if visual.shape is VisualShape.PLANE:
            z, below = _THICKNESS, -0.5 * _THICKNESS
        return {
            "shapeType": pybullet.GEOM_BOX,
            "halfExtents": (0.5 * x, 0.5 * y, 0.5 * z),
            "visualFramePosition": (0.0, 0.0, below),
        }

    def set_lamp_levels(self, levels: Mapping[str, float]) -> None:
        """Dim the lamps that have names: 0 is off, 1 full."""
        self._levels = {name: levels.get(name, 1.0) for name in self._levels}

    def place(self, frames_in_world: np.ndarray, focus: np.ndarray, recast: bool = True) -> None:
        """Move everything to where it is now.

        Parameters
        ----------
        frames_in_world
            Poses of the scene's frames, shape (frames, 4, 4).
        focus, recast
            Not used: shadows, where there are any, are drawn with each picture.

        Raises
        ------
        ValueError
            When the number of frames is not the scene's.
        """
        if len(frames_in_world) != self._frame_count:
            raise ValueError(
                f"poses of {len(frames_in_world)} frames for a scene of {self._frame_count}"
            )
        placed = frames_in_world[self._frames] @ self._local
        # Also true where nothing has been placed yet.
        moved = ~(np.abs(placed - self._placed).reshape(len(placed), -1) < _STILL).all(axis=1)
        for number in np.flatnonzero(moved).tolist():
            matrix = placed[number]
            pybullet.resetBasePositionAndOrientation(
                self._bodies[number],
                matrix[:3, 3].tolist(),
                quaternion_tuple(matrix[:3, :3]),
                physicsClientId=self._client,
            )
        self._placed[moved] = placed[moved]

    def render(
        self, camera: PinholeCamera, optical_in_world: np.ndarray, exposure: float = 1.0
    ) -> np.ndarray:
        """Take a picture: RGBA, shape (height, width, 4), uint8, rows from above."""
        view = _EYE_FROM_OPTICAL @ inverse(optical_in_world)
        upright = np.diag([1.0, -1.0, 1.0, 1.0])
        # TinyRenderer looks at the lower left corners of pixels, not at their middles.
        upright[:2, 3] = -1.0 / camera.width, -1.0 / camera.height
        projection = upright @ camera.clip_from_optical() @ _EYE_FROM_OPTICAL
        _, _, pixels, depths, _ = pybullet.getCameraImage(
            camera.width,
            camera.height,
            # OpenGL takes matrices column by column.
            view.T.reshape(-1).tolist(),
            projection.T.reshape(-1).tolist(),
            shadow=int(self._shadows),
            renderer=pybullet.ER_TINY_RENDERER,
            flags=pybullet.ER_NO_SEGMENTATION_MASK,
            physicsClientId=self._client,
            **self._light(optical_in_world),
        )
        size = (camera.height, camera.width)
        self._depths = np.asarray(depths, dtype=np.float32).reshape(size)
        picture = np.array(pixels, dtype=np.uint8).reshape(*size, 4)
        picture[self._depths >= _NOWHERE, :3] = _SKY * np.sqrt(self._daylight.ambient)
        return cv2.LUT(picture, _exposed(exposure)) if exposure != 1.0 else picture

    def _light(self, optical_in_world: np.ndarray) -> Dict[str, Any]:
        daylight = self._daylight
        lamps = 1.0 if self._fixed_lamps else max(self._levels.values(), default=0.0)
        sun = max(daylight.sun)
        if sun > 0.0:
            direction = unit(daylight.to_sun)
            color = tuple(min(component / sun, 1.0) for component in daylight.sun)
        else:
            direction = -optical_in_world[:3, 2]
            color = (1.0, 1.0, 1.0)
        return {
            "lightDirection": np.asarray(direction).tolist(),
            "lightColor": color,
            "lightAmbientCoeff": min(0.5 * daylight.ambient + 0.1 * lamps, 1.0),
            "lightDiffuseCoeff": min(0.5 * sun + 0.6 * lamps, 1.0),
            "lightSpecularCoeff": 0.0,
        }

    def depth(self, camera: PinholeCamera) -> np.ndarray:
        """Return depths along z (m, inf for none) of the picture that was taken last."""
        near, far = camera.near, camera.far
        along = 2.0 * self._depths - 1.0
        depths = 2.0 * far * near / (far + near - along * (far - near))
        return np.where(self._depths < _NOWHERE, depths, np.inf).astype(np.float32)

    def release(self) -> None:
        """Free everything."""
        pybullet.disconnect(physicsClientId=self._client)


def _exposed(factor: float) -> np.ndarray:
    """Values for each value of a picture, were there more or less light, shape (256,)."""
    # Values are about the square root of light.
    values = np.arange(256) * np.sqrt(factor)
    return np.clip(np.rint(values), 0, 255).astype(np.uint8)
