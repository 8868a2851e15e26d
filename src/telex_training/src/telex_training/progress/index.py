"""The index of people, trials and repetitions: an SQLite file made from the trials' recordings.

Nothing stands in it that is not in the recordings: deleted, damaged or of another version, it is
made anew.
"""

from __future__ import annotations

import contextlib
import os
import sqlite3
import threading
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Container, Dict, Iterator, List, Optional, Sequence, Tuple

from ..judging.workload import SCALES
from ..recording.signature import OTHER, Signature
from ..recording.station_keys import known_keys
from ..recording.trial_file import trials
from ..recording.writer import RecordingError
from .trial_facts import MarkFacts, MetricFacts, RepetitionFacts, TrialFacts, read_trial

FILE = "progress.sqlite"
VERSION = 4
_PATIENCE = 30.0
"""Wall time for which another process may hold the index (s)."""

_SCHEMA = """
CREATE TABLE files (
    file TEXT PRIMARY KEY, size INTEGER NOT NULL, changed_ns INTEGER NOT NULL,
    trial TEXT, problem TEXT NOT NULL
);
CREATE TABLE trials (
    trial TEXT PRIMARY KEY, file TEXT NOT NULL REFERENCES files(file) ON DELETE CASCADE,
    began_ns INTEGER NOT NULL, operator TEXT NOT NULL, exercise TEXT NOT NULL, title TEXT NOT NULL,
    setting TEXT NOT NULL, mode TEXT NOT NULL, software TEXT NOT NULL, ended TEXT NOT NULL,
    seed INTEGER, seconds REAL NOT NULL, valid INTEGER NOT NULL, verdict TEXT NOT NULL,
    provisional INTEGER NOT NULL, log TEXT NOT NULL, signer TEXT NOT NULL, flaw TEXT NOT NULL
);
CREATE INDEX trials_of ON trials (operator, exercise, setting, began_ns);
CREATE TABLE repetitions (
    trial TEXT NOT NULL REFERENCES trials(trial) ON DELETE CASCADE, number INTEGER NOT NULL,
    began REAL NOT NULL, seconds REAL NOT NULL, penalty REAL NOT NULL, fault TEXT NOT NULL,
    completed INTEGER NOT NULL, passed INTEGER NOT NULL, PRIMARY KEY (trial, number)
);
CREATE TABLE figures (
    trial TEXT NOT NULL, number INTEGER NOT NULL, name TEXT NOT NULL, value REAL,
    PRIMARY KEY (trial, number, name),
    FOREIGN KEY (trial, number) REFERENCES repetitions(trial, number) ON DELETE CASCADE
);
CREATE TABLE metrics (
    trial TEXT NOT NULL REFERENCES trials(trial) ON DELETE CASCADE, place INTEGER NOT NULL,
    name TEXT NOT NULL, kind TEXT NOT NULL, unit TEXT NOT NULL, text TEXT NOT NULL,
    more_is_better INTEGER NOT NULL, value REAL, bound REAL, expert REAL,
    PRIMARY KEY (trial, place)
);
CREATE TABLE marks (
    trial TEXT NOT NULL REFERENCES trials(trial) ON DELETE CASCADE, place INTEGER NOT NULL,
    verdict TEXT NOT NULL, reason TEXT NOT NULL, by TEXT NOT NULL, PRIMARY KEY (trial, place)
);
CREATE TABLE workloads (
    trial TEXT PRIMARY KEY REFERENCES trials(trial) ON DELETE CASCADE, mental REAL NOT NULL,
    physical REAL NOT NULL, temporal REAL NOT NULL, performance REAL NOT NULL,
    effort REAL NOT NULL, frustration REAL NOT NULL
);
CREATE VIEW people AS
    SELECT operator AS name, count(*) AS trials, min(began_ns) AS first_ns, max(began_ns) AS last_ns
    FROM trials GROUP BY operator;
CREATE VIEW progress AS
    SELECT operator, exercise, setting, count(DISTINCT trials.trial) AS trials,
        count(number) AS repetitions, coalesce(sum(completed), 0) AS completed,
        coalesce(sum(passed), 0) AS passed,
        min(CASE WHEN completed THEN repetitions.seconds + penalty END) AS best,
        max(trials.began_ns) AS last_ns
    FROM trials LEFT JOIN repetitions USING (trial) WHERE valid
    GROUP BY operator, exercise, setting;
"""
_PARTS = ("repetitions", "metrics", "marks", "workload")
"""Of a trial, in tables of their own."""
_TRIAL = tuple(field.name for field in fields(TrialFacts) if field.name not in _PARTS)
_REPETITION = tuple(field.name for field in fields(RepetitionFacts) if field.name != "metrics")
_METRIC = tuple(field.name for field in fields(MetricFacts))
_MARK = tuple(field.name for field in fields(MarkFacts))


