"""Folders of the workspace that an experiment takes files from."""

from __future__ import annotations

from pathlib import Path

ROOT = Path(__file__).resolve().parents[4]
"""The checkout."""

SCENES = Path(__file__).resolve().parents[2] / "scenes"
"""Scenes of the experiments alone."""
