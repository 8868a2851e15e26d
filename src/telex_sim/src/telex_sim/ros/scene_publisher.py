"""Tells what there is to see, in a thread of its own.

A scene of a thousand objects takes tens of milliseconds to be put into a message, for which the
loop does not wait.
"""

from __future__ import annotations

import threading
from typing import Callable

import rospy
from telex_msgs.msg import SceneDescription


class ScenePublisher:
    """Publishes the present description on ``sim/scene``, latched, whenever it is told to.

    Parameters
    ----------
    describe : callable
        Makes the message; it is called in the publisher's thread.
    """

    def __init__(self, describe: Callable[[], SceneDescription]) -> None:
        self._describe = describe
        self._publisher = rospy.Publisher("sim/scene", SceneDescription, queue_size=1, latch=True)
        self._wanted = threading.Event()
        self._ended = False
        threading.Thread(target=self._run, name="scene_publisher", daemon=True).start()

    def publish_soon(self) -> None:
        """Publish what is there by then."""
        self._wanted.set()

    def close(self) -> None:
        """Publish no more."""
        self._ended = True
        self._wanted.set()

    def _run(self) -> None:
        while True:
            self._wanted.wait()
            self._wanted.clear()
            if self._ended:
                return
            try:
                self._publisher.publish(self._describe())
            except Exception as error:  # whatever it is, what comes next is told
                if rospy.is_shutdown():
                    return
                rospy.logerr("sim/scene cannot be told: %s: %s", type(error).__name__, error)
