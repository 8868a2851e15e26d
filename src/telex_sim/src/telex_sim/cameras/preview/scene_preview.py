"""``rosrun telex_sim scene preview``: a picture of a scene, drawn with care instead of haste."""

from __future__ import annotations

import argparse
import itertools
import logging
import math
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import List, Optional, Sequence, Tuple

import cv2
import numpy as np
from genpy import Time

from telex_control.common.file_catalog import package_path
from telex_control.common.geometry.matrices import rotation_matrix
from telex_control.common.params import ConfigError
from telex_control.urdf.joints import UrdfError

from ...engine.world import WorldError
from ...robot.urdf.visuals import urdf_visuals
from ...ros.scene_messages import SceneMessages
from ...scene.catalog import find_scene
from ...scene.files.scene_file import SceneError
from ...scene.model import WORLD_FRAME, Vector3, Viewpoint
from ...scene.robot_in_scene import place_robot, robot_description
from ...scene.visual_scene import Visual, VisualScene, VisualShape
from ..cameras_config import CameraConfig, shipped_cameras
from ..drawing.gl_context import NoContextError
from ..drawing.light.daylight import Lighting
from ..drawing.meshes.batching import bounding_radius
from ..drawing.quality import STILL, TIERS, Quality
from ..optics.pinhole import PinholeCamera
from ..ros.messages import as_received, frames_from_message, scene_from_message
from .still import Still, looking

# Nothing in a scene is further than this from what is looked at and still casts a shadow (m).
_SHADOW_REACH = 30.0

_LARGEST_SIDE = 4096
_NEAR, _FAR = 0.05, 300.0

# The operator's radio antenna: a mast with a ball (m).
_MAST, _BALL = 0.04, 0.12
_MAST_COLOR, _BALL_COLOR = (0.85, 0.85, 0.85, 1.0), (0.9, 0.1, 0.1, 1.0)

# From where a scene without views is looked at; of any length. Of its distance, against that from
# which all of the scene just fits.
_MARGIN = 1.05
_USUAL_SIDE = (-1.0, -0.8, 0.75)
_USUAL_FOV = 0.9


class PreviewError(RuntimeError):
    """The picture cannot be made; the message says why."""


@dataclass(frozen=True)
class Subject:
    """A scene at rest, ready to be drawn.

    Attributes
    ----------
    name
        Of the scene.
    scene
        What there is to see.
    frames_in_world
        Poses of its frames, shape (frames, 4, 4).
    views
        From where its file wants it to be seen.
    model
        Name of the robot in it.
    further
        Names of those beside it.
    """

    name: str
    scene: VisualScene
    frames_in_world: np.ndarray
    views: Tuple[Viewpoint, ...]
    model: str
    further: Tuple[str, ...] = ()

    def frame(self, name: str) -> Optional[np.ndarray]:
        """Pose of a frame, shape (4, 4), or None if there is none of this name."""
        if name not in self.scene.frames:
            return None
        return self.frames_in_world[self.scene.frames.index(name)]

    def without_robot(self) -> Subject:
        """Leave the robot, and those beside it, out of the picture."""
        models = tuple(f"{model}/" for model in (self.model, *self.further))
        others = tuple(
            visual for visual in self.scene.visuals if not visual.frame.startswith(models)
        )
        return replace(self, scene=replace(self.scene, visuals=others))

    def extent(self) -> Tuple[np.ndarray, float]:
        """Middle and radius of a sphere around `bounds` (m)."""
        low, high = self.bounds()
        return 0.5 * (low + high), 0.5 * float(np.linalg.norm(high - low))

    def bounds(self) -> Tuple[np.ndarray, np.ndarray]:
        """Lowest and highest coordinates of all but planes, or of a place where nothing is (m)."""
        number = {name: index for index, name in enumerate(self.scene.frames)}
        centers, halves = [], []
        for visual in self.scene.visuals:
            if visual.shape is not VisualShape.PLANE:
                pose = self.frames_in_world[number[visual.frame]]
                centers.append((pose @ [*visual.position, 1.0])[:3])
                halves.append(_half_extents(visual, pose[:3, :3]))
        if not centers:
            return np.array([-1.5, -1.0, 0.0]), np.array([1.5, 1.0, 1.0])
        middles, reaches = np.array(centers), np.array(halves)
        low, high = (middles - reaches).min(axis=0), (middles + reaches).max(axis=0)
        low[2] = max(low[2], 0.0)
        return low, high


