"""Files that take their names once they are complete."""

from __future__ import annotations

from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Iterator


@contextmanager
def draft_of(path: Path) -> Iterator[Path]:
    """Give the name of a draft, which becomes the file at the end; after an error, it goes."""
    draft = path.with_name(f".{path.name}.draft")
    try:
        yield draft
        draft.replace(path)
    finally:
        with suppress(OSError):
            draft.unlink()
