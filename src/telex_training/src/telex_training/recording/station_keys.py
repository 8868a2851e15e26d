"""The key with which a station signs its exams, and those of stations that it trusts.

The private key is made at its first use, and only the user of the training node can read it. Keys
are 32 bytes of ed25519 in hexadecimal, a file each.
"""

from __future__ import annotations

import contextlib
import os
import re
from pathlib import Path
from typing import Dict, Optional

import rospkg
from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey, Ed25519PublicKey
from cryptography.hazmat.primitives.serialization import (
    Encoding,
    NoEncryption,
    PrivateFormat,
    PublicFormat,
)

from telex_control.common.params import ConfigError
from telex_control.common.private_file import make_private_file, read_private_file

PRIVATE, PUBLIC, TRUSTED = "telex_station.key", "telex_station.pub", "telex_trusted_keys"
"""Names of the files in ROS_HOME (``~/.ros``), and of the folder of trusted stations' keys."""
OWN = "this station"
_KEY = re.compile(rb"[0-9a-f]{64}\s*")
_MOST = 1024
_SUFFIX = ".pub"


class StationKeyError(RuntimeError):
    """A key cannot be made or used; the message names the file and says what is wrong."""


class StationKey:
    """A private key.

    Parameters
    ----------
    private : bytes
        32 bytes.

    Attributes
    ----------
    public : str
        The public key, in hexadecimal.
    """

    def __init__(self, private: bytes) -> None:
        self._key = Ed25519PrivateKey.from_private_bytes(private)
        public = self._key.public_key().public_bytes(Encoding.Raw, PublicFormat.Raw)
        self.public = public.hex()

    def sign(self, content: bytes) -> bytes:
        """Sign some bytes."""
        return bytes(self._key.sign(content))


def station_key(folder: Optional[Path] = None) -> StationKey:
    """Return the station's key, made where there is none, with the public one beside it.

    Parameters
    ----------
    folder : Path, optional
        Of the keys; else ROS_HOME.

    Raises
    ------
    StationKeyError
        Others may read it, it is no key, or it cannot be read or made.
    """
    folder = folder or _home()
    path = folder / PRIVATE
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if not path.exists():
            make_private_file(str(path), _new_key())
        key = StationKey(_bytes_of(read_private_file(str(path), _MOST, "key"), path))
        _show(folder / PUBLIC, key.public)
    except ConfigError as error:
        raise StationKeyError(f"the station's key: {error}") from error
    except OSError as error:
        raise StationKeyError(f"the station's key: {path}: {error.strerror}") from error
    return key


def known_keys(folder: Optional[Path] = None) -> Dict[str, str]:
    """Return whose signatures count: names of stations by their public keys.

    A file that is no key names nobody.

    Parameters
    ----------
    folder : Path, optional
        Of the keys; else ROS_HOME.
    """
    folder = folder or _home()
    known = {}
    for path in sorted((folder / TRUSTED).glob(f"*{_SUFFIX}")):
        with contextlib.suppress(StationKeyError):
            known[read_public_key(path)] = path.stem
    with contextlib.suppress(StationKeyError):
        known[read_public_key(folder / PUBLIC)] = OWN
    return known


def read_public_key(path: Path) -> str:
    """Read a station's public key.

    Raises
    ------
    StationKeyError
        There is none.
    """
    try:
        with path.open("rb") as file:
            return _bytes_of(file.read(_MOST), path).hex()
    except OSError as error:
        raise StationKeyError(f"{path}: {error.strerror}") from error
    except ConfigError as error:
        raise StationKeyError(str(error)) from error


def is_signed(content: bytes, signature: bytes, public: str) -> bool:
    """Tell whether a signature is that of a public key over some bytes."""
    try:
        Ed25519PublicKey.from_public_bytes(bytes.fromhex(public)).verify(signature, content)
    except (InvalidSignature, ValueError):
        return False
    return True


def _home() -> Path:
    return Path(rospkg.get_ros_home())


def _new_key() -> bytes:
    made = Ed25519PrivateKey.generate()
    raw = made.private_bytes(Encoding.Raw, PrivateFormat.Raw, NoEncryption())
    return f"{raw.hex()}\n".encode()


def _bytes_of(text: bytes, path: Path) -> bytes:
    if not _KEY.fullmatch(text):
        raise ConfigError(f"'{path}' holds no key; 64 digits in hexadecimal are needed")
    return bytes.fromhex(text.decode())


def _show(path: Path, public: str) -> None:
    """Write the public key beside the private one, whole from its first moment."""
    text = f"{public}\n"
    with contextlib.suppress(OSError):
        if path.read_text() == text:
            return
    draft = path.with_name(f".{path.name}.{os.getpid()}")
    draft.write_text(text)
    draft.chmod(0o644)
    draft.replace(path)
