"""Topics that the bridge itself publishes: `bridge/clients` and `bridge/missing_nodes`."""

from __future__ import annotations

import asyncio
import contextlib
import time
from typing import List, Optional

import genpy
from telex_msgs.msg import BridgeClient, BridgeClients, MissingNodes

from ..workers import in_own_thread
from .clients.control import Control, Member
from .clients.other_robots import OtherRobots
from .protocol.operations import OperationError
from .ros import Ros
from .topics.shared_topics import Publishers, SharedPublisher

CLIENTS_PERIOD = 1.0
"""Time (s) between two lists of clients when nothing changes but the count of dropped commands."""

NODES_PERIOD = 0.5
"""Time (s) between two looks at the nodes."""

LOOKS_PER_LIST = 4
"""So often the nodes are looked at before the master is asked again which there are: its answer
names every topic and service."""

_MISSING_NODES = "bridge/missing_nodes"

_SHARED_NODES = ("simulator", "cameras", "video_server")
"""Nodes beside the simulator that serve all robots."""


class Roster:
    """Publishes `bridge/clients` on every change and once a second, latched."""

    def __init__(self, control: Control, publishers: Publishers, ros: Ros) -> None:
        self._control = control
        self._publishers = publishers
        self._topic = ros.resolve("bridge/clients")
        self._changed = asyncio.Event()
        control.changed = self._changed.set

    async def run(self) -> None:
        """Publish until cancelled."""
        publisher = await self._publishers.acquire(
            self._topic, BridgeClients._type, latch=True, queue_size=1
        )
        while True:
            self._publish(publisher)
            with contextlib.suppress(asyncio.TimeoutError):
                await asyncio.wait_for(self._changed.wait(), CLIENTS_PERIOD)

    def _publish(self, publisher: SharedPublisher) -> None:
        self._changed.clear()
        with contextlib.suppress(OperationError):  # the node is ending
            publisher.publish(self._message())

    def _message(self) -> BridgeClients:
        holder = self._control.holder
        message = BridgeClients(holder="" if holder is None else holder.id)
        message.header.stamp = genpy.Time.from_sec(time.time())
        message.clients = [_entry(member, holder) for member in self._control.members]
        return message


def _entry(member: Member, holder: Optional[Member]) -> BridgeClient:
    holds = member is holder
    return BridgeClient(
        id=member.id,
        name=member.name,
        role="instructor" if member.instructor else "operator" if holds else "watcher",
        address=member.address,
        connected_since=genpy.Time.from_sec(member.connected_since),
        in_control=holds,
        dropped_commands=min(member.dropped, 2**32 - 1),
    )


class NodeWatch:
    """Publishes which of the robot's nodes cannot be reached, and finds other robots.

    A node that has ended in order has told the master so and is not missed; one that has crashed is
    still known to it, and does not answer. The list is published as `bridge/missing_nodes` when it
    changes, latched.

    Parameters
    ----------
    other_robots
        Told of all services, by which it knows the robots that there are.
    simulator
        Namespace in which nodes serve this robot as well; empty: none but its own.
    """

    def __init__(
        self,
        ros: Ros,
        publishers: Publishers,
        other_robots: OtherRobots,
        simulator: str = "",
    ) -> None:
        self._ros = ros
        self._other_robots = other_robots
        self._publishers = publishers
        self._topic = ros.resolve(_MISSING_NODES)
        self._namespace = self._topic[: -len(_MISSING_NODES)]
        names = _SHARED_NODES if simulator else ()
        self._shared = {f"{simulator.rstrip('/')}/{name}" for name in names}
        self._nodes: List[str] = []
        self._services: List[str] = []
        self._looks = 0

    async def run(self) -> None:
        """Look and publish until cancelled."""
        publisher = await self._publishers.acquire(
            self._topic, MissingNodes._type, latch=True, queue_size=1
        )
        told: Optional[List[str]] = None
        while True:
            # Without a master nothing is known of anybody. Whatever else it is, the next look may
            # succeed.
            with contextlib.suppress(Exception):
                missing = await in_own_thread(self._missing)
                self._other_robots.note(self._services)
                if missing != told:
                    message = MissingNodes(names=missing)
                    message.header.stamp = genpy.Time.from_sec(time.time())
                    publisher.publish(message)
                    told = missing
            await asyncio.sleep(NODES_PERIOD)

    def _missing(self) -> List[str]:
        """Return the nodes that do not answer; blocks."""
        if self._looks % LOOKS_PER_LIST == 0:
            self._nodes = [node for node in self._ros.nodes() if self._serves(node)]
            self._services = self._ros.services()
        self._looks += 1
        return [node for node in self._nodes if not self._answers(node)]

    def _serves(self, node: str) -> bool:
        return node.startswith(self._namespace) or node in self._shared

    def _answers(self, node: str) -> bool:
        try:
            return self._ros.node_answers(node)
        except ValueError:  # what is wrong with one node hides no other
            return False
