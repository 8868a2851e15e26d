"""The simulator's side of its rehearsal process; any thread may ask, and waits for its answer."""

from __future__ import annotations

import contextlib
import os
import socket
import subprocess
import sys
import threading
from dataclasses import replace
from typing import Any, Dict, List, Optional, Sequence

from telex_control.common.params import ConfigError

from ..engine.simulator_config import SimulatorConfig
from ..robot.body import RobotBody
from ..robot.urdf.visuals import UrdfVisual
from ..scene.model import Floor, Start
from ..scene.objects.assembly import Assembly
from ..scene.planning import PlannedScene
from .frames import read_values, write_values
from .process import (
    MOST_MEMORY,
    MOST_TIME,
    EntryRequest,
    ListedScene,
    ListingRequest,
    RobotRequest,
    SceneRequest,
)

_STARTING = 45.0
"""Wall time that the process may take to start (s)."""
_ENDING = 2.0


class RehearsalClient:
    """Has scenes, objects and robots read and tried in another process.

    The process is started here, and again when it has ended.

    Parameters
    ----------
    most_memory : int
        Bytes that a rehearsal may take.
    """

    def __init__(self, config: SimulatorConfig, most_memory: int = MOST_MEMORY) -> None:
        self._config = config
        self._most_memory = most_memory
        self._lock = threading.Lock()
        self._process: Optional[subprocess.Popen] = None
        self._connection: Optional[socket.socket] = None
        self._listed: Dict[str, ListedScene] = {}
        self._start()

    def scene(self, world: str, robots: Sequence[RobotBody]) -> PlannedScene:
        """Read and try a scene.

        Parameters
        ----------
        world : str
            Its name, the path of its file, or its text.
        robots : sequence of RobotBody
            The first stands where the scene says.

        Raises
        ------
        ConfigError, SceneError
        """
        planned, *assemblies = self._ask(SceneRequest(world, tuple(robots)))
        objects = tuple(assembly.source for assembly in assemblies)
        return replace(
            planned, scene=replace(planned.scene, objects=objects), assemblies=tuple(assemblies)
        )

    def entry(
        self,
        text: str,
        name: str,
        folder: str,
        taken: Sequence[str],
        models: Sequence[str],
        floor: Floor,
    ) -> List[Assembly]:
        """Read and try an entry of a scene; parameters as of `plan_entry`.

        Raises
        ------
        ConfigError
        """
        return self._ask(EntryRequest(text, name, folder, tuple(taken), tuple(models), floor))

    def robot(self, robot: RobotBody, start: Start) -> List[UrdfVisual]:
        """Read and try a further robot; returns what is to be seen of it.

        Raises
        ------
        ConfigError, UrdfError, WorldError
        """
        return self._ask(RobotRequest(robot, start))

    def listing(self) -> List[ListedScene]:
        """Describe all scenes that have a name; a file is read again when it has changed.

        Raises
        ------
        ConfigError
        """
        listed = self._ask(ListingRequest(self._listed))
        self._listed = {scene.path: scene for scene in listed}
        return listed

    def close(self) -> None:
        """End the process; who waits for an answer is told that it has ended."""
        connection = self._connection
        if connection is not None:
            # Of a request in flight, which would hold the lock for as long as it takes.
            with contextlib.suppress(OSError):
                connection.shutdown(socket.SHUT_RDWR)
        with self._lock:
            self._end()

    def _ask(self, request: Any) -> List[Any]:
        with self._lock:
            if self._process is None or self._process.poll() is not None:
                self._start()
            assert self._connection is not None
            try:
                with self._connection.makefile("wb") as file:
                    write_values(file, [request])
                with self._connection.makefile("rb") as answers:
                    answer = list(read_values(answers.read))
            except Exception as error:  # whatever it is, the rest of the answer must not stay
                self._end()
                raise ConfigError(
                    f"{request.what} could not be tried: the process for that has ended ({error}); "
                    "it is started again with the next call"
                ) from error
        if answer and isinstance(answer[0], Exception):
            raise answer[0]
        return answer

    def _start(self) -> None:
        self._end()
        ours, theirs = socket.socketpair()
        # Some of ROS's modules set a default timeout when they are imported: with one, the other
        # process would read nothing where it is to wait.
        ours.setblocking(True)
        theirs.setblocking(True)
        module = ["-m", "telex_sim.rehearsal.start"]
        with theirs:
            try:
                self._process = subprocess.Popen(
                    [sys.executable, *module, str(theirs.fileno()), str(self._most_memory)],
                    pass_fds=[theirs.fileno()],
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.DEVNULL,
                    env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
                )
            except OSError as error:
                ours.close()
                raise ConfigError(
                    f"the process that tries what comes from outside cannot be started: {error}"
                ) from error
        ours.settimeout(_STARTING + MOST_TIME)
        self._connection = ours
        with contextlib.suppress(OSError), ours.makefile("wb") as file:
            write_values(file, [self._config])

    def _end(self) -> None:
        if self._connection is not None:
            self._connection.close()
            self._connection = None
        if self._process is not None:
            try:
                self._process.wait(_ENDING)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
            self._process = None
