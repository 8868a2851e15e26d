"""Pictures of goals: the shipped previews, or drawn when they are first wanted, and kept."""

from __future__ import annotations

import hashlib
import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path

from telex_control.common.file_catalog import package_path

from ..exercises.exercise_file import ExerciseError
from ..exercises.model import PRACTICE, Exercise
from ..exercises.seeds import scene_text

_SIZE = "640x360"
_LONGEST = 25.0
"""Wall time that drawing may take (s); the video server waits for 30 s."""
_KEPT = 100


class GoalPictures:
    """Pictures of exercises in their settings, with zones and names.

    A picture shows the places of practice, never those of an exam, and other charts and pipes than
    a trial has.

    Parameters
    ----------
    folder : Path
        Where those are kept that had to be drawn; made when it is needed.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._package = Path(package_path("telex_training"))
        self._drawing = threading.Lock()

    def shipped(self, exercise: Path) -> str:
        """Name of the preview of an exercise's file without its suffix; empty: there is none."""
        folder = self._package / "exercises"
        picture = folder / "previews" / f"{exercise.stem}.jpg"
        return exercise.stem if exercise.parent == folder and picture.is_file() else ""

    def shipped_path(self, name: str) -> Path:
        """Path of a shipped preview by its name, whether it is there or not."""
        return self._package / "exercises" / "previews" / f"{name}.jpg"

    def picture(self, exercise: Exercise) -> Path:
        """Return the path of an exercise's picture; may take seconds.

        Raises
        ------
        ExerciseError
            It cannot be drawn or kept.
        """
        if exercise.setting == exercise.settings[0] and self.shipped(exercise.path):
            return self.shipped_path(exercise.path.stem)
        scene = scene_text(exercise, exercise.seeds.of(PRACTICE) or 0)
        told = f"{exercise.sha256} {exercise.setting} {scene}"
        path = self._folder / f"{hashlib.sha256(told.encode()).hexdigest()[:32]}.jpg"
        with self._drawing:
            if not path.is_file():
                self._draw(exercise, path)
        return path

    def _draw(self, exercise: Exercise, path: Path) -> None:
        # In a process of its own: what draws takes much memory, and a trial's judge must not wait.
        draft = path.with_name(f".{path.name}")
        command = [
            "nice",
            "-n",
            "10",
            sys.executable,
            str(self._package / "nodes" / "exercise"),
            "preview",
            str(exercise.path),
            f"--setting={exercise.setting}",
            f"--size={_SIZE}",
            f"--output={draft}",
        ]
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            done = subprocess.run(
                command, capture_output=True, text=True, check=False, timeout=_LONGEST
            )
            if done.returncode:
                said = done.stderr.strip().splitlines() or [f"status {done.returncode}"]
                raise ExerciseError(said[-1])
            draft.replace(path)
        except subprocess.TimeoutExpired:
            raise ExerciseError(
                f"{exercise.path}: its picture is not drawn within {_LONGEST:g} s"
            ) from None
        except OSError as error:
            raise ExerciseError(f"{path}: {error.strerror}") from error
        finally:
            with suppress(OSError):
                draft.unlink()
        self._forget_old()

    def _forget_old(self) -> None:
        kept = sorted(self._folder.glob("*.jpg"), key=lambda path: path.stat().st_mtime)
        for path in kept[:-_KEPT]:
            with suppress(OSError):
                path.unlink()
