"""A whole station of one's own with its training, and a page of a class that looks at it."""

from __future__ import annotations

import contextlib
import json
import subprocess
import sys
import tempfile
import threading
import time
import urllib.request
from typing import Any, Dict, Iterator, List, Optional, Sequence

import rosgraph

from telex_control.common.child_processes import DIES_WITH_US
from telex_experiments.classroom.class_server import ClassServer
from telex_experiments.rigs.bringup import STATION
from telex_experiments.rigs.private_simulator import PrivateSimulator, cpu_seconds
from telex_experiments.rigs.report import PATIENCE
from telex_experiments.workspace import ROOT

ASKED = ("video_server", "training", "master")
"""Processes of a station that the page of a class has work for; where nobody watches, its cameras
as well."""
CAMERAS = "cameras"
_PERIOD = 1.0
_WATCHERS = ROOT / "src/telex_experiments/src/telex_experiments/console/watchers.py"


class LiveStation:
    """Runs ``telex_training station.launch`` on a master of its own; a context manager.

    Attributes
    ----------
    url, bridge : str
        Of its video server and its bridge.
    """

    def __init__(self) -> None:
        self._stack = contextlib.ExitStack()
        self._pids: Dict[str, int] = {}
        self.url = self.bridge = ""

    def __enter__(self) -> LiveStation:
        try:
            self._start()
        except BaseException:
            self._stack.close()
            raise
        return self

    def __exit__(self, *exception: object) -> None:
        self._stack.close()

    def _start(self) -> None:
        recordings = self._stack.enter_context(tempfile.TemporaryDirectory(prefix="telex-trials-"))
        station = self._stack.enter_context(
            PrivateSimulator(
                *(f"recordings:={recordings}", "exercise:=slalom", "operator:=ann"), launch=STATION
            )
        )
        station.wait_for_master()
        self.url = station.wait_for_param("/telex/video_server/url")
        self.bridge = station.wait_for_param("/telex/rosbridge/url")
        station.wait_for_param("/telex/video_server/mounts/training")
        master = rosgraph.Master("/live_station", master_uri=station.master_uri)
        self._pids = {**station.processes(), "master": int(master.getPid())}

    def used(self, names: Sequence[str]) -> float:
        """CPU time (s) of some of its processes, see `ASKED` and `CAMERAS`."""
        return sum(cpu_seconds(self._pids[name]) for name in names)

    @contextlib.contextmanager
    def watched(self) -> Iterator[None]:
        """Have somebody watch it as the console does, for a while."""
        command = [*DIES_WITH_US, sys.executable, str(_WATCHERS), self.bridge]
        with subprocess.Popen(
            [*command, f"{self.url.replace('http', 'ws', 1)}/video", "1"],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
        ) as watcher:
            try:
                yield
                if watcher.poll() is not None:
                    raise RuntimeError("who was to watch the station has ended")
            finally:
                watcher.terminate()


class Looking:
    """A page of a class, as far as its server sees of it; a context manager.

    Parameters
    ----------
    pictures : bool
        Whether it shows them.
    """

    def __init__(self, server: ClassServer, pictures: bool) -> None:
        self._address = f"{server.url}api/state{'?pictures=1' if pictures else ''}"
        self._url = server.url
        self._pictures = pictures
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._look, name="page", daemon=True)
        self._shown: Dict[str, Any] = {}

    def __enter__(self) -> Looking:
        self._thread.start()
        return self

    def __exit__(self, *exception: object) -> None:
        self._ended.set()
        self._thread.join()

    def _look(self) -> None:
        numbers: Dict[str, Optional[int]] = {}
        while not self._ended.wait(_PERIOD):
            with contextlib.suppress(OSError, ValueError):
                with urllib.request.urlopen(self._address, timeout=10.0) as reply:
                    stations: List[Dict[str, Any]] = json.load(reply)["stations"]
                self._shown = {each["name"]: each for each in stations}
                for each in stations:
                    name, number = each["name"].replace(" ", "%20"), each["picture"]
                    if number is not None and numbers.get(name) != number:
                        numbers[name] = number
                        urllib.request.urlopen(f"{self._url}api/picture/{name}").read()

    def wait_until_all_here(self) -> None:
        """Wait until all stations answer, with pictures where they are wanted."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            with contextlib.suppress(RuntimeError):
                self.require_all_here()
                return
            time.sleep(0.1)
        self.require_all_here()

    def require_all_here(self) -> None:
        """Raise a RuntimeError unless all stations answer, with pictures where they are wanted."""
        for each in self._shown.values() or [{"name": "none", "phase": "no page"}]:
            if each["phase"] != "here":
                raise RuntimeError(f"{each['name']} is {each['phase']}: {each.get('reason')}")
            if self._pictures and each["picture"] is None:
                raise RuntimeError(f"{each['name']} shows no picture")
