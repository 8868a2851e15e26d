"""Picture of an exercise: its scene, with the zones and the names that its conditions use."""

from __future__ import annotations

import math
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, Iterator, List, Sequence, Tuple

import cv2
import numpy as np

from telex_control.common.file_catalog import package_path
from telex_control.common.geometry.quaternions import IDENTITY, Pose, compose
from telex_sim.scene.model import Scene, Vector3

from .exercise_file import ExerciseError
from .model import Exercise, Zone
from .seeds import scene_of, scene_text

_FOV = 0.9
_SIDE = np.array([-1.0, -0.8, 0.75])
"""From where it is looked at; of any length."""
_NEAR = 0.05
_MARGIN = 0.08
"""Of the picture, on each side."""
_ROOM = 0.8
"""What the robot takes up around its start (m)."""
_ROUND = 32
_JPEG_QUALITY = 82
_SMALLEST_LETTERS = 0.33
"""In the font's own unit: such that they can be read in a small picture, too."""
_COLORS = (
    (255, 200, 80),
    (120, 255, 120),
    (80, 180, 255),
    (255, 130, 200),
    (230, 240, 90),
    (130, 150, 255),
)
"""Of the zones in turn: blue, green, red."""
_NAME_COLOR = (255, 255, 255)


@dataclass(frozen=True)
class Camera:
    """A pinhole camera.

    Attributes
    ----------
    eye, target : ndarray, shape (3,)
        m.
    fov : float
        Full width of view (rad).
    width, height : int
        Pixels.
    """

    eye: np.ndarray
    target: np.ndarray
    fov: float
    width: int
    height: int

    def in_view(self, points: np.ndarray) -> np.ndarray:
        """Points of the world, shape (N, 3), in the camera: right, down, ahead (m)."""
        ahead = (self.target - self.eye) / np.linalg.norm(self.target - self.eye)
        # As the scene's preview has it: straight down, the picture's top is towards +x.
        up = np.array([1.0, 0.0, 0.0] if abs(ahead[2]) > 0.9999 else [0.0, 0.0, 1.0])
        right = np.cross(ahead, up)
        right /= np.linalg.norm(right)
        axes: np.ndarray = np.stack([right, np.cross(ahead, right), ahead])
        return (np.asarray(points, dtype=float) - self.eye) @ axes.T

    def pixels(self, seen: np.ndarray) -> np.ndarray:
        """Pixels, shape (N, 2), of points in the camera that are before it."""
        focus = 0.5 * self.width / math.tan(0.5 * self.fov)
        middle = np.array([0.5 * self.width, 0.5 * self.height])
        return seen[:, :2] / seen[:, 2:] * focus + middle

    def segment(self, a: Vector3, b: Vector3) -> List[Tuple[int, int]]:
        """Ends in pixels of what is to be seen of a line in the world; none: nothing."""
        seen = self.in_view(np.array([a, b]))
        if seen[:, 2].max() <= _NEAR:
            return []
        low, high = np.argsort(seen[:, 2])
        if seen[low, 2] < _NEAR:
            share = (_NEAR - seen[low, 2]) / (seen[high, 2] - seen[low, 2])
            seen[low] += share * (seen[high] - seen[low])
        ends = self.pixels(seen)
        if np.abs(ends).max() > 1e6:
            return []
        return [(int(round(x)), int(round(y))) for x, y in ends]


def preview_picture(
    exercise: Exercise,
    seed: int,
    size: Tuple[int, int] = (1280, 720),
    top: bool = False,
    quality: str = "still",
) -> np.ndarray:
    """Draw an exercise.

    Parameters
    ----------
    size : tuple of int
        Pixels.
    top : bool
        Look straight down; the picture's top is towards +x.
    quality : str
        As for ``scene preview``.

    Returns
    -------
    ndarray, shape (height, width, 3), uint8
        BGR.

    Raises
    ------
    ExerciseError
        The scene cannot be drawn.
    """
    text = scene_text(exercise, seed)
    scene = scene_of(exercise, text)
    camera = framed(exercise, scene, size, top)
    picture = _photograph(text, exercise, camera, quality)
    annotate(picture, exercise, scene, camera)
    return picture


