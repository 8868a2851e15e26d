"""The contacts under load of a body with others, as that body has them."""

from __future__ import annotations

from typing import Dict, Iterator, NamedTuple, Optional, Tuple

import pybullet

from .world import Body, Vector


class Contact(NamedTuple):
    """One point in which a body touches another.

    Attributes
    ----------
    link : int
        The body's (PyBullet's number).
    other : tuple of 2 ints
        The other body and its link (PyBullet's numbers).
    point : Vector
        On the body, in the world (m).
    normal : Vector
        In the world; towards the body.
    force : float
        Along `normal` (N); above 0.
    friction : Vector
        On the body, in the world (N).
    """

    link: int
    other: Tuple[int, int]
    point: Vector
    normal: Vector
    force: float
    friction: Vector


def contacts(body: Body, link: Optional[int] = None) -> Iterator[Contact]:
    """Contacts of the last step, without those of the body with itself.

    All frictions with one other body may have the wrong sign, alike: PyBullet turns the normal of a
    contact that is asked for by its second body, and forgets to turn the friction.

    Parameters
    ----------
    link : int, optional
        This one's only (PyBullet's number).
    """
    filters = {"bodyA": body.uid}
    if link is not None:
        filters["linkIndexA"] = link
    return _read(body, filters)


def directed_contacts(body: Body, link: Optional[int] = None) -> Iterator[Contact]:
    """The same with all frictions as they act, for more time: it looks at the whole world's."""
    return _read(body, {}, link)


def _read(body: Body, filters: Dict[str, int], only: Optional[int] = None) -> Iterator[Contact]:
    uid = body.uid
    for contact in pybullet.getContactPoints(**filters, physicsClientId=body.client) or ():
        _, first, second, first_link, second_link = contact[:5]
        if contact[9] <= 0.0 or first == second or uid not in (first, second):
            continue
        is_first = first == uid
        if only is not None and only != (first_link if is_first else second_link):
            continue
        on_first, on_second, normal, _, force, one, along, other, across = contact[5:14]
        friction = (
            one * along[0] + other * across[0],
            one * along[1] + other * across[1],
            one * along[2] + other * across[2],
        )
        if is_first:
            yield Contact(first_link, (second, second_link), on_first, normal, force, friction)
        else:
            place = second_link, (first, first_link), on_second
            yield Contact(*place, _opposite(normal), force, _opposite(friction))


def _opposite(vector: Vector) -> Vector:
    x, y, z = vector
    return -x, -y, -z
