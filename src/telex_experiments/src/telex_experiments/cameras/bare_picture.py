"""A picture by PyBullet's getCameraImage: the yardstick of what a machine's processor can draw."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any, Dict

import numpy as np
import pybullet

from telex_control.common.geometry.matrices import inverse, pose_matrices, quaternion_tuple
from telex_sim.cameras.optics.pinhole import PinholeCamera
from telex_sim.scene.addresses import PackagePath, resolve_address
from telex_sim.scene.visual_scene import Visual, VisualScene, VisualShape

# Between OpenGL's eye (x right, y up, looking against z) and the optical frame.
_EYE_FROM_OPTICAL = np.diag([1.0, -1.0, -1.0, 1.0])

# A plane is drawn as a box of this thickness (m).
_THICKNESS = 0.002


class BarePicture:
    """One view of a scene by PyBullet's TinyRenderer, without shadows.

    Parameters
    ----------
    frames_in_world
        Poses of its frames, shape (frames, 4, 4).
    optical_in_world
        Pose of the camera's optical frame, shape (4, 4).
    package_path
        Gives the directory of a ROS package, for package:// addresses.
    """

    def __init__(
        self,
        scene: VisualScene,
        frames_in_world: np.ndarray,
        camera: PinholeCamera,
        optical_in_world: np.ndarray,
        package_path: PackagePath,
    ) -> None:
        self._client = pybullet.connect(pybullet.DIRECT)
        number = {name: index for index, name in enumerate(scene.frames)}
        for visual in scene.visuals:
            if visual.color[3] > 0.0:
                self._add(visual, frames_in_world[number[visual.frame]], package_path)
        view = _EYE_FROM_OPTICAL @ inverse(optical_in_world)
        upright = np.diag([1.0, -1.0, 1.0, 1.0])
        projection = upright @ camera.clip_from_optical() @ _EYE_FROM_OPTICAL
        # OpenGL takes matrices column by column.
        self._matrices = [matrix.T.reshape(-1).tolist() for matrix in (view, projection)]
        self._size = camera.width, camera.height

    def _add(self, visual: Visual, frame_in_world: np.ndarray, package_path: PackagePath) -> None:
        shape = pybullet.createVisualShape(
            rgbaColor=visual.color,
            physicsClientId=self._client,
            **_shape(visual, package_path),
        )
        pose = np.array([(*visual.position, *visual.orientation)])
        world_from_visual = frame_in_world @ pose_matrices(pose)[0]
        pybullet.createMultiBody(
            baseVisualShapeIndex=shape,
            basePosition=world_from_visual[:3, 3].tolist(),
            baseOrientation=quaternion_tuple(world_from_visual),
            physicsClientId=self._client,
        )

    def cost(self) -> float:
        """CPU time of a picture, with nothing around it but an array (s)."""
        began = time.thread_time()
        width, height = self._size
        _, _, pixels, depths, _ = pybullet.getCameraImage(
            width,
            height,
            *self._matrices,
            shadow=0,
            renderer=pybullet.ER_TINY_RENDERER,
            flags=pybullet.ER_NO_SEGMENTATION_MASK,
            physicsClientId=self._client,
        )
        np.array(pixels, dtype=np.uint8).reshape(height, width, 4)
        np.asarray(depths, dtype=np.float32).reshape(height, width)
        return time.thread_time() - began

    def release(self) -> None:
        """Free everything."""
        pybullet.disconnect(physicsClientId=self._client)


def _shape(visual: Visual, package_path: PackagePath) -> Dict[str, Any]:
    x, y, z = visual.size
    if visual.shape is VisualShape.SPHERE:
        return {"shapeType": pybullet.GEOM_SPHERE, "radius": x}
    if visual.shape is VisualShape.CYLINDER:
        return {"shapeType": pybullet.GEOM_CYLINDER, "radius": x, "length": z}
    if visual.shape is VisualShape.MESH:
        path = Path(resolve_address(visual.mesh, package_path))
        return {"shapeType": pybullet.GEOM_MESH, "fileName": str(path), "meshScale": visual.size}
    below = 0.0
    if visual.shape is VisualShape.PLANE:
        z, below = _THICKNESS, -0.5 * _THICKNESS
    return {
        "shapeType": pybullet.GEOM_BOX,
        "halfExtents": (0.5 * x, 0.5 * y, 0.5 * z),
        "visualFramePosition": (0.0, 0.0, below),
    }
