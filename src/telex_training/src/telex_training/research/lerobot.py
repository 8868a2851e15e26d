"""Data sets as LeRobot reads them (its format v3.0): Parquet files, videos, and what they hold."""

from __future__ import annotations

import json
import shutil
from fractions import Fraction
from pathlib import Path
from typing import Any, Dict, Iterable, List, Mapping, Sequence

import numpy as np

from telex_sim.cameras.cameras_config import CameraConfig

from .command_vector import CommandVector, state_names
from .episodes import Episode

try:
    import av  # optional: requirements-lerobot.txt
    import pyarrow as pa
    import pyarrow.parquet as pq
except ImportError as error:
    MISSING = str(error)
else:
    MISSING = ""
"""Why no data set can be written here; empty: one can."""

VERSION = "v3.0"
ROBOT = "telex"
PICTURES = "observation.images."
_FILES_A_CHUNK = 1000
_FILE = "chunk-{chunk_index:03d}/file-{file_index:03d}"
_DATA = f"data/{_FILE}.parquet"
_VIDEO = f"videos/{{video_key}}/{_FILE}.mp4"
_EPISODES = f"meta/episodes/{_FILE}.parquet"
_TASKS = "meta/tasks.parquet"
_CODEC, _PIXELS = "libx264", "yuv420p"
_QUALITY = {"crf": "20", "g": "2", "preset": "veryfast"}
"""A key frame in every other picture: a policy's training reads them in any order."""
_QUANTILES = (0.01, 0.1, 0.5, 0.9, 0.99)
_SAMPLED = 8
"""Of pictures, every so many rows, columns and pictures count in their statistics."""
_NUMBERS = ("timestamp", "frame_index", "episode_index", "index", "task_index")

Stats = Dict[str, Dict[str, np.ndarray]]
Pictures = Mapping[str, np.ndarray]


class DataSet:
    """A data set that is being written; it has its name once it is finished.

    An episode has files of its own, which the format allows.

    Parameters
    ----------
    folder : Path
        Must not be there yet.
    rate : int
        Frames per second.
    vector : CommandVector
        What actions are.
    cameras : mapping of str to CameraConfig
        Of the videos, in their size.

    Raises
    ------
    OSError
        The folder is there already, or cannot be made.
    """

    def __init__(
        self,
        folder: Path,
        rate: int,
        vector: CommandVector,
        cameras: Mapping[str, CameraConfig],
    ) -> None:
        if folder.exists():
            raise FileExistsError(f"{folder}: it exists already; another name is needed")
        self._folder, self._rate = folder, rate
        self._draft = folder.with_name(f".{folder.name}.draft")
        shutil.rmtree(self._draft, ignore_errors=True)
        self._draft.mkdir(parents=True)
        self._features = _features(vector, cameras, rate)
        self._cameras = tuple(cameras)
        self._tasks: Dict[str, int] = {}
        self._rows: List[Dict[str, Any]] = []
        self._stats: List[Stats] = []
        self.frames = 0

    @property
    def episodes(self) -> int:
        """How many episodes there are."""
        return len(self._rows)

    def add(self, episode: Episode, pictures: Iterable[Pictures]) -> None:
        """Write an episode.

        Parameters
        ----------
        pictures : iterable of mapping of str to ndarray
            For each frame the picture of each camera: RGB, uint8.
        """
        number, count = len(self._rows), len(episode.states)
        chunk, file = divmod(number, _FILES_A_CHUNK)
        place = {"chunk_index": chunk, "file_index": file}
        task = self._tasks.setdefault(episode.task, len(self._tasks))
        columns = _columns(episode, self._rate, number, self.frames, task)
        self._write(_DATA.format(**place), _table(columns, self._features))
        stats = {name: _stats(values, self._features[name]) for name, values in columns.items()}
        row: Dict[str, Any] = {
            "episode_index": number,
            "tasks": [episode.task],
            "length": count,
            "data/chunk_index": chunk,
            "data/file_index": file,
            "dataset_from_index": self.frames,
            "dataset_to_index": self.frames + count,
            "meta/episodes/chunk_index": 0,
            "meta/episodes/file_index": 0,
        }
        for key, sampled in self._film(pictures, place).items():
            stats[key] = _picture_stats(sampled)
            row[f"videos/{key}/chunk_index"] = chunk
            row[f"videos/{key}/file_index"] = file
            row[f"videos/{key}/from_timestamp"] = 0.0
            row[f"videos/{key}/to_timestamp"] = count / self._rate
        for key, found in stats.items():
            row.update({f"stats/{key}/{kind}": value.tolist() for kind, value in found.items()})
        self._rows.append(row)
        self._stats.append(stats)
        self.frames += count

    def _film(self, pictures: Iterable[Pictures], place: Mapping[str, int]) -> Dict[str, Any]:
        """Write an episode's videos; returns samples of their pictures, by the videos' keys."""
        sampled: Dict[str, List[np.ndarray]] = {PICTURES + name: [] for name in self._cameras}
        films = {}
        try:
            for name in self._cameras:
                path = self._draft / _VIDEO.format(video_key=PICTURES + name, **place)
                path.parent.mkdir(parents=True, exist_ok=True)
                films[name] = _Film(path, self._rate)
            for number, shown in enumerate(pictures):
                for name, film in films.items():
                    film.show(shown[name])
                    if number % _SAMPLED == 0:
                        sampled[PICTURES + name].append(shown[name][::_SAMPLED, ::_SAMPLED])
        finally:
            for film in films.values():
                film.close()
        return sampled

    def finish(self) -> None:
        """Write what the files hold, and give the data set its name."""
        self._write(_EPISODES.format(chunk_index=0, file_index=0), pa.Table.from_pylist(self._rows))
        self._write(_TASKS, _tasks_table(self._tasks))
        self._write_json("stats.json", _plain(_merged(self._stats)))
        self._write_json(
            "info.json",
            {
                "codebase_version": VERSION,
                "robot_type": ROBOT,
                "total_episodes": len(self._rows),
                "total_frames": self.frames,
                "total_tasks": len(self._tasks),
                "chunks_size": _FILES_A_CHUNK,
                "data_files_size_in_mb": 100,
                "video_files_size_in_mb": 200,
                "fps": self._rate,
                "splits": {"train": f"0:{len(self._rows)}"},
                "data_path": _DATA,
                "video_path": _VIDEO if self._cameras else None,
                "features": self._features,
            },
        )
        self._draft.rename(self._folder)

    def discard(self) -> None:
        """Remove what was written of a data set that was not finished."""
        shutil.rmtree(self._draft, ignore_errors=True)

    def _write(self, name: str, table: Any) -> None:
        path = self._draft / name
        path.parent.mkdir(parents=True, exist_ok=True)
        pq.write_table(table, path, compression="snappy", use_dictionary=True)

    def _write_json(self, name: str, content: Any) -> None:
        text = json.dumps(content, indent=4, allow_nan=False)
        (self._draft / "meta" / name).write_text(f"{text}\n", encoding="utf-8")


