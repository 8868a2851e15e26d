"""Keeps the renderer's scene like the simulator's."""

from __future__ import annotations

from dataclasses import replace
from typing import Dict, Iterable, List, Optional, Sequence

import numpy as np
import rospy
from telex_msgs.msg import SceneDescription, ScenePoses

from .messages import frames_from_message, scene_from_message
from .renderer import Renderer
from .scene import Lamp, Scene

_WARNING_PERIOD = 5.0


class SceneMirror:
    """Loads scenes and moves them; says in the log what is wrong with them.

    Parameters
    ----------
    renderer
        That shows the scene.
    camera_frames
        Names in the scene of the optical frames, e.g. "telex/front_camera_optical_frame"; shadows
        matter around them.
    lamps
        Of the robot, on frames of the scene.
    """

    def __init__(
        self, renderer: Renderer, camera_frames: Iterable[str], lamps: Sequence[Lamp] = ()
    ) -> None:
        self._renderer = renderer
        self._lamps = tuple(lamps)
        self._camera_frames = tuple(camera_frames)
        self._missing: List[str] = []
        self._revision: Optional[int] = None
        self._frame_count = 0
        self._numbers: Dict[str, int] = {}
        self._frames_in_world = np.zeros((0, 4, 4))

    def load(self, message: SceneDescription) -> None:
        """Show another scene from now on."""
        self._revision = None
        try:
            scene, problems = scene_from_message(message)
        except ValueError as error:
            rospy.logerr("scene %d cannot be shown: %s", message.revision, error)
            return
        numbers = {name: number for number, name in enumerate(scene.frames)}
        self._numbers = {name: numbers[name] for name in self._camera_frames if name in numbers}
        self._tell_missing(message.revision, scene)
        lamps = tuple(lamp for lamp in self._lamps if lamp.frame in numbers)
        problems += self._renderer.load_scene(replace(scene, lamps=scene.lamps + lamps))
        self._revision = scene.revision
        self._frame_count = len(scene.frames)
        for problem in problems:
            rospy.logerr("scene %d: %s", scene.revision, problem)
        rospy.loginfo("scene %d: %d visuals are shown", scene.revision, len(scene.visuals))

    def _tell_missing(self, revision: int, scene: Scene) -> None:
        """Say what of the configuration this variant of the robot does not have."""
        wanted = {*self._camera_frames, *(lamp.frame for lamp in self._lamps)}
        missing = sorted(wanted - set(scene.frames))
        if missing and missing != self._missing:
            rospy.loginfo(
                "scene %d: this robot has no %s; what is mounted there stays off",
                revision,
                ", ".join(missing),
            )
        self._missing = missing

    def place(self, message: ScenePoses) -> bool:
        """Move everything to where the poses say.

        Returns
        -------
        bool
            Whether the poses make sense and are those of the scene that is loaded; if not, nothing
            was moved.
        """
        if message.revision != self._revision:
            rospy.logwarn_throttle(
                _WARNING_PERIOD, f"waiting for scene {message.revision}, whose poses are coming"
            )
            return False
        try:
            frames_in_world = frames_from_message(message, self._frame_count)
            self._renderer.place(frames_in_world, self._focus(frames_in_world))
        except ValueError as error:
            rospy.logwarn_throttle(_WARNING_PERIOD, f"poses are left out: {error}")
            return False
        self._frames_in_world = frames_in_world
        return True

    def _focus(self, frames_in_world: np.ndarray) -> np.ndarray:
        """Choose the point around which shadows matter: amid the cameras."""
        cameras = frames_in_world[list(self._numbers.values()), :3, 3]
        return cameras.mean(axis=0) if len(cameras) else np.zeros(3)

    def camera_in_world(self, frame: str) -> Optional[np.ndarray]:
        """Return where a camera was placed, shape (4, 4), or None if the scene has none."""
        number = self._numbers.get(frame)
        return None if number is None else self._frames_in_world[number]