def draw_preview(exercise: Exercise, seed: int, output: Path, **options: Any) -> None:
    """Draw an exercise into a file; see `preview_picture`.

    Raises
    ------
    ExerciseError
        The scene cannot be drawn, or the picture not be written.
    """
    require_writer(output)
    write_picture(output, preview_picture(exercise, seed, **options))


def require_writer(output: Path) -> None:
    """Raise an `ExerciseError` unless a file of this name can hold a picture."""
    if not cv2.haveImageWriter(str(output)):
        raise ExerciseError(f"{output}: unknown kind of picture; a name ending in .png is usual")


def write_picture(output: Path, picture: np.ndarray) -> None:
    """Write a picture, shape (height, width, 3), BGR.

    Raises
    ------
    ExerciseError
        It cannot be written.
    """
    try:
        written = cv2.imwrite(str(output), picture, (cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY))
    except cv2.error as error:
        raise ExerciseError(f"{output}: {error.err}") from error
    if not written:
        raise ExerciseError(f"{output}: it cannot be written")


def _photograph(text: str, exercise: Exercise, camera: Camera, quality: str) -> np.ndarray:
    """Let the simulator's package draw the scene; shape (height, width, 3), BGR."""
    script = Path(package_path("telex_sim"), "nodes", "scene")
    with tempfile.TemporaryDirectory() as folder:
        path, picture = Path(folder, f"{exercise.name}.yaml"), Path(folder, "scene.png")
        path.write_text(text, encoding="utf-8")
        command = [
            str(script),
            "preview",
            str(path),
            f"--output={picture}",
            f"--size={camera.width}x{camera.height}",
            f"--eye={_triple(camera.eye)}",
            f"--target={_triple(camera.target)}",
            f"--fov={camera.fov}",
            f"--variant={exercise.variant}",
            f"--quality={quality}",
        ]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            reason = done.stderr.strip().replace(f"{path}: ", "").splitlines()
            raise ExerciseError(
                f"{exercise.path}: scene: {reason[-1] if reason else done.returncode}"
            )
        drawn: Any = cv2.imread(str(picture))
    return drawn


def _triple(point: np.ndarray) -> str:
    return ",".join(f"{number:.4f}" for number in point)


def framed(exercise: Exercise, scene: Scene, size: Tuple[int, int], top: bool) -> Camera:
    """Look at all zones, at the objects that conditions name, and at the start."""
    points: List[Vector3] = []
    for start in (scene.start, *scene.robots):
        points += [
            (start.x + dx, start.y + dy, start.ground)
            for dx in (-_ROOM, _ROOM)
            for dy in (-_ROOM, _ROOM)
        ]
        points.append((start.x, start.y, start.ground + _ROOM))
    names = named_objects(exercise)
    for item in scene.objects:
        if item.name in names or not names:
            points.append(item.position)
    for zone in exercise.zones.values():
        for a, b in outline(zone, frame_of(zone, scene)):
            points += [a, b]
    spread = np.array(points, dtype=float)
    low, high = spread.min(axis=0), spread.max(axis=0)
    middle = 0.5 * (low + high)
    away = np.array([0.0, 0.0, 1.0]) if top else _SIDE / np.linalg.norm(_SIDE)
    nearest, farthest = 0.0, 50.0 * (1.0 + float(np.linalg.norm(high - low)))
    for _ in range(40):
        distance = 0.5 * (nearest + farthest)
        camera = Camera(middle + distance * away, middle, _FOV, *size)
        if _shows(camera, spread):
            farthest = distance
        else:
            nearest = distance
    return Camera(middle + farthest * away, middle, _FOV, *size)


def _shows(camera: Camera, points: np.ndarray) -> bool:
    """Whether points are in the picture, with a margin around them."""
    seen = camera.in_view(points)
    if seen[:, 2].min() < 0.5:
        return False
    shares = camera.pixels(seen) / [camera.width, camera.height]
    return bool(((shares > _MARGIN) & (shares < 1.0 - _MARGIN)).all())


def height_of(zone: Zone) -> float:
    """Height at which a zone is drawn (m): of a cylinder without an end, 2 m."""
    return zone.size[2] if zone.size is not None else zone.height or 2.0


