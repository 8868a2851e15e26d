"""Processes that do the jobs of a campaign, on this machine or on many."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import platform
import socket
import traceback
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from importlib import metadata
from typing import Any, Callable, Dict, Iterator, List, Optional, Sequence, Set, Tuple, TypeVar
from urllib.parse import urlsplit

from .jobs import software_digest
from .processor import processor

Job = TypeVar("Job")
Result = TypeVar("Result")
Done = Callable[[Job, Optional[Result], Optional[Exception]], None]

TRIES = 3
"""How often a job is begun whose process is lost."""
CONNECTING = 10.0
"""How long a scheduler may take to answer (s)."""
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
_WHEELS = ("llvmlite", "numba", "numpy", "pybullet")


class CrewError(RuntimeError):
    """The processes cannot work; the message says why."""


class LostError(RuntimeError):
    """A job's process was lost as often as it was begun."""


class WorkError(RuntimeError):
    """What a job raised could not leave its process; the message says what it was."""


def processors() -> int:
    """How many processors this process may use."""
    return len(os.sched_getaffinity(0))


# --- this machine --------------------------------------------------------------------------------


def do_here(
    jobs: Sequence[Job],
    work: Callable[[Job], Result],
    workers: int,
    done: Done[Job, Result],
) -> None:
    """Do jobs in processes of this machine.

    Parameters
    ----------
    jobs : sequence
        Plain data.
    work : callable
        Function of a module, which does a job.
    workers : int
        Processes.
    done : callable
        Told of each job its result, or what it raised; `LostError` where its process was lost
        `TRIES` times.
    """
    with _one_thread_each():
        left: List[Job] = list(jobs)
        while left:
            # A lost process spoils its pool. Which job it was at nobody knows: each of those that
            # were under way begins again in a process of its own.
            suspects = _in_pool(left, work, min(workers, len(left)), done)
            for job in suspects:
                _alone(job, work, done)


def _in_pool(
    left: List[Job], work: Callable[[Job], Result], workers: int, done: Done[Job, Result]
) -> List[Job]:
    """Do jobs, which are taken out of `left`; returns those that a lost process left undone."""
    suspects: List[Job] = []
    running: Dict[Future, Job] = {}
    with _pool(workers) as pool:
        while running or (left and not suspects):
            while left and len(running) < workers and not suspects:
                try:
                    running[pool.submit(_done, work, left[0])] = left[0]
                except BrokenProcessPool:
                    break
                left.pop(0)
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                job = running.pop(future)
                if isinstance(future.exception(), BrokenProcessPool):
                    suspects.append(job)
                else:
                    _tell(future, job, done)
    return suspects


def _alone(job: Job, work: Callable[[Job], Result], done: Done[Job, Result]) -> None:
    for _ in range(TRIES - 1):
        with _pool(1) as pool:
            future = pool.submit(_done, work, job)
            wait([future])
        if not isinstance(future.exception(), BrokenProcessPool):
            _tell(future, job, done)
            return
    done(job, None, LostError(f"its process was lost {TRIES} times"))


def _tell(future: Any, job: Job, done: Done[Job, Result]) -> None:
    error = future.exception()
    if error is not None and not isinstance(error, Exception):
        raise error
    done(job, None if error is not None else future.result(), error)


def _done(work: Callable[[Job], Result], job: Job) -> Result:
    """Do a job, in its own process: what cannot be read out of a pipe would spoil the pool."""
    try:
        return work(job)
    except Exception as error:
        try:
            pickle.loads(pickle.dumps(error))
        except Exception:  # an operator's own kind of error raises whatever it leads to
            text = traceback.format_exception_only(type(error), error)[-1].strip()
            raise WorkError(text) from None
        raise


@contextmanager
def _pool(workers: int) -> Iterator[ProcessPoolExecutor]:
    # A child that is forked would have this process's threads' locks, and its physics.
    pool = ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn"))
    try:
        yield pool
    except BaseException:
        for process in list(getattr(pool, "_processes", None) or {}).copy():
            os.kill(process, 15)
        raise
    finally:
        pool.shutdown()


@contextmanager
def _one_thread_each() -> Iterator[None]:
    """Have children compute with one thread: the same sums, and a processor for each of them."""
    kept = {name: os.environ.get(name) for name in _THREADS}
    os.environ.update({name: "1" for name in _THREADS})
    try:
        yield
    finally:
        for name, value in kept.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


