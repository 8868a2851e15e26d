"""Checks of plain data that came as JSON, or as the name of a file."""

from __future__ import annotations

import json
from typing import Any


def require_text(content: Any) -> None:
    """Refuse plain data in which a text is none: JSON can spell half a surrogate pair.

    Raises
    ------
    ValueError
        Such a text could be neither stored nor sent.
    """
    json.dumps(content, ensure_ascii=False).encode()


def is_text(text: str) -> bool:
    """Whether a text is one; see `require_text`."""
    try:
        require_text(text)
    except ValueError:
        return False
    return True
