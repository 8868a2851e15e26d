"""A network of its own for a program, with one cable to this machine that can be pulled out."""

from __future__ import annotations

import os
import subprocess
from typing import Tuple


class NetworkNamespace:
    """A network namespace, and a veth pair between it and this one. Only root can have it.

    Use it as a context manager.

    Attributes
    ----------
    address : str
        Of this machine, as seen from there.
    before : tuple
        Words before a command that is to run there.
    """

    def __init__(self) -> None:
        number = os.getpid()
        self._name = f"telex{number}"
        self._near, self._far = f"tlx{number}n", f"tlx{number}f"
        # A net of two addresses out of the range that is kept for measurements of networks.
        high, low = divmod(number % 0x4000 * 4, 256)
        net = f"198.{18 + high // 256}.{high % 256}"
        self.address, self._other = f"{net}.{low + 1}", f"{net}.{low + 2}"
        self.before: Tuple[str, ...] = ("ip", "netns", "exec", self._name)

    @staticmethod
    def available() -> bool:
        """Whether this process may make one."""
        return os.geteuid() == 0

    def __enter__(self) -> NetworkNamespace:
        try:
            _ip("netns", "add", self._name)
            _ip("link", "add", self._near, "type", "veth", "peer", "name", self._far)
            _ip("link", "set", self._far, "netns", self._name)
            _ip("address", "add", f"{self.address}/30", "dev", self._near)
            _ip("link", "set", self._near, "up")
            inside = ("-n", self._name)
            _ip(*inside, "address", "add", f"{self._other}/30", "dev", self._far)
            _ip(*inside, "link", "set", self._far, "up")
            _ip(*inside, "link", "set", "lo", "up")
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *exception: object) -> None:
        """Take it away; the pair of devices goes with it."""
        subprocess.run(["ip", "link", "del", self._near], stderr=subprocess.DEVNULL, check=False)
        subprocess.run(["ip", "netns", "del", self._name], stderr=subprocess.DEVNULL, check=False)

    def cut(self) -> None:
        """Pull the cable out."""
        _ip("link", "set", self._near, "down")

    def mend(self) -> None:
        """Put it in again."""
        _ip("link", "set", self._near, "up")


def _ip(*words: str) -> None:
    subprocess.run(["ip", *words], check=True)
