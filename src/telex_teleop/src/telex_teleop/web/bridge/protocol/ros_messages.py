"""ROS message types by their names, and messages as JSON and back by rosbridge's rules.

A plan of conversions is made once per message class and kept: one function per field and direction.

| ROS | JSON |
|---|---|
| bool, string | true/false, string |
| integers | number without a fraction; a float is refused |
| float32, float64 | number; NaN and infinities go out as null, which comes in as NaN |
| time, duration | {"secs", "nsecs"}; for a time that comes in, "now" as well |
| uint8[], char[] | base64 string; a list of integers is accepted, too |
| other arrays | list |
| std_msgs/Header | a stamp that is missing is filled with the present time |

Fields that are missing keep their default; unknown ones are refused.
"""

from __future__ import annotations

import base64
import binascii
import functools
import math
import re
from typing import Any, Callable, Dict, List, Optional, Tuple, Type

import genpy

from .operations import OperationError

Now = Callable[[], genpy.Time]
_Encode = Callable[[Any], Any]
_Decode = Callable[[Any, Now], Any]

_INTEGER_BITS = {
    "int8": (True, 8),
    "byte": (True, 8),
    "uint8": (False, 8),
    "char": (False, 8),
    "int16": (True, 16),
    "uint16": (False, 16),
    "int32": (True, 32),
    "uint32": (False, 32),
    "int64": (True, 64),
    "uint64": (False, 64),
}
_MAX_FLOAT = {"float32": 3.4028234663852886e38, "float64": math.inf}
_BYTE_TYPES = ("uint8", "char")
_TYPE_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*/[A-Za-z][A-Za-z0-9_]*", re.ASCII)


def message_class(type_name: str) -> Type[genpy.Message]:
    """Return the class of a message type such as "std_msgs/String".

    Raises
    ------
    OperationError
        This is no type name, or the type is not built on this machine.
    """
    return _find(genpy.message.get_message_class, "message", type_name)


def service_class(type_name: str) -> Any:
    """Return the class of a service type such as "std_srvs/Empty"; raises as message_class."""
    return _find(genpy.message.get_service_class, "service", type_name)


def _find(find: Callable[[str], Optional[Any]], what: str, type_name: str) -> Any:
    # The name decides what is imported, so nothing but a type's name may get there.
    if not _TYPE_NAME.fullmatch(type_name):
        raise OperationError(
            f"{type_name[:80]!r} is no {what} type; one looks like std_msgs/String"
        )
    try:
        found = find(type_name)
    except (ImportError, AttributeError, ValueError):
        found = None
    if found is None:
        raise OperationError(f"the {what} type {type_name} is not built on this machine")
    return found


class FieldError(ValueError):
    """A value that does not fit its field; the text begins with the field's path."""

    def __init__(self, reason: str, path: str = "") -> None:
        super().__init__(f"{path}: {reason}" if path else reason)
        self.reason = reason
        self.path = path

    def inside(self, outer: str) -> FieldError:
        """Return the same error seen from the field around it."""
        joint = "" if not self.path or self.path.startswith("[") else "."
        return FieldError(self.reason, f"{outer}{joint}{self.path}")


def _kind(value: Any) -> str:
    """Name a JSON value the way a user would."""
    if value is None:
        return "null"
    names = {bool: "a boolean", int: "an integer", float: "a float", str: "a string"}
    names.update({dict: "an object", list: "a list"})
    return names.get(type(value), type(value).__name__)


def split_array(slot_type: str) -> Tuple[str, Optional[int], bool]:
    """Split a slot type: element type, fixed length, and whether it is an array at all."""
    if not slot_type.endswith("]"):
        return slot_type, None, False
    element, _, length = slot_type[:-1].partition("[")
    return element, int(length) if length else None, True


class MessageCodec:
    """Converts messages of one class, or requests and responses of a service.

    Parameters
    ----------
    message_class
        Generated class; of it come the fields and their types.
    """

    def __init__(self, message_class: Type[genpy.Message]) -> None:
        self.message_class = message_class
        self._is_header = message_class._type == "std_msgs/Header"
        self._encoders: List[Tuple[str, _Encode]] = []
        self._decoders: Dict[str, _Decode] = {}
        for name, slot_type in zip(message_class.__slots__, message_class._slot_types):
            encode, decode = _converters(slot_type)
            self._encoders.append((name, encode))
            self._decoders[name] = decode

    @property
    def type_name(self) -> str:
        """Name of the type, such as "std_msgs/String"."""
        return str(self.message_class._type)

    @property
    def fields(self) -> List[str]:
        """Names of the fields, in their order."""
        return [name for name, _ in self._encoders]

    def to_json(self, message: genpy.Message) -> Dict[str, Any]:
        """Return a message as values that json.dumps takes."""
        return {name: encode(getattr(message, name)) for name, encode in self._encoders}

    def from_json(self, value: Any, now: Now) -> genpy.Message:
        """Return the message that a JSON object stands for.

        Parameters
        ----------
        value
            What json.loads gave.
        now
            Returns the present ROS time.

        Raises
        ------
        FieldError
            A value does not fit its field, or there is no such field.
        """
        if not isinstance(value, dict):
            raise FieldError(f"expected an object, got {_kind(value)}")
        message = self.message_class()
        for name, part in value.items():
            decode = self._decoders.get(name)
            if decode is None:
                known = ", ".join(self._decoders) or "none at all"
                reason = f"{self.type_name} has no such field; its fields are {known}"
                raise FieldError(reason, name[:80])
            try:
                setattr(message, name, decode(part, now))
            except FieldError as error:
                raise error.inside(name) from None
        if self._is_header and "stamp" not in value:
            message.stamp = now()
        return message


