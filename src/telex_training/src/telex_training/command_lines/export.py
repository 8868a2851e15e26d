"""The command ``export``: recordings as rosbag files, as tables, or as a data set."""

from __future__ import annotations

import argparse
import csv
import sys
from pathlib import Path
from typing import Any, Callable, Iterator, List, Optional, Sequence

import genpy
import rosbag

from ..judging.entries import NAMES, TRUTH, BadEntryError, decode
from ..judging.truth import read_sample
from ..recording.reader import Recording, read_recording
from ..recording.writer import RecordingError
from .drafts import draft_of

_LATEST = 2.0**32
"""Seconds that a time of ROS can have."""


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Run the command; returns its exit status: 0, or 1 where a recording cannot be exported."""
    parser = argparse.ArgumentParser(prog="export", description=__doc__)
    parser.add_argument("files", type=Path, metavar="FILE", nargs="+", help="a recording (.mcap)")
    forms = parser.add_mutually_exclusive_group(required=True)
    forms.add_argument(
        "--bag", action="store_true", help="FILE.bag, for rosbag, rqt_bag and others"
    )
    forms.add_argument("--csv", action="store_true", help="FILE.csv, a row a sample of the truth")
    forms.add_argument(
        "--lerobot", type=Path, metavar="FOLDER", help="a data set of LeRobot, of all files"
    )
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FILE", help="in place of that name, of a single file"
    )
    sets = parser.add_argument_group("data sets")
    sets.add_argument(
        "--cameras", default="front", metavar="NAMES", help="with commas between (front); '': none"
    )
    sets.add_argument("--width", type=int, default=320, help="of the pictures, pixels (320)")
    sets.add_argument("--rate", type=int, default=10, help="frames per second (10)")
    sets.add_argument("--completed", action="store_true", help="completed repetitions alone")
    given = parser.parse_args(arguments)
    if given.output and (given.lerobot or len(given.files) > 1):
        parser.error("-o is for a single file, and for --bag or --csv")
    try:
        if given.lerobot:
            # Libraries that nothing else needs are imported then.
            from ..research.data_set import write_data_set

            names = [name for name in given.cameras.split(",") if name]
            print(
                write_data_set(
                    given.lerobot, given.files, names, given.width, given.rate, given.completed
                )
            )
            return 0
        for file in given.files:
            output = given.output or file.with_suffix(".bag" if given.bag else ".csv")
            _export(file, output, given.bag)
    except (RecordingError, OSError) as error:
        print(f"export: {error}", file=sys.stderr)
        return 1
    return 0


def _export(file: Path, output: Path, bag: bool) -> None:
    recording = read_recording(file)
    if output.exists():
        raise RecordingError(f"{output}: it exists already; another name is needed (-o)")
    write: Callable[[Recording, Path], int] = write_bag if bag else write_csv
    with draft_of(output) as draft:
        count = write(recording, draft)
    print(f"{output}: {count} {'messages' if bag else 'samples'}")


def write_bag(recording: Recording, path: Path) -> int:
    """Write all messages of a recording to a bag, at their sim times; returns how many.

    What has a type that this workspace does not know is left out.

    Raises
    ------
    RecordingError
        A message has a time that a bag cannot have.
    """
    for entry in recording.entries:
        if not 0.0 <= entry.time < _LATEST:
            raise RecordingError(
                f"{recording.path}: entry {entry.number} is of {entry.time:g} s; a bag takes times"
                f" below {_LATEST:g} s"
            )
    count = 0
    with rosbag.Bag(str(path), "w", compression="lz4") as bag:
        for entry in recording.entries:
            known = genpy.message.get_message_class(entry.kind)
            if known is None:
                continue
            raw = (entry.kind, entry.data, known._md5sum, known)
            # A bag takes no time 0.
            stamp = genpy.Time.from_sec(max(entry.time, 1e-9))
            bag.write(entry.channel, raw, stamp, raw=True)
            count += 1
    return count


def write_csv(recording: Recording, path: Path) -> int:
    """Write the truth of a recording as a table: times, base, joints, mechanisms, margin, held.

    Returns
    -------
    int
        Rows.
    """
    count = 0
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        for row in _rows(recording):
            writer.writerow(row)
            count += 1
    return max(0, count - 1)


def _rows(recording: Recording) -> Iterator[List[Any]]:
    """Heading and rows; of the names that come first, as long as they fit."""
    names: Any = None
    objects: List[str] = []
    for entry in recording.entries:
        try:
            if entry.channel == NAMES:
                newest = decode(entry, "telex_msgs/TruthNames")
                objects = newest.objects
                if names is None:
                    names = newest
                    yield _heading(names)
            elif entry.channel == TRUTH and names is not None:
                sample = read_sample(entry.data)
                if len(sample.joints) != len(names.joints):
                    continue
                held = objects[sample.held] if 0 <= sample.held < len(objects) else ""
                position, orientation = sample.base
                fits = len(sample.mechanisms) == len(names.mechanisms)
                mechanisms = sample.mechanisms if fits else [""] * len(names.mechanisms)
                yield [
                    f"{sample.time:.3f}",
                    f"{sample.wall_time:.3f}",
                    *position,
                    *orientation,
                    *sample.twist,
                    *sample.joints,
                    *mechanisms,
                    sample.margin,
                    held,
                    sample.grip,
                ]
        except BadEntryError:
            continue


def _heading(names: Any) -> List[str]:
    axes = ("x", "y", "z")
    return [
        "time",
        "wall_time",
        *axes,
        "qx",
        "qy",
        "qz",
        "qw",
        *(f"v{axis}" for axis in axes),
        *(f"w{axis}" for axis in axes),
        *names.joints,
        *names.mechanisms,
        "margin",
        "held",
        "grip",
    ]
