"""Facts of a trial as its recording's sheet has them, checked: the index is made of them."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional, Tuple

from mcap.reader import make_reader

from telex_control.common.params import ConfigError, read_struct, read_value, require

from ..exercises.metric_kinds import DIGITS, KINDS
from ..exercises.model import EXAM
from ..judging.sheet import FORMAT, MOST_SECONDS, PASSED, sheet_text
from ..judging.stats import raw_tlx
from ..plain_data import require_text
from ..recording.reader import read_recording
from ..recording.signature import VALID
from ..recording.trial_file import SHEET, SUFFIX, judged, read_workload, signature_of
from ..recording.writer import PROFILE, RecordingError

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,199}")
_MOST_REPETITIONS = 10_000
_MOST_BEGAN = 2.0**32
"""Sim time (s) at which a repetition can begin: what a ROS time can be."""
_MOST_FIGURE = 1e12
"""Figure of a metric, in whatever unit."""


@dataclass(frozen=True)
class RepetitionFacts:
    """A repetition that has ended.

    Attributes
    ----------
    began, seconds, penalty : float
        Sim time of its beginning, its time, and what penalties add (s).
    fault : str
        Empty: none.
    passed : bool
        Completed, with every metric within its bound.
    metrics : dict of str to float or None
        None: it could not be measured.
    """

    began: float
    seconds: float
    penalty: float
    fault: str
    completed: bool
    passed: bool
    metrics: Dict[str, Optional[float]]

    @property
    def time(self) -> float:
        """With its penalties (s)."""
        return self.seconds + self.penalty


@dataclass(frozen=True)
class MetricFacts:
    """A metric of the exercise, and what the trial made of it.

    Attributes
    ----------
    value, bound, expert : float or None
        Of the trial, to pass, and the expert's mean.
    """

    name: str
    kind: str
    unit: str
    text: str
    more_is_better: bool
    value: Optional[float]
    bound: Optional[float]
    expert: Optional[float]

    @property
    def of_trial(self) -> bool:
        """Whether it is of the whole trial, not of each repetition."""
        return self.kind in KINDS and KINDS[self.kind].of_trial


@dataclass(frozen=True)
class MarkFacts:
    """An instructor's mark, which stands beside the verdict.

    Attributes
    ----------
    verdict : str
        ``passed`` or ``failed``.
    """

    verdict: str
    reason: str
    by: str


@dataclass(frozen=True)
class TrialFacts:
    """A trial that has ended.

    Attributes
    ----------
    trial : str
        By which trials are told apart: its name.
    began_ns : int
        Wall time of its first entry (ns since the epoch).
    seconds : float
        Its length in sim time (s).
    verdict : str
        ``passed``, ``failed``, or empty: none.
    provisional : bool
        Whether the expert's figures are a script's.
    log : str
        SHA-256 over the recorded entries.
    signer : str
        Public key whose signature is over just this recording of an exam; empty: none.
    flaw : str
        Why an exam has no signature that counts; empty for others.
    marks : tuple of MarkFacts
        The last one counts.
    workload : tuple of float
        The operator's six ratings, see `telex_training.judging.workload`; empty: none.
    """

    trial: str
    began_ns: int
    operator: str
    exercise: str
    title: str
    setting: str
    mode: str
    software: str
    ended: str
    seed: Optional[int]
    seconds: float
    valid: bool
    verdict: str
    provisional: bool
    log: str
    signer: str
    flaw: str
    repetitions: Tuple[RepetitionFacts, ...]
    metrics: Tuple[MetricFacts, ...]
    marks: Tuple[MarkFacts, ...] = ()
    workload: Tuple[float, ...] = ()

    @property
    def raw_workload(self) -> Optional[float]:
        """Mean of the ratings, of 100; None: there are none."""
        return raw_tlx(self.workload) if self.workload else None

    @property
    def began(self) -> float:
        """Wall time of its beginning (s since the epoch)."""
        return self.began_ns / 1e9

    @property
    def passed(self) -> bool:
        """Whether it is valid and its verdict is passed."""
        return self.valid and self.verdict == PASSED

    @property
    def in_exam(self) -> bool:
        """Whether it is an exam: without a valid signature it is none."""
        return self.mode == EXAM and not self.flaw

    @property
    def signature(self) -> str:
        """Whether an exam's signature is valid, or what is wrong with it; empty for others."""
        return (self.flaw or VALID) if self.mode == EXAM else ""

    @property
    def faults(self) -> int:
        """Repetitions that were not completed."""
        return sum(not repetition.completed for repetition in self.repetitions)


