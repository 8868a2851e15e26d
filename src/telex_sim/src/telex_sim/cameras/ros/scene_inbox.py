"""Hands the newest scene and poses from ROS's threads to the one that renders."""

from __future__ import annotations

import threading
import time
from typing import NamedTuple, Optional

from telex_msgs.msg import SceneDescription, ScenePoses


class Arrival(NamedTuple):
    """Poses that have come.

    Attributes
    ----------
    earlier : ScenePoses, optional
        Those before them, of the same scene.
    time : float
        When they came (monotonic, s).
    """

    poses: ScenePoses
    earlier: Optional[ScenePoses]
    time: float


class SceneInbox:
    """Keeps the newest messages only; what was not collected in time is gone."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._news = False
        self._revision: Optional[int] = None
        self._scene: Optional[SceneDescription] = None
        self._poses: Optional[Arrival] = None

    def put_scene(self, message: SceneDescription) -> None:
        """Store a scene."""
        with self._changed:
            # Poses may overtake the scene that they belong to. When the revision does not rise,
            # however, another simulation has begun and the poses are of the old one.
            if self._revision is not None and message.revision <= self._revision:
                self._poses = None
            self._revision = message.revision
            self._scene = message
            self._notify()

    def put_poses(self, message: ScenePoses) -> None:
        """Store poses."""
        with self._changed:
            last = self._poses.poses if self._poses is not None else None
            earlier = last if last is not None and last.revision == message.revision else None
            self._poses = Arrival(message, earlier, time.monotonic())
            self._notify()

    def drop_poses(self) -> None:
        """Forget the poses: they are no longer being followed."""
        with self._changed:
            self._poses = None

    def wait(self, timeout: float) -> None:
        """Wait until something has come since the last call, at most ``timeout`` (s)."""
        with self._changed:
            self._changed.wait_for(lambda: self._news, timeout)
            self._news = False

    def take_scene(self) -> Optional[SceneDescription]:
        """Return the newest scene, if it has not been taken yet."""
        with self._changed:
            scene, self._scene = self._scene, None
            return scene

    def newest_poses(self) -> Optional[Arrival]:
        """Return the newest poses, however often."""
        with self._changed:
            return self._poses

    def _notify(self) -> None:
        self._news = True
        self._changed.notify()
