"""Bodies that a gripper holds, from its contacts."""

from __future__ import annotations

from typing import Dict, List, Sequence, Set, Tuple

import pybullet

from telex_control.common.geometry.vectors import dot

from ..engine.world import Body, Vector


def grasped_bodies(body: Body, fingers: Sequence[Sequence[int]]) -> Set[int]:
    """Find the bodies on which fingers press from opposite sides.

    The sides tell a grasp from finger tips that rest on a table.

    Parameters
    ----------
    fingers : sequence of sequence of int
        The links of each finger.

    Returns
    -------
    set of int
        PyBullet's numbers.
    """
    pressed: Dict[int, List[Tuple[int, Vector]]] = {}
    grasped: Set[int] = set()
    for number, finger in enumerate(fingers):
        for link in finger:
            for uid, normal in _pressed(body, link):
                others = pressed.setdefault(uid, [])
                if any(each != number and dot(side, normal) < 0.0 for each, side in others):
                    grasped.add(uid)
                others.append((number, normal))
    return grasped


def _pressed(body: Body, link: int) -> List[Tuple[int, Vector]]:
    """Other bodies that a link presses on, and the direction from each towards the link."""
    found: List[Tuple[int, Vector]] = []
    for contact in (
        pybullet.getContactPoints(bodyA=body.uid, linkIndexA=link, physicsClientId=body.client)
        or ()
    ):
        first, second, normal, force = contact[1], contact[2], contact[7], contact[9]
        if force <= 0.0 or first == second:
            continue
        if first == body.uid:
            found.append((second, normal))
        else:
            found.append((first, (-normal[0], -normal[1], -normal[2])))
    return found