class _Film:
    """A video that is being written."""

    def __init__(self, path: Path, rate: int) -> None:
        self._file = av.open(str(path), "w")
        self._stream: Any = self._file.add_stream(_CODEC, rate, options=_QUALITY)
        self._stream.pix_fmt = _PIXELS
        self._stream.time_base = Fraction(1, rate)

    def show(self, picture: np.ndarray) -> None:
        """Append a picture."""
        self._stream.height, self._stream.width = picture.shape[:2]
        frame = av.VideoFrame.from_ndarray(picture, "rgb24")
        self._file.mux(self._stream.encode(frame))

    def close(self) -> None:
        """End it."""
        self._file.mux(self._stream.encode(None))
        self._file.close()


def _features(
    vector: CommandVector, cameras: Mapping[str, CameraConfig], rate: int
) -> Dict[str, Dict[str, Any]]:
    """Return what a frame has."""
    states = state_names(vector.joints)
    found: Dict[str, Dict[str, Any]] = {
        "observation.state": _feature("float32", len(states), states),
        "action": _feature("float32", len(vector.names), vector.names),
        "next.reward": _feature("float32"),
        "next.done": _feature("bool"),
        "next.success": _feature("bool"),
    }
    for name, camera in cameras.items():
        found[PICTURES + name] = {
            "dtype": "video",
            "shape": [camera.height, camera.width, 3],
            "names": ["height", "width", "channels"],
            "info": {
                "video.height": camera.height,
                "video.width": camera.width,
                "video.codec": "h264",
                "video.pix_fmt": _PIXELS,
                "video.is_depth_map": False,
                "video.fps": rate,
                "video.channels": 3,
                "has_audio": False,
            },
        }
    for name in _NUMBERS:
        found[name] = _feature("float32" if name == "timestamp" else "int64")
    return found