def _half_extents(visual: Visual, turn: np.ndarray) -> np.ndarray:
    """Half of a visual's extents along the world's axes (m), shape (3,).

    Parameters
    ----------
    turn : ndarray, shape (3, 3)
        Of its frame in the world.
    """
    turn = turn @ rotation_matrix(visual.orientation)
    x, _, z = visual.size
    if visual.shape is VisualShape.BOX:
        return np.abs(turn) @ (0.5 * np.array(visual.size))
    if visual.shape is VisualShape.CYLINDER:
        along = np.abs(turn[:, 2])
        return 0.5 * z * along + x * np.sqrt(np.maximum(1.0 - along**2, 0.0))
    return np.full(3, bounding_radius(visual, _guessed_radius))


def _guessed_radius(visual: Visual) -> float:
    """Take a mesh for one of unit size: those of the library are."""
    return min(float(np.linalg.norm(visual.size)), 1.0)


def settled(
    world: str,
    pose: str = "",
    seconds: float = 1.0,
    variant: str = "standard",
    options: Sequence[str] = (),
) -> Subject:
    """Load a scene with the robot at its start, and let everything come to rest.

    Parameters
    ----------
    world
        Name of the scene, or path of its file.
    pose
        Named pose of the robot; empty for the scene's.
    seconds
        Of sim time that things have to come to rest.
    variant, options
        Of the robot, as for ``rosrun telex_description robot_description``.

    Raises
    ------
    SceneError, ConfigError, WorldError, UrdfError, PreviewError
    """
    path = find_scene(world)
    urdf = robot_description(variant, options)
    simulation = place_robot(path, urdf, pose)
    try:
        for _ in range(round(seconds / simulation.config.timing.step_size)):
            simulation.step()
        model = simulation.config.model
        messages = SceneMessages(model, simulation.body.link_names(), urdf, simulation.scene)
        for robot in simulation.robots[1:]:
            messages.add_robot(robot.model, robot.body.link_names(), urdf_visuals(urdf))
        messages.show(simulation.objects.objects())
        # As the cameras' node gets it, whose pictures this prepares.
        scene, problems = scene_from_message(as_received(messages.description(Time())))
        frames = frames_from_message(
            messages.poses(Time(), simulation.link_poses()), len(scene.frames)
        )
    finally:
        simulation.close()
    if problems:
        raise PreviewError(f"{path}: " + "; ".join(problems))
    if simulation.scene.antenna is not None:
        scene = replace(scene, visuals=(*scene.visuals, *_antenna(simulation.scene.antenna)))
    further = tuple(robot.model for robot in simulation.robots[1:])
    return Subject(path.stem, scene, frames, simulation.scene.views, model, further)


def _antenna(place: Vector3) -> Tuple[Visual, ...]:
    """Show where the operator's antenna is, which no camera of the robot sees."""
    x, y, z = place
    ball = Visual(WORLD_FRAME, VisualShape.SPHERE, (_BALL, 0.0, 0.0), place, color=_BALL_COLOR)
    if z <= _BALL:
        return (ball,)
    size, middle = (_MAST, _MAST, z), (x, y, 0.5 * z)
    return ball, Visual(WORLD_FRAME, VisualShape.BOX, size, middle, color=_MAST_COLOR)


def photograph(
    subject: Subject,
    camera: PinholeCamera,
    optical_in_world: np.ndarray,
    quality: Quality = STILL,
    oversampling: int = 2,
) -> np.ndarray:
    """Take a picture of a scene at rest.

    Parameters
    ----------
    camera, optical_in_world
        As for `Renderer.render`.
    oversampling
        Pixels that are drawn for each of the picture's, along each side.

    Returns
    -------
    numpy.ndarray
        RGB, shape (height, width, 3), uint8.

    Raises
    ------
    NoContextError
        There is no way to render on this machine.
    PreviewError
        A mesh or a texture cannot be loaded.
    """
    focus, radius = subject.extent()
    if radius > _SHADOW_REACH:
        # The sharpest shadows are wanted where the camera looks.
        focus = optical_in_world[:3, 3] + 0.5 * _SHADOW_REACH * optical_in_world[:3, 2]
    focus[2] = _eye_level(subject)
    lighting = Lighting(shadow_radius=min(radius, _SHADOW_REACH))
    fine = replace(camera, width=oversampling * camera.width, height=oversampling * camera.height)
    still = Still(quality, lighting, package_path)
    try:
        problems = still.load(subject.scene)
        if problems:
            raise PreviewError("; ".join(problems))
        picture = still.picture(fine, optical_in_world, subject.frames_in_world, focus)
    finally:
        still.release()
    size = (camera.width, camera.height)
    return cv2.resize(picture, size, interpolation=cv2.INTER_AREA)


