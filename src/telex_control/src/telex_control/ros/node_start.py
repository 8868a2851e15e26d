"""Start of the workspace's nodes: as rospy's, but signals always end them.

Nor do web pages reach them.
"""

from __future__ import annotations

import contextlib
import io
import signal
import sys
import threading
import weakref
from types import FrameType
from typing import Any, Iterator, Optional

import rospy
from rospy.core import is_shutdown_requested

from ..common.calm_log import calm_log
from ..common.scheduling import ask_for_short_slices
from .rospy_fixes.coarse_clock import read_clock_seldom
from .rospy_fixes.connecting import miss_nothing
from .rospy_fixes.direct_sending import send_directly
from .rospy_fixes.xmlrpc_guard import guard_xmlrpc

__all__ = ["end_quietly", "init_node", "until_shutdown"]

LONGEST_CALLBACK = 2.0
"""Time (s) that the end of a node waits for a callback of an action server."""


def init_node(
    name: str,
    anonymous: bool = False,
    own_signals: bool = False,
    coarse_clock: bool = False,
    prompt: bool = False,
) -> None:
    """Start a node that SIGINT and SIGTERM shut down, and that refuses requests of web pages.

    rospy shuts down inside the signal handler, which runs in the main thread between any two
    instructions. When that thread is just asking the master (each log line may), it holds the lock
    of that connection, and the handler, which asks too, waits for it without end. So another thread
    shuts down here, and the main thread can let go of its lock.

    Parameters
    ----------
    anonymous : bool
        Whether to make the name unique.
    own_signals : bool
        Whether the program does itself what signals ask for.
    coarse_clock : bool
        Whether sim time may be some hundredths of a second late, which saves processor time.
    prompt : bool
        Whether it hands commands to the robot: where the processor is full, it is then served soon.
    """
    if prompt:
        ask_for_short_slices()
    guard_xmlrpc()
    miss_nothing()
    send_directly()
    if coarse_clock:
        read_clock_seldom()
    if isinstance(sys.stdout, io.TextIOWrapper):
        # rospy flushes nothing: a pipe or a file would get what a node says long after.
        sys.stdout.reconfigure(line_buffering=True)
    rospy.init_node(name, anonymous=anonymous, disable_signals=True)
    calm_log()
    if own_signals:
        return
    signal.signal(signal.SIGTERM, _on_signal)
    signal.signal(signal.SIGINT, _on_signal)


@contextlib.contextmanager
def until_shutdown() -> Iterator[None]:
    """Let a loop end quietly that finds its topics closed because the node is shut down."""
    try:
        yield
    except rospy.ROSException:
        # rospy closes the topics before it says that it is shut down.
        if not (rospy.is_shutdown() or is_shutdown_requested()):
            raise


def end_quietly(server: Any) -> None:
    """Keep the status timer of an action server from publishing while its node shuts down.

    actionlib asks whether the node is shut down, then publishes. rospy closes the topics in
    between, and the timer's thread ends with a traceback.

    Parameters
    ----------
    server : actionlib.ActionServer
        It may be forgotten before the node ends.
    """
    known = weakref.ref(server)

    def silence() -> None:
        server = known()
        if server is not None and server.lock.acquire(timeout=LONGEST_CALLBACK):
            server.started = False
            server.lock.release()

    rospy.on_shutdown(silence)


def _on_signal(number: int, frame: Optional[FrameType]) -> None:
    threading.Thread(
        target=rospy.signal_shutdown, args=(f"signal {number}",), name="shutdown"
    ).start()
