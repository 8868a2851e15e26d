"""What launch files may not say."""

from __future__ import annotations

import re
from pathlib import Path

FILES = sorted((Path(__file__).resolve().parents[1] / "src").glob("*/launch/*.launch"))


def test_programs_are_not_looked_for_within_quotes():
    """roslaunch takes the quote for a part of the path, and finds none of an install space."""
    assert FILES
    quoted = re.compile(r"'\$\(find \w+\)/nodes/")
    assert not [file.name for file in FILES if quoted.search(file.read_text())]