class ProgressIndexError(RuntimeError):
    """The index cannot be made or read; the message names the file and says why."""


@dataclass(frozen=True)
class Person:
    """Somebody who has done trials.

    Attributes
    ----------
    name : str
        Empty: trials under no name.
    first, last : float
        Wall times of the first and the last trial (s since the epoch).
    """

    name: str
    trials: int
    first: float
    last: float


class ProgressIndex:
    """The index of a folder of recordings. Its methods may be called from any thread.

    Parameters
    ----------
    folder : Path
        Of the recordings; the index stands in it.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.path = folder / FILE
        self._lock = threading.Lock()
        self._refreshing = threading.Lock()

    def rebuild(self) -> List[str]:
        """Make the index anew from all files; returns what `refresh` does."""
        with self._lock:
            self._remove()
        return self.refresh()

    def refresh(self) -> List[str]:
        """Take in what is new or has changed, and drop what is gone.

        Returns
        -------
        list of str
            Of each file that cannot be used, why not.

        Raises
        ------
        ProgressIndexError
        """
        with self._refreshing:
            return self._refresh()

    def _refresh(self) -> List[str]:
        with self._open() as base:
            known = _known(base)
        # Outside a transaction: reading a large archive takes minutes, and others wait for seconds.
        read = {
            (name, state): self._read(name)
            for name, state in self._there().items()
            if known.get(name) != state
        }
        with self._open() as base:
            # Anew: files may have gone meanwhile, and others may have taken some in.
            known, there = _known(base), self._there()
            gone = [
                (name,)
                for (name,) in base.execute("SELECT file FROM files")
                if name not in there or known.get(name) != there[name]
            ]
            base.executemany("DELETE FROM files WHERE file = ?", gone)
            for name, state in there.items():
                if known.get(name) != state:
                    self._take(base, name, state, read.get((name, state)) or self._read(name))
            return [
                row[0]
                for row in base.execute(
                    "SELECT problem FROM files WHERE problem != '' ORDER BY file"
                )
            ]

    def people(self) -> List[Person]:
        """Everybody who has done trials, by name."""
        with self._open() as base:
            rows = base.execute("SELECT name, trials, first_ns, last_ns FROM people ORDER BY name")
            return [
                Person(name, count, first / 1e9, last / 1e9) for name, count, first, last in rows
            ]

    def trials(
        self, operator: Optional[str] = None, exercise: Optional[str] = None
    ) -> List[TrialFacts]:
        """Trials, the oldest first.

        Parameters
        ----------
        operator, exercise : str, optional
            Only theirs.
        """
        wanted = {"operator": operator, "exercise": exercise}
        given = {key: value for key, value in wanted.items() if value is not None}
        where = "".join(f" AND {key} = :{key}" for key in given)
        with self._open() as base:
            rows = base.execute(
                f"SELECT {', '.join(_TRIAL)} FROM trials WHERE true{where}"
                " ORDER BY began_ns, trial",
                given,
            ).fetchall()
            parts = _parts(base, where, given)
        keys = known_keys()
        return [_trial(row, parts.get(row[0], {}), keys) for row in rows]

    def file_of(self, trial: str) -> Optional[Path]:
        """Path of a trial's recording; None: the index has no such trial."""
        with self._open() as base:
            row = base.execute("SELECT file FROM trials WHERE trial = ?", (trial,)).fetchone()
        return None if row is None else self.folder / row[0]

    # --- the file --------------------------------------------------------------------------------

    def _there(self) -> Dict[str, Tuple[int, int]]:
        """Size and time of change (ns) of each recording."""
        found = {}
        for path in trials(self.folder):
            with contextlib.suppress(OSError):  # it was taken away meanwhile
                state = path.stat()
                found[path.name] = state.st_size, state.st_mtime_ns
        return found

    def _read(self, name: str) -> Tuple[Optional[TrialFacts], str]:
        """Return what a file tells, or why it tells nothing."""
        try:
            return read_trial(self.folder / name), ""
        except RecordingError as error:
            return None, str(error)
        except Exception as error:  # what one file leads to must not keep out all others
            return None, f"{self.folder / name}: {type(error).__name__}: {error}"

    def _take(
        self,
        base: sqlite3.Connection,
        name: str,
        state: Tuple[int, int],
        read: Tuple[Optional[TrialFacts], str],
    ) -> None:
        facts, problem = read
        if facts is not None:
            other = base.execute(
                "SELECT file FROM trials WHERE trial = ?", (facts.trial,)
            ).fetchone()
            if other is not None:
                problem = (
                    f"{self.folder / name}: its trial {facts.trial} stands in {other[0]} already, "
                    "which counts; one of the two is one too many"
                )
        base.execute(
            "INSERT INTO files VALUES (?, ?, ?, ?, ?)",
            (name, *state, None if facts is None else facts.trial, problem),
        )
        if facts is not None and not problem:
            _insert(base, name, facts)

    @contextlib.contextmanager
    def _open(self) -> Iterator[sqlite3.Connection]:
        """Yield a connection, in one transaction; a file that is no index of today is made anew."""
        with self._lock:
            try:
                self.folder.mkdir(parents=True, exist_ok=True)
                base = self._connect()
            except (OSError, sqlite3.Error) as error:
                raise ProgressIndexError(f"{self.path}: {_reason(error)}") from error
            try:
                with base:
                    base.execute("BEGIN IMMEDIATE")
                    yield base
            except sqlite3.Error as error:
                raise ProgressIndexError(
                    f"{self.path}: {error}; rosrun telex_training progress rebuild makes it anew"
                ) from error
            finally:
                base.close()

    def _connect(self) -> sqlite3.Connection:
        try:
            return self._made(_connection(self.path))
        except sqlite3.DatabaseError as error:
            # Locked, or a disk that is full: nothing is wrong with the file.
            if isinstance(error, sqlite3.OperationalError):
                raise
        self._remove()
        return self._made(_connection(self.path))

    def _made(self, base: sqlite3.Connection) -> sqlite3.Connection:
        """Return the connection, of an index that has its tables."""
        try:
            # Under the lock, for another process may be making them.
            base.execute("BEGIN IMMEDIATE")
            version = base.execute("PRAGMA user_version").fetchone()[0]
            tables = base.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]
            if tables and version != VERSION:
                raise sqlite3.DatabaseError("an index of another version")
            if not tables:
                for statement in _SCHEMA.split(";"):
                    base.execute(statement)
                base.execute(f"PRAGMA user_version = {VERSION}")
            base.execute("COMMIT")
        except BaseException:
            base.close()
            raise
        return base

    def _remove(self) -> None:
        for suffix in ("", "-journal"):
            with contextlib.suppress(FileNotFoundError):
                self.path.with_name(self.path.name + suffix).unlink()


