"""Lets no subscriber of rospy miss a publisher.

A subscriber learns of its publishers by the master's answer to its registration, and by the
updates that the master sends. An update may overtake the answer, which is older then. rospy keeps
of what it has not worked off only what has come last: the publisher that the update has named is
never connected to.
"""

from __future__ import annotations

from typing import List

from rospy.impl.registration import RegManager

__all__ = ["miss_no_publisher"]


def miss_no_publisher() -> None:
    """Let subscribers of this process connect to every publisher that the master has named."""
    RegManager.publisher_update = _publisher_update


def _publisher_update(self: RegManager, resolved_name: str, uris: List[str]) -> None:
    """Add publishers to those that a topic is still to be connected to.

    To one that has gone meanwhile there is no connection, which rospy takes for an answer.
    """
    with self.cond:
        waiting = [uri for name, named in self.updates if name == resolved_name for uri in named]
        self.updates = [update for update in self.updates if update[0] != resolved_name]
        self.updates.append((resolved_name, list(dict.fromkeys([*waiting, *uris]))))
        self.cond.notify_all()