# --- many machines -------------------------------------------------------------------------------


def do_elsewhere(
    jobs: Sequence[Job],
    work: Callable[[Job], Result],
    scheduler: str,
    done: Done[Job, Result],
    warn: Callable[[str], None],
) -> None:
    """Do jobs in the workers of a scheduler of dask.distributed.

    Parameters
    ----------
    jobs, work, done
        As of `do_here`.
    scheduler : str
        Its address, e.g. ``tcp://10.0.0.5:8786``.
    warn : callable
        Told where workers differ so that the same jobs may give other bytes.

    Raises
    ------
    CrewError
        The library is not installed, nobody answers at the address or any more, there are no
        workers, or they have other sources.
    """
    try:
        import distributed  # optional: requirements-many-machines.txt
    except ImportError as error:
        raise CrewError(
            f"--scheduler needs dask.distributed ({error}): "
            "pip install -r requirements-many-machines.txt"
        ) from error
    _check_answers(scheduler)
    here = about_machine()
    warned: Set[str] = set()

    def warn_once(text: str) -> None:
        if text not in warned:
            warned.add(text)
            warn(text)

    with distributed.Client(scheduler, timeout=CONNECTING) as client:
        machines = client.run(about_machine)
        compare(machines, here, scheduler, warn_once)
        sources = here["sources"]
        futures = {client.submit(_done_there, work, job, sources, pure=False): job for job in jobs}
        for future in distributed.as_completed(list(futures)):
            if future.cancelled():
                raise CrewError(f"scheduler {scheduler}: the connection was lost")
            job, raised = futures.pop(future), future.exception()
            if isinstance(raised, distributed.KilledWorker):
                done(job, None, LostError(str(raised)))
            elif raised is not None:
                _tell(future, job, done)
            else:
                worker, about, result = future.result()
                if machines.get(worker) != about:  # it came later
                    compare({worker: about}, here, scheduler, warn_once)
                    machines[worker] = about
                done(job, result, None)
            future.release()


def _done_there(
    work: Callable[[Job], Result], job: Job, sources: str
) -> Tuple[str, Dict[str, str], Optional[Result]]:
    """Do a job in a worker, unless it has other sources; returns also its address and machine."""
    import distributed  # a worker has it

    about = about_machine()
    result = _done(work, job) if about["sources"] == sources else None
    return distributed.get_worker().address, about, result


def _check_answers(scheduler: str) -> None:
    """Refuse an address at which nobody answers: a client of dask would try on at its end."""
    address = urlsplit(scheduler)
    try:
        host, port = address.hostname, address.port
    except ValueError:
        host, port = None, None
    if address.scheme not in ("tcp", "tls") or host is None or port is None:
        raise CrewError(f"scheduler is '{scheduler}'; an address such as tcp://HOST:8786 is needed")
    try:
        socket.create_connection((host, port), CONNECTING).close()
    except OSError as error:
        raise CrewError(f"scheduler {scheduler}: {error.strerror or error}") from error


def about_machine() -> Dict[str, str]:
    """Return what a job's bytes depend on: sources, wheels, processor."""
    return {
        "sources": software_digest(),
        "wheels": ", ".join(f"{name} {metadata.version(name)}" for name in _WHEELS),
        "Python": platform.python_version(),
        "processor": processor(),
    }


def compare(
    found: Dict[str, Dict[str, str]],
    here: Dict[str, str],
    scheduler: str,
    warn: Callable[[str], None],
) -> None:
    """Refuse machines that would do other jobs, and warn of those whose bytes may differ.

    Parameters
    ----------
    found : mapping
        `about_machine` of each worker, by its address.
    here : mapping
        Of this machine.
    warn : callable

    Raises
    ------
    CrewError
    """
    if not found:
        raise CrewError(
            f"scheduler {scheduler} has no workers; start some: dask worker {scheduler}"
        )
    for worker, about in sorted(found.items()):
        if about["sources"] != here["sources"]:
            raise CrewError(
                f"worker {worker} has other sources than this machine: the same checkout is needed,"
                " and nothing changed in it meanwhile"
            )
    for key in ("wheels", "Python", "processor"):
        kinds = sorted({about[key] for about in (*found.values(), here)})
        if len(kinds) > 1:
            warn(f"machines differ in {key} ({'; '.join(kinds)}): results may differ between them")
