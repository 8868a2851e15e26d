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
from pathlib import Path
from types import TracebackType
from typing import Any, Dict, Iterator, List, Optional, Sequence, Type

import rosgraph

from telex_control.common.child_processes import DIES_WITH_US
from telex_experiments.classroom.class_server import ClassServer
from telex_experiments.rigs.private_master import PrivateMaster, descendants, end_tree
from telex_experiments.rigs.private_simulator import cpu_seconds
from telex_experiments.workspace import ROOT

ASKED = ("video_server", "training", "master")
"""Processes of a station that the page of a class has work for; where nobody watches, its cameras
as well."""
CAMERAS = "cameras"
_STARTS_WITHIN = 180.0
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

    def __exit__(
        self,
        kind: Optional[Type[BaseException]],
        error: Optional[BaseException],
        trace: Optional[TracebackType],
    ) -> None:
        self._stack.close()

    def _start(self) -> None:
        master = self._stack.enter_context(PrivateMaster())
        recordings = self._stack.enter_context(tempfile.TemporaryDirectory(prefix="telex-trials-"))
        launch = subprocess.Popen(
            [
                *(*DIES_WITH_US, "roslaunch", "telex_training", "station.launch"),
                *("video_port:=0", "bridge_port:=0", f"recordings:={recordings}"),
                *("exercise:=slalom", "operator:=ann"),
            ],
            env=master.environment(),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        self._stack.callback(end_tree, launch)
        asks = rosgraph.Master("/live_station", master_uri=master.uri)
        end = time.monotonic() + _STARTS_WITHIN
        self.url = self._parameter(asks, "/telex/video_server/url", end)
        self.bridge = self._parameter(asks, "/telex/rosbridge/url", end)
        self._parameter(asks, "/telex/video_server/mounts/training", end)
        self._pids = {**_nodes(launch.pid), "master": int(asks.getPid())}

    def _parameter(self, asks: rosgraph.Master, name: str, end: float) -> Any:
        while time.monotonic() < end:
            with contextlib.suppress(OSError, rosgraph.MasterError):
                return asks.getParam(name)
            time.sleep(0.2)
        raise RuntimeError(f"the station did not set {name} within {_STARTS_WITHIN} s")

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


def _nodes(pid: int) -> Dict[str, int]:
    """Processes of nodes below one, by name."""
    found = {}
    for each in descendants(pid):
        with contextlib.suppress(OSError):
            for word in Path(f"/proc/{each}/cmdline").read_text(errors="replace").split("\0"):
                if word.startswith("__name:="):
                    found[word[len("__name:=") :]] = each
    return found


class Looking:
    """A page of a class, as far as its server sees of it; a context manager.

    Parameters
    ----------
    server : ClassServer
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

    def __exit__(
        self,
        kind: Optional[Type[BaseException]],
        error: Optional[BaseException],
        trace: Optional[TracebackType],
    ) -> None:
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

    def require_all_here(self) -> None:
        """Raise a RuntimeError unless all stations answer, with pictures where they are wanted."""
        for each in self._shown.values() or [{"name": "none", "phase": "no page"}]:
            if each["phase"] != "here":
                raise RuntimeError(f"{each['name']} is {each['phase']}: {each.get('reason')}")
            if self._pictures and each["picture"] is None:
                raise RuntimeError(f"{each['name']} shows no picture")
