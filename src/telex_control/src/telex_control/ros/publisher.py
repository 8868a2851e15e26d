"""`Publisher` on rospy, made for a control loop.

``rospy.Publisher.publish`` takes locks, serializes, and hands the interpreter over to rospy's
threads: 0.05 ms of CPU time for each message and listener, and longer by the wall. Twenty
controllers that publish in the same cycle would hold it up, so that a thread of its own does it
for the whole process; the loop only leaves the message in a queue.
"""

from __future__ import annotations

import logging
import queue
import threading
from collections import deque
from typing import Any, Deque, Optional

import rospy

from .node_handle import Publisher

_log = logging.getLogger("rosout")


class RosPublisher(Publisher):
    """A rospy publisher that never holds its caller up; to be closed with its node handle.

    A message belongs to the publisher once it is published: it is serialized later.

    Parameters
    ----------
    topic : str
        Full name.
    queue_size : int
        So many messages wait at most; then the oldest is dropped.
    """

    def __init__(self, topic: str, kind: Any, queue_size: int) -> None:
        self._publisher = rospy.Publisher(topic, kind, queue_size=queue_size, tcp_nodelay=True)
        self._messages: Deque[Any] = deque(maxlen=queue_size)
        self._is_queued = False
        self._complained = False

    def publish(self, message: Any) -> None:
        """Leave `message` to the sending thread."""
        self._messages.append(message)
        if not self._is_queued:
            self._is_queued = True
            _sender.send_of(self)

    def send(self) -> None:
        """Send what waits. In the sending thread."""
        # First, so that a message that comes meanwhile is either sent below or queued anew.
        self._is_queued = False
        while self._messages:
            message = self._messages.popleft()
            try:
                self._publisher.publish(message)
            except Exception as error:  # of a message that a user's controller filled wrongly
                self._drop(error)

    def _drop(self, error: Exception) -> None:
        closed = isinstance(error, rospy.ROSException)
        if closed and not isinstance(error, rospy.ROSSerializationException):
            # The publisher was closed by an unload or a shutdown between two cycles.
            if not rospy.is_shutdown():
                _log.debug("a message on the closed topic %s was dropped", self._publisher.name)
        elif not self._complained:
            self._complained = True
            _log.error("topic %s: a message is dropped: %r", self._publisher.name, error)

    def has_subscribers(self) -> bool:
        """Whether anybody listens."""
        return self._publisher.get_num_connections() > 0

    def close(self) -> None:
        """Take the topic back."""
        self._publisher.unregister()


class _Sender:
    """The thread that sends for all publishers of the process, in the order of their messages."""

    def __init__(self) -> None:
        self._queue: queue.SimpleQueue[RosPublisher] = queue.SimpleQueue()
        self._start = threading.Lock()
        self._thread: Optional[threading.Thread] = None

    def send_of(self, publisher: RosPublisher) -> None:
        """Have the messages of `publisher` sent soon."""
        self._queue.put(publisher)
        if self._thread is None:
            with self._start:
                if self._thread is None:
                    self._thread = threading.Thread(target=self._run, name="sender", daemon=True)
                    self._thread.start()

    def _run(self) -> None:
        while True:
            self._queue.get().send()


_sender = _Sender()
