"""The scene as the renderer knows it: frames, and the visuals that are fixed to them."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass
from typing import Iterable, Tuple

import numpy as np

from .transforms import Quaternion, pose_matrices

Vector3 = Tuple[float, float, float]
Color = Tuple[float, float, float, float]

CHECKER = "checker"


class Shape(enum.IntEnum):
    """Kinds of visuals; the numbers are those of telex_msgs/SceneVisual."""

    BOX = 1
    SPHERE = 2
    CYLINDER = 3
    MESH = 4
    PLANE = 5


# The components of the size that a shape reads and that must therefore be lengths above zero.
_LENGTHS = {
    Shape.BOX: (0, 1, 2),
    Shape.SPHERE: (0,),
    Shape.CYLINDER: (0, 2),
    Shape.MESH: (),
    Shape.PLANE: (0, 1),
}


@dataclass(frozen=True)
class Visual:
    """One visible shape, fixed to a frame.

    Attributes
    ----------
    frame
        Name of the frame: "<model>/<link>" in a scene, the link's name in a model.
    shape, size
        What ``size`` means depends on the shape, as in telex_msgs/SceneVisual (m; a factor for
        meshes).
    position, orientation
        Of the shape in its frame: x y z (m), quaternion x y z w.
    color
        Red, green, blue, alpha, each 0..1, as in sRGB.
    mesh
        Address of the mesh, for ``Shape.MESH``.
    texture
        Empty, "checker", or the address of an image; it is multiplied by the colour.
    texture_scale
        Length that one repetition of the texture covers (m).

    Raises
    ------
    ValueError
        When a value is not finite or out of its range.
    """

    frame: str
    shape: Shape
    size: Vector3
    position: Vector3 = (0.0, 0.0, 0.0)
    orientation: Quaternion = (0.0, 0.0, 0.0, 1.0)
    color: Color = (0.7, 0.7, 0.7, 1.0)
    mesh: str = ""
    texture: str = ""
    texture_scale: float = 1.0

    def __post_init__(self) -> None:
        numbers = (*self.size, *self.position, *self.orientation, *self.color, self.texture_scale)
        if not all(math.isfinite(number) for number in numbers):
            raise ValueError(f"{self.label}: a number is not finite: {numbers}")
        if any(self.size[axis] <= 0.0 for axis in _LENGTHS[self.shape]):
            raise ValueError(f"{self.label}: size {self.size} must be above zero")
        if self.shape is Shape.MESH:
            if not self.mesh:
                raise ValueError(f"{self.label}: a mesh needs an address")
            if 0.0 in self.size:
                raise ValueError(f"{self.label}: scale {self.size} must not be zero")
        if sum(component * component for component in self.orientation) < 1e-12:
            raise ValueError(f"{self.label}: the quaternion is zero")
        if not all(0.0 <= component <= 1.0 for component in self.color):
            raise ValueError(f"{self.label}: colour {self.color} must lie within 0..1")
        if self.texture and self.texture_scale <= 0.0:
            raise ValueError(f"{self.label}: texture_scale must be above zero")

    @property
    def label(self) -> str:
        """What messages call this visual."""
        return f"{self.shape.name.lower()} {self.mesh or ''}".strip() + f" of frame '{self.frame}'"

    @property
    def casts_shadow(self) -> bool:
        """Whether it belongs in the shadow map; a plane is ground or wall, with nothing behind."""
        return self.shape is not Shape.PLANE and self.color[3] >= 0.5


@dataclass(frozen=True)
class Scene:
    """What there is to see.

    Raises
    ------
    ValueError
        When a frame is named twice or a visual's frame is unknown.
    """

    revision: int
    frames: Tuple[str, ...]
    visuals: Tuple[Visual, ...]

    def __post_init__(self) -> None:
        known = set(self.frames)
        if len(known) != len(self.frames):
            raise ValueError("a frame is named twice in the scene")
        for visual in self.visuals:
            if visual.frame not in known:
                raise ValueError(f"{visual.label}: no such frame in the scene")


class Placement:
    """Turns the poses of frames into model matrices of the visuals fixed to them.

    Parameters
    ----------
    frames
        Names, in the order of the poses to come.
    visuals
        Whose frames are all among ``frames``.
    """

    def __init__(self, frames: Iterable[str], visuals: Iterable[Visual]) -> None:
        index = {name: number for number, name in enumerate(frames)}
        visuals = tuple(visuals)
        self._frame_count = len(index)
        self._frames = np.array([index[visual.frame] for visual in visuals], dtype=np.intp)
        poses = [(*visual.position, *visual.orientation) for visual in visuals]
        self._local = pose_matrices(np.reshape(np.array(poses, dtype=np.float64), (-1, 7)))

    def model_matrices(self, frames_in_world: np.ndarray) -> np.ndarray:
        """Matrices from each visual's own coordinates to the world.

        Parameters
        ----------
        frames_in_world
            Shape (frames, 4, 4).

        Returns
        -------
        numpy.ndarray
            Shape (visuals, 4, 4).

        Raises
        ------
        ValueError
            When the number of frames is not the scene's.
        """
        if len(frames_in_world) != self._frame_count:
            raise ValueError(
                f"poses of {len(frames_in_world)} frames for a scene of {self._frame_count}"
            )
        return frames_in_world[self._frames] @ self._local