def _known(base: sqlite3.Connection) -> Dict[str, Tuple[int, int]]:
    """Size and time of change (ns) of each recording that is in the index."""
    rows = base.execute("SELECT file, size, changed_ns FROM files WHERE problem = ''")
    return {name: (size, changed) for name, size, changed in rows}


def _connection(path: Path) -> sqlite3.Connection:
    # It has names and results of people: for the station's user alone.
    os.close(os.open(path, os.O_CREAT | os.O_RDWR, 0o600))
    base = sqlite3.connect(str(path), timeout=_PATIENCE, isolation_level=None)
    base.execute("PRAGMA foreign_keys = ON")
    base.execute("PRAGMA secure_delete = ON")
    return base


def _insert(base: sqlite3.Connection, file: str, facts: TrialFacts) -> None:
    base.execute(
        f"INSERT INTO trials (file, {', '.join(_TRIAL)}) VALUES (?{', ?' * len(_TRIAL)})",
        (file, *(getattr(facts, name) for name in _TRIAL)),
    )
    for number, repetition in enumerate(facts.repetitions, 1):
        base.execute(
            f"INSERT INTO repetitions (trial, number, {', '.join(_REPETITION)})"
            f" VALUES (?, ?{', ?' * len(_REPETITION)})",
            (facts.trial, number, *(getattr(repetition, name) for name in _REPETITION)),
        )
        base.executemany(
            "INSERT INTO figures VALUES (?, ?, ?, ?)",
            [(facts.trial, number, *item) for item in repetition.metrics.items()],
        )
    _insert_list(base, "metrics", facts.trial, _METRIC, facts.metrics)
    _insert_list(base, "marks", facts.trial, _MARK, facts.marks)
    if facts.workload:
        row = (facts.trial, *facts.workload)
        base.execute(f"INSERT INTO workloads VALUES ({', '.join('?' * len(row))})", row)