def holds_null(value: Any) -> bool:
    """Tell whether a JSON value holds a null; if it has become a message, that one holds a NaN."""
    if isinstance(value, dict):
        value = list(value.values())
    return value is None or (isinstance(value, list) and any(map(holds_null, value)))


_codecs: Dict[Type[genpy.Message], MessageCodec] = {}


def codec_of(message_class: Type[genpy.Message]) -> MessageCodec:
    """Return the codec of a message class; it is made only once."""
    codec = _codecs.get(message_class)
    if codec is None:
        codec = _codecs[message_class] = MessageCodec(message_class)
    return codec


def _converters(slot_type: str) -> Tuple[_Encode, _Decode]:
    """Return how values of a slot are encoded and decoded."""
    element, length, is_array = split_array(slot_type)
    if not is_array:
        return _scalar_converters(element)
    if element in _BYTE_TYPES:
        return _bytes_encoder, functools.partial(_decode_bytes, length, element)
    encode, decode = _scalar_converters(element)
    encode_all = _encode_floats if element in _MAX_FLOAT else functools.partial(_encode_all, encode)
    return encode_all, functools.partial(_decode_all, length, decode)


def _scalar_converters(kind: str) -> Tuple[_Encode, _Decode]:
    if kind == "bool":
        return bool, _decode_bool
    if kind == "string":
        return str, _decode_string
    if kind in _INTEGER_BITS:
        signed, bits = _INTEGER_BITS[kind]
        low = -(1 << (bits - 1)) if signed else 0
        high = (1 << (bits - 1 if signed else bits)) - 1
        return int, functools.partial(_decode_integer, kind, low, high)
    if kind in _MAX_FLOAT:
        return _encode_float, functools.partial(_decode_float, _MAX_FLOAT[kind])
    if kind == "time":
        return _encode_time, _decode_time
    if kind == "duration":
        return _encode_time, _decode_duration
    message_class = genpy.message.get_message_class(kind)
    if message_class is None:
        raise FieldError(f"the message type {kind} is not built on this machine")
    codec = codec_of(message_class)
    return codec.to_json, codec.from_json


def _encode_float(value: float) -> Optional[float]:
    return value if math.isfinite(value) else None


def _encode_floats(values: Any) -> List[Optional[float]]:
    return [value if math.isfinite(value) else None for value in values]


def _encode_all(encode: _Encode, values: Any) -> List[Any]:
    return [encode(value) for value in values]


def _bytes_encoder(value: Any) -> str:
    return base64.b64encode(bytes(value)).decode("ascii")


def _encode_time(value: genpy.rostime.TVal) -> Dict[str, int]:
    return {"secs": value.secs, "nsecs": value.nsecs}


def _decode_bool(value: Any, _now: Now) -> bool:
    if not isinstance(value, bool):
        raise FieldError(f"expected true or false, got {_kind(value)}")
    return value


def _decode_string(value: Any, _now: Now) -> str:
    if not isinstance(value, str):
        raise FieldError(f"expected a string, got {_kind(value)}")
    try:
        value.encode("utf-8")
    except UnicodeEncodeError:
        raise FieldError("the string holds half of a surrogate pair") from None
    return value


def _decode_integer(kind: str, low: int, high: int, value: Any, _now: Optional[Now] = None) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise FieldError(f"expected an integer ({kind}), got {_kind(value)}")
    if not low <= value <= high:
        raise FieldError(f"{kind} goes from {low} to {high}")
    return value


def _decode_float(maximum: float, value: Any, _now: Now) -> float:
    if value is None:
        return math.nan
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise FieldError(f"expected a number, got {_kind(value)}")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number) or abs(number) > maximum:
        raise FieldError("the number is not finite or too large")
    return number


def _seconds(value: Any, kind: str, low: int, high: int) -> Tuple[int, int]:
    if not isinstance(value, dict):
        raise FieldError(f'expected {{"secs", "nsecs"}}, got {_kind(value)}')
    unknown = set(value) - {"secs", "nsecs"}
    if unknown:
        raise FieldError(f"a {kind} has secs and nsecs only", sorted(unknown)[0][:80])
    parts = []
    for name, bounds in (("secs", (low, high)), ("nsecs", (0, 999999999))):
        try:
            parts.append(_decode_integer(name, *bounds, value.get(name, 0)))
        except FieldError as error:
            raise error.inside(name) from None
    return parts[0], parts[1]


def _decode_time(value: Any, now: Now) -> genpy.Time:
    if value == "now":
        return now()
    return genpy.Time(*_seconds(value, "time", 0, 2**32 - 1))


def _decode_duration(value: Any, _now: Now) -> genpy.Duration:
    return genpy.Duration(*_seconds(value, "duration", -(2**31), 2**31 - 1))


def _check_length(length: Optional[int], values: Any) -> None:
    if length is not None and len(values) != length:
        raise FieldError(f"expected {length} elements, got {len(values)}")


def _decode_bytes(length: Optional[int], element: str, value: Any, now: Now) -> bytes:
    if isinstance(value, str):
        try:
            data = base64.b64decode(value, validate=True)
        except (binascii.Error, ValueError):
            raise FieldError("the string is not base64") from None
    else:
        one = functools.partial(_decode_integer, element, 0, 255)
        data = bytes(_decode_all(None, one, value, now))
    _check_length(length, data)
    return data


def _decode_all(length: Optional[int], decode: _Decode, value: Any, now: Now) -> List[Any]:
    if not isinstance(value, list):
        raise FieldError(f"expected a list, got {_kind(value)}")
    _check_length(length, value)
    decoded = []
    for index, element in enumerate(value):
        try:
            decoded.append(decode(element, now))
        except FieldError as error:
            raise error.inside(f"[{index}]") from None
    return decoded
