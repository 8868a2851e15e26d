"""Published topics that carry pictures."""

from __future__ import annotations

import dataclasses
from typing import Dict, List, Optional

COMPRESSED_TYPE = "sensor_msgs/CompressedImage"
RAW_TYPE = "sensor_msgs/Image"
_SUFFIX = "/compressed"

Topics = Dict[str, str]
"""Published topics: name and type."""


@dataclasses.dataclass(frozen=True)
class PictureTopic:
    """A ROS topic to subscribe to: its name, and whether its pictures are compressed."""

    name: str
    compressed: bool


def base_topics(topics: Topics) -> List[str]:
    """Return the image topics among published topics ({name: type}), without "/compressed"."""
    names = {name for name, kind in topics.items() if kind == RAW_TYPE}
    for name, kind in topics.items():
        if kind == COMPRESSED_TYPE:
            names.add(name[: -len(_SUFFIX)] if name.endswith(_SUFFIX) else name)
    return sorted(names)


def find_topic(
    name: str, topics: Topics, namespace: str, *, raw: bool = False
) -> Optional[PictureTopic]:
    """Find the topic to subscribe to for a name that a client gave.

    Parameters
    ----------
    name
        With or without the leading slash; without it, it may also be relative to the namespace.
        "/compressed" may stand at its end.
    topics
        Published topics and their types.
    namespace
        The server's own namespace, with slashes around it.
    raw
        Prefer the raw topic.

    Returns
    -------
    topic
        The compressed topic where there is one, else the raw one, or the other way round; None if
        there is neither.
    """
    spellings = [name] if name.startswith("/") else [f"/{name}", f"{namespace}{name}"]
    for spelling in spellings:
        if raw and topics.get(spelling) == RAW_TYPE:
            return PictureTopic(spelling, compressed=False)
        if topics.get(spelling + _SUFFIX) == COMPRESSED_TYPE:
            return PictureTopic(spelling + _SUFFIX, compressed=True)
        if topics.get(spelling) == COMPRESSED_TYPE:
            return PictureTopic(spelling, compressed=True)
        if topics.get(spelling) == RAW_TYPE:
            return PictureTopic(spelling, compressed=False)
    return None


def find_preview(camera: str, topics: Topics, namespace: str) -> Optional[PictureTopic]:
    """Return the topic of a camera's small pictures, if it offers them beside the full ones."""
    return find_topic(f"{namespace}cameras/{camera}/preview", topics, namespace)


def belongs_to(topic: str, camera: str) -> bool:
    """Tell whether a topic is one of a camera of this name, in any namespace."""
    return f"/cameras/{camera}/" in f"{topic}/"


def find_cameras(topics: Topics, namespace: str) -> Dict[str, str]:
    """Return the topic of every camera of the namespace, `cameras/<name>/image_raw`, by name."""
    prefix, suffix = f"{namespace}cameras/", "/image_raw"
    return {
        topic[len(prefix) : -len(suffix)]: topic
        for topic in base_topics(topics)
        if topic.startswith(prefix) and topic.endswith(suffix)
    }
