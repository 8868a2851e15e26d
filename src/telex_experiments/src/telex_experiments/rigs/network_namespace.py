"""A network of its own for a program, with one cable to this machine: to be pulled out, or long.

Over a long cable, packets pass between two TUN devices through a process that keeps each for the
delay; kernels that can delay by themselves (netem) are not everywhere. ``python -m`` this module is
that process.
"""

from __future__ import annotations

import fcntl
import os
import select
import struct
import subprocess
import sys
import time
from collections import deque
from typing import Deque, List, Optional, Sequence, Tuple

_TUNSETIFF = 0x400454CA
_IFF_TUN, _IFF_NO_PI = 0x0001, 0x1000
_LARGEST = 65536
"""Bytes of a packet."""
_FOLDER = "/run/netns"


class NoNamespaceError(RuntimeError):
    """No network can be made by this process on this machine; the message says why."""


class NetworkNamespace:
    """A network namespace, and a pair of devices between it and this one. Only root can have it.

    Parameters
    ----------
    delay : float
        Of what passes the cable, each way (s).

    Use it as a context manager; entering it may raise a `NoNamespaceError`.

    Attributes
    ----------
    address, other : str
        Of this machine, as seen from there, and the other way round.
    before : tuple of str
        Words before a command that is to run there.
    """

    def __init__(self, delay: float = 0.0) -> None:
        number = os.getpid()
        self._delay = delay
        self._relay: Optional[subprocess.Popen] = None
        self._was_mounted = True
        self._name = f"telex{number}"
        self._near, self._far = f"tlx{number}n", f"tlx{number}f"
        # A net of two addresses out of the range that is kept for measurements of networks.
        high, low = divmod(number % 0x4000 * 4, 256)
        net = f"198.{18 + high // 256}.{high % 256}"
        self.address, self.other = f"{net}.{low + 1}", f"{net}.{low + 2}"
        # Not by "ip netns exec" or "ip -n": these mount, which a changed root does not allow.
        self.before: Tuple[str, ...] = ("nsenter", f"--net={_FOLDER}/{self._name}")

    @staticmethod
    def available() -> bool:
        """Whether this process may make one."""
        return os.geteuid() == 0

    def __enter__(self) -> NetworkNamespace:
        self._was_mounted = _is_mounted()
        try:
            _ip("netns", "add", self._name)
            if self._delay:
                self._lay_long_cable()
            else:
                _ip("link", "add", self._near, "type", "veth", "peer", "name", self._far)
                _ip("link", "set", self._far, "netns", self._name)
            _ip("address", "add", f"{self.address}/30", "dev", self._near)
            _ip("link", "set", self._near, "up")
            inside = self.before
            _ip("address", "add", f"{self.other}/30", "dev", self._far, before=inside)
            _ip("link", "set", self._far, "up", before=inside)
            _ip("link", "set", "lo", "up", before=inside)
        except (OSError, subprocess.CalledProcessError) as error:
            self.__exit__()
            raise NoNamespaceError(f"no network of its own: {error}") from error
        except BaseException:
            self.__exit__()
            raise
        return self

    def _lay_long_cable(self) -> None:
        devices: List[int] = []
        try:
            devices += [_tun(self._near), _tun(self._far)]
            _ip("link", "set", self._far, "netns", self._name)
            words = [sys.executable, "-m", __name__, *map(str, devices), str(self._delay)]
            self._relay = subprocess.Popen(words, pass_fds=devices, start_new_session=True)
        finally:
            for device in devices:
                os.close(device)

    def __exit__(self, *exception: object) -> None:
        """Take it away; the pair of devices goes with it."""
        if self._relay is not None:
            self._relay.terminate()
            self._relay.wait()
        for words in (("link", "del", self._near), ("netns", "del", self._name)):
            subprocess.run(["ip", *words], stderr=subprocess.DEVNULL, check=False)
        if not self._was_mounted:
            # Fails, as it shall, while there are other networks.
            subprocess.run(["umount", _FOLDER], stderr=subprocess.DEVNULL, check=False)

    def cut(self) -> None:
        """Pull the cable out."""
        _ip("link", "set", self._near, "down")

    def mend(self) -> None:
        """Put it in again."""
        _ip("link", "set", self._near, "up")


def _is_mounted() -> bool:
    """Whether the folder of networks is mounted on itself, as ip does for the first one."""
    with open("/proc/self/mounts", encoding="utf-8") as mounts:
        return any(line.split()[1] == _FOLDER for line in mounts)


def _tun(name: str) -> int:
    device = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
    try:
        request = struct.pack("16sH", name.encode(), _IFF_TUN | _IFF_NO_PI)
        fcntl.ioctl(device, _TUNSETIFF, request)
    except OSError:
        os.close(device)
        raise
    return device


def _ip(*words: str, before: Sequence[str] = ()) -> None:
    subprocess.run([*before, "ip", *words], check=True)


def relay(devices: Sequence[int], delay: float) -> None:
    """Carry packets between two devices for ever, each after the delay (s)."""
    waiting: Deque[Tuple[float, int, bytes]] = deque()
    other = dict(zip(devices, reversed(devices)))
    while True:
        rest = max(0.0, waiting[0][0] - time.monotonic()) if waiting else None
        for device in select.select(devices, [], [], rest)[0]:
            packet = os.read(device, _LARGEST)
            waiting.append((time.monotonic() + delay, other[device], packet))
        now = time.monotonic()
        while waiting and waiting[0][0] <= now:
            _, device, packet = waiting.popleft()
            try:
                os.write(device, packet)
            except OSError:  # its queue is full, or it is down: networks lose packets
                continue


if __name__ == "__main__":
    relay([int(sys.argv[1]), int(sys.argv[2])], float(sys.argv[3]))
