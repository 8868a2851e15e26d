"""``rosrun telex_sim scene pictures``: a small picture of each type of object, for lists."""

from __future__ import annotations

import argparse
import logging
import sys
import tempfile
from pathlib import Path
from typing import Optional, Sequence

import cv2
import numpy as np
import yaml

from telex_control.common.params import ConfigError

from ...engine.world import WorldError
from ...scene.files.scene_file import SceneError
from ...scene.library import types_by_name
from ..drawing.gl_context import NoContextError
from ..optics.pinhole import PinholeCamera
from .scene_preview import PreviewError, framed, photograph, settled
from .still import looking

SIZE = (112, 84)
"""Of a picture (pixels)."""
_JPEG_QUALITY = 80
_FLOOR = [0.22, 0.27, 0.32, 1.0]
"""Colour that what is white, of steel or black is seen on."""
_FOV, _WIDE = 0.6, 1.1
"""Full widths of view (rad): of what is large, from nearer, for there is haze."""
_LARGE = 6.0
"""Radius from which on something is large (m)."""
_NEAR, _FAR = 0.02, 300.0
_ROBOT_AT = -60.0
"""Where the robot starts along x, out of the picture (m)."""


def object_picture(kind: str, folder: Path) -> np.ndarray:
    """Draw an object as its type is by default.

    Parameters
    ----------
    kind
        Name of its type.
    folder
        For the file of a scene.

    Returns
    -------
    numpy.ndarray
        RGB, shape (height, width, 3), uint8.

    Raises
    ------
    SceneError, ConfigError, WorldError, NoContextError, PreviewError
    """
    path = folder / f"{kind}.yaml"
    floor = {"surface": {"color": _FLOOR, "texture": ""}}
    scene = {"floor": floor, "start": {"x": _ROBOT_AT}, "objects": [{"type": kind}]}
    path.write_text(yaml.safe_dump(scene), encoding="utf-8")
    subject = settled(str(path)).without_robot()
    width, height = SIZE
    view = framed(subject, _WIDE if subject.extent()[1] > _LARGE else _FOV, width / height)
    camera = PinholeCamera(width, height, view.fov, _NEAR, _FAR)
    return photograph(subject, camera, looking(view.eye, view.target))


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Run the command; returns the exit status."""
    parser = argparse.ArgumentParser(
        prog="scene pictures",
        description="Draw the pictures that lists show of the types of objects.",
    )
    parser.add_argument("folder", type=Path, help="for TYPE.jpg; made if absent")
    parser.add_argument("types", nargs="*", metavar="TYPE", help="default: all")
    options = parser.parse_args(arguments)
    known = types_by_name()
    unknown = [name for name in options.types if name not in known]
    if unknown:
        print(f"type is '{unknown[0]}'; there are: {', '.join(known)}", file=sys.stderr)
        return 1
    logging.getLogger("rosout").setLevel(logging.WARNING)
    quality = [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY]
    try:
        options.folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory() as folder:
            for name in options.types or known:
                path = options.folder / f"{name}.jpg"
                picture = object_picture(name, Path(folder))
                if not cv2.imwrite(str(path), picture[..., ::-1], quality):
                    raise PreviewError(f"{path}: it cannot be written")
                print(path)
    except (SceneError, ConfigError, WorldError, NoContextError, PreviewError, OSError) as error:
        print(error, file=sys.stderr)
        return 1
    return 0
