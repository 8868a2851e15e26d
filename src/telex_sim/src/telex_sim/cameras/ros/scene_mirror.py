"""Keeps the renderer's scene like the simulator's."""

from __future__ import annotations

from typing import TYPE_CHECKING, Dict, Iterable, List, Optional, Sequence

import numpy as np
import rospy
from telex_msgs.msg import SceneDescription, ScenePoses

from ...scene.visual_scene import VisualLamp, VisualScene
from ..drawing.stillness import is_still
from .messages import frames_from_message, scene_from_message, shadow_focus

if TYPE_CHECKING:
    from ..drawing.renderer import Renderer

_WARNING_PERIOD = 5.0


class SceneMirror:
    """Loads scenes and moves them; says in the log what is wrong with them.

    Parameters
    ----------
    camera_frames
        Names in the scene of the optical frames, e.g. "telex/front_camera_optical_frame"; shadows
        matter around them.
    lamps
        Of the robot, on frames of the scene.
    followed
        Names of further frames that `frame_in_world` shall know.
    """

    def __init__(
        self,
        renderer: Renderer,
        camera_frames: Iterable[str],
        lamps: Sequence[VisualLamp] = (),
        followed: Iterable[str] = (),
    ) -> None:
        self._renderer = renderer
        self._lamps = tuple(lamps)
        self._camera_frames = tuple(camera_frames)
        self._followed = tuple(followed)
        self._message: Optional[SceneDescription] = None
        self._missing: List[str] = []
        self._revision: Optional[int] = None
        self._frame_count = 0
        self._numbers: Dict[str, int] = {}
        self._others: Dict[str, int] = {}
        self._frames_in_world = np.zeros((0, 4, 4))
        self._poses = np.zeros(0)

    def load(self, message: SceneDescription) -> None:
        """Show another scene from now on."""
        self._message = message
        self._revision = None
        try:
            scene, problems = scene_from_message(message)
        except ValueError as error:
            rospy.logerr("scene %d cannot be shown: %s", message.revision, error)
            return
        numbers = {name: number for number, name in enumerate(scene.frames)}
        self._numbers = {name: numbers[name] for name in self._camera_frames if name in numbers}
        self._others = {name: numbers[name] for name in self._followed if name in numbers}
        self._tell_missing(message.revision, scene)
        problems += self._renderer.load_scene(scene.with_lamps(self._lamps))
        self._revision = scene.revision
        self._frame_count = len(scene.frames)
        for problem in problems:
            rospy.logerr("scene %d: %s", scene.revision, problem)
        rospy.loginfo("scene %d: %d visuals are shown", scene.revision, len(scene.visuals))

    def change_renderer(self, renderer: Renderer) -> None:
        """Show the scene with another renderer from now on; poses must be placed anew."""
        self._renderer = renderer
        if self._message is not None:
            self.load(self._message)

    def _tell_missing(self, revision: int, scene: VisualScene) -> None:
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

    def place(
        self,
        message: ScenePoses,
        earlier: Optional[ScenePoses] = None,
        back: float = 0.0,
        recast: bool = True,
    ) -> bool:
        """Move everything to where the poses say.

        Parameters
        ----------
        message
            The poses.
        recast
            Whether shadows move as well.
        earlier, back
            As for `frames_from_message`, to see things where they were a moment (s) before.

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
            frames_in_world = frames_from_message(message, self._frame_count, earlier, back)
            focus = shadow_focus(frames_in_world, tuple(self._numbers.values()))
            self._renderer.place(frames_in_world, focus, recast)
        except ValueError as error:
            rospy.logwarn_throttle(_WARNING_PERIOD, f"poses are left out: {error}")
            return False
        self._frames_in_world = frames_in_world
        self._poses = np.asarray(message.poses)
        return True

    def moves(self, message: ScenePoses) -> bool:
        """Whether anybody could see that these poses differ from those that were placed last."""
        return message.revision == self._revision and not is_still(
            np.asarray(message.poses), self._poses
        )

    def has(self, frame: str) -> bool:
        """Whether the scene has a camera, or what else is to be known, of this name."""
        return frame in self._numbers or frame in self._others

    def frame_in_world(self, frame: str) -> np.ndarray:
        """Return where a camera, or what else is to be known, was placed, shape (4, 4).

        Raises
        ------
        KeyError
            The scene does not have it.
        """
        numbers = self._numbers if frame in self._numbers else self._others
        return self._frames_in_world[numbers[frame]]
