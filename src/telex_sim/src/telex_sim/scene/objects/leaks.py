"""Leaks among the objects of a scene."""

from __future__ import annotations

from typing import List, Sequence, Tuple

import numpy as np

from telex_control.common.geometry.quaternions import UPRIGHT, compose, rotate

from ...gas.plume import shares
from ..model import Leak
from .bodies import SceneBodies


class SceneGas:
    """The gas of a scene's leaks, which moves with them.

    It is of the objects that there are when it is made, as `SceneField` is.
    """

    def __init__(self, objects: SceneBodies) -> None:
        self._objects = objects
        self._leaks: List[Tuple[str, str, Leak]] = [
            (item.name, link.name, link.leak)
            for item in objects.objects()
            for link in item.model.links
            if link.leak is not None
        ]

    @property
    def empty(self) -> bool:
        """Whether there is no leak."""
        return not self._leaks

    def share(self, point: Sequence[float]) -> float:
        """Share of volume of gas at a point of the world (m), with all where it is."""
        poses = [self._objects.link_pose(item, link) for item, link, _ in self._leaks]
        leaks = [leak for _, _, leak in self._leaks]
        places = [compose(pose, (leak.position, UPRIGHT))[0] for pose, leak in zip(poses, leaks)]
        drifts = [rotate(pose[1], leak.drift) for pose, leak in zip(poses, leaks)]
        flows = np.array([leak.flow for leak in leaks])
        found = shares(np.array(point) - np.array(places), flows, np.array(drifts))
        return min(float(found.sum()), 1.0)
