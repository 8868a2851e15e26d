"""ROS messages to and from what the renderer works with."""

from __future__ import annotations

import io
import sys
from typing import Callable, Iterator, List, Optional, Sequence, Tuple, TypeVar

import cv2
import numpy as np
import simplejpeg
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_msgs.msg import ColorRGBA, Header
from telex_msgs.msg import SceneDescription, SceneLamp, ScenePoses, SceneVisual

from telex_control.common.geometry.matrices import pose_matrices
from telex_control.ros.pose_messages import pose_in, vector_in

from ...scene.visual_scene import Daylight, Rgb, Visual, VisualLamp, VisualScene, VisualShape
from ..optics.lens import LensCamera

# As compressed_image_transport writes it: what the picture is, and how it is encoded.
_JPEG_FORMAT = "rgb8; jpeg compressed bgr8"

# Between poses further apart than this nobody knows how things have moved (s); and how many times
# the move between two poses may be continued.
_LONGEST_MOVE = 0.2
_MOST_MOVES = 4.0

Message = TypeVar("Message")
Thing = TypeVar("Thing")


def as_received(message: SceneDescription) -> SceneDescription:
    """Return a scene as those get it who subscribe to it: some numbers in single precision.

    Content that is kept, and compiled shaders, are found again for equal numbers only.
    """
    buffer = io.BytesIO()
    message.serialize(buffer)
    return SceneDescription().deserialize(buffer.getvalue())


def scene_from_message(message: SceneDescription) -> Tuple[VisualScene, List[str]]:
    """Read a scene.

    Returns
    -------
    tuple of Scene and list of str
        The second says what was left out because it makes no sense, and why.

    Raises
    ------
    ValueError
        When not even the frames make sense.
    """
    problems: List[str] = []
    scene = VisualScene(
        message.revision,
        tuple(message.frames),
        tuple(_readable("visual", message.visuals, _visual, message.frames, problems)),
        tuple(_readable("lamp", message.lamps, _lamp, message.frames, problems)),
        _daylight(message, problems),
    )
    return scene, problems


def _readable(
    kind: str,
    messages: Sequence[Message],
    read: Callable[[Message, List[str]], Thing],
    frames: List[str],
    problems: List[str],
) -> Iterator[Thing]:
    """Read what makes sense, and note what does not."""
    for number, message in enumerate(messages):
        try:
            yield read(message, frames)
        except ValueError as error:
            problems.append(f"{kind} {number} is left out: {error}")


def _frame(number: int, frames: List[str]) -> str:
    if number >= len(frames):
        raise ValueError(f"frame {number} of a scene with {len(frames)}")
    return frames[number]


def _visual(message: SceneVisual, frames: List[str]) -> Visual:
    position, orientation = pose_in(message.pose)
    color = message.color
    return Visual(
        frame=_frame(message.frame, frames),
        shape=VisualShape(message.shape),
        size=vector_in(message.size),
        position=position,
        orientation=orientation,
        color=(color.r, color.g, color.b, color.a),
        mesh=message.mesh,
        texture=message.texture,
        texture_scale=message.texture_scale,
        glow=message.glow,
        drive=_frame(message.drive, frames) if message.drive else "",
        mesh_materials=message.mesh_materials,
    )


def _lamp(message: SceneLamp, frames: List[str]) -> VisualLamp:
    return VisualLamp(
        frame=_frame(message.frame, frames),
        position=vector_in(message.position),
        direction=vector_in(message.direction),
        angle=message.angle,
        intensity=message.intensity,
        reach=message.reach,
        color=_rgb(message.color),
    )


def _daylight(message: SceneDescription, problems: List[str]) -> Daylight:
    try:
        return Daylight(
            to_sun=vector_in(message.to_sun),
            sun=_rgb(message.sun),
            ambient=message.ambient,
            visibility=message.visibility,
            fog=_rgb(message.fog),
        )
    except ValueError as error:
        problems.append(f"{error}; it is shown by day")
        return Daylight()


def _rgb(message: ColorRGBA) -> Rgb:
    return message.r, message.g, message.b


def frames_from_message(
    message: ScenePoses, count: int, earlier: Optional[ScenePoses] = None, back: float = 0.0
) -> np.ndarray:
    """Read the poses of a scene's ``count`` frames in the world, shape (count, 4, 4).

    Parameters
    ----------
    message, count
        What to read, and of how many frames.
    earlier, back
        Poses before those of ``message``, and the time before it (s) for which to find poses: all
        move evenly.

    Raises
    ------
    ValueError
        When a number is not finite, a quaternion is zero, or there are not 7 numbers per frame.
    """
    if len(message.poses) != 7 * count:
        raise ValueError(f"{len(message.poses)} numbers for {count} frames, 7 for each are needed")
    poses = np.reshape(message.poses, (-1, 7))
    if back > 0.0 and earlier is not None and len(earlier.poses) == len(message.poses):
        passed = (message.header.stamp - earlier.header.stamp).to_sec()
        if 0.0 < passed < _LONGEST_MOVE:
            before = np.reshape(earlier.poses, (-1, 7)).copy()
            # q and -q are the same orientation; of both, the one near the later one.
            opposite = np.einsum("ij,ij->i", before[:, 3:], poses[:, 3:]) < 0.0
            before[opposite, 3:] *= -1.0
            poses = poses + min(back / passed, _MOST_MOVES) * (before - poses)
    return pose_matrices(poses)


def shadow_focus(frames_in_world: np.ndarray, cameras: Sequence[int]) -> np.ndarray:
    """Choose the point around which shadows matter: amid the frames of these numbers."""
    places = frames_in_world[list(cameras), :3, 3]
    return places.mean(axis=0) if len(places) else np.zeros(3)


def camera_info_message(camera: LensCamera, header: Header) -> CameraInfo:
    """Describe a camera. A rectified picture (R, P) has the focal length and the middle of K."""
    k = camera.intrinsic_matrix()
    return CameraInfo(
        header=header,
        width=camera.width,
        height=camera.height,
        distortion_model="plumb_bob",
        D=list(camera.distortion),
        K=k.reshape(-1).tolist(),
        R=np.eye(3).reshape(-1).tolist(),
        P=np.hstack([k, np.zeros((3, 1))]).reshape(-1).tolist(),
    )


def compressed_image_message(picture: np.ndarray, quality: int, header: Header) -> CompressedImage:
    """Encode an RGBA picture as JPEG of quality 1 to 100."""
    data = simplejpeg.encode_jpeg(
        picture, quality, colorspace="RGBA", colorsubsampling="420", fastdct=True
    )
    return CompressedImage(header=header, format=_JPEG_FORMAT, data=data)


def image_message(picture: np.ndarray, header: Header) -> Image:
    """Convert an RGBA picture to rgb8."""
    height, width = picture.shape[:2]
    return Image(
        header=header,
        height=height,
        width=width,
        encoding="rgb8",
        is_bigendian=0,
        step=3 * width,
        data=cv2.cvtColor(picture, cv2.COLOR_RGBA2RGB).tobytes(),
    )


def depth_message(depth: np.ndarray, header: Header) -> Image:
    """Convert depths along z (m, inf for none), float32, to 32FC1, as REP 118 has them."""
    height, width = depth.shape
    return Image(
        header=header,
        height=height,
        width=width,
        encoding="32FC1",
        is_bigendian=int(sys.byteorder == "big"),
        step=4 * width,
        data=np.ascontiguousarray(depth, dtype=np.float32).tobytes(),
    )
