"""Addresses of the files of a scene."""

from __future__ import annotations

import os
from typing import Callable
from urllib.parse import unquote

PackagePath = Callable[[str], str]
"""Gives the directory of a ROS package; raises for an unknown one."""

_PACKAGE = "package://"
_FILE = "file://"


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
