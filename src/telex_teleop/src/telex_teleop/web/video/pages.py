"""The HTML pages of the video server; everything that comes from outside is escaped here."""

from __future__ import annotations

from html import escape
from typing import Iterable, List, Mapping
from urllib.parse import urlencode

_REASONS = {
    400: "Bad Request",
    401: "Unauthorized",
    403: "Forbidden",
    404: "Not Found",
    413: "Content Too Large",
    500: "Internal Server Error",
    502: "Bad Gateway",
    503: "Service Unavailable",
    504: "Gateway Timeout",
}


def error_page(status: int, sentence: str = "") -> str:
    """Return the page of an HTTP error, with a sentence that says what is wrong."""
    reason = _REASONS[status]
    detail = f"<p>{escape(sentence)}</p>" if sentence else ""
    return (
        f"<html><head><title>{reason}</title></head>"
        f"<body><h1>{status} {reason}</h1>{detail}</body></html>"
    )


def viewer_page(topic: str, query: Mapping[str, str]) -> str:
    """Return the page that shows one stream.

    Parameters
    ----------
    topic
        Name of the topic, for the heading.
    """
    address = escape(f"/stream?{urlencode(query)}")
    name = escape(topic)
    return (
        f'<!doctype html><html><head><meta charset="utf-8"><title>{name}</title></head>'
        f'<body><h1>{name}</h1><img src="{address}" alt="{name}"></body></html>'
    )


def index_page(
    image_topics: Iterable[str], all_topics: Iterable[str], access: Mapping[str, str]
) -> str:
    """Return the list of image topics with links.

    First the topics that share a prefix with a camera_info topic, grouped by that prefix; then
    the others.

    Parameters
    ----------
    image_topics
        Image topics, without "/compressed".
    all_topics
        Every topic that is published.
    access
        Parameters of the client's own query that the links need as well.
    """
    cameras = sorted(t[: -len("camera_info")] for t in all_topics if t.endswith("/camera_info"))
    rest = set(image_topics)
    groups: List[str] = []
    for prefix in cameras:
        own = sorted(topic for topic in rest if topic.startswith(prefix))
        rest.difference_update(own)
        if own:
            items = "".join(_links(topic, topic[len(prefix) :], access) for topic in own)
            groups.append(f"<li>{escape(prefix)}<ul>{items}</ul></li>")
    others = "".join(_links(topic, topic, access) for topic in sorted(rest))
    return (
        '<!doctype html><html><head><meta charset="utf-8"><title>Image topics</title></head>'
        f"<body><h1>Available image topics</h1><ul>{''.join(groups)}</ul>"
        f"<ul>{others}</ul></body></html>"
    )


def _links(topic: str, label: str, access: Mapping[str, str]) -> str:
    address = escape(urlencode({"topic": topic, **access}, safe="/"))
    return (
        f'<li><a href="/stream_viewer?{address}">{escape(label)}</a> '
        f'(<a href="/stream?{address}">stream</a>, '
        f'<a href="/snapshot?{address}">snapshot</a>)</li>'
    )
