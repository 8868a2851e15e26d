"""State that a node leaves to its successor, in case it crashes and is started again."""

from __future__ import annotations

import contextlib
import json
import os
from typing import Any, Dict, Optional

import rospkg
import rospy

_OWNER_ONLY = 0o600


def run_path(node: str, ending: str) -> str:
    """Return the path of a file of a node beside the logs of the present run of the ROS master.

    Parameters
    ----------
    node : str
        Its full name.
    ending : str
        What the name of the file ends with, after a dot.
    """
    name = node.strip("/").replace("/", ".")  # no ROS name has a dot
    run = str(rospy.get_param("/run_id", "run"))
    return os.path.join(rospkg.get_log_dir(), run, f"{name}.{ending}")


class RunMemory:
    """A few values of one node in a small file, as long as one ROS master runs.

    A node that ends in order forgets them: what is recalled was left by one that could not. Only
    the user who runs the node can read the file, as nobody can who reads parameters or topics.
    Without a file, because it cannot be made, read or written, nothing is recalled, and nothing
    else changes.
    """

    def __init__(self, path: str) -> None:
        self.path = path
        self._size = 0
        self._file: Optional[int] = None
        with contextlib.suppress(OSError):
            os.makedirs(os.path.dirname(path), exist_ok=True)
            self._file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, _OWNER_ONLY)
        if self._file is not None and not _is_private(self._file):
            os.close(self._file)
            self._file = None

    @classmethod
    def of_this_node(cls) -> RunMemory:
        """Return the memory of the present node, in the folder of its run's logs."""
        return cls(run_path(rospy.get_name(), "memory.json"))

    def recall(self) -> Dict[str, Any]:
        """Return what was kept last; nothing after an end in order."""
        if self._file is None:
            return {}
        try:
            self._size = os.fstat(self._file).st_size
            values = json.loads(os.pread(self._file, self._size, 0) or b"{}")
        except ValueError:  # it crashed while it wrote
            return {}
        except OSError as error:
            self._give_up(error)
            return {}
        return values if isinstance(values, dict) else {}

    def keep(self, **values: Any) -> None:
        """Keep these values instead of those before; costs some microseconds."""
        if self._file is None:
            return
        # One write over what was there, padded to its length: a crash leaves the one or the other.
        text = json.dumps(values).encode()
        self._size = max(self._size, len(text))
        try:
            os.pwrite(self._file, text.ljust(self._size), 0)
        except OSError as error:
            self._give_up(error)

    def forget(self) -> None:
        """Leave nothing to a successor."""
        if self._file is None:
            return
        file, self._file = self._file, None
        with contextlib.suppress(OSError):
            os.close(file)
        with contextlib.suppress(OSError):
            os.remove(self.path)

    def _give_up(self, error: OSError) -> None:
        """Go on without the file: what it has may be old, or half written."""
        rospy.logwarn(
            "%s cannot be used: %s; after a crash of this node nothing is recalled",
            self.path,
            error.strerror,
        )
        self.forget()


def _is_private(file: int) -> bool:
    """Whether nobody else has made the file, or can read it."""
    status = os.fstat(file)
    return status.st_uid == os.geteuid() and status.st_mode & 0o077 == 0
