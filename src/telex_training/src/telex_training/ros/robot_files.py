"""Robot and software as a recording keeps them, so that it can be drawn again."""

from __future__ import annotations

import hashlib
import subprocess
from functools import lru_cache
from pathlib import Path
from typing import Any, Dict, Mapping
from xml.etree import ElementTree

import rospkg
import rospy

from telex_control.common.file_catalog import package_path
from telex_sim.scene.addresses import AddressError, resolve_address

_UNKNOWN = "unknown"


def about_robot(others: Mapping[str, str]) -> Dict[str, Any]:
    """Return ``urdf``, ``cameras`` and ``meshes`` of the robot in this namespace.

    Parameters
    ----------
    others : mapping of str to str
        Namespaces of further robots, by the exercise's names, of which there are ``urdfs``.
    """
    urdf = str(rospy.get_param("robot_description", ""))
    cameras = rospy.get_param("cameras", {})
    return {
        "urdf": urdf,
        "cameras": cameras if isinstance(cameras, dict) else {},
        "meshes": mesh_digests(urdf),
        "urdfs": {
            name: str(rospy.get_param(f"{namespace}/robot_description", ""))
            for name, namespace in others.items()
        },
    }


def mesh_digests(urdf: str) -> Dict[str, str]:
    """Return the SHA-256 of each mesh file that a URDF names, by its address."""
    found: Dict[str, str] = {}
    try:
        meshes = list(ElementTree.fromstring(urdf).iter("mesh"))
    except ElementTree.ParseError:
        return found
    for mesh in meshes:
        address = mesh.get("filename", "")
        try:
            content = Path(resolve_address(address, package_path)).read_bytes()
        except (AddressError, OSError):
            found[address] = _UNKNOWN
            continue
        found[address] = hashlib.sha256(content).hexdigest()
    return found


@lru_cache(maxsize=None)
def software_version() -> str:
    """Return the commit of the sources, with a + if they were changed; or the package's version."""
    try:
        folder = package_path("telex_training")
    except rospkg.ResourceNotFound:
        return _UNKNOWN
    commit = _git(folder, "rev-parse", "--short=12", "HEAD")
    if not commit:
        return str(rospkg.RosPack().get_manifest("telex_training").version)
    return commit + ("+" if _git(folder, "status", "--porcelain", "--untracked-files=no") else "")


def _git(folder: str, *arguments: str) -> str:
    try:
        done = subprocess.run(
            ["git", "-C", folder, *arguments],
            check=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            timeout=10.0,
            text=True,
        )
    except (OSError, subprocess.SubprocessError):
        return ""
    return done.stdout.strip()