def _insert_list(
    base: sqlite3.Connection, table: str, trial: str, keys: Sequence[str], items: Sequence[Any]
) -> None:
    base.executemany(
        f"INSERT INTO {table} (trial, place, {', '.join(keys)}) VALUES (?, ?{', ?' * len(keys)})",
        [(trial, place, *(getattr(item, key) for key in keys)) for place, item in enumerate(items)],
    )


def _parts(
    base: sqlite3.Connection, where: str, given: Dict[str, Any]
) -> Dict[str, Dict[str, List[Any]]]:
    """What stands in tables of its own of the trials that are asked for, by trial."""
    chosen = f"trial IN (SELECT trial FROM trials WHERE true{where})"
    found: Dict[str, Dict[str, List[Any]]] = {}

    def rows(table: str, keys: Sequence[str], order: str) -> Iterator[Tuple[str, Dict[str, Any]]]:
        """Each row of a table: its trial, and its columns by their names."""
        for trial, *row in base.execute(
            f"SELECT trial, {', '.join(keys)} FROM {table} WHERE {chosen} ORDER BY {order}", given
        ):
            yield trial, dict(zip(keys, row))

    def put(trial: str, part: str, made: Any) -> None:
        found.setdefault(trial, {}).setdefault(part, []).append(made)

    figures: Dict[Tuple[str, int], Dict[str, Optional[float]]] = {}
    for trial, row in rows("figures", ("number", "name", "value"), "trial"):
        figures.setdefault((trial, row["number"]), {})[row["name"]] = row["value"]
    for trial, row in rows("repetitions", ("number", *_REPETITION), "trial, number"):
        metrics = figures.get((trial, row.pop("number")), {})
        row.update(completed=bool(row["completed"]), passed=bool(row["passed"]))
        put(trial, "repetitions", RepetitionFacts(**row, metrics=metrics))
    for trial, row in rows("metrics", _METRIC, "trial, place"):
        row["more_is_better"] = bool(row["more_is_better"])
        put(trial, "metrics", MetricFacts(**row))
    for trial, row in rows("marks", _MARK, "trial, place"):
        put(trial, "marks", MarkFacts(**row))
    for trial, row in rows("workloads", SCALES, "trial"):
        for name in SCALES:
            put(trial, "workload", row[name])
    return found


def _trial(row: Tuple[Any, ...], parts: Dict[str, List[Any]], keys: Container[str]) -> TrialFacts:
    made: Dict[str, Any] = dict(zip(_TRIAL, row))
    made.update(valid=bool(made["valid"]), provisional=bool(made["provisional"]))
    if made["signer"] and made["signer"] not in keys:
        made["flaw"] = str(Signature(OTHER, made["signer"]))
    made.update({part: tuple(parts.get(part, ())) for part in _PARTS})
    return TrialFacts(**made)


def _reason(error: Exception) -> str:
    return getattr(error, "strerror", None) or str(error)
