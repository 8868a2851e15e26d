"""Addresses of meshes and textures: as scene files give them, and the files that they name."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Callable
from urllib.parse import quote, unquote

from telex_control.common.params import require

PackagePath = Callable[[str], str]
"""Gives the directory of a ROS package; raises for an unknown one."""

_PACKAGE = "package://"
_FILE = "file://"
_WITH_SCHEME = (_PACKAGE, _FILE, "generated:")


def absolute(address: str, folder: Path) -> str:
    """Make the address that an author wrote independent of where the scene lies.

    Parameters
    ----------
    address : str
        ``package://…``, ``file://…``, ``generated:…``, an absolute path, or one relative to
        `folder`. Empty stays empty.
    folder : Path
        The scene file's; a path that is itself relative stands for "there is none".

    Raises
    ------
    ConfigError
        The address is relative, and there is no folder that it could start from.
    """
    if not address or address.startswith(_WITH_SCHEME):
        return address
    path = Path(address)
    require(
        path.is_absolute() or folder.is_absolute(),
        f"'{address}' is relative, but there is no folder to start from; "
        "an absolute path or a package:// address is needed",
    )
    return _FILE + quote(str(folder / path))


class AddressError(ValueError):
    """An address names no file; the message says which and why."""


def resolve_address(address: str, package_path: PackagePath) -> str:
    """Find the path of the file that a package:// or file:// address names.

    Parameters
    ----------
    address
        As in URDF, e.g. "package://telex_description/meshes/visual/base.obj".
    package_path
        Looks packages up; whatever it raises counts as "not found".

    Raises
    ------
    AddressError
        When the address has another scheme, no file, or names an unknown package.
    """
    if "\0" in unquote(address):
        raise AddressError(f"'{address}': no file's name has %00")
    if address.startswith(_FILE):
        path = unquote(address[len(_FILE) :])
        if not os.path.isabs(path):
            raise AddressError(f"'{address}': a file:// address needs an absolute path")
        return path
    if not address.startswith(_PACKAGE):
        raise AddressError(f"'{address}': an address begins with {_PACKAGE} or {_FILE}")
    package, _, relative = address[len(_PACKAGE) :].partition("/")
    if not package or not relative:
        raise AddressError(f"'{address}': expected {_PACKAGE}<package>/<path of the file>")
    try:
        directory = package_path(package)
    except Exception as error:  # the kind depends on who looks packages up
        raise AddressError(f"'{address}': package '{package}' is not found ({error})") from error
    return os.path.join(directory, unquote(relative))
