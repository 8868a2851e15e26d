"""Choice of the lamps that light a picture, and their uniforms."""

from __future__ import annotations

import math
from typing import Dict, Mapping, NamedTuple, Sequence, Tuple, Union

import numpy as np

from ....scene.visual_scene import VisualLamp
from ..culling import Cones, cones_in_view, spheres_in_cones
from .daylight import LUMINANCE, unit

# Share of a cone's half angle within which its light is even; it fades from there to the edge.
_EVEN_SHARE = 0.6

# A lamp is no point: nearer than this its light grows no more (m).
NEAREST = 0.4

# Distance ahead of a camera at which light matters most (m).
_INTEREST = 1.5

# Of the light of a lamp that is not drawn as one, what a surface of any direction gets, if it
# shines all around; one with a cone gives as much less as its cone is narrower.
_DIFFUSE_SHARE = 0.25


class ChosenLamps(NamedTuple):
    """The lamps of a picture.

    Attributes
    ----------
    numbers
        Of the lamps.
    levels
        At which each burns, 0..1.
    rest
        Light of those that could not be had, spread evenly: red, green, blue.
    """

    numbers: np.ndarray
    levels: np.ndarray
    rest: np.ndarray


class LampRig:
    """All lamps of a scene.

    Parameters
    ----------
    lamps
        In the scene.
    frames
        Names of the scene's frames, in the order of their poses.
    sun
        Light of a lamp of intensity 1 at 1 m.

    Attributes
    ----------
    angles, reaches
        Of the lamps (rad, m), shape (N,).
    lights
        Of the lamps when they burn fully, linear, shape (N, 3).
    levels
        At which they burn, 0 to 1, shape (N,).
    positions, directions
        In the world (m), shape (N, 3).
    axes
        Of their views in the world, by rows: right, down, forward; shape (N, 3, 3).
    """

    def __init__(self, lamps: Sequence[VisualLamp], frames: Sequence[str], sun: float) -> None:
        number = {name: index for index, name in enumerate(frames)}
        self._names = [lamp.name for lamp in lamps]
        self._frames = np.array([number[lamp.frame] for lamp in lamps], dtype=np.intp)
        self._positions = np.array([lamp.position for lamp in lamps]).reshape(-1, 3)
        self._directions = np.array([unit(lamp.direction) for lamp in lamps]).reshape(-1, 3)
        self.reaches = np.array([lamp.reach for lamp in lamps])
        self.angles = np.array([lamp.angle for lamp in lamps])
        # Of all directions, those into which each shines.
        self._solid_shares = 0.5 - 0.5 * np.cos(0.5 * np.minimum(self.angles, 2.0 * math.pi))
        strength = (1.0 + NEAREST**2) * sun
        self.lights = np.array(
            [strength * lamp.intensity * np.square(lamp.color) for lamp in lamps]
        ).reshape(-1, 3)
        self._cones = np.array([_cone(lamp.angle) for lamp in lamps]).reshape(-1, 2)
        self._casting = np.array([lamp.casts_shadow for lamp in lamps], dtype=bool)
        self._axes = np.array([_axes(direction) for direction in self._directions])
        self._axes = self._axes.reshape(-1, 3, 3)
        self.levels = np.ones(len(lamps))
        self.positions = np.zeros((len(lamps), 3))
        self.directions = np.zeros((len(lamps), 3))
        self.axes = np.zeros((len(lamps), 3, 3))

    def __len__(self) -> int:
        return len(self._names)

    def set_levels(self, levels: Mapping[str, float]) -> None:
        """Dim lamps, by their names: 0 is off, 1 full; lamps that are not named burn fully."""
        self.levels = np.array([levels.get(name, 1.0) for name in self._names])

    def place(self, frames_in_world: np.ndarray) -> None:
        """Move all to where their frames are, shape (frames, 4, 4)."""
        poses = frames_in_world[self._frames]
        self.positions = (
            np.einsum("nij,nj->ni", poses[:, :3, :3], self._positions) + poses[:, :3, 3]
        )
        self.axes = np.einsum("nij,nkj->nki", poses[:, :3, :3], self._axes)
        self.directions = self.axes[:, 2]

    def matter_most(self, focus: np.ndarray, most: int) -> np.ndarray:
        """Numbers of the burning lamps whose shadows matter most around a point, shape (3,)."""
        light = self.levels * (self.lights @ LUMINANCE)
        squares = np.square(self.positions - focus).sum(axis=1)
        score = np.where(self._casting & (light > 1e-4), light / (1.0 + squares), 0.0)
        order = np.argsort(-score, kind="stable")[:most]
        return order[score[order] > 0.0]

    def choose(self, clip_from_world: np.ndarray, eye: np.ndarray, most: int) -> ChosenLamps:
        """Choose the lamps that matter most for a picture.

        Parameters
        ----------
        clip_from_world
            Of the view, perspective, shape (4, 4).
        eye
            Position of the camera, shape (3,).
        most
            How many can be had.
        """
        burning = self.levels * self.lights.max(axis=1, initial=0.0) > 1e-4
        if not burning.any():
            return ChosenLamps(np.zeros(0, dtype=np.intp), np.zeros(0), np.zeros(3))
        seen = np.flatnonzero(burning & cones_in_view(clip_from_world, self._lit(slice(None))))
        ahead = eye + _INTEREST * unit(clip_from_world[3, :3])
        squares = np.square(self.positions[seen] - ahead).sum(axis=1)
        arriving = self.lights[seen] * (self.levels[seen] / (1.0 + squares))[:, None]
        score = arriving @ LUMINANCE
        order = np.argsort(-score, kind="stable")
        shares = np.ones(len(seen))
        if len(order) > most:
            # The weakest are faded, so that none springs into the picture when another goes.
            shares = np.clip(4.0 * (1.0 - score[order[most]] / score), 0.0, 1.0)
        chosen = order[:most]
        rest = _DIFFUSE_SHARE * ((1.0 - shares) * self._solid_shares[seen] @ arriving)
        return ChosenLamps(seen[chosen], (self.levels[seen] * shares)[chosen], rest)

    def arriving(self, point: np.ndarray) -> np.ndarray:
        """Light of each lamp that reaches a point if nothing stops it, shape (N, 3)."""
        away = point - self.positions
        squares = np.square(away).sum(axis=1)
        ahead = np.einsum("ni,ni->n", away, self.directions) / np.sqrt(np.maximum(squares, 1e-9))
        shares = np.clip(self._cones[:, 1] + self._cones[:, 0] * ahead, 0.0, 1.0)
        shares *= np.maximum(1.0 - np.square(squares) * self.reaches**-4.0, 0.0)
        weights = self.levels * np.square(shares) / (squares + NEAREST**2)
        light: np.ndarray = self.lights * weights[:, None]
        return light

    def uniforms(self, numbers: np.ndarray, levels: np.ndarray, room: int) -> Dict[str, np.ndarray]:
        """Values for a program with room for so many lamps, by the names of its uniforms."""
        place, aim, light = (np.zeros((room, 4), dtype=np.float32) for _ in range(3))
        used = len(numbers)
        place[:used, :3] = self.positions[numbers]
        place[:used, 3] = self.reaches[numbers] ** -2.0
        # What is left over must not divide by zero.
        place[used:, 3] = 1.0
        aim[:used, :3] = self.directions[numbers]
        aim[:used, 3] = self._cones[numbers, 0]
        light[:used, :3] = self.lights[numbers] * levels[:, None]
        light[:used, 3] = self._cones[numbers, 1]
        return {"lamp_place": place, "lamp_aim": aim, "lamp_light": light}

    def reach(self, numbers: np.ndarray, centers: np.ndarray, radii: np.ndarray) -> np.ndarray:
        """Which of some lamps light which of some spheres, shape (spheres, lamps), bool."""
        return spheres_in_cones(centers, radii, self._lit(numbers))

    def _lit(self, numbers: Union[np.ndarray, slice]) -> Cones:
        """What some lamps light."""
        return Cones(
            self.positions[numbers],
            self.directions[numbers],
            0.5 * np.minimum(self.angles[numbers], 2.0 * math.pi),
            self.reaches[numbers],
        )


def _cone(angle: float) -> Tuple[float, float]:
    """Factor and offset that turn the cosine off a cone's axis into 0 at its edge, 1 inside."""
    if angle >= 2.0 * math.pi - 1e-3:
        return 0.0, 1.0
    edge, even = math.cos(0.5 * angle), math.cos(0.5 * angle * _EVEN_SHARE)
    factor = 1.0 / max(even - edge, 1e-6)
    return factor, -edge * factor


def _axes(direction: np.ndarray) -> np.ndarray:
    """Axes of a view in a direction, by rows: right, down, forward."""
    beside = np.eye(3)[np.abs(direction).argmin()]
    right = unit(np.cross(beside, direction))
    return np.stack([right, np.cross(direction, right), direction])
