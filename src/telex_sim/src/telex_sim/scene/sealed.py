"""Seeds that only this machine's user can read: for pictures whose content has to be found out.

A scene's texture names go to every client. So a picture that is a question is not named by the seed
that it is drawn from, but by a token; the seed is a keyed hash of the token, and the key stands in
a file that only the user of simulator and cameras can read.
"""

from __future__ import annotations

import functools
import hashlib
import hmac
import re
import secrets
from pathlib import Path

import rospkg

from telex_control.common.params import ConfigError
from telex_control.common.private_file import make_private_file

FILE = "telex_sealed.key"
"""Name of the key's file in ROS_HOME (``~/.ros``). Cameras on another machine need a copy."""
TOKEN = re.compile(r"[0-9a-f]{8,64}")
"""What a token may be."""
_KEY_BYTES = 32


def new_token() -> str:
    """Make a token that nobody can guess."""
    return secrets.token_hex(16)


def seed_of(token: str, part: str = "") -> int:
    """Seed that a token stands for, 0 to 2**31 - 1.

    Parameters
    ----------
    part : str
        Tells several seeds of one token apart.

    Raises
    ------
    ConfigError
        The key's file cannot be read or made.
    """
    digest = hmac.new(_key(key_file()), f"{token}/{part}".encode(), hashlib.sha256).digest()
    return int.from_bytes(digest[:4], "big") & 0x7FFFFFFF


def key_file() -> Path:
    """Path of the key's file."""
    return Path(rospkg.get_ros_home(), FILE)


@functools.lru_cache(maxsize=4)
def _key(path: Path) -> bytes:
    """Read the key, or make it where there is none."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.exists():
            make_private_file(str(path), secrets.token_bytes(_KEY_BYTES))
        key = path.read_bytes()
    except OSError as error:
        raise ConfigError(
            f"sealed: its key cannot be read or made: {path}: {error.strerror}"
        ) from error
    if len(key) != _KEY_BYTES:
        raise ConfigError(
            f"sealed: {path} has {len(key)} bytes; {_KEY_BYTES} are needed; delete it to have it "
            "made anew"
        )
    return key
