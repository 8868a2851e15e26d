"""The command ``score``: sheets of recordings judged anew, and signatures of exams."""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any, Dict, List, Optional, Sequence

from ..exercises.exercise_file import ExerciseError, load_exercise
from ..exercises.model import EXAM
from ..judging.judge import Judge
from ..judging.sheet import sheet_text
from ..recording.reader import Recording, read_recording
from ..recording.sheet_table import sheet_csv
from ..recording.signature import VALID, verified
from ..recording.station_keys import StationKeyError, known_keys, read_public_key
from ..recording.trial_file import EXERCISE, SHEET, judged, signature_of
from ..recording.writer import Attachment, RecordingError

_TEXT, _JSON, _CSV = "text", "json", "csv"


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Run the command.

    Returns its exit status: 0, or 1 where a recording cannot be scored, or has no valid signature.
    """
    parser = _parser()
    given = parser.parse_args(arguments)
    if given.key is not None and not given.verify:
        parser.error("--key goes with --verify")
    if given.verify:
        return _verify(given.files, given.key)
    status = 0
    for path in given.files:
        try:
            recording = read_recording(path)
            if given.exercise is not None:
                recording = with_exercise(recording, given.exercise)
            judge = judged(recording)
        except (RecordingError, ExerciseError) as error:
            print(f"score: {error}", file=sys.stderr)
            status = 1
            continue
        print(_shown(recording, judge, given.form, given.exercise is not None), end="")
    return status


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="score", description=__doc__)
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE", help="a recording (.mcap)")
    forms = parser.add_mutually_exclusive_group()
    forms.add_argument(
        "--json", dest="form", action="store_const", const=_JSON, help="the sheet as it was shown"
    )
    forms.add_argument(
        "--csv", dest="form", action="store_const", const=_CSV, help="a row a repetition"
    )
    parser.add_argument(
        "--exercise",
        type=Path,
        metavar="FILE",
        help="judge by this exercise (other metrics, pass values) in place of the recorded one",
    )
    parser.add_argument(
        "--verify",
        action="store_true",
        help="check signatures of exams instead: of this station's and of trusted keys",
    )
    parser.add_argument(
        "--key", type=Path, metavar="PUBLIC", help="of this public key alone (telex_station.pub)"
    )
    parser.set_defaults(form=_TEXT)
    return parser


def _verify(files: Sequence[Path], key: Optional[Path]) -> int:
    try:
        keys = known_keys() if key is None else {read_public_key(key): key.name}
    except StationKeyError as error:
        print(f"score: --key: {error}", file=sys.stderr)
        return 1
    status = 0
    for path in files:
        try:
            found = signature_of(path, keys)
        except RecordingError as error:
            print(f"score: {error}", file=sys.stderr)
            status = 1
            continue
        print(f"{path}: {found}")
        if found.state != VALID:
            status = 1
    return status


def with_exercise(recording: Recording, path: Path) -> Recording:
    """Return a recording with another exercise in place of its own.

    Raises
    ------
    ExerciseError
    """
    text = load_exercise(path).text.encode()
    changed = {**recording.attachments, EXERCISE: Attachment("text/yaml", text)}
    return replace(recording, attachments=changed)


def _shown(recording: Recording, judge: Judge, form: str, other: bool) -> str:
    sheet = judge.sheet()
    if form == _JSON:
        return sheet_text(sheet)
    if form == _CSV:
        return sheet_csv(sheet)
    remarks = [] if recording.whole else ["cut off: scored as far as it goes"]
    shown = recording.attachments.get(SHEET)
    if shown is not None and not other:
        same = shown.data == sheet_text(sheet).encode()
        remarks.append("the same sheet as was shown" if same else "ANOTHER SHEET THAN WAS SHOWN")
    if sheet["mode"] == EXAM and not other:
        remarks.append(f"signature: {verified(recording, known_keys())}")
    if judge.workload is not None:
        remarks.append(f"workload {judge.workload['raw']:.0f} of 100 (raw NASA-TLX)")
    return sheet_report(sheet, f"{recording.path}", remarks)


def _line(setting: Dict[str, Any]) -> str:
    """Say what the line to the operator was set to, and when."""
    figures = {key: value for key, value in setting.items() if key not in ("time", "profile")}
    shown = ", ".join(f"{key} {value:g}" for key, value in sorted(figures.items()))
    return f"{setting['profile']} at {setting['time']:.1f} s" + (f": {shown}" if shown else "")


def _aid(aid: Dict[str, Any]) -> str:
    """Say which aid was on, for how long, and what it was."""
    kind = "training aid" if aid["training"] else "aid"
    robot = f", robot {aid['robot']}" if "robot" in aid else ""
    return f"{kind} on: {aid['text']}, {aid['seconds']:.1f} s{robot}"


def sheet_report(sheet: Dict[str, Any], name: str, remarks: Sequence[str]) -> str:
    """Write a sheet for people."""
    summary = sheet["summary"]
    # What did not count may have figures that would have passed.
    verdict = sheet["verdict"] or "no verdict" if sheet["valid"] else "invalid"
    done, tried = summary["completed"], summary["completed"] + summary["faults"]
    lines = [
        f"{name}: {'; '.join(remarks)}" if remarks else name,
        f"{sheet['exercise']['title']}, {sheet['exercise']['setting']}, "
        f"{sheet['operator'] or 'no name'}, {sheet['mode']}",
        f"{verdict.upper()}: {done} of {tried} repetitions"
        + _share(", proficiency", summary["proficiency"], sheet["expert"])
        + _bound(summary),
    ]
    lines += [f"  not valid: {reason}" for reason in sheet["invalid_because"]]
    lines += [f"  line {_line(setting)}" for setting in sheet.get("link", [])]
    lines += [f"  {_aid(aid)}" for aid in sheet.get("aids", [])]
    lines += [f"  {_metric(item)}" for item in sheet["metrics"]]
    for number, rep in enumerate(sheet["repetitions"], 1):
        fault = rep["fault"] or "completed"
        lines.append(
            f"  repetition {number}: {rep['seconds']:.1f} s + {rep['penalty']:g} s, {fault}"
        )
    for rep in sheet.get("practised", []):
        lines.append(
            f"  practice only, from '{rep['bookmark']}': {rep['seconds']:.1f} s, "
            f"{rep['fault'] or 'completed'}"
        )
    return "\n".join(lines) + "\n\n"


def _share(words: str, share: Optional[float], expert: Dict[str, Any]) -> str:
    if share is None:
        return ""
    provisional = " (provisional)" if expert["provisional"] else ""
    return f"{words} {100.0 * share:.0f} % of the expert{provisional}"


def _bound(summary: Dict[str, Any]) -> str:
    bound = summary["reliability"]
    if bound is None:
        return ""
    return (
        f", reliability at least {100.0 * bound:.0f} % ({100.0 * summary['confidence']:.0f} % sure)"
    )


def _metric(item: Dict[str, Any]) -> str:
    # Without a figure nothing is within a bound, but nothing was missed that anybody tried.
    measured = item["value"] is not None
    value = f"{item['value']:g} {item['unit']}".rstrip() if measured else "no figure"
    parts: List[str] = [f"{item['text']}: {value}"]
    if item["pass"] is not None:
        sign = ">=" if item["more_is_better"] else "<="
        found = f": {'ok' if item['within'] else 'MISSED'}" if measured else ""
        parts.append(f"{sign} {item['pass']:g}{found}")
    if item["expert"] is not None:
        parts.append(f"expert {item['expert'][0]:g}")
    return ", ".join(parts)