def read_trial(path: Path, verify: bool = False) -> TrialFacts:
    """Read what the index keeps of a recording.

    Parameters
    ----------
    verify : bool
        Whether to judge the recording anew, too: its sheet has to be the one that comes of it.

    Raises
    ------
    RecordingError
        It is damaged, not closed, no trial, or not judged like this; the message names file and
        reason.
    """
    began, text = _first_and_sheet(path)
    try:
        sheet = json.loads(text)
        require_text(sheet)
        facts = _facts(sheet, began, read_workload(path))
    except (ConfigError, ValueError, RecursionError) as error:
        raise RecordingError(f"{path}: its {SHEET} is wrong: {error}") from error
    if verify and sheet_text(judged(read_recording(path)).sheet()).encode() != text:
        raise RecordingError(
            f"{path}: judged anew, it makes another sheet than its {SHEET}; it was changed, or "
            "made by another version of the software"
        )
    if facts.mode != EXAM:
        return facts
    # Whose key counts may change; whose it is does not.
    found = signature_of(path, {})
    return replace(facts, signer=found.key, flaw="" if found.key else str(found))


def _first_and_sheet(path: Path) -> Tuple[int, bytes]:
    """Wall time of the first entry (ns), and the sheet; without reading what is between."""
    try:
        with path.open("rb") as file:
            reader = make_reader(file, validate_crcs=True)
            if reader.get_header().profile != PROFILE:
                raise ValueError(f"its profile is no {PROFILE}")
            sheets = [each.data for each in reader.iter_attachments() if each.name == SHEET]
            first = next(iter(reader.iter_messages(log_time_order=False)), None)
    except OSError as error:
        raise RecordingError(f"{path}: {error.strerror}") from error
    except Exception as error:  # damaged bytes raise whatever they lead the reader to
        raise RecordingError(
            f"{path}: it is damaged, was cut off, or is still written ({error}); "
            "rosrun telex_training score shows what can be read of it"
        ) from error
    if not sheets or first is None:
        raise RecordingError(f"{path}: it has no {SHEET}; the trial in it was not ended")
    return first[2].publish_time, sheets[-1]


def _facts(sheet: Any, began_ns: int, workload: Optional[Mapping[str, Any]]) -> TrialFacts:
    require(isinstance(sheet, Mapping), "a struct is needed")
    form = sheet.get("format")
    require(form == FORMAT, f"format is {str(form)[:40]}; {FORMAT} is read")
    trial = _text(sheet, "trial")
    require(
        bool(_NAME.fullmatch(trial)),
        f"trial is {trial[:60]!r}; letters, digits, _ and - are possible",
    )
    seed = _at(sheet, "exercise/seed")
    require(began_ns < 2**63, f"the first entry's time is {began_ns} ns; at most 2^63 is possible")
    return TrialFacts(
        trial=trial,
        began_ns=began_ns,
        operator=_text(sheet, "operator"),
        exercise=_text(sheet, "exercise/name"),
        title=_text(sheet, "exercise/title"),
        setting=_text(sheet, "exercise/setting"),
        mode=_text(sheet, "mode"),
        software=_text(sheet, "software"),
        ended=_text(sheet, "ended"),
        seed=seed if isinstance(seed, int) and abs(seed) < 2**63 else None,
        seconds=read_value(float, _at(sheet, "trial_seconds"), "trial_seconds"),
        valid=read_value(bool, _at(sheet, "valid"), "valid"),
        verdict=_text(sheet, "verdict"),
        provisional=read_value(bool, _at(sheet, "expert/provisional"), "expert/provisional"),
        log=_text(sheet, "log/sha256"),
        signer="",
        flaw="",
        repetitions=tuple(
            _repetition(given, f"repetitions[{i}]")
            for i, given in enumerate(_list(sheet, "repetitions"))
        ),
        metrics=tuple(
            _metric(given, f"metrics[{i}]") for i, given in enumerate(_list(sheet, "metrics"))
        ),
        marks=tuple(_mark(given, f"marks[{i}]") for i, given in enumerate(_list(sheet, "marks"))),
        workload=() if workload is None else tuple(workload["ratings"]),
    )


