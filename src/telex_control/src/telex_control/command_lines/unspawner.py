"""Keeps controllers stopped while it runs, and starts them again when it ends."""

from __future__ import annotations

import argparse
import threading
import time
from typing import Callable, Dict, List

import rospy

from ..manager.client import BEST_EFFORT, ControllerManagerClient
from . import program
from .last_calls import call_at_the_end

PERIOD = 3.0
"""Wall time (s) between two checks of what runs: sim time may stand still."""


class Unspawner:
    """Stops controllers whenever they run."""

    def __init__(self, client: ControllerManagerClient, names: List[str]) -> None:
        self._client = client
        self._names = names
        self._stopped: Dict[str, None] = {}
        self._lock = threading.Lock()
        self._ended = False

    def stop_running(self) -> None:
        """Stop those of the controllers that run now."""
        with self._lock:
            if self._ended:
                return
            running = {
                each.name for each in self._client.list_controllers() if each.state == "running"
            }
            to_stop = [name for name in self._names if name in running]
            if to_stop:
                rospy.loginfo("Inhibiting controllers: %s", ", ".join(to_stop))
                self._client.switch([], to_stop, BEST_EFFORT)
                self._stopped.update(dict.fromkeys(to_stop))

    def restart(self) -> None:
        """Start what was stopped."""
        call_at_the_end(self._client.prefix, self._restart)

    def _restart(self, _answered: Callable[[], None]) -> None:
        with self._lock:
            self._ended = True
            if self._stopped:
                self._client.switch(list(self._stopped), [], BEST_EFFORT)


def parse(arguments: List[str]) -> List[str]:
    """Read the command line: the names of controllers."""
    parser = argparse.ArgumentParser(prog="unspawner", description=__doc__)
    parser.add_argument("controllers", nargs="+", metavar="NAME", help="controllers to stop")
    return list(dict.fromkeys(parser.parse_args(arguments).controllers))


def main() -> None:
    """Run until it is shut down."""
    names = parse(program.arguments())

    def work() -> int:
        unspawner = Unspawner(ControllerManagerClient(), names)
        unspawner.stop_running()
        rospy.on_shutdown(unspawner.restart)
        next_look = time.monotonic() + PERIOD
        while not rospy.is_shutdown():
            time.sleep(0.05)
            if time.monotonic() >= next_look:
                next_look += PERIOD
                unspawner.stop_running()
        return 0

    program.run("unspawner", work)
