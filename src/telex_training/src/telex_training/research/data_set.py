"""Recordings as one data set of LeRobot."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Dict, Mapping, Optional, Sequence, Tuple

from telex_control.common.params import ConfigError
from telex_sim.cameras.cameras_config import CameraConfig, shipped_params
from telex_sim.cameras.drawing.gl_context import NoContextError
from telex_sim.cameras.preview.still_cameras import sized

from ..recording.reader import read_recording
from ..recording.writer import RecordingError
from ..replay.replay import Replay
from .command_vector import CommandVector
from .episodes import episodes
from .lerobot import MISSING, DataSet
from .redrawing import redrawn, replay_cameras

_RATES = (1, 50)
"""Frames per second: the truth has no more."""


def require_even_sides(cameras: Mapping[str, CameraConfig], width: int) -> None:
    """Refuse pictures with an odd side: H.264 in YUV 4:2:0 has two pixels of each to a colour.

    Raises
    ------
    ConfigError
    """
    for name, camera in cameras.items():
        if camera.width % 2 or camera.height % 2:
            raise ConfigError(
                f"width is {width}, which makes '{name}' {camera.width} x {camera.height};"
                " one that makes both even is needed, as 160 or 320"
            )


def _sizes(cameras: Mapping[str, CameraConfig]) -> Dict[str, Tuple[int, int]]:
    return {name: (camera.width, camera.height) for name, camera in cameras.items()}


def write_data_set(
    folder: Path,
    files: Sequence[Path],
    cameras: Sequence[str],
    width: int,
    rate: int,
    completed: bool,
) -> str:
    """Write all repetitions of recordings as episodes of a data set; says in words what it has.

    Names of people are in none of its files.

    Parameters
    ----------
    folder : Path
        Of the data set.
    width : int
        Of the pictures (pixels).
    rate : int
        Frames per second of sim time.
    completed : bool
        Whether only completed repetitions count.

    Raises
    ------
    RecordingError
        An argument is wrong, a recording cannot be read or does not go with the others, none has a
        repetition, or the libraries are missing.
    OSError
    """
    if MISSING:
        raise RecordingError(
            f"--lerobot needs pyarrow and av ({MISSING}): pip install -r requirements-lerobot.txt"
        )
    if not _RATES[0] <= rate <= _RATES[1]:
        raise RecordingError(f"rate is {rate}; {_RATES[0]} to {_RATES[1]} 1/s is possible")
    written: Optional[DataSet] = None
    first: Tuple[Tuple[str, ...], Tuple[str, ...]] = ((), ())
    sizes: Dict[str, Tuple[int, int]] = {}
    try:
        for path in files:
            recording = read_recording(path)
            replay = Replay(recording, shipped_params())
            vector = CommandVector(replay.urdf)
            used = sized(replay_cameras(replay), cameras, width)
            require_even_sides(used, width)
            if written is None:
                written = DataSet(folder, rate, vector, used)
                first, sizes = (vector.names, vector.joints), _sizes(used)
            if first != (vector.names, vector.joints):
                raise RecordingError(f"{path}: its robot has other joints than that of {files[0]}")
            for name, (across, down) in _sizes(used).items():
                if (across, down) != sizes[name]:
                    raise RecordingError(
                        f"{path}: its camera '{name}' makes {across} x {down}, "
                        f"{' x '.join(map(str, sizes[name]))} that of {files[0]}"
                    )
            for episode in episodes(recording, replay, vector, rate):
                if episode.success or not completed:
                    written.add(episode, redrawn(replay, episode.moments, cameras, width))
                    print(f"{path.name}: {len(episode.moments)} frames", file=sys.stderr)
        if written is None or not written.episodes:
            raise RecordingError(f"{', '.join(map(str, files))}: no repetition to export")
        written.finish()
    except (ConfigError, NoContextError, ValueError) as error:
        raise RecordingError(str(error)) from error
    finally:
        if written is not None:
            written.discard()
    return f"{folder}: {written.episodes} episodes, {written.frames} frames"
