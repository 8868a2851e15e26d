"""ROS messages to and from what the renderer works with."""

from __future__ import annotations

from typing import List, Tuple

import cv2
import numpy as np
import simplejpeg
from geometry_msgs.msg import Pose
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_msgs.msg import Header
from telex_msgs.msg import SceneDescription, ScenePoses, SceneVisual

from .camera import PinholeCamera
from .scene import Scene, Shape, Vector3, Visual
from .transforms import Quaternion, pose_matrices


def scene_from_message(message: SceneDescription) -> Tuple[Scene, List[str]]:
    """Read a scene.

    Returns
    -------
    tuple of Scene and list of str
        The second says which visuals were left out because they make no sense, and why.

    Raises
    ------
    ValueError
        When not even the frames make sense.
    """
    visuals: List[Visual] = []
    problems: List[str] = []
    for number, visual in enumerate(message.visuals):
        try:
            visuals.append(_visual(visual, message.frames))
        except ValueError as error:
            problems.append(f"visual {number} is left out: {error}")
    return Scene(message.revision, tuple(message.frames), tuple(visuals)), problems


def _visual(message: SceneVisual, frames: List[str]) -> Visual:
    if message.frame >= len(frames):
        raise ValueError(f"frame {message.frame} of a scene with {len(frames)}")
    position, orientation = _pose(message.pose)
    color = message.color
    return Visual(
        frame=frames[message.frame],
        shape=Shape(message.shape),
        size=(message.size.x, message.size.y, message.size.z),
        position=position,
        orientation=orientation,
        color=(color.r, color.g, color.b, color.a),
        mesh=message.mesh,
        texture=message.texture,
        # Left at zero it would say nothing.
        texture_scale=message.texture_scale or 1.0,
    )


def _pose(message: Pose) -> Tuple[Vector3, Quaternion]:
    position, orientation = message.position, message.orientation
    return (
        (position.x, position.y, position.z),
        (orientation.x, orientation.y, orientation.z, orientation.w),
    )


def frames_from_message(message: ScenePoses, count: int) -> np.ndarray:
    """Read the poses of a scene's ``count`` frames in the world, shape (count, 4, 4).

    Raises
    ------
    ValueError
        When a number is not finite, a quaternion is zero, or there are not 7 numbers per frame.
    """
    if len(message.poses) != 7 * count:
        raise ValueError(f"{len(message.poses)} numbers for {count} frames, 7 for each are needed")
    return pose_matrices(np.reshape(message.poses, (-1, 7)))


def camera_info_message(optics: PinholeCamera, header: Header) -> CameraInfo:
    """Describe a camera without distortion."""
    k = optics.intrinsic_matrix()
    return CameraInfo(
        header=header,
        width=optics.width,
        height=optics.height,
        distortion_model="plumb_bob",
        D=[0.0] * 5,
        K=k.reshape(-1).tolist(),
        R=np.eye(3).reshape(-1).tolist(),
        P=np.hstack([k, np.zeros((3, 1))]).reshape(-1).tolist(),
    )


def compressed_image_message(picture: np.ndarray, quality: int, header: Header) -> CompressedImage:
    """Encode an RGBA picture as JPEG of quality 1 to 100."""
    data = simplejpeg.encode_jpeg(
        picture, quality, colorspace="RGBA", colorsubsampling="420", fastdct=True
    )
    return CompressedImage(header=header, format="jpeg", data=data)


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
