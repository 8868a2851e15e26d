"""Poses of objects in the world, as the simulator tells them to renderers."""

from __future__ import annotations

import threading
from typing import Dict, Optional

import numpy as np
from telex_msgs.msg import SceneDescription, ScenePoses

from telex_control.kinematics import make_pose
from telex_control.ros.node_handle import NodeHandle


class ObjectPoses:
    """Poses of the links of all objects, by ``sim/scene`` and ``sim/poses``."""

    def __init__(self, node: NodeHandle) -> None:
        self._lock = threading.Lock()
        self._frames: Dict[int, Dict[str, int]] = {}
        self._poses: ScenePoses = ScenePoses()
        node.subscribe("sim/scene", SceneDescription, self._on_scene)
        node.subscribe("sim/poses", ScenePoses, self._on_poses)

    def _on_scene(self, message: SceneDescription) -> None:
        with self._lock:
            places = {frame: index for index, frame in enumerate(message.frames)}
            self._frames = {message.revision: places}

    def _on_poses(self, message: ScenePoses) -> None:
        with self._lock:
            self._poses = message

    @property
    def known(self) -> bool:
        """Whether poses have come that the scene explains."""
        with self._lock:
            return self._poses.revision in self._frames and bool(self._poses.poses)

    def find(self, name: str) -> Optional[np.ndarray]:
        """Return a pose in the world, 4x4; None where it is not known.

        Parameters
        ----------
        name : str
            Of an object, whose first link that can move is meant, or of a link: "object/link".
        """
        with self._lock:
            places = self._frames.get(self._poses.revision, {})
            for frame, index in places.items():
                if name in (frame, frame.split("/")[0]):
                    numbers = self._poses.poses[7 * index : 7 * index + 7]
                    return make_pose(numbers[:3], numbers[3:])
        return None
