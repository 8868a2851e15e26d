"""Goals of actions: whose they are, the way back for their answers, and their end."""

from __future__ import annotations

import asyncio
from typing import Any, Dict, Optional

import genpy
from actionlib_msgs.msg import GoalID

from ...workers import in_own_thread
from ..protocol.compression import TopicMessage
from ..protocol.operations import OperationError
from ..ros import Ros
from .shared_topics import Publishers, SharedPublisher, SharedSubscriber, Subscribers

MAX_GOALS = 100
"""Goals that a client may have at an action without their results; all are cancelled when it goes.
"""

MAX_ID = 1000
"""Characters in the id of a goal, which is kept until the result has come."""

CONNECTION_POLL = 0.02
"""Period (s) at which an action's servers are asked whether they are connected."""

_GOAL, _RESULT, _CANCEL = "/goal", "/result", "/cancel"


class AllGoals:
    """The goals of all clients that are under way, and whose they are; on the loop's thread.

    Parameters
    ----------
    publishers
        Where publishers of cancellations come from.
    ros
        Who is connected to an action's servers, and the present time.
    """

    def __init__(self, publishers: Publishers, subscribers: Subscribers, ros: Ros) -> None:
        self.publishers = publishers
        self.subscribers = subscribers
        self.ros = ros
        self._clients: Dict[str, Dict[str, str]] = {}  # by action and id

    def enter(self, action: str, goal_id: str, client: str) -> None:
        """Note a goal; raises OperationError if it has the id of another client's."""
        if self._clients.setdefault(action, {}).setdefault(goal_id, client) != client:
            raise OperationError("another client's goal has this id; goals need ids of their own")

    def strike(self, action: str, goal_id: str) -> None:
        """Forget a goal."""
        goals = self._clients[action]
        del goals[goal_id]
        if not goals:
            del self._clients[action]

    def check_cancel(self, topic: str, message: genpy.Message, client: str) -> None:
        """Raise OperationError if a message would cancel the goal of another client."""
        if not (isinstance(message, GoalID) and topic.endswith(_CANCEL)):
            return
        goals = self._clients.get(topic[: -len(_CANCEL)], {})
        if goals.get(message.id, client) != client:
            raise OperationError("this goal is another client's, who alone may cancel it")
        # As actionlib has it: without an id all goals, with a time all that are older.
        if (message.stamp or not message.id) and set(goals.values()) - {client}:
            raise OperationError(
                "this would cancel goals of other clients as well; name one by its id, without a "
                "stamp"
            )


class ClientGoals:
    """The goals that one client sends to one action, until their results come.

    Parameters
    ----------
    topic
        Global name of the topic that the goals go to.
    type_name
        Their type.
    client
        Name of the client, in the ids of goals to which it gave none.
    """

    def __init__(self, topic: str, type_name: str, client: str, all_goals: AllGoals) -> None:
        self._action = topic[: -len(_GOAL)]
        self._result_type = type_name[: -len("Goal")] + "Result"
        self._client = client
        self._all = all_goals
        self._canceller: Optional[SharedPublisher] = None
        self._results: Optional[SharedSubscriber] = None
        self._ids: Dict[str, None] = {}  # as they were sent
        self._count = 0

    @staticmethod
    def go_to(topic: str) -> bool:
        """Tell whether a topic has the name of one that goals go to."""
        return topic.endswith(_GOAL)

    async def open(self) -> None:
        """Get the publisher of cancellations, and begin to hear results."""
        self._canceller = await self._all.publishers.acquire(
            self._action + _CANCEL, GoalID._type, latch=False, queue_size=MAX_GOALS
        )
        self._results = await self._all.subscribers.join(
            self._action + _RESULT, self._result_type, self
        )

    def deliver(self, message: TopicMessage) -> None:
        """Forget a goal that has ended."""
        self._forget(message.message.status.goal_id.id)

    def _forget(self, goal_id: str) -> None:
        if goal_id in self._ids:
            del self._ids[goal_id]
            self._all.strike(self._action, goal_id)

    async def connect(self, timeout: float) -> bool:
        """Wait until servers and bridge are connected both ways, for `timeout` (s) at most.

        An action says its result once. What a server says before its own connection is made is
        lost, whatever the bridge has subscribed to.
        """
        loop = asyncio.get_running_loop()
        deadline = loop.time() + timeout
        # Who sends a goal has subscribed to its answers just before, or does so just now.
        await self._all.publishers.catch_up()
        while not await in_own_thread(lambda: self._all.ros.action_connected(self._action)):
            if loop.time() >= deadline:
                return False
            await asyncio.sleep(CONNECTION_POLL)
        return True

    def note(self, goal: Any) -> None:
        """Remember a goal that is sent, and give it an id if it has none.

        Raises
        ------
        OperationError
            Too many are under way, or its id is too long, or that of another client's goal.
        """
        if not goal.goal_id.id:
            self._count += 1
            now = self._all.ros.now().to_sec()
            goal.goal_id.id = f"bridge client {self._client}, {self._count}, {now:.6f}"
        length = len(goal.goal_id.id)
        if length > MAX_ID:
            raise OperationError(f"the goal's id has {length} characters; at most {MAX_ID} fit")
        if len(self._ids) >= MAX_GOALS and goal.goal_id.id not in self._ids:
            raise OperationError(
                f"the results of {MAX_GOALS} goals of this client have not come, which is as many "
                "as may be under way; cancel some, or connect anew"
            )
        self._all.enter(self._action, goal.goal_id.id, self._client)
        self._ids[goal.goal_id.id] = None

    def cancel(self) -> None:
        """Cancel the goals that have not ended; raises OperationError if that cannot be done."""
        goals = tuple(self._ids)
        for goal_id in goals:
            self._forget(goal_id)
        if self._canceller is not None:
            for goal_id in goals:
                self._canceller.publish(GoalID(id=goal_id))

    def close(self) -> None:
        """Give back what was opened."""
        if self._canceller is not None:
            self._all.publishers.release(self._action + _CANCEL, latch=False)
            self._canceller = None
        if self._results is not None:
            self._all.subscribers.leave(self._action + _RESULT, self._results, self)
            self._results = None
