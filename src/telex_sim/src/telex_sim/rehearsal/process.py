"""The process in which all that comes from outside is read, built and stepped first.

It belongs to one simulator, and ends with it. For each request it forks: whatever a scene, an
object or a robot does to the memory and the time of that process is bounded, and gone with it.
"""

from __future__ import annotations

import contextlib
import ctypes
import errno
import gc
import os
import resource
import select
import signal
import socket
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, BinaryIO, Iterator, List, Mapping, Optional, Sequence, Tuple

import rospkg

from telex_control.common.file_catalog import package_path
from telex_control.common.params import ConfigError

from ..engine.simulator_config import SimulatorConfig
from ..robot.body import RobotBody
from ..robot.urdf.visuals import urdf_visuals
from ..scene.addresses import resolve_address
from ..scene.assets import Assets
from ..scene.catalog import preview_of, scenes, small_jpeg
from ..scene.files.scene_file import SceneError, read_description
from ..scene.library import object_types
from ..scene.model import Floor, Start
from ..scene.planning import plan_entry, plan_world
from .frames import read_values, write_values
from .trial import Rehearsal, check_names, check_scene

MOST_SECONDS = 2.0
"""Computing time for reading, and again for building and stepping."""
MOST_WAITING = 15.0
"""Wall time without computing after which a rehearsal is ended, whatever it waits for (s)."""
MOST_TIME = 50.0
"""Wall time after which it is ended even where a busy machine lets it compute now and then (s):
whoever asked waits for 60 s (the bridge) or more."""
MOST_MEMORY = 1024**3
"""Bytes of memory of its own, what it starts with included."""
_LOOK = 0.5
"""Wall time between two looks whether a rehearsal computes (s)."""
_MOST_ANSWER = 256 * 1024**2
"""Bytes of an answer."""
_STOOD = -1
"""Status of a rehearsal that was ended after `MOST_WAITING`."""
_TOO_LATE = -2
"""Status of one that was ended after `MOST_TIME`."""
_PR_SET_PDEATHSIG = 1
_prctl = ctypes.CDLL(None).prctl


@dataclass(frozen=True)
class SceneRequest:
    """A scene, by its name, path or text, with these robots in it.

    The answer is the planned scene without objects, then an `Assembly` for each of them.
    """

    world: str
    robots: Tuple[RobotBody, ...]

    what = "the scene"

    def answer(self, stage: _Stage) -> Iterator[Any]:
        """Read and try it."""
        planned = plan_world(self.world, Assets(package_path), stage.step_size)
        check_scene(stage.config, planned, [robot.model for robot in self.robots])
        stage.begin_building()
        with stage.rehearsal() as rehearsal:
            rehearsal.scene(planned, self.robots)
        yield replace(planned, scene=replace(planned.scene, objects=()), assemblies=())
        yield from planned.assemblies


@dataclass(frozen=True)
class EntryRequest:
    """An entry of a scene, as ``sim/spawn`` gets it; the answer is an `Assembly` an object."""

    text: str
    name: str
    folder: str
    taken: Tuple[str, ...]
    models: Tuple[str, ...]
    floor: Floor

    what = "the object"

    def answer(self, stage: _Stage) -> Iterator[Any]:
        """Read and try it."""
        plans = plan_entry(
            self.text, self.name, self.folder, self.taken, Assets(package_path), stage.step_size
        )
        check_names(plans, self.models)
        stage.begin_building()
        with stage.rehearsal() as rehearsal:
            rehearsal.objects(self.floor, plans)
        yield from plans


@dataclass(frozen=True)
class RobotRequest:
    """A further robot; the answer is a `UrdfVisual` for each of its visuals."""

    robot: RobotBody
    start: Start

    what = "the robot"

    def answer(self, stage: _Stage) -> Iterator[Any]:
        """Read and try it."""
        with stage.rehearsal() as rehearsal:
            rehearsal.check_robot(self.robot)
            visuals = urdf_visuals(self.robot.urdf)
            stage.begin_building()
            rehearsal.robot(self.robot, self.start)
        yield from visuals


@dataclass(frozen=True)
class ListedScene:
    """What the list of scenes tells of one; times and sizes of its files when they were read."""

    name: str
    path: str
    description: str
    problem: str
    hidden: bool
    picture: bytes
    state: Tuple[Optional[Tuple[int, int]], ...]


@dataclass(frozen=True)
class ListingRequest:
    """All scenes that have a name; the answer is a `ListedScene` for each.

    Those that are known already, by their paths, are read again only where the file has changed.
    """

    known: Mapping[str, ListedScene]

    what = "the list of scenes"

    def answer(self, stage: _Stage) -> Iterator[Any]:
        """Read what they say of themselves."""
        for name, path in scenes().items():
            stage.begin_reading()
            preview = preview_of(path)
            known, state = self.known.get(str(path)), (_state(path), _state(preview))
            if known is not None and state[0] is not None and known.state == state:
                yield known
                continue
            description, hidden, problem = "", False, ""
            try:
                description, hidden = read_description(path)
            except SceneError as error:
                problem = str(error)
            yield ListedScene(
                name, str(path), description, problem, hidden, small_jpeg(preview), state
            )


def _state(path: Path) -> Optional[Tuple[int, int]]:
    """Time (ns) and size (bytes) of a file; the time is that of any change, rights included."""
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_ctime_ns, status.st_size


