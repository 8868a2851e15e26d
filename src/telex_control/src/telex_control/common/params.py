"""Validated reading of nested parameters into frozen dataclasses.

A dataclass field is a number, a string, a bool, a list, a dict, another such dataclass, or Optional
of one of these; what the parameters leave out keeps the field's default, and a key that is no field
is an error. What a type cannot say, `require` and its relatives check; they name a parameter within
its struct, `read_config` adds the struct's own name.

A dataclass that is `Declared` says beside each field what it means and what is possible::

    rate: float = number(4.0, "How often it is computed (Hz).", 0.0, 50.0)
    mounting: str = choice("stand", ("stand", "wall"))

Its checks and their messages come from there. The functions return what `dataclasses.field` does;
they are declared as Any, so that they pass as the default of a field of any type.
"""

from __future__ import annotations

import dataclasses
import functools
import math
import reprlib
from typing import (
    Any,
    Callable,
    Dict,
    Iterable,
    Mapping,
    Optional,
    Type,
    TypeVar,
    Union,
    get_type_hints,
)

Config = TypeVar("Config")

_WANTED = {
    int: "an integer",
    str: "a string",
    bool: "true or false",
    dict: "a struct",
    list: "a list",
}

_BOUNDED = reprlib.Repr()
_BOUNDED.maxlevel = 3
_BOUNDED.maxdict = _BOUNDED.maxlist = _BOUNDED.maxtuple = _BOUNDED.maxset = 20
_BOUNDED.maxstring = _BOUNDED.maxlong = _BOUNDED.maxother = 200


class ConfigError(ValueError):
    """A parameter is wrong; the message names it, its value and what would be right."""


def read_config(kind: Type[Config], params: Any, name: str) -> Config:
    """Make a `kind` of nested parameters.

    Parameters
    ----------
    name : str
        Full name of the parameter that holds them, for messages.

    Raises
    ------
    ConfigError
    """
    try:
        return read_struct(kind, params, name)
    except ConfigError as error:
        raise ConfigError(f"parameter {error}") from None


def read_struct(kind: Type[Config], params: Any, name: str = "") -> Config:
    """Make a `kind` of nested values that are no ROS parameters, as those of a file.

    Parameters
    ----------
    name : str
        Of the struct, for messages; without one they begin with the name of the value.

    Raises
    ------
    ConfigError
    """
    if not isinstance(params, Mapping):
        raise ConfigError(f"{name or 'it'} is {shown(params)}; a struct is needed")
    inside = f"{name}/" if name else ""
    hints = get_type_hints(kind)
    fields = {field.name: field for field in dataclasses.fields(kind)}  # type: ignore[arg-type]
    for key in params:
        if key not in fields:
            raise ConfigError(f"{inside}{key} is unknown; known are {', '.join(sorted(fields))}")
    values = {}
    for key, field in fields.items():
        if key in params:
            values[key] = read_value(hints[key], params[key], f"{inside}{key}")
        elif _is_required(field):
            raise ConfigError(f"{inside}{key} is missing")
    try:
        return kind(**values)
    except ConfigError as error:
        raise ConfigError(f"{name}: {error}" if name else str(error)) from None


def required() -> Any:
    """Stand in as the default_factory of a field that has none but follows fields with a default.

    A derived dataclass needs it; Python 3.8 does not have what the standard library offers for it,
    `kw_only`.

    Raises
    ------
    ConfigError
        Always.
    """
    raise ConfigError("a required parameter is missing")


def _is_required(field: Any) -> bool:
    no_default = field.default is dataclasses.MISSING
    return no_default and field.default_factory in (dataclasses.MISSING, required)


def shown(value: Any) -> str:
    """Show a value in a message, shortened where somebody gave a whole file of it.

    The text is never made in full: aliases in a few lines of YAML can stand for billions of values.
    """
    try:
        text = _BOUNDED.repr(value)
    except ValueError:
        # Python does not write integers of thousands of digits.
        text = f"a {type(value).__name__} too long to show"
    return text if len(text) <= 80 else text[:77] + "..."


