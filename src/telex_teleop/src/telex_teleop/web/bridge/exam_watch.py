"""Follows the training node's exams, and publishes on `bridge/exam` that the list holds."""

from __future__ import annotations

import asyncio
import contextlib
from typing import Callable, Optional

from std_msgs.msg import String

from ..exam.exam_list import BRIDGE_TOPIC, EQUIPMENT, PARAMETER, TRAINING_TOPIC
from .protocol.compression import TopicMessage
from .protocol.operations import OperationError
from .session import Shared

_PATIENCE = 1.0
"""Time (s) that the list waits to be told what the robot has."""


class ExamWatch:
    """Lets an exam's list begin and end, and remembers it for a successor.

    A bridge that is started again during an exam knows of it before the first client: by its own
    parameter, which outlasts it.

    Parameters
    ----------
    warn
        Called with what an administrator should know.
    """

    def __init__(self, shared: Shared, warn: Callable[[str], None]) -> None:
        self._shared = shared
        self._warn = warn
        self._exam = shared.exam
        self._parameter = shared.ros.resolve(f"~{PARAMETER}")
        self._changed = asyncio.Event()
        self._heard = ""
        self._asking: Optional[asyncio.Future[None]] = None
        self._exam.equip(self._equipment())
        with contextlib.suppress(KeyError):
            self._exam.set(shared.ros.get_param(self._parameter))
        self._review, self._exam.changed = self._exam.changed, self._note

    def _note(self) -> None:
        self._review()
        self._changed.set()

    def _equipment(self) -> object:
        """What the robot has; None where nobody says. Blocks."""
        ros = self._shared.ros
        with contextlib.suppress(KeyError, OSError):
            return ros.get_param(ros.resolve(EQUIPMENT))
        return None

    def deliver(self, message: TopicMessage) -> None:
        """Hear the training node; the list begins once it is known what the robot has."""
        self._heard = message.message.data
        if self._heard:
            self._asking = asyncio.ensure_future(self._begin(self._heard))
        else:
            self._exam.set("")

    async def _begin(self, trial: str) -> None:
        # Whatever the master does meanwhile: what was known before holds else.
        with contextlib.suppress(Exception):
            asked = self._shared.worker.submit(self._equipment)
            self._exam.equip(await asyncio.wait_for(asked, _PATIENCE))
        if self._heard == trial:  # and not ended meanwhile
            self._exam.set(trial)

    async def run(self) -> None:
        """Publish until cancelled."""
        ros, shared = self._shared.ros, self._shared
        publisher = await shared.publishers.acquire(
            ros.resolve(BRIDGE_TOPIC), String._type, latch=True, queue_size=1
        )
        await shared.subscribers.join(ros.resolve(TRAINING_TOPIC), String._type, self)
        while True:
            self._changed.clear()
            trial = self._exam.trial
            await self._remember(trial)
            with contextlib.suppress(OperationError):  # the node is ending
                publisher.publish(String(trial))
            await self._changed.wait()

    async def _remember(self, trial: str) -> None:
        def write() -> None:
            if trial:
                self._shared.ros.set_param(self._parameter, trial)
            else:
                with contextlib.suppress(KeyError):
                    self._shared.ros.delete_param(self._parameter)

        try:
            await self._shared.worker.submit(write)
        except OSError as error:
            self._warn(f"the exam cannot be remembered for a bridge that starts anew: {error}")