def frame_of(zone: Zone, scene: Scene) -> Pose:
    """Pose of the frame that a zone is given in, as the scene begins.

    Raises
    ------
    ExerciseError
        There is no such object.
    """
    if not zone.of:
        return IDENTITY
    for item in scene.objects:
        if item.name == zone.of:
            return item.position, item.orientation
    raise ExerciseError(f"a zone is of '{zone.of}'; the scene has no object of this name")


def outline(zone: Zone, frame: Pose) -> Iterator[Tuple[Vector3, Vector3]]:
    """Yield the lines of a zone (m, in the world)."""
    if zone.size is not None:
        turns = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        ring = [(0.5 * a * zone.size[0], 0.5 * b * zone.size[1]) for a, b in turns]
        posts = ring
    else:
        radius = zone.radius or 0.0
        angles = [2.0 * math.pi * i / _ROUND for i in range(_ROUND)]
        ring = [(radius * math.cos(a), radius * math.sin(a)) for a in angles]
        posts = ring[:: _ROUND // 4]
    cosine, sine, half = math.cos(zone.yaw), math.sin(zone.yaw), 0.5 * height_of(zone)

    def world(x: float, y: float, z: float) -> Vector3:
        place = (
            zone.center[0] + cosine * x - sine * y,
            zone.center[1] + sine * x + cosine * y,
            zone.center[2] + z,
        )
        return compose(frame, (place, IDENTITY[1]))[0]

    for level in (-half, half):
        for (ax, ay), (bx, by) in zip(ring, ring[1:] + ring[:1]):
            yield world(ax, ay, level), world(bx, by, level)
    for x, y in posts:
        yield world(x, y, -half), world(x, y, half)


def named_objects(exercise: Exercise) -> List[str]:
    """Objects that the exercise's conditions name, in their order."""
    found: Dict[str, None] = {}
    for _, condition in exercise.conditions():
        for part in condition.walk():
            for key in ("object", "what"):
                name = getattr(part.of, key, "")
                if name:
                    found[name.partition("/")[0]] = None
    return list(found)


def annotate(picture: np.ndarray, exercise: Exercise, scene: Scene, camera: Camera) -> None:
    """Draw zones and names over a picture, shape (height, width, 3), BGR."""
    taken: List[Tuple[int, int, int, int]] = []
    zones = [
        (name, list(outline(zone, frame_of(zone, scene))), _COLORS[number % len(_COLORS)])
        for number, (name, zone) in enumerate(exercise.zones.items())
    ]
    for _, lines, color in zones:
        for a, b in lines:
            ends = camera.segment(a, b)
            if ends:
                cv2.line(picture, ends[0], ends[1], color, 2, cv2.LINE_AA)
    for name, lines, color in zones:
        points = [point for line in lines for point in line]
        highest = max(points, key=lambda point: point[2])
        middle = tuple(float(x) for x in np.mean(np.array(points), axis=0))
        _label(picture, camera, (middle[0], middle[1], highest[2]), name, color, taken)
    names = named_objects(exercise)
    for item in scene.objects:
        if item.name in names:
            _label(picture, camera, item.position, item.name, _NAME_COLOR, taken)


def _label(
    picture: np.ndarray,
    camera: Camera,
    place: Sequence[float],
    text: str,
    color: Tuple[int, int, int],
    taken: List[Tuple[int, int, int, int]],
) -> None:
    """Write a name at a place of the world, below what is written there already."""
    seen = camera.in_view(np.array([place]))
    if seen[0, 2] <= _NEAR:
        return
    x, y = (int(round(value)) for value in camera.pixels(seen)[0])
    scale = max(_SMALLEST_LETTERS, camera.height / 1200.0)
    font = cv2.FONT_HERSHEY_SIMPLEX
    (width, height), below = cv2.getTextSize(text, font, scale, 1)
    # Below its place, which stays to be seen.
    x, y = x - width // 2, y + 2 * height
    while any(
        x < right and x + width > left and y > high and y - height < low + below
        for left, high, right, low in taken
    ):
        y += height + below
    taken.append((x, y - height, x + width, y))
    cv2.putText(picture, text, (x, y), font, scale, (0, 0, 0), 3, cv2.LINE_AA)
    cv2.putText(picture, text, (x, y), font, scale, color, 1, cv2.LINE_AA)
