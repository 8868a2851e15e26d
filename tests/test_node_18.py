"""The page's tests run on Node 18, which Debian 12 has, as they do on newer ones."""

from __future__ import annotations

import json
import re
from pathlib import Path

TESTS = Path(__file__).resolve().parents[1] / "src/telex_teleop/test/javascript"


def test_what_is_imported_is_said_to_be_modules():
    # Newer versions find that out by themselves.
    imported = {
        (file.parent / name).resolve()
        for file in TESTS.glob("*.js")
        for name in re.findall(r'from "(\.[^"]+)"', file.read_text(encoding="utf-8"))
    }
    assert len(imported) > 20
    for file in sorted(imported):
        near = [each / "package.json" for each in file.parents if (each / "package.json").exists()]
        assert near, file
        assert json.loads(near[0].read_text(encoding="utf-8"))["type"] == "module", file


def test_timers_are_not_mocked_by_node():
    # The call that does it takes other arguments since Node 20.
    assert not [file.name for file in TESTS.glob("*.js") if "mock.timers" in file.read_text()]