def read_value(kind: Any, value: Any, name: str) -> Any:
    """Return one value, checked as a field of the type `kind` would be.

    Parameters
    ----------
    kind : type
        For ``float``, integers are taken too, and the value must be finite.
    name : str
        For messages.

    Raises
    ------
    ConfigError
    """
    if dataclasses.is_dataclass(kind):
        return read_struct(kind, value, name)  # type: ignore[arg-type]
    if kind is float:
        return _number(value, name)
    origin = getattr(kind, "__origin__", None)
    if origin is Union:
        return None if value is None else read_value(kind.__args__[0], value, name)
    if origin is dict:
        if not isinstance(value, Mapping):
            raise ConfigError(f"{name} is {shown(value)}; a struct is needed")
        element = kind.__args__[1]
        # YAML reads a bare 1 as a number, also where it is a key.
        return {str(key): read_value(element, item, f"{name}/{key}") for key, item in value.items()}
    if origin in (tuple, list):
        return _elements(kind, value, name)
    if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
        raise ConfigError(f"{name} is {shown(value)}; {_WANTED[kind]} is needed")
    return value


def _number(value: Any, name: str) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ConfigError(f"{name} is {shown(value)}; a number is needed")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise ConfigError(f"{name} is {shown(value)}; it must be finite")
    return number


def _elements(kind: Any, value: Any, name: str) -> Any:
    if not isinstance(value, (list, tuple)):
        raise ConfigError(f"{name} is {shown(value)}; a list is needed")
    element = kind.__args__[0]
    fixed = kind.__origin__ is tuple and Ellipsis not in kind.__args__
    if fixed and len(value) != len(kind.__args__):
        raise ConfigError(f"{name} has {len(value)} elements; {len(kind.__args__)} are needed")
    return tuple(read_value(element, item, f"{name}[{i}]") for i, item in enumerate(value))


def require(condition: bool, message: str) -> None:
    """Raise a `ConfigError` with `message` unless `condition` holds."""
    if not condition:
        raise ConfigError(message)


def require_range(
    config: object,
    name: str,
    minimum: float = -math.inf,
    maximum: float = math.inf,
    *,
    above: float = -math.inf,
) -> None:
    """Raise a `ConfigError` unless a number is finite and in range.

    Parameters
    ----------
    name : str
        Its field to check; None is taken there, as "not given".
    minimum, maximum : float
        Inclusive.
    above : float
        Exclusive.
    """
    value = getattr(config, name)
    if value is None:
        return
    bounds = [
        words
        for words, bound in (
            (f"above {above:g}", above),
            (f"at least {minimum:.12g}", minimum),
            (f"at most {maximum:.12g}", maximum),
        )
        if math.isfinite(bound)
    ]
    require(
        math.isfinite(value) and minimum <= value <= maximum and value > above,
        f"{name} is {value!r}; it must be {' and '.join(bounds) or 'finite'}",
    )


def require_choice(config: object, name: str, choices: Iterable[str]) -> None:
    """Raise a `ConfigError` unless the field `name` of `config` is one of `choices`."""
    value, known = getattr(config, name), list(choices)
    require(value in known, f"{name} is {value!r}; {', '.join(known)} are possible")


def require_text(config: object, name: str) -> None:
    """Raise a `ConfigError` when the string `name` of `config` is empty."""
    require(bool(getattr(config, name)), f"{name} is ''; it must not be empty")


def require_names(config: object, name: str) -> None:
    """Raise a `ConfigError` unless the field is a list, not empty, of distinct strings, not empty.

    Parameters
    ----------
    name : str
        Its field to check.
    """
    names = getattr(config, name)
    require(
        bool(names) and all(names) and len(set(names)) == len(names),
        f"{name} is {list(names)}; a list of distinct names is needed",
    )


Bound = Union[float, Callable[[Any], float]]
"""A number, or a function that computes it from the dataclass's other fields."""

_MEANING = "meaning"
_CHECK = "check"
_CHECK_WITH_OTHERS = "check with others"
_Check = Callable[[Any, str], None]


class Declared:
    """Base of dataclasses whose fields are declared by the functions of this module.

    A derived class may give a field another default; what was declared of it holds on.
    """

    def __post_init__(self) -> None:
        """Check every field alone, then those with limits by other fields, then `check`."""
        kind: type = type(self)
        declared = _declarations(kind)
        for stage in (_CHECK, _CHECK_WITH_OTHERS):
            for name, metadata in declared.items():
                if stage in metadata:
                    metadata[stage](self, name)
        self.check()

    def check(self) -> None:
        """Check what concerns several fields, or one in a way of its own.

        Raises
        ------
        ConfigError
            The message names the field, its value and what would be right.
        """


