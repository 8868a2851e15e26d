"""Tells which nodes of the robot do not answer: the topic `bridge/missing_nodes`."""

from __future__ import annotations

import asyncio
import contextlib
import time
from typing import List, Optional

import genpy
from telex_msgs.msg import MissingNodes

from ..workers import in_own_thread
from .protocol.operations import OperationError
from .publish.publishers import PublisherPool
from .ros import Ros

PERIOD = 0.5
"""Time (s) between two looks."""

LOOKS_PER_LIST = 4
"""So often the nodes are looked at before the master is asked again which there are: its answer
names every topic and service."""

TOPIC = "bridge/missing_nodes"


class NodeWatch:
    """Looks again and again whether all nodes of the bridge's namespace can be reached.

    One that has ended in order has told the master so and is not missed; one that has crashed is
    still known to it, and does not answer. The list is published when it changes, latched.

    Parameters
    ----------
    ros
        Where to look.
    pool
        Where publishers come from.
    """

    def __init__(self, ros: Ros, pool: PublisherPool) -> None:
        self._ros = ros
        self._pool = pool
        self._topic = ros.resolve(TOPIC)
        self._namespace = self._topic[: -len(TOPIC)]
        self._nodes: List[str] = []
        self._looks = 0

    async def run(self) -> None:
        """Look and publish until cancelled."""
        publisher = await self._pool.acquire(
            self._topic, MissingNodes._type, latch=True, queue_size=1
        )
        told: Optional[List[str]] = None
        while True:
            # Without a master nothing is known of anybody.
            with contextlib.suppress(OSError, OperationError):
                missing = await in_own_thread(self._missing)
                if missing != told:
                    message = MissingNodes(names=missing)
                    message.header.stamp = genpy.Time.from_sec(time.time())
                    publisher.publish(message)
                    told = missing
            await asyncio.sleep(PERIOD)

    def _missing(self) -> List[str]:
        """Return the nodes that do not answer; blocks."""
        if self._looks % LOOKS_PER_LIST == 0:
            self._nodes = [node for node in self._ros.nodes() if node.startswith(self._namespace)]
        self._looks += 1
        return [node for node in self._nodes if not self._ros.node_answers(node)]
