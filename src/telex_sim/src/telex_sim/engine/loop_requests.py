"""Work that other threads ask of the loop's, which alone may touch the simulation."""

from __future__ import annotations

import queue
import threading
import time
from typing import Callable, Iterator, Optional

import rospy

from .world import WorldError

Action = Callable[[], Optional[Iterator[None]]]
"""What is asked for; one that returns an iterator is carried on with between further steps."""


REST = 2.0
"""How much longer than a part took the next one waits: the loop steps meanwhile, and catches up."""


class _Request:
    def __init__(self, action: Action) -> None:
        self.action = action
        self.rest: Optional[Iterator[None]] = None
        self.done = threading.Event()
        self.error: Optional[Exception] = None


class LoopRequests:
    """A queue: ROS callbacks put actions into it, the loop carries them out between two steps.

    Parameters
    ----------
    clock : callable
        Wall time (s) that never goes back.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._rests_until = clock()
        self._queue: queue.Queue[_Request] = queue.Queue()
        self._present: Optional[_Request] = None

    def carry_out(self, action: Action) -> None:
        """Have the loop's thread carry out `action`, and wait for it.

        Raises
        ------
        rospy.ServiceException
            The action failed, or the node shuts down.
        """
        request = _Request(action)
        self._queue.put(request)
        while not request.done.wait(0.1):
            if rospy.is_shutdown():
                raise rospy.ServiceException("the simulator shuts down")
        if request.error is not None:
            raise rospy.ServiceException(str(request.error))

    def serve(self) -> None:
        """Carry out, in the present thread, all that has been asked for, in that order.

        Of what comes in parts, one is carried out, unless the loop is still to make up for the one
        before (`REST`), and what was asked for later waits.
        """
        while self._present is not None or not self._queue.empty():
            if self._present is None:
                self._present = self._queue.get_nowait()
            elif self._clock() < self._rests_until:
                return
            began = self._clock()
            if not self._ended(self._present):
                now = self._clock()
                self._rests_until = now + REST * (now - began)
                return
            self._present.done.set()
            self._present = None

    @staticmethod
    def _ended(request: _Request) -> bool:
        """Carry on with a request; returns whether nothing of it is left."""
        try:
            if request.rest is None:
                request.rest = request.action()
            if request.rest is None:
                return True
            next(request.rest)
            return False
        except StopIteration:
            return True
        except WorldError as error:
            request.error = error
            rospy.logerr("%s", error)
        except Exception as error:  # whatever it is, the simulation goes on
            request.error = error
            rospy.logerr("a request failed: %s: %s", type(error).__name__, error)
        return True