def _eye_level(subject: Subject) -> float:
    """Height about which the robot's cameras are (m)."""
    base = subject.frame(f"{subject.model}/base_link")
    return 0.5 + (0.0 if base is None else float(base[2, 3]))


def framed(subject: Subject, fov: float, aspect: float) -> Viewpoint:
    """Look at all of a scene from above one of its corners.

    Parameters
    ----------
    fov
        Full width of view (rad).
    aspect
        Of the picture: width over height.
    """
    low, high = subject.bounds()
    middle = 0.5 * (low + high)
    turn = looking(_USUAL_SIDE, (0.0, 0.0, 0.0))[:3, :3]
    corners = np.array(list(itertools.product(*zip(low - middle, high - middle)))) @ turn
    wide = math.tan(0.5 * fov)
    # How far from the middle the eye must be for each corner to be in the picture.
    needed = np.abs(corners[:, :2]) / (wide, wide / aspect) - corners[:, 2:]
    eye = middle - _MARGIN * float(needed.max()) * turn[:, 2]
    return Viewpoint((eye[0], eye[1], eye[2]), (middle[0], middle[1], middle[2]), fov)


def robot_camera(subject: Subject, name: str) -> Tuple[CameraConfig, np.ndarray]:
    """Find one of the robot's cameras and the pose of its optical frame, shape (4, 4).

    Raises
    ------
    PreviewError
        When there is no such camera, or this variant of the robot lacks it.
    """
    cameras = shipped_cameras().cameras
    if name not in cameras:
        raise PreviewError(f"camera is '{name}'; there are {', '.join(sorted(cameras))}")
    pose = subject.frame(f"{subject.model}/{cameras[name].frame}")
    if pose is None:
        raise PreviewError(f"camera is '{name}'; this robot has no {cameras[name].frame}")
    return cameras[name], pose


