"""Keeps on disk what is expensive to make of a scene: textures, meshes, their coarse shapes.

The name of a file is the hash of all that its content depends on: the function's arguments, the
sources that it is made of, the libraries. What is there is therefore right, whoever has made it;
what is broken or missing is made anew. Without a folder everything is made anew, and nothing else
changes.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import importlib.util
import json
import operator
import os
import re
import sys
import tempfile
import time
import zlib
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any, Callable, Iterator, List, Optional, Set, Tuple

import cv2
import numpy as np

MOST_BYTES = 512 * 2**20
"""Size of the folder, beyond which those files go that were not used for longest."""

# What takes less is not worth a file (s of CPU time).
_WORTH = 7e-4

# The time of a file's last use is that exact (s).
_USE_NOTED = 86400.0

_MAGIC = b"telex content 1\n"
_SUFFIX = ".content"
_IMPORT = re.compile(r"^\s*from (\.*[\w.]*) import (\([^)]*\)|[^\n]*)", re.MULTILINE)
_NAME = re.compile(r"[A-Za-z_]\w*")
_LIBRARIES = f"numpy {np.__version__} opencv {cv2.__version__} {sys.byteorder}"
_OWN_PACKAGE = __name__.partition(".")[0]


class ContentStore:
    """Results of functions, in a folder or nowhere.

    Parameters
    ----------
    folder
        None: nothing is kept.
    most_bytes
        See `MOST_BYTES`.
    """

    def __init__(self, folder: Optional[Path] = None, most_bytes: int = MOST_BYTES) -> None:
        self._folder = folder
        self._most_bytes = most_bytes
        self._size: Optional[int] = None

    def get(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """Return ``function(*arguments)``, which must depend on nothing else.

        Parameters
        ----------
        function
            Of a module. It returns an array, None, or a tuple or dataclass of these.
        arguments
            Numbers, text, arrays, or tuples and dataclasses of these. A `Path` stands for what the
            file contains.

        Returns
        -------
        object
            As the function returns it, but tuples of any kind and dataclasses are plain tuples, and
            arrays that were read cannot be written to.
        """
        if self._folder is None:
            return _plain(function(*arguments))
        try:
            path = self._folder / f"{_key(function, arguments)}{_SUFFIX}"
        except OSError:  # of an argument's file; the function says what is wrong with it
            return _plain(function(*arguments))
        with contextlib.suppress(OSError, ValueError, KeyError, TypeError):
            result = _unpacked(path.read_bytes())
            _note_use(path)
            return result
        began = time.thread_time()
        result = _plain(function(*arguments))
        if time.thread_time() - began >= _WORTH:
            with contextlib.suppress(OSError):
                self._write(path, _packed(result))
        return result

    def _write(self, path: Path, content: bytes) -> None:
        assert self._folder is not None
        handle, name = tempfile.mkstemp(dir=self._folder)
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(content)
            os.replace(name, path)
        except OSError:
            with contextlib.suppress(OSError):
                os.unlink(name)
            raise
        self._size = (self._size or 0) + len(content)
        if self._size == len(content) or self._size > self._most_bytes:
            self._clear_up()

    def _clear_up(self) -> None:
        """Measure the folder, and delete what was not used for longest if it is too large."""
        assert self._folder is not None
        files = []
        for path in self._folder.iterdir():
            with contextlib.suppress(OSError):
                status = path.stat()
                files.append((status.st_mtime, status.st_size, path))
        self._size = sum(size for _, size, _ in files)
        for _, size, path in sorted(files):
            # Not at every file again.
            if self._size <= self._most_bytes or self._size <= 0.8 * self._most_bytes:
                break
            with contextlib.suppress(OSError):
                path.unlink()
            self._size -= size


def shared_store() -> ContentStore:
    """Open the store in the user's cache folder; without one, nothing is kept."""
    return ContentStore(cache_folder("content"))


def cache_folder(name: str) -> Optional[Path]:
    """Make a folder in the user's cache; None: none can be made."""
    try:
        home = os.environ.get("XDG_CACHE_HOME", "")
        # The specification has relative ones passed over.
        base = Path(home) if os.path.isabs(home) else Path.home() / ".cache"
        folder = base / "telex_sim" / name
        folder.mkdir(parents=True, exist_ok=True)
        return folder if os.access(folder, os.R_OK | os.W_OK | os.X_OK) else None
    except (OSError, RuntimeError):
        return None


