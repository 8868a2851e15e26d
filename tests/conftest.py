"""Puts what the tests share on the path: `mobility`, the scripted operators."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
