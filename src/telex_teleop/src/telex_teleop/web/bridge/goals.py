"""What goals of an action need beside a publisher: a way back for the answers, and an end."""

from __future__ import annotations

import asyncio
import collections
from typing import Any, Deque, Optional

import genpy

from ..workers import in_own_thread
from .publishers import PublisherPool, SharedPublisher
from .ros import Ros
from .stop import cancel_for

MAX_GOALS = 10
"""Goals of an action that are cancelled when their client goes; the newest ones."""

CONNECTION_POLL = 0.02
"""Period (s) at which an action's servers are asked whether they are connected."""

_GOAL, _CANCEL, _CANCEL_TYPE = "/goal", "/cancel", "actionlib_msgs/GoalID"


class Goals:
    """The goals that one client sends to one action.

    Parameters
    ----------
    topic
        Global name of the topic that the goals go to.
    client
        Name of the client, in the ids of goals to which it gave none.
    pool
        Where the publisher of cancellations comes from.
    ros
        Who is connected to the servers, and the present time.
    """

    def __init__(self, topic: str, client: str, pool: PublisherPool, ros: Ros) -> None:
        self._action = topic[: -len(_GOAL)]
        self._client = client
        self._pool = pool
        self._ros = ros
        self._canceller: Optional[SharedPublisher] = None
        self._cancels: Deque[genpy.Message] = collections.deque(maxlen=MAX_GOALS)
        self._count = 0

    @staticmethod
    def go_to(topic: str) -> bool:
        """Tell whether a topic has the name of one that goals go to."""
        return topic.endswith(_GOAL)

    async def open(self) -> None:
        """Get the publisher of cancellations."""
        self._canceller = await self._pool.acquire(
            self._action + _CANCEL, _CANCEL_TYPE, latch=False, queue_size=MAX_GOALS
        )

    async def connect(self, timeout: float) -> bool:
        """Wait until servers and bridge are connected both ways, for `timeout` (s) at most.

        An action says its result once. What a server says before its own connection is made is
        lost, whatever the bridge has subscribed to.
        """
        loop = asyncio.get_running_loop()
        deadline = loop.time() + timeout
        # Who sends a goal has subscribed to its answers just before, or does so just now.
        await self._pool.catch_up()
        while not await in_own_thread(lambda: self._ros.action_connected(self._action)):
            if loop.time() >= deadline:
                return False
            await asyncio.sleep(CONNECTION_POLL)
        return True

    def note(self, goal: Any) -> None:
        """Remember a goal that is sent, and give it an id if it has none."""
        if not goal.goal_id.id:
            self._count += 1
            now = self._ros.now().to_sec()
            goal.goal_id.id = f"bridge client {self._client}, {self._count}, {now:.6f}"
        self._cancels.append(cancel_for(goal))

    def cancel(self) -> None:
        """Cancel the goals that were sent; raises OperationError if that cannot be done."""
        while self._cancels and self._canceller is not None:
            self._canceller.publish(self._cancels.popleft())

    def close(self) -> None:
        """Give the publisher back."""
        if self._canceller is not None:
            self._pool.release(self._action + _CANCEL, latch=False)
            self._canceller = None