class _Stage:
    """What a rehearsal gets from its process."""

    def __init__(self, config: SimulatorConfig, most_memory: int = MOST_MEMORY) -> None:
        self.config = config
        self.most_memory = most_memory
        self.step_size = config.timing.step_size

    def rehearsal(self) -> Rehearsal:
        return Rehearsal(self.config, lambda address: resolve_address(address, package_path))

    def begin_reading(self) -> None:
        """Be ended (SIGPROF) after the computing time for the next part, if that goes on."""
        signal.setitimer(signal.ITIMER_PROF, MOST_SECONDS)

    begin_building = begin_reading


def _rehearse(request: Any, stage: _Stage, answer: BinaryIO) -> None:
    """Answer a request within the limits; the exception that refuses it is an answer too."""
    resource.setrlimit(resource.RLIMIT_DATA, (stage.most_memory, stage.most_memory))
    resource.setrlimit(resource.RLIMIT_FSIZE, (_MOST_ANSWER, _MOST_ANSWER))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    stage.begin_reading()
    try:
        write_values(answer, request.answer(stage))
    except MemoryError:
        raise
    except OSError as error:
        if error.errno in (errno.ENOMEM, errno.EFBIG):
            raise
        _refuse(answer, ConfigError(f"{request.what}: {error}"))
    except Exception as error:  # whatever refuses it, the simulator is told
        _refuse(answer, error)


def _refuse(answer: BinaryIO, error: Exception) -> None:
    answer.seek(0)
    answer.truncate()
    write_values(answer, [error])


def _end_with(parent: int) -> None:
    """Have this process killed when `parent` ends, however it ends."""
    _prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)


def _perform(request: Any, stage: _Stage) -> Tuple[int, int]:
    """Fork for a request; returns the file of its answer, and how the process ended.

    That is a status as `os.waitpid` has it, `_STOOD` or `_TOO_LATE`.
    """
    answer = os.memfd_create("rehearsal")
    parent = os.getpid()
    # The child holds the other end of it for as long as it lives.
    lives, held = os.pipe()
    pid = os.fork()
    if pid == 0:
        status = 1
        _end_with(parent)
        with contextlib.suppress(BaseException), open(answer, "wb") as file:
            _rehearse(request, stage, file)
            status = 0
        os._exit(status)
    os.close(held)
    late = _wait_for_end(pid, lives)
    os.close(lives)
    if late:
        os.kill(pid, signal.SIGKILL)
    _, status = os.waitpid(pid, 0)
    # It may have ended by itself before it was killed.
    killed = os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGKILL
    return answer, late if late and killed else status


def _wait_for_end(pid: int, lives: int) -> int:
    """Wait until a child that holds a pipe ends; returns 0, `_STOOD` or `_TOO_LATE`."""
    # Of all its threads, as clock_getcpuclockid(3) makes it.
    clock = (~pid << 3) | 2
    until = time.monotonic() + MOST_TIME
    # By looks, for a busy machine may hold up both processes for longer than one of them takes.
    computed, stood = 0.0, 0
    while not select.select([lives], [], [], _LOOK)[0]:
        before, computed = computed, time.clock_gettime(clock)
        stood = stood + 1 if computed == before else 0
        if stood * _LOOK > MOST_WAITING:
            return _STOOD
        if time.monotonic() > until:
            return _TOO_LATE
    return 0


def _why_ended(request: Any, status: int, most_memory: int) -> ConfigError:
    """In words, what ended a process that gave no answer."""
    if status == _STOOD:
        why = f"it waited for more than {MOST_WAITING:g} s"
    elif status == _TOO_LATE:
        why = f"it took more than {MOST_TIME:g} s"
    elif os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGPROF:
        why = f"it took more than {MOST_SECONDS:g} s of computing"
    elif os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGKILL:
        why = "it was killed from outside, as the system does when its memory runs out"
    else:
        why = f"it took more than {most_memory // 1024**2} MB of memory, or PyBullet failed at it"
    return ConfigError(
        f"{request.what} was tried in a process of its own: {why}; less, or simpler, is needed"
    )


def serve(connection: socket.socket, config: SimulatorConfig, most_memory: int) -> None:
    """Answer requests until the other side closes the connection."""
    stage = _Stage(config, most_memory)
    # Looked up once here, for all who are forked.
    object_types()
    with contextlib.suppress(rospkg.ResourceNotFound):
        package_path("telex_sim")
    gc.collect()
    gc.freeze()
    with connection.makefile("rb") as asked, connection.makefile("wb") as answers:
        while True:
            try:
                requests: List[Any] = list(read_values(asked.read))
            except EOFError:
                return
            for request in requests:
                _answer(answers, request, stage)


def _answer(file: BinaryIO, request: Any, stage: _Stage) -> None:
    memory, status = _perform(request, stage)
    with open(memory, "rb") as answer:
        if status:
            write_values(file, [_why_ended(request, status, stage.most_memory)])
            return
        answer.seek(0)
        while True:
            block = answer.read(1 << 16)
            if not block:
                break
            file.write(block)
        file.flush()


def main(arguments: Sequence[str]) -> None:
    """Serve the connection whose file descriptor is the first argument.

    The second is the most memory (bytes). What comes first is the configuration.
    """
    # A terminal's, which reaches all that it started: the simulator says when this one ends.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with socket.socket(fileno=int(arguments[0])) as connection:
        with connection.makefile("rb", buffering=0) as file:
            (config,) = read_values(file.read)
        serve(connection, config, int(arguments[1]))