def _repetition(given: Any, where: str) -> RepetitionFacts:
    keys = ("began", "seconds", "penalty", "completed", "passed", "metrics")
    fields = {key: _at(given, key, where) for key in keys}
    fault = _at(given, "fault", where)
    made = read_struct(RepetitionFacts, {**fields, "fault": "" if fault is None else fault}, where)
    return replace(
        made,
        began=_bounded(made.began, _MOST_BEGAN, f"{where}/began"),
        seconds=_bounded(made.seconds, MOST_SECONDS, f"{where}/seconds"),
        penalty=_bounded(made.penalty, MOST_SECONDS, f"{where}/penalty"),
        metrics={
            name: _figure(value, f"{where}/metrics/{name}") for name, value in made.metrics.items()
        },
    )


def _bounded(value: float, most: float, name: str) -> float:
    """Return a number with the digits that sheets have.

    Below 0 is what a simulator that began anew has left of an invalid trial.
    """
    require(abs(value) <= most, f"{name} is {value:g}; at most {most:g} is possible")
    return round(value, DIGITS)


def _figure(value: Optional[float], name: str) -> Optional[float]:
    return None if value is None else _bounded(value, _MOST_FIGURE, name)


def _metric(given: Any, where: str) -> MetricFacts:
    keys = ("name", "kind", "unit", "text", "more_is_better", "value")
    fields = {key: _at(given, key, where) for key in keys}
    expert = _at(given, "expert", where)
    if expert is not None:
        expert = read_value(List[float], expert, f"{where}/expert")
    fields["bound"] = _at(given, "pass", where)
    fields["expert"] = expert[0] if expert else None
    made = read_struct(MetricFacts, fields, where)
    return replace(
        made,
        value=_figure(made.value, f"{where}/value"),
        bound=_figure(made.bound, f"{where}/pass"),
        expert=_figure(made.expert, f"{where}/expert"),
    )


def _mark(given: Any, where: str) -> MarkFacts:
    keys = ("verdict", "reason", "by")
    return read_struct(MarkFacts, {key: _at(given, key, where) for key in keys}, where)


def _at(content: Any, keys: str, where: str = "") -> Any:
    """Value under keys that are joined by slashes."""
    for key in keys.split("/"):
        inside = f"{where}/" if where else ""
        require(isinstance(content, Mapping), f"{where or 'it'}: a struct is needed")
        require(key in content, f"{inside}{key} is missing")
        content, where = content[key], f"{inside}{key}"
    return content


def _text(content: Any, keys: str) -> str:
    return str(read_value(str, _at(content, keys), keys))


def _list(content: Any, key: str) -> List[Any]:
    given = _at(content, key)
    fits = isinstance(given, list) and len(given) <= _MOST_REPETITIONS
    require(fits, f"{key}: a list of at most {_MOST_REPETITIONS} structs is needed")
    return list(given)


def file_of(folder: Path, trial: str) -> Path:
    """Path of a trial's recording."""
    return folder / f"{trial}{SUFFIX}"