def _feature(kind: str, count: int = 1, names: Sequence[str] = ()) -> Dict[str, Any]:
    return {"dtype": kind, "shape": [count], "names": list(names) or None}


def _columns(
    episode: Episode, rate: int, number: int, first: int, task: int
) -> Dict[str, np.ndarray]:
    """Return the numbers of all frames of an episode."""
    count = len(episode.states)
    frames = np.arange(count)
    last = frames == count - 1
    return {
        "observation.state": episode.states,
        "action": episode.actions,
        "next.reward": episode.rewards,
        "next.done": last,
        "next.success": last & episode.success,
        "timestamp": (frames / rate).astype(np.float32),
        "frame_index": frames,
        "episode_index": np.full(count, number),
        "index": first + frames,
        "task_index": np.full(count, task),
    }


def _table(columns: Mapping[str, np.ndarray], features: Mapping[str, Mapping[str, Any]]) -> Any:
    made = {}
    for name, values in columns.items():
        kind = pa.type_for_alias(features[name]["dtype"])
        if values.ndim == 2:
            kind = pa.list_(kind, values.shape[1])
            made[name] = pa.array(values.tolist(), kind)
        else:
            made[name] = pa.array(values, kind)
    return pa.table(made)


def _tasks_table(tasks: Mapping[str, int]) -> Any:
    """Return the tasks as pandas has a table whose index are the texts."""
    table = pa.table(
        {"task_index": pa.array(list(tasks.values()), pa.int64()), "task": list(tasks)}
    )

    def column(name: str, kind: str, numpy_kind: str) -> Dict[str, Any]:
        about = {"name": name, "field_name": name, "pandas_type": kind, "metadata": None}
        return {**about, "numpy_type": numpy_kind}

    about = {
        "index_columns": ["task"],
        "column_indexes": [],
        "columns": [column("task_index", "int64", "int64"), column("task", "unicode", "object")],
        "pandas_version": "2.0.0",
    }
    return table.replace_schema_metadata({"pandas": json.dumps(about)})


# --- statistics ----------------------------------------------------------------------------------


def _stats(values: np.ndarray, feature: Mapping[str, Any]) -> Dict[str, np.ndarray]:
    """Return the statistics of an episode's column, each of as many numbers as it has."""
    return _over_rows(
        values.astype(np.float64).reshape(len(values), *feature["shape"]), len(values)
    )


def _picture_stats(sampled: Sequence[np.ndarray]) -> Dict[str, np.ndarray]:
    """Return the statistics of pictures by colour, 0 to 1, each of the shape (3, 1, 1)."""
    pixels = np.concatenate([picture.reshape(-1, 3) for picture in sampled]) / 255.0
    found = _over_rows(pixels, len(sampled))
    return {
        kind: value if kind == "count" else value.reshape(3, 1, 1) for kind, value in found.items()
    }


def _over_rows(values: np.ndarray, count: int) -> Dict[str, np.ndarray]:
    quantiles = np.quantile(values, _QUANTILES, axis=0)
    return {
        "min": values.min(axis=0),
        "max": values.max(axis=0),
        "mean": values.mean(axis=0),
        "std": values.std(axis=0),
        "count": np.array([count]),
        **{f"q{round(100 * share):02d}": row for share, row in zip(_QUANTILES, quantiles)},
    }


def _merged(parts: Sequence[Stats]) -> Stats:
    """Return the statistics of all episodes; their quantiles are the mean of the episodes'."""
    return {key: _merged_column([part[key] for part in parts]) for key in parts[0]}


def _merged_column(parts: Sequence[Mapping[str, np.ndarray]]) -> Dict[str, np.ndarray]:
    counts = np.array([part["count"][0] for part in parts], dtype=np.float64)

    def mean(values: Sequence[np.ndarray]) -> np.ndarray:
        return np.tensordot(counts / counts.sum(), np.array(values), axes=1)

    middle = mean([part["mean"] for part in parts])
    spread = mean([part["std"] ** 2 + (part["mean"] - middle) ** 2 for part in parts])
    return {
        "min": np.min([part["min"] for part in parts], axis=0),
        "max": np.max([part["max"] for part in parts], axis=0),
        "mean": middle,
        "std": np.sqrt(spread),
        "count": np.array([int(counts.sum())]),
        **{kind: mean([part[kind] for part in parts]) for kind in parts[0] if kind[0] == "q"},
    }


def _plain(stats: Stats) -> Dict[str, Dict[str, Any]]:
    return {key: {kind: v.tolist() for kind, v in found.items()} for key, found in stats.items()}
