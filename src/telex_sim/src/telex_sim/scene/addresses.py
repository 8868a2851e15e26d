"""Addresses of meshes and textures, as scene files give them."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import quote

from telex_control.common.params import require

_WITH_SCHEME = ("package://", "file://", "generated:")


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
    return "file://" + quote(str(folder / path))
