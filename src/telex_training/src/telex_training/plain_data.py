"""What JSON can spell and nothing else can hold."""

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
