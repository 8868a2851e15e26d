"""Contacts of the robot with itself: which pairs of its links cannot touch.

PyBullet leaves out a link and its parent by itself. Other pairs are left out by name, each with
its reason, so that nobody disables one to hide a fault of the model.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Collection, Tuple

import pybullet

from telex_control.common.params import ConfigError, require, require_choice, require_text

from ..engine.world import Body

REASONS = ("adjacent", "by_design", "never")


@dataclass(frozen=True)
class DisabledPair:
    """Two links between which contacts are not computed.

    Attributes
    ----------
    reason : str
        ``adjacent``: housings of neighbours overlap at their joint. ``by_design``: one part runs
        inside or on the other. ``never``: the joints cannot bring them together.
    explanation : str
        Why it is so, for the reader.
    """

    links: Tuple[str, str]
    reason: str
    explanation: str

    def __post_init__(self) -> None:
        require(self.links[0] != self.links[1], f"links are '{self.links[0]}' twice")
        require_choice(self, "reason", REASONS)
        require_text(self, "explanation")


@dataclass(frozen=True)
class SelfCollisionConfig:
    """The disabled pairs of a robot and its variants.

    Attributes
    ----------
    enabled : bool
        Whether the robot's links can touch each other at all.
    optional_links : tuple of str
        Links that a variant of the robot may lack. Any other name that is not there is a mistake.
    """

    enabled: bool = True
    optional_links: Tuple[str, ...] = ()
    disabled_pairs: Tuple[DisabledPair, ...] = ()

    def __post_init__(self) -> None:
        seen = set()
        for index, pair in enumerate(self.disabled_pairs):
            key = frozenset(pair.links)
            require(
                key not in seen,
                f"disabled_pairs[{index}]: {' and '.join(pair.links)} are named twice",
            )
            seen.add(key)

    def check_links(self, links: Collection[str]) -> None:
        """Refuse pairs of links that are not there.

        Parameters
        ----------
        links : collection of str
            All links of the robot.

        Raises
        ------
        ConfigError
        """
        for index, pair in enumerate(self.disabled_pairs):
            for link in pair.links:
                if link not in links and link not in self.optional_links:
                    raise ConfigError(
                        f"self_collision/disabled_pairs[{index}]: the robot has no link '{link}'; "
                        "a link that only some variants have belongs into "
                        "self_collision/optional_links"
                    )


def disable_pairs(body: Body, config: SelfCollisionConfig) -> None:
    """Switch off the contacts between the disabled pairs of a robot that was just loaded."""
    for pair in config.disabled_pairs:
        if all(link in body.links for link in pair.links):
            first, second = (body.links[link] for link in pair.links)
            pybullet.setCollisionFilterPair(
                body.uid, body.uid, first, second, 0, physicsClientId=body.client
            )
