"""Work that other threads ask of the loop's, which alone may touch the simulation."""

from __future__ import annotations

import queue
import threading
from typing import Callable, Optional

import rospy

from .world import WorldError


class _Request:
    def __init__(self, action: Callable[[], None]) -> None:
        self.action = action
        self.done = threading.Event()
        self.error: Optional[Exception] = None


class LoopRequests:
    """A queue: ROS callbacks put actions into it, the loop carries them out between two steps."""

    def __init__(self) -> None:
        self._queue: queue.Queue[_Request] = queue.Queue()

    def carry_out(self, action: Callable[[], None]) -> None:
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
        """Carry out, in the present thread, all that has been asked for."""
        while not self._queue.empty():
            request = self._queue.get_nowait()
            try:
                request.action()
            except WorldError as error:
                request.error = error
                rospy.logerr("%s", error)
            except Exception as error:  # whatever it is, the simulation goes on
                request.error = error
                rospy.logerr("a request failed: %s: %s", type(error).__name__, error)
            finally:
                request.done.set()
