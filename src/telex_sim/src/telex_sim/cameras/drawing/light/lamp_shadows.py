"""The lamps' shadow maps, drawn once for all cameras that look at the same poses.

All lie in one texture, a tile for each lamp, so that a program needs only one sampler for them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Dict, List, Optional, Tuple

import moderngl
import numpy as np

from ..culling import spheres_in_view
from ..meshes.gpu_scene import GpuScene
from ..stillness import is_still
from .lamps import LampRig

# What is nearer to a lamp is its housing, which throws no shadow (m).
_NEAREST_CASTER = 0.06

# A tile shows a little more than the cone, so that no look-up at its edge falls beside the tile;
# lamps that shine all around have shadows in front of them, up to this angle (rad).
_BESIDE_CONE, _WIDEST = 0.06, 2.5

# Slope factor and constant of OpenGL's polygon offset: against surfaces that shade themselves.
_POLYGON_OFFSET = (2.0, 4.0)

_TILES_PER_ROW = 3


@dataclass
class _Tile:
    """A tile and what it shows; it is checked when that has been seen to since the last move."""

    lamp: Optional[int] = None
    pose: Optional[np.ndarray] = None
    casters: Optional[np.ndarray] = None
    model: Optional[np.ndarray] = None
    checked: bool = False

    def shows(self, pose: np.ndarray, casters: np.ndarray, model: np.ndarray) -> bool:
        """Whether it need not be drawn again."""
        return (
            self.pose is not None
            and self.casters is not None
            and self.model is not None
            and is_still(pose, self.pose)
            and np.array_equal(casters, self.casters)
            and is_still(model, self.model)
        )


class LampShadows:
    """Depths as the lamps see them.

    Parameters
    ----------
    context, program
        To draw with; the program writes depth alone.
    count
        How many lamps can have shadows at a time.
    size
        Pixels along each side of a tile.
    softness
        Half the width of the soft edges of shadows, in pixels of a tile.
    """

    def __init__(
        self,
        context: moderngl.Context,
        program: moderngl.Program,
        count: int,
        size: int,
        softness: float,
    ) -> None:
        self._context = context
        self._program = program
        self._clip_from_model: Any = program["clip_from_model"]
        self._size = size
        self._softness = softness
        self._tiles = [_Tile() for _ in range(count)]
        columns = min(count, _TILES_PER_ROW)
        rows = -(-count // columns)
        self._extent = np.array([columns * size, rows * size])
        self._depths = context.depth_texture((columns * size, rows * size))
        self._depths.compare_func = "<="
        self._depths.filter = (moderngl.LINEAR, moderngl.LINEAR)
        self._depths.repeat_x = self._depths.repeat_y = False
        self._framebuffer = context.framebuffer(depth_attachment=self._depths)

    def invalidate(self) -> None:
        """Have everything drawn anew even if nothing has moved: the scene is another one."""
        self._tiles = [_Tile() for _ in self._tiles]

    def choose(self, rig: LampRig, focus: np.ndarray) -> None:
        """Choose the lamps that have maps, now that things have moved.

        Parameters
        ----------
        rig
            The lamps.
        focus
            Point around which shadows matter (m), shape (3,).
        """
        self._assign(rig.matter_most(focus, len(self._tiles)))
        for tile in self._tiles:
            tile.checked = False

    def update(
        self,
        scene: GpuScene,
        model: np.ndarray,
        centers: np.ndarray,
        rig: LampRig,
        numbers: np.ndarray,
    ) -> None:
        """Draw the maps that a picture needs, unless another one has needed them since the choice.

        Parameters
        ----------
        scene
            What there is.
        model
            World from model of each drawable, shape (N, 4, 4).
        centers
            Of their bounding spheres in the world, shape (N, 3).
        rig
            The lamps.
        numbers
            Of the lamps in the picture.
        """
        needed = set(numbers.tolist())
        casters = np.flatnonzero(scene.casts_shadow)
        for place, tile in enumerate(self._tiles):
            if tile.lamp is not None and tile.lamp in needed and not tile.checked:
                tile.checked = True
                self._draw(place, tile, tile.lamp, scene, model, centers, casters, rig)

    def _assign(self, wanted: np.ndarray) -> None:
        """Give each lamp a tile; one that had one keeps it, with what is drawn there."""
        missing: List[int] = [int(lamp) for lamp in wanted]
        for tile in self._tiles:
            if tile.lamp in missing:
                missing.remove(tile.lamp)
            else:
                tile.lamp = tile.pose = None
        for tile in self._tiles:
            if tile.lamp is None and missing:
                tile.lamp = missing.pop(0)

    def _draw(
        self,
        place: int,
        tile: _Tile,
        lamp: int,
        scene: GpuScene,
        model: np.ndarray,
        centers: np.ndarray,
        casters: np.ndarray,
        rig: LampRig,
    ) -> None:
        pose = np.vstack([rig.axes[lamp], rig.positions[lamp]])
        clip = self._clip_from_world(rig, lamp)
        seen = casters[spheres_in_view(clip, centers[casters], scene.radii[casters])]
        if tile.shows(pose, seen, model[seen]):
            return
        tile.pose, tile.casters, tile.model = pose, seen, model[seen].copy()
        corner = self._corner(place)
        viewport = (int(corner[0]), int(corner[1]), self._size, self._size)
        self._framebuffer.viewport = viewport
        self._framebuffer.use()
        self._framebuffer.clear(depth=1.0, viewport=viewport)
        # OpenGL takes matrices column by column.
        matrices = (clip @ model[seen]).transpose(0, 2, 1).astype(np.float32)
        self._context.polygon_offset = _POLYGON_OFFSET
        for number, matrix in zip(seen, matrices):
            self._clip_from_model.write(matrix.tobytes())
            scene.drawables[number].mesh.outline(self._program).render()
        self._context.polygon_offset = (0.0, 0.0)

    def _corner(self, place: int) -> np.ndarray:
        return self._size * np.array([place % _TILES_PER_ROW, place // _TILES_PER_ROW])

    @staticmethod
    def _clip_from_world(rig: LampRig, lamp: int) -> np.ndarray:
        focal = _focal(rig.angles[lamp])
        near, far = _depths(rig, lamp)
        projection = np.array(
            [
                [focal, 0.0, 0.0, 0.0],
                [0.0, focal, 0.0, 0.0],
                [0.0, 0.0, (far + near) / (far - near), -2.0 * far * near / (far - near)],
                [0.0, 0.0, 1.0, 0.0],
            ]
        )
        lamp_from_world = np.eye(4)
        lamp_from_world[:3, :3] = rig.axes[lamp]
        lamp_from_world[:3, 3] = -rig.axes[lamp] @ rig.positions[lamp]
        return projection @ lamp_from_world

    def uniforms(self, rig: LampRig, numbers: np.ndarray, room: int) -> Dict[str, np.ndarray]:
        """Values for a program with room for so many lamps, by the names of its uniforms.

        A lamp without a map gets values with which every look-up finds light.
        """
        right, down, shadow = (np.zeros((room, 4), dtype=np.float32) for _ in range(3))
        places = {tile.lamp: place for place, tile in enumerate(self._tiles)}
        half = 0.5 * self._size / self._extent
        for row, lamp in enumerate(numbers.tolist()):
            place = places.get(lamp)
            if place is None:
                continue
            focal = _focal(rig.angles[lamp])
            middle = self._corner(place) / self._extent + half
            near, far = _depths(rig, lamp)
            texel = 2.0 / (focal * self._size)
            # No look-up of the ring, nor the pixel that it falls into, may dip into the surface.
            lift = (1.5 + self._softness) * texel
            right[row] = (*(half[0] * focal * rig.axes[lamp][0]), lift)
            down[row] = (*(half[1] * focal * rig.axes[lamp][1]), far * near / (far - near))
            shadow[row] = (*middle, far / (far - near), 0.0)
        return {"lamp_right": right, "lamp_down": down, "lamp_shadow": shadow}

    def tile(self) -> Tuple[float, ...]:
        """Half the extent of a tile, and half the width of soft edges, x and y each."""
        half = 0.5 * (self._size - 2.0) / self._extent
        return (*half.tolist(), *(self._softness / self._extent).tolist())

    def use(self, unit: int) -> None:
        """Bind the maps to a texture unit."""
        self._depths.use(unit)


def _depths(rig: LampRig, lamp: int) -> Tuple[float, float]:
    """Distances ahead of a lamp between which things throw shadows (m)."""
    # The light of a lamp may end within its housing.
    return _NEAREST_CASTER, max(float(rig.reaches[lamp]), 2.0 * _NEAREST_CASTER)


def _focal(angle: float) -> float:
    """Focal length of a tile, in halves of its side."""
    return 1.0 / math.tan(0.5 * min(angle + _BESIDE_CONE, _WIDEST))
