"""One client of the bridge, as the operations that it asks for see it."""

from __future__ import annotations

import asyncio
import json
from typing import Any, Awaitable, Callable, Coroutine, Dict, Set

from ..protocol.operations import Id, Operation
from .access import Access
from .control import Member
from .outbox import Outbox, OutboxFullError

LEVELS = ("none", "error", "warning", "info")
"""Levels of status messages that a client can ask for, rising."""

WARNING_PERIOD = 1.0
"""Shortest time (s) between two equal warnings; commands come up to a hundred times a second."""

MAX_WARNINGS = 100
"""Number of different warnings that are remembered."""


class Client:
    """What one client is and may do, its replies, and its work under way; on the loop's thread.

    Parameters
    ----------
    drop
        Cuts the connection, with the reason.
    """

    def __init__(
        self, member: Member, access: Access, outbox: Outbox, drop: Callable[[str], None]
    ) -> None:
        self.member = member
        self.access = access
        self.level = "error"
        self.send_message = outbox.put_message
        self._outbox = outbox
        self._drop = drop
        self._said: Dict[str, float] = {}
        self._tasks: Set[asyncio.Task[None]] = set()

    def reply(self, reply: Dict[str, Any]) -> None:
        """Send an operation."""
        try:
            self._outbox.put_reply(json.dumps(reply, separators=(",", ":")))
        except OutboxFullError as error:
            self._drop(str(error))

    def report(self, sentence: str, operation_id: Id = None, level: str = "error") -> None:
        """Tell the client what went wrong, if it has asked to hear of what is that grave."""
        if LEVELS.index(level) > LEVELS.index(self.level):
            return
        if level == "warning" and self._said_lately(sentence):
            return
        status: Dict[str, Any] = {"op": "status", "level": level, "msg": sentence}
        if operation_id is not None:
            status["id"] = operation_id
        self.reply(status)

    def _said_lately(self, sentence: str) -> bool:
        now = asyncio.get_running_loop().time()
        if now - self._said.get(sentence, -WARNING_PERIOD) < WARNING_PERIOD:
            return True
        if len(self._said) >= MAX_WARNINGS:
            self._said.clear()
        self._said[sentence] = now
        return False

    def start(self, work: Coroutine[Any, Any, None]) -> asyncio.Task[None]:
        """Run something that ends with the session at the latest."""
        task = asyncio.ensure_future(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return task

    def open(
        self,
        opening: Callable[[], Awaitable[None]],
        operation: Operation,
        forget: Callable[[], Any],
    ) -> asyncio.Task[None]:
        """Open what an operation asks for; if that fails, tell the client and forget it."""

        async def open_or_forget() -> None:
            try:
                await opening()
            except Exception as error:  # whatever ROS raises is an answer to the client
                forget()
                self.report(f"{operation.op}: {error}", operation.id)

        return self.start(open_or_forget())

    def close(self) -> None:
        """End all work under way."""
        for task in tuple(self._tasks):
            task.cancel()
