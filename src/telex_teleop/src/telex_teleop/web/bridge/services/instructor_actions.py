"""The topic `bridge/actions`: what instructors have done to the scene, and who it was."""

from __future__ import annotations

import contextlib
import json
from typing import Any, Dict, Optional

from telex_msgs.msg import InstructorAction

from ..clients.control import Member
from ..protocol.operations import OperationError
from ..ros import Ros
from ..topics.shared_topics import Publishers, SharedPublisher

_TOLD = tuple(f"/sim/{name}" for name in ("spawn", "move", "delete", "set_light"))
"""Ends of the names of services that arrange the scene. Of what else an instructor may do, the
recording hears from whoever does it."""
_LONGEST = 300
"""Characters of a text in the request that are told."""


class InstructorActions:
    """Publishes what has been done, for the recording of a trial; on the loop's thread."""

    def __init__(self, ros: Ros, publishers: Publishers) -> None:
        self._ros = ros
        self._publishers = publishers
        self._topic = ros.resolve("bridge/actions")
        self._publisher: Optional[SharedPublisher] = None

    async def run(self) -> None:
        """Open the topic: who has only just subscribed may miss nothing."""
        self._publisher = await self._publishers.acquire(
            self._topic, InstructorAction._type, latch=False, queue_size=100
        )

    def note(self, member: Member, service: str, fields: Dict[str, Any], answer: Any) -> None:
        """Tell of a call that was answered, if it has arranged the scene.

        Parameters
        ----------
        service
            Global name.
        fields, answer
            Of request and response, as JSON has them.
        """
        ends = [end for end in _TOLD if service.endswith(end)]
        refused = isinstance(answer, dict) and answer.get("success") is False
        if not (member.instructor and ends and self._publisher) or refused:
            return
        told = {
            key: value[:_LONGEST] if isinstance(value, str) else value
            for key, value in fields.items()
        }
        message = InstructorAction(
            by=member.name or f"client {member.id}",
            service=ends[0][1:],
            request=json.dumps(told, sort_keys=True),
        )
        message.header.stamp = self._ros.now()
        with contextlib.suppress(OperationError):  # the node is ending
            self._publisher.publish(message)
