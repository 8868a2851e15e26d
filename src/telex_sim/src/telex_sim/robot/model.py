"""``rosrun telex_sim robot_model FILE [xacro arguments]``: prints a robot's URDF for simulation.

The addresses of meshes and pictures may be relative to the file, as many URDFs have them; those
who get a robot_description do not know that file, so they are printed in full.
"""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from typing import List, Sequence
from urllib.parse import quote
from xml.etree import ElementTree

from telex_control.urdf.checks import check_links
from telex_control.urdf.model import UrdfError, read_xml, robot_of

_USAGE = "usage: robot_model FILE.urdf|FILE.xacro [xacro arguments, e.g. arm:=long or arm=long]"


def robot_model(path: Path, options: Sequence[str] = ()) -> str:
    """Return the URDF text of a URDF or xacro file.

    Parameters
    ----------
    options : sequence of str
        Arguments for xacro; NAME=VALUE is taken as well, since a roslaunch command line has no room
        for another ``:=`` in ``options:=``.

    Raises
    ------
    UrdfError
        The file cannot be read, or is no robot description.
    """
    try:
        root = read_xml(_text(path, options))
        check_links(robot_of(root))
    except (OSError, UnicodeDecodeError, UrdfError) as error:
        raise UrdfError(f"{path}: {error}") from error
    folder = path.resolve().parent
    for element in (*root.iter("mesh"), *root.iter("texture")):
        address = element.get("filename", "")
        if address and "://" not in address:
            element.set("filename", "file://" + quote(str(folder / address)))
    return ElementTree.tostring(root, encoding="unicode")


def _text(path: Path, options: Sequence[str]) -> str:
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".urdf" and not options:
        return text
    done = subprocess.run(
        ["xacro", str(path), *(re.sub(r"^(\w+)=", r"\1:=", each) for each in options)],
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        raise UrdfError(f"xacro: {_xacro_problem(done.stderr)}")
    return done.stdout


def _xacro_problem(said: str) -> str:
    """What xacro says, in one line where a macro or a file contains itself: it lists each level."""
    # It says twice, with the exception's class, what fails in a substitution such as $(find).
    said = re.sub(r"(?:error: )?<class '[\w.]+'>: (.+) \1", r"\1", said.strip())
    lines = said.splitlines()
    if not lines or "recursion" not in lines[0]:
        return said
    place = next((line.partition(": ")[2] for line in lines[1:] if ": " in line), "")
    return f"{place} contains itself, without end; a macro or file that does needs a condition"


def main(arguments: List[str]) -> int:
    """Print the URDF; returns the exit status."""
    # roslaunch adds remappings, which are no arguments for xacro.
    given = [each for each in arguments if not each.startswith("__")]
    if not given or given[0] in ("-h", "--help"):
        print(_USAGE, file=sys.stderr)
        return 2
    try:
        print(robot_model(Path(given[0]), given[1:]))
    except UrdfError as error:
        print(f"robot_model: {error}", file=sys.stderr)
        return 1
    return 0
