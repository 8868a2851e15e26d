#!/usr/bin/env python3
"""Names the node that a simulator would push off its ROS master, or whose clock it would share.

Prints nothing, and ends with status 0, where there is none.
"""

from __future__ import annotations

import contextlib
import os
import socket
import sys
from typing import Iterator
from urllib.parse import urlsplit

_ANSWERS = 2.0
"""Time (s) in which whatever is there answers."""
_ME = "/run_sh"


def others(master_uri: str, namespace: str) -> Iterator[str]:
    """Names of nodes that run, publish the clock or are called as those that would be started."""
    there = urlsplit(master_uri)
    # Mostly there is no master, and what follows takes longer to import than this.
    socket.create_connection((there.hostname or "", there.port or 11311), _ANSWERS).close()
    from xmlrpc.client import Error, ServerProxy

    socket.setdefaulttimeout(_ANSWERS)
    master = ServerProxy(master_uri)
    with contextlib.suppress(Error):
        publishers = master.getSystemState(_ME)[2][0]
        clocks = {node for topic, nodes in publishers if topic == "/clock" for node in nodes}
        own = {f"/{namespace.strip('/')}/{name}" for name in ("simulator", "video_server")}
        for node in sorted(clocks | own):
            code, _, address = master.lookupNode(_ME, node)
            # A master remembers nodes that were killed.
            with contextlib.suppress(OSError, Error):
                if code == 1 and ServerProxy(address).getPid(_ME)[0] == 1:
                    yield node


def main() -> int:
    """Look at the master of ROS_MASTER_URI, for the namespace that is given."""
    try:
        for node in others(os.environ["ROS_MASTER_URI"], sys.argv[1]):
            print(node)
            return 1
    except (OSError, ValueError):
        return 0  # roslaunch says what is wrong with it
    return 0


if __name__ == "__main__":
    sys.exit(main())