@functools.lru_cache(maxsize=None)
def sources(module: str) -> Tuple[str, ...]:
    """Names of the modules of this package that a module is made of, itself included."""
    found: Set[str] = set()
    wanted = [module]
    while wanted:
        name = wanted.pop()
        if name in found or not name.startswith(_OWN_PACKAGE):
            continue
        # What a module imports within itself may not be there yet; nothing is made of it then.
        file = getattr(sys.modules.get(name), "__file__", None)
        if file is None:
            continue
        found.add(name)
        package = name if hasattr(sys.modules[name], "__path__") else name.rpartition(".")[0]
        for origin, names in _IMPORT.findall(Path(file).read_text(encoding="utf-8")):
            base = importlib.util.resolve_name(origin, package) if origin else package
            wanted.append(base)
            if origin.strip(".") == "":
                wanted += [f"{base}.{each}" for each in _NAME.findall(names)]
    return tuple(sorted(found))


@functools.lru_cache(maxsize=None)
def _digest(module: str) -> bytes:
    """Hash of the sources that a module is made of, and of the libraries."""
    digest = hashlib.blake2b(_LIBRARIES.encode())
    for name in sources(module):
        content = Path(str(sys.modules[name].__file__)).read_bytes()
        digest.update(f"{name} {len(content)}\n".encode() + content)
    return digest.digest()


def _key(function: Callable[..., Any], arguments: Tuple[Any, ...]) -> str:
    digest = hashlib.blake2b(_digest(function.__module__), digest_size=20)
    digest.update(function.__qualname__.encode())
    for part in _parts(arguments):
        digest.update(part)
    return digest.hexdigest()


def _parts(value: Any) -> Iterator[bytes]:
    """What tells a value from all others."""
    if isinstance(value, np.ndarray):
        yield f"array {value.dtype.descr} {value.shape} ".encode()
        yield value.tobytes()
    elif isinstance(value, Path):
        content = value.read_bytes()
        yield f"file {value.suffix} {len(content)} ".encode()
        yield content
    elif isinstance(value, (tuple, list)):
        yield f"{len(value)} of ".encode()
        for item in value:
            yield from _parts(item)
    elif is_dataclass(value):
        kind: Any = type(value)
        head, read = _fields(kind)
        items = read(value)
        if np.ndarray in map(type, items):
            yield head
            yield from _parts(items)
        else:  # plain ones; many of them, so that haste matters
            yield head + f"{items!r} ".encode()
    else:
        yield f"{value!r} ".encode()


@functools.lru_cache(maxsize=None)
def _fields(kind: Any) -> Tuple[bytes, Callable[[Any], Tuple[Any, ...]]]:
    """Name of a dataclass with those of its fields, and what reads them all."""
    names = [each.name for each in fields(kind)]
    head = f"{kind.__name__} {names} ".encode()
    if len(names) > 1:
        return head, operator.attrgetter(*names)
    return head, lambda value: tuple(getattr(value, name) for name in names)


def _plain(result: Any) -> Any:
    if is_dataclass(result):
        return tuple(getattr(result, each.name) for each in fields(result))
    return tuple(result) if isinstance(result, (tuple, list)) else result


def _packed(result: Any) -> bytes:
    items = result if isinstance(result, tuple) else (result,)
    arrays = [None if item is None else np.ascontiguousarray(item) for item in items]
    head = {
        "tuple": isinstance(result, tuple),
        "arrays": [item if item is None else [item.dtype.descr, item.shape] for item in arrays],
    }
    body = json.dumps(head).encode() + b"\n"
    body += b"".join(item.tobytes() for item in arrays if item is not None)
    return _MAGIC + zlib.crc32(body).to_bytes(4, "little") + body


def _unpacked(content: bytes) -> Any:
    """Read what `_packed` has written.

    Raises
    ------
    ValueError, KeyError, TypeError
        It is something else.
    """
    start = len(_MAGIC) + 4
    body = memoryview(content)[start:]
    checksum = int.from_bytes(content[start - 4 : start], "little")
    if content[: len(_MAGIC)] != _MAGIC or zlib.crc32(body) != checksum:
        raise ValueError("it is no content, or broken")
    end = content.index(b"\n", start) + 1
    head = json.loads(content[start:end])
    result: List[Optional[np.ndarray]] = []
    for item in head["arrays"]:
        if item is None:
            result.append(None)
            continue
        dtype = _dtype(item[0])
        count = int(np.prod(item[1], dtype=np.int64))
        result.append(np.frombuffer(content, dtype, count, end).reshape(item[1]))
        end += count * dtype.itemsize
    return tuple(result) if head["tuple"] else result[0]


def _dtype(description: List[List[Any]]) -> np.dtype:
    """Read a dtype's description that has become lists."""
    named = [(name, form, *map(tuple, shape)) for name, form, *shape in description]
    return np.dtype(named[0][1]) if [each[0] for each in named] == [""] else np.dtype(named)


def _note_use(path: Path) -> None:
    if time.time() - path.stat().st_mtime > _USE_NOTED:
        with contextlib.suppress(OSError):
            os.utime(path)
