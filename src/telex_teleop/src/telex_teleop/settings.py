"""Reading of a node's parameters: every value checked, every unknown key refused."""

from __future__ import annotations

import math
from typing import Any, Dict, List, Mapping, Optional, Set, Tuple

__all__ = ["Section", "SettingsError"]


class SettingsError(ValueError):
    """A setting is missing, unknown or wrong; the message says where and what would be right."""


class Section:
    """One mapping of settings, read key by key.

    Parameters
    ----------
    values
        The mapping as YAML or the parameter server gives it.
    source
        Where it came from (a file or a parameter name), for the messages.

    Notes ----- Call `finish` after the last key: it refuses what nobody asked for, which is how a
    misspelt key is found.
    """

    def __init__(self, values: Any, source: str) -> None:
        if values is None:
            values = {}
        if not isinstance(values, Mapping):
            raise SettingsError(f"{source}: is {values!r}; must be a mapping of settings")
        # YAML reads a bare 1 as a number, also where it is a key of the keyboard
        self._values: Dict[str, Any] = {str(key): value for key, value in values.items()}
        self._source = source
        self._read: Set[str] = set()

    @property
    def source(self) -> str:
        """Where these settings came from."""
        return self._source

    def has(self, key: str) -> bool:
        """Tell whether the key is given."""
        return key in self._values

    def names_given(self) -> List[str]:
        """Return the keys that are given, in their order."""
        return list(self._values)

    def number(
        self,
        key: str,
        default: Optional[float] = None,
        *,
        minimum: float = -math.inf,
        maximum: float = math.inf,
        positive: bool = False,
    ) -> float:
        """Return a finite number.

        Parameters
        ----------
        key
            Name of the setting.
        default
            Value when it is not given; None makes the setting required.
        minimum, maximum
            Inclusive range.
        positive
            Also refuse zero and less.

        Raises
        ------
        SettingsError
            When the setting is missing, is no finite number or is out of range.
        """
        value = self._take(key, default, "a number")
        wanted = self._wanted_number(minimum, maximum, positive)
        # bool is an int to Python, but "true" as a speed is a mistake
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise self.error(key, value, wanted)
        number = float(value)
        in_range = math.isfinite(number) and minimum <= number <= maximum
        if not in_range or (positive and number <= 0.0):
            raise self.error(key, value, wanted)
        return number

    def text(
        self, key: str, default: Optional[str] = None, *, choices: Tuple[str, ...] = ()
    ) -> str:
        """Return a non-empty string, one of `choices` when these are given."""
        wanted = "one of " + ", ".join(choices) if choices else "a non-empty text"
        value = self._take(key, default, wanted)
        if not isinstance(value, str) or not value or (choices and value not in choices):
            raise self.error(key, value, wanted)
        return value

    def names(self, key: str) -> Tuple[str, ...]:
        """Return a required, non-empty list of distinct names."""
        wanted = "a list of distinct names"
        value = self._take(key, None, wanted)
        if not isinstance(value, (list, tuple)) or not value:
            raise self.error(key, value, wanted)
        if not all(isinstance(name, str) and name for name in value):
            raise self.error(key, value, wanted)
        if len(set(value)) != len(value):
            raise self.error(key, value, wanted)
        return tuple(value)

    def section(self, key: str, *, required: bool = False) -> Section:
        """Return a nested mapping; an absent one is empty unless it is required."""
        value = self._take(key, None if required else {}, "a mapping of settings")
        return Section(value, f"{self._source}/{key}")

    def finish(self) -> None:
        """Refuse the keys that nobody has read.

        Raises
        ------
        SettingsError
            Naming the unknown keys and those that are known here.
        """
        unknown = sorted(set(self._values) - self._read)
        if unknown:
            known = ", ".join(sorted(self._read)) or "none"
            raise SettingsError(
                f"{self._source}: unknown setting {', '.join(unknown)}; known here: {known}"
            )

    def error(self, key: str, value: Any, wanted: str) -> SettingsError:
        """Return the error for a bad value, in the words that all settings use."""
        return SettingsError(f"{self._source}/{key}: is {value!r}; must be {wanted}")

    def _take(self, key: str, default: Any, wanted: str) -> Any:
        self._read.add(key)
        if key in self._values:
            return self._values[key]
        if default is None:
            raise SettingsError(f"{self._source}/{key}: is missing; must be {wanted}")
        return default

    @staticmethod
    def _wanted_number(minimum: float, maximum: float, positive: bool) -> str:
        parts: Dict[str, bool] = {
            "above 0": positive,
            f"at least {minimum:g}": math.isfinite(minimum) and not positive,
            f"at most {maximum:g}": math.isfinite(maximum),
        }
        bounds = " and ".join(text for text, use in parts.items() if use)
        return f"a number {bounds}" if bounds else "a finite number"