def with_lamps(subject: Subject, level: float) -> Subject:
    """Switch the robot's lamps on, 0 to 1."""
    config = replace(shipped_cameras(), model=subject.model)
    lamps = [replace(lamp, intensity=level * lamp.intensity) for lamp in config.scene_lamps()]
    return replace(subject, scene=subject.scene.with_lamps(lamps))


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Run the command; returns the exit status."""
    options = _parser().parse_args(arguments)
    logging.getLogger("rosout").setLevel(logging.WARNING)
    try:
        path = _run(options)
    except (
        SceneError,
        ConfigError,
        WorldError,
        UrdfError,
        NoContextError,
        PreviewError,
    ) as error:
        print(error, file=sys.stderr)
        return 1
    print(path)
    return 0


def _run(options: argparse.Namespace) -> Path:
    output = Path(options.output or f"{find_scene(options.scene).stem}.png")
    if not cv2.haveImageWriter(str(output)):
        raise PreviewError(f"{output}: unknown kind of picture; a name ending in .png is usual")
    subject = settled(options.scene, options.pose, options.settle, options.variant, options.option)
    camera, pose = _camera(subject, options)
    if options.lamps > 0.0:
        subject = with_lamps(subject, options.lamps)
    if options.no_robot:
        subject = subject.without_robot()
    still = options.quality == "still"
    quality = STILL if still else TIERS[options.quality]
    picture = photograph(subject, camera, pose, quality, oversampling=2 if still else 1)
    try:
        written = cv2.imwrite(str(output), picture[..., ::-1])
    except cv2.error as error:
        raise PreviewError(f"{output}: {error.err}") from error
    if not written:
        raise PreviewError(f"{output}: it cannot be written")
    return output


def _camera(subject: Subject, options: argparse.Namespace) -> Tuple[PinholeCamera, np.ndarray]:
    width, height = options.size or (1280, 720)
    if options.camera:
        config, pose = robot_camera(subject, options.camera)
        optics = config.pinhole()
        if options.size:
            optics = replace(optics, width=width, height=height)
        return optics, pose
    if options.eye is not None:
        view = Viewpoint(
            options.eye, options.target or _ahead(options.eye), options.fov or _USUAL_FOV
        )
    elif options.view is not None:
        if not 1 <= options.view <= len(subject.views):
            raise PreviewError(
                f"view is {options.view}; the scene has {len(subject.views)}, counted from 1"
            )
        view = subject.views[options.view - 1]
    elif subject.views:
        view = subject.views[0]
    else:
        view = framed(subject, options.fov or _USUAL_FOV, width / height)
    fov = options.fov or view.fov
    return PinholeCamera(width, height, fov, _NEAR, _FAR), looking(view.eye, view.target)


def _ahead(eye: Tuple[float, float, float]) -> Tuple[float, float, float]:
    """Look from somewhere towards the middle of the scene, or along x from there."""
    return (0.0, 0.0, 0.3) if math.dist(eye, (0.0, 0.0, 0.3)) > 0.1 else (1.0, 0.0, 0.3)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="scene preview",
        description="Draw a picture of a scene, with the robot at its start.",
    )
    parser.add_argument("scene", metavar="FILE", help="file, or name of a scene")
    parser.add_argument("-o", "--output", metavar="PICTURE", help="default: the scene's name.png")
    parser.add_argument("--size", type=_size, metavar="WxH", help="pixels; default 1280x720")
    views = parser.add_argument_group("from where (default: the scene's first view)")
    views.add_argument("--view", type=int, metavar="N", help="one of the scene's views, from 1")
    views.add_argument("--eye", type=_point, metavar="X,Y,Z", help="where the camera is (m)")
    views.add_argument("--target", type=_point, metavar="X,Y,Z", help="what it looks at (m)")
    views.add_argument("--fov", type=_fov, metavar="RAD", help="full width of view")
    views.add_argument("--camera", metavar="NAME", help="one of the robot's cameras instead")
    robot = parser.add_argument_group("the robot")
    robot.add_argument("--no-robot", action="store_true", help="leave it out of the picture")
    robot.add_argument("--pose", default="", metavar="NAME", help="named pose to start in")
    robot.add_argument(
        "--variant", default="standard", metavar="NAME", help="name of a variant, or its file"
    )
    robot.add_argument(
        "--option",
        action="append",
        default=[],
        metavar="KEY:=VALUE",
        help="key of a variant that overrides it, as tool:=probe; may be repeated",
    )
    robot.add_argument(
        "--lamps", type=_share, default=0.0, metavar="LEVEL", help="its lamps, 0 (default) to 1"
    )
    parser.add_argument(
        "--settle", type=_seconds, default=1.0, metavar="S", help="sim time to come to rest (s)"
    )
    parser.add_argument(
        "--quality", choices=("still", *TIERS), default="still", help="default: still"
    )
    return parser


def _size(text: str) -> Tuple[int, int]:
    try:
        width, height = (int(word) for word in text.lower().split("x"))
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}'; WIDTHxHEIGHT is needed") from None
    if not (16 <= width <= _LARGEST_SIDE and 16 <= height <= _LARGEST_SIDE):
        raise argparse.ArgumentTypeError(f"'{text}'; 16 to {_LARGEST_SIDE} pixels are possible")
    return width, height


def _point(text: str) -> Tuple[float, float, float]:
    try:
        x, y, z = _numbers(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}'; X,Y,Z in m is needed") from None
    return x, y, z


def _numbers(text: str) -> List[float]:
    numbers = [float(word) for word in text.split(",")]
    if not all(math.isfinite(number) for number in numbers):
        raise ValueError(text)
    return numbers


def _fov(text: str) -> float:
    return _within(text, 0.05, 2.9)


def _share(text: str) -> float:
    return _within(text, 0.0, 1.0)


def _seconds(text: str) -> float:
    return _within(text, 0.0, 60.0)


def _within(text: str, minimum: float, maximum: float) -> float:
    try:
        (number,) = _numbers(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}'; a number is needed") from None
    if not minimum <= number <= maximum:
        raise argparse.ArgumentTypeError(f"'{text}'; {minimum:g} to {maximum:g} is possible")
    return number
