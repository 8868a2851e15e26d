"""A server of the page of a class, for stations that are given."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Mapping, Optional

from telex_control.common.child_processes import DIES_WITH_US
from telex_experiments.workspace import ROOT

_STOPS_WITHIN = 10.0


class ClassServer:
    """Runs ``rosrun telex_training class``; use it as a context manager.

    Parameters
    ----------
    stations : mapping of str to str
        Addresses by name, of stations on this machine that ask for no token.

    Attributes
    ----------
    url : str
        Of the page.
    """

    def __init__(self, stations: Mapping[str, str]) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="telex-class-")
        self._file = Path(self._folder.name, "stations.yaml")
        lines = [f"  - {{name: {name}, address: '{at}'}}" for name, at in stations.items()]
        self._file.write_text("\n".join(["stations:", *lines, ""]))
        self._process: Optional[subprocess.Popen] = None
        self.url = ""

    def __enter__(self) -> ClassServer:
        command = ROOT / "src" / "telex_training" / "nodes" / "class"
        self._process = subprocess.Popen(
            [*DIES_WITH_US, sys.executable, str(command), str(self._file), "--port", "0"],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self._process.stdout is not None
        words = self._process.stdout.readline().split()
        if not words:
            self.__exit__()
            raise RuntimeError("the server of the class has ended; its message is above")
        self.url = words[-1]
        return self

    @property
    def pid(self) -> int:
        """Its process."""
        assert self._process is not None
        return self._process.pid

    def __exit__(self, *exception: object) -> None:
        assert self._process is not None
        self._process.terminate()
        try:
            self._process.wait(_STOPS_WITHIN)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        if self._process.stdout is not None:
            self._process.stdout.close()
        self._folder.cleanup()
