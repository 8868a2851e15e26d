"""The cameras that are published, with a number for each that never changes."""

from __future__ import annotations

import dataclasses
from typing import Container, Dict, List, Optional, Tuple

from .topics import PictureTopic, Topics, find_cameras, find_preview, find_topic

MAX_CAMERAS = 256
"""Cameras that the one byte of a picture's header can tell apart."""


@dataclasses.dataclass(frozen=True)
class Camera:
    """A camera.

    Attributes
    ----------
    index
        Its number.
    name, topic
        Its name and its base topic.
    source
        The topic to subscribe to.
    preview
        The topic of its small pictures, if it offers them.
    """

    index: int
    name: str
    topic: str
    source: PictureTopic
    preview: Optional[PictureTopic] = None


class CameraList:
    """All cameras of a namespace that have been published since the server started.

    One that is gone keeps its place: it may come back, and clients know it by its index.

    Parameters
    ----------
    namespace
        With slashes around it.
    hidden
        Names of cameras that are left out.
    """

    def __init__(self, namespace: str, hidden: Container[str] = ()) -> None:
        self._namespace = namespace
        self._hidden = hidden
        self._cameras: Dict[str, Camera] = {}

    def update(self, topics: Topics) -> bool:
        """Take over what is published now; tell whether anything has changed."""
        before = dict(self._cameras)
        for name, topic in find_cameras(topics, self._namespace).items():
            if name in self._hidden:
                continue
            source = find_topic(topic, topics, self._namespace)
            preview = find_preview(name, topics, self._namespace)
            known = self._cameras.get(name)
            index = known.index if known is not None else len(self._cameras)
            if source is not None and index < MAX_CAMERAS:
                self._cameras[name] = Camera(index, name, topic, source, preview)
        return self._cameras != before

    def find(self, name: str) -> Optional[Camera]:
        """Return a camera by its name."""
        return self._cameras.get(name)

    @property
    def names(self) -> Tuple[str, ...]:
        """Names of all cameras, by index."""
        return tuple(self._cameras)

    def described(self) -> List[Dict[str, str]]:
        """Return name and topic of every camera, by index, as clients are told."""
        return [{"name": each.name, "topic": each.topic} for each in self._cameras.values()]