@functools.lru_cache(maxsize=None)
def _declarations(kind: type) -> Dict[str, Mapping[str, Any]]:
    """What was declared of each field of a dataclass, by itself or else by a base."""
    found: Dict[str, Mapping[str, Any]] = {}
    for base in reversed(kind.__mro__):
        for field in vars(base).get("__dataclass_fields__", {}).values():
            if field.metadata or field.name not in found:
                found[field.name] = field.metadata
    return found


def meaning(field: Any) -> str:
    """Meaning of a field that was declared here, with its unit; of any other, an empty string."""
    text: str = field.metadata.get(_MEANING, "")
    return text


def parameter(default: Any, text: str = "") -> Any:
    """Declare a field that needs no check beyond its type.

    Parameters
    ----------
    default
        Something to call, such as a class, makes it; `required`: the field must be given.
    text : str
        What it means, with its unit; empty where a file beside it says that.
    """
    return checked(default, text)


def number(
    default: Any,
    text: str = "",
    minimum: Bound = -math.inf,
    maximum: Bound = math.inf,
    *,
    above: Bound = -math.inf,
) -> Any:
    """Declare a number within limits; None passes, where the field's type is Optional.

    Parameters
    ----------
    default, text
        As for `parameter`.
    minimum, maximum : float or callable
        Inclusive.
    above : float or callable
        Exclusive.

    Notes
    -----
    Limits that depend on other fields are checked after those that do not, and may rely on them.
    """

    def check(config: Any, name: str) -> None:
        low, high, beyond = (_bound(each, config) for each in (minimum, maximum, above))
        require_range(config, name, low, high, above=beyond)

    with_others = any(callable(each) for each in (minimum, maximum, above))
    return checked(default, text, check, with_others)


def number_or_zero(default: Any, text: str, zero: str, minimum: float, maximum: float) -> Any:
    """Declare a number that is 0, or within limits, bounds included.

    Parameters
    ----------
    default, text
        As for `parameter`.
    zero : str
        What 0 stands for, for messages: "for never".
    """

    def check(config: Any, name: str) -> None:
        value = getattr(config, name)
        require(
            value == 0.0 or minimum <= value <= maximum,
            f"{name} is {value}; it must be 0, {zero}, or at least {minimum:g} and at most "
            f"{maximum:g}",
        )

    return checked(default, text, check)


LEAST_RATE = 1e-3
"""Hz of sim time; what would come more seldom comes in no run."""


def rate_or_never(default: float, text: str, maximum: float) -> Any:
    """Declare a rate (Hz of sim time) that may be 0, for never; see `number_or_zero`."""
    return number_or_zero(default, text, "for never", LEAST_RATE, maximum)


def numbers(default: Any, text: str, minimum: float, maximum: float) -> Any:
    """Declare a list of numbers, each within limits, bounds included; None passes.

    Parameters
    ----------
    default, text
        As for `parameter`.
    """

    def check(config: Any, name: str) -> None:
        for index, value in enumerate(getattr(config, name) or ()):
            require(
                math.isfinite(value) and minimum <= value <= maximum,
                f"{name}[{index}] is {value!r}; it must be at least {minimum:g} and at most"
                f" {maximum:g}",
            )

    return checked(default, text, check)


def word(default: Any, text: str = "") -> Any:
    """Declare a string that must not be empty."""
    return checked(default, text, require_text)


def choice(default: Any, choices: Iterable[str], text: str = "") -> Any:
    """Declare a string that is one of several.

    Parameters
    ----------
    default, text
        As for `parameter`; without a text, the choices are its meaning.
    """
    known = tuple(choices)

    def check(config: Any, name: str) -> None:
        require_choice(config, name, known)

    return checked(default, text or f"{', '.join(known[:-1])} or {known[-1]}.", check)


def checked(
    default: Any, text: str, check: Optional[_Check] = None, with_others: bool = False
) -> Any:
    """Declare a field with a check of one's own, of the dataclass and the field's name.

    Parameters
    ----------
    default, text
        As for `parameter`.
    with_others : bool
        Whether it relies on other fields, which are checked before.
    """
    metadata: Dict[str, Any] = {_MEANING: text}
    if check is not None:
        metadata[_CHECK_WITH_OTHERS if with_others else _CHECK] = check
    if callable(default):
        return dataclasses.field(default_factory=default, metadata=metadata)
    return dataclasses.field(default=default, metadata=metadata)


def _bound(bound: Bound, config: Any) -> float:
    return bound(config) if callable(bound) else bound
