"""Tells ROS who is connected to the bridge and who holds control: the topic `bridge/clients`."""

from __future__ import annotations

import asyncio
import contextlib
import time
from typing import Optional

import genpy
from telex_msgs.msg import BridgeClient, BridgeClients

from ..protocol.operations import OperationError
from ..publish.publishers import PublisherPool, SharedPublisher
from .clients import Control, Member

PERIOD = 1.0
"""Time (s) between two messages when nothing changes but the count of dropped commands."""


class Roster:
    """Publishes the list of clients on every change and once a second, latched.

    Parameters
    ----------
    control
        Who is there.
    pool
        Where publishers come from.
    topic
        Global name of the topic.
    """

    def __init__(self, control: Control, pool: PublisherPool, topic: str) -> None:
        self._control = control
        self._pool = pool
        self._topic = topic
        self._changed = asyncio.Event()
        control.changed = self._changed.set

    async def run(self) -> None:
        """Publish until cancelled."""
        publisher = await self._pool.acquire(
            self._topic, BridgeClients._type, latch=True, queue_size=1
        )
        while True:
            self._publish(publisher)
            with contextlib.suppress(asyncio.TimeoutError):
                await asyncio.wait_for(self._changed.wait(), PERIOD)

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
