"""Attachments of a recording, and the sheet that its entries make."""

from __future__ import annotations

import json
import re
from dataclasses import asdict, dataclass
from io import BytesIO
from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional, Tuple

from mcap.reader import make_reader
from std_msgs.msg import String

from telex_control.common.params import ConfigError, read_struct

from ..exercises.exercise_file import ExerciseError, parse_exercise
from ..exercises.model import Exercise
from ..judging.entries import INPUTS, Entry, json_of
from ..judging.judge import Judge
from ..judging.sheet import is_sheet, sheet_text
from ..judging.workload import INPUT as TLX
from ..judging.workload import workload_of
from ..plain_data import is_text
from .reader import Recording, read_recording
from .signature import CHANGED, Signature, verified
from .writer import Attachment, RecordingError

EXERCISE, SCENE, ROBOT = "exercise.yaml", "scene.yaml", "robot.urdf"
CAMERAS, MESHES, TRIAL, SHEET = "cameras.json", "meshes.json", "trial.json", "sheet.json"
SUFFIX = ".mcap"
FOLDER = "~/.ros/telex_training"
"""Of the recordings, where nobody says otherwise."""
EXPERTS = "experts"
"""Folder beside people's recordings with those of experts."""
NAMELESS = "nobody"
"""How a name is spelt that has no letter which a trial's name can have."""
_YAML, _XML, _JSON = "text/yaml", "text/xml", "application/json"
_UNSAFE = re.compile(r"[^A-Za-z0-9_-]+")


@dataclass(frozen=True)
class Trial:
    """Of what and whom a recording is.

    Attributes
    ----------
    trial : str
        Its name, which is that of the file without its suffix.
    exercise : str
        Path of the exercise's file when the trial began.
    """

    trial: str
    exercise: str
    setting: str
    mode: str
    operator: str
    software: str
    seed: int


def safe_name(name: str) -> str:
    """Spell a name, of a person or an exercise, as a trial's name and its file's can have it."""
    return _UNSAFE.sub("-", name).strip("-") or NAMELESS


def expert_path(folder: Path, exercise: str, setting: str) -> Path:
    """Where the recording of an expert's run stands, or would; `folder` has people's."""
    return folder / EXPERTS / f"{safe_name(exercise)}_{safe_name(setting)}{SUFFIX}"


def attachments(
    trial: Trial,
    exercise: str,
    scene: str,
    urdf: str,
    cameras: Mapping[str, Any],
    meshes: Mapping[str, str],
    urdfs: Optional[Mapping[str, str]] = None,
) -> Dict[str, Attachment]:
    """Attachments of a recording that begins.

    Parameters
    ----------
    exercise, scene, urdf : str
        Texts of the exercise's file, of the scene as it was loaded, and of the robot.
    cameras : mapping
        The cameras' configuration.
    meshes : mapping of str to str
        SHA-256 of each mesh file, by its address.
    urdfs : mapping of str to str, optional
        Texts of further robots, by the exercise's names.
    """
    further = {
        urdf_of(name): Attachment(_XML, text.encode()) for name, text in (urdfs or {}).items()
    }
    return {
        TRIAL: Attachment(_JSON, _json(asdict(trial))),
        EXERCISE: Attachment(_YAML, exercise.encode()),
        SCENE: Attachment(_YAML, scene.encode()),
        ROBOT: Attachment(_XML, urdf.encode()),
        CAMERAS: Attachment(_JSON, _json(cameras)),
        MESHES: Attachment(_JSON, _json(meshes)),
        **further,
    }


def urdf_of(robot: str) -> str:
    """Name of the attachment with a further robot's URDF."""
    return f"robots/{robot}.urdf"


def input_entry(number: int, time_ns: int, content: Mapping[str, Any]) -> Entry:
    """Entry of one of the training's own inputs."""
    return Entry(number, time_ns / 1e9, INPUTS, "std_msgs/String", serialised_input(content))


def serialised_input(content: Mapping[str, Any]) -> bytes:
    """Serialise one of the training's own inputs: JSON in a std_msgs/String."""
    file = BytesIO()
    String(json.dumps(content, sort_keys=True, allow_nan=False)).serialize(file)
    return file.getvalue()


def sheet_attachment(text: str) -> Attachment:
    """Attachment of a score sheet's text."""
    return Attachment(_JSON, text.encode())


