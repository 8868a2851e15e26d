"""Frames of pickled values between the simulator and its rehearsal process.

Values come one frame each, so that the thread that reads a large answer hands Python's lock over to
the loop in between. An array that several values share crosses once.
"""

from __future__ import annotations

import hashlib
import io
import pickle
import struct
from typing import Any, BinaryIO, Callable, Dict, Iterable, Iterator, List

import numpy as np

_LENGTH = struct.Struct("!Q")
_SHARED = 1024
"""Bytes; smaller arrays stand in the values themselves."""
_ARRAY, _VALUE = 0, 1


def write_values(file: BinaryIO, values: Iterable[Any]) -> None:
    """Write values, and an end."""
    known: Dict[bytes, int] = {}
    for value in values:
        arrays: List[np.ndarray] = []
        frame = io.BytesIO()
        _Pickler(frame, known, arrays).dump((_VALUE, value))
        for array in arrays:
            _write_frame(file, pickle.dumps((_ARRAY, array), protocol=4))
        _write_frame(file, frame.getvalue())
    file.write(_LENGTH.pack(0))
    file.flush()


def read_values(read: Callable[[int], bytes]) -> Iterator[Any]:
    """Read values up to their end.

    Parameters
    ----------
    read : callable
        Returns a number of bytes, or fewer at the end of all.

    Raises
    ------
    EOFError
        They broke off.
    """
    arrays: List[np.ndarray] = []
    while True:
        length = _LENGTH.unpack(_exactly(read, _LENGTH.size))[0]
        if not length:
            return
        kind, value = _Unpickler(io.BytesIO(_exactly(read, length)), arrays).load()
        if kind == _ARRAY:
            arrays.append(value)
        else:
            yield value


def _write_frame(file: BinaryIO, content: bytes) -> None:
    file.write(_LENGTH.pack(len(content)))
    file.write(content)


def _exactly(read: Callable[[int], bytes], length: int) -> bytes:
    content = read(length)
    if len(content) < length:
        raise EOFError("the other side has ended")
    return content


class _Pickler(pickle.Pickler):
    def __init__(self, file: BinaryIO, known: Dict[bytes, int], new: List[np.ndarray]) -> None:
        super().__init__(file, protocol=4)
        self._known = known
        self._new = new

    def persistent_id(self, value: Any) -> Any:
        """Number of a large array; what is not yet known is noted."""
        if not isinstance(value, np.ndarray) or value.nbytes < _SHARED:
            return None
        array = np.ascontiguousarray(value)
        digest = hashlib.sha256(f"{array.dtype.str} {array.shape}".encode())
        digest.update(array.data)
        key = digest.digest()
        if key not in self._known:
            self._known[key] = len(self._known)
            self._new.append(array)
        return self._known[key]


class _Unpickler(pickle.Unpickler):
    def __init__(self, file: BinaryIO, arrays: List[np.ndarray]) -> None:
        super().__init__(file)
        self._arrays = arrays

    def persistent_load(self, number: Any) -> Any:
        """The array of a number."""
        return self._arrays[number]
