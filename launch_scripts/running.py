#!/usr/bin/env python3
"""Names the node that a simulator would push off its ROS master, or whose clock it would share.

Prints nothing, and ends with status 0, where there is none.
"""

from __future__ import annotations

import contextlib
import os
import socket
import sys
from typing import Optional
from urllib.parse import urlsplit

_ANSWERS = 2.0
"""Time (s) in which whatever is there answers."""
_ME = "/run_sh"


def running(master_uri: str, namespace: str) -> Optional[str]:
    """Find a node that answers, and publishes the clock or has the name of one to be started."""
    there = urlsplit(master_uri)
    # Mostly there is no master, and what follows takes longer to import than this.
    socket.create_connection((there.hostname or "", there.port or 11311), _ANSWERS).close()
    from xmlrpc.client import ServerProxy

    from telex_control.ros.start_order import NO_ANSWER

    socket.setdefaulttimeout(_ANSWERS)
    master = ServerProxy(master_uri)
    own = {f"/{namespace.strip('/')}/{name}" for name in ("simulator", "video_server")}
    with contextlib.suppress(*NO_ANSWER):
        publishers = master.getSystemState(_ME)[2][0]
        clocks = {node for topic, nodes in publishers if topic == "/clock" for node in nodes}
        for node in sorted(clocks | own):
            code, _, address = master.lookupNode(_ME, node)
            # A master remembers nodes that were killed.
            with contextlib.suppress(*NO_ANSWER):
                if code == 1 and ServerProxy(address).getPid(_ME)[0] == 1:
                    return node
    return None


def main() -> int:
    """Look at the master of ROS_MASTER_URI, for the namespace that is given."""
    try:
        node = running(os.environ["ROS_MASTER_URI"], sys.argv[1])
    except (OSError, ValueError):
        return 0  # roslaunch says what is wrong with it
    if node is None:
        return 0
    print(node)
    return 1


if __name__ == "__main__":
    sys.exit(main())