def trial_of(recording: Recording) -> Tuple[Trial, Exercise]:
    """Of what a recording is.

    Raises
    ------
    RecordingError
        An attachment is missing or wrong.
    """
    path = recording.path
    try:
        trial = read_struct(Trial, json.loads(attached_text(recording, TRIAL)))
        file = parse_exercise(attached_text(recording, EXERCISE), Path(trial.exercise))
        return trial, file.setting(trial.setting)
    except (ConfigError, ExerciseError, ValueError, RecursionError) as error:
        raise RecordingError(f"{path}: {error}") from error


def judge_of(recording: Recording) -> Judge:
    """Make the judge of a recording, who has heard nothing of it yet.

    Raises
    ------
    RecordingError
        The recording does not say of what it is.
    """
    _, exercise = trial_of(recording)
    further = {each.name: attached_text(recording, urdf_of(each.name)) for each in exercise.robots}
    scene, robot = attached_text(recording, SCENE), attached_text(recording, ROBOT)
    try:
        return Judge(exercise, scene, robot, further)
    except ValueError as error:  # of the exercise, the scene or the URDF
        raise RecordingError(f"{recording.path}: {error}") from error


def judged(recording: Recording) -> Judge:
    """Fold a recording's entries anew.

    Raises
    ------
    RecordingError
        The recording does not say of what it is.
    """
    judge = judge_of(recording)
    for entry in recording.entries:
        judge.feed(entry)
    return judge


def read_sheet(path: Path) -> Optional[Dict[str, Any]]:
    """Read the sheet that a closed recording ends with; None: there is none.

    Nor is there where something is missing of it, or where it could not be sent as JSON.
    """
    try:
        made: Dict[str, Any] = json.loads(_indexed_sheet(path) or b"null")
        if is_sheet(made):
            sheet_text(made).encode()
            return made
    except (ValueError, RecursionError):
        return None
    return None


def _indexed_sheet(path: Path) -> Optional[bytes]:
    """Bytes of the sheet that a file's index leads to; None: to none."""
    try:
        with path.open("rb") as file:
            for attachment in make_reader(file).iter_attachments():
                if attachment.name == SHEET:
                    return bytes(attachment.data)
    except Exception:  # damaged bytes raise whatever they lead the reader to
        return None
    return None


def signature_of(path: Path, keys: Mapping[str, str]) -> Signature:
    """Check the signature of a recording's file.

    Parameters
    ----------
    keys : mapping of str to str
        See `verified`.

    Raises
    ------
    RecordingError
        It cannot be read.
    """
    recording = read_recording(path)
    found = verified(recording, keys)
    # What shows sheets finds them by the file's index, which must not lead elsewhere.
    if found.key and _indexed_sheet(path) != attached_text(recording, SHEET).encode():
        return Signature(CHANGED, reason=f"its index leads to another '{SHEET}'")
    return found


def read_workload(path: Path) -> Optional[Dict[str, Any]]:
    """Read the operator's ratings of a trial, see `workload_of`; None: there are none."""
    found = None
    try:
        with path.open("rb") as file:
            for schema, _, message in make_reader(file).iter_messages(topics=[INPUTS]):
                kind = "" if schema is None else schema.name
                content = json_of(Entry(message.sequence, 0.0, INPUTS, kind, message.data))
                if content.get("input") == TLX:
                    found = workload_of(content.get("values"))
    except Exception:  # damaged bytes raise whatever they lead the reader to
        return None
    return found


def trials(folder: Path) -> List[Path]:
    """Recordings of a folder, the newest last; those whose name is no UTF-8 are none."""
    found = (path for path in folder.glob(f"*{SUFFIX}") if not path.name.startswith("."))
    return sorted(path for path in found if is_text(path.name))


def attached_text(recording: Recording, name: str) -> str:
    """Return the text of an attachment.

    Raises
    ------
    RecordingError
        It is not there, or no UTF-8.
    """
    found = recording.attachments.get(name)
    if found is None:
        raise RecordingError(f"{recording.path}: it has no attachment '{name}'")
    try:
        return found.data.decode()
    except UnicodeDecodeError:
        raise RecordingError(f"{recording.path}: '{name}' is no UTF-8 text") from None


def _json(content: Mapping[str, Any]) -> bytes:
    return (json.dumps(content, sort_keys=True, indent=1) + "\n").encode()
