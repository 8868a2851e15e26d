"""State that is saved and restored, declared by the names of the attributes that hold it."""

from __future__ import annotations

from collections import deque
from typing import Any, ClassVar, Iterator, Tuple

import numpy as np

Names = Tuple[str, ...]


class Stateful:
    """Base of a part that remembers something from one step to the next.

    A class declares what it remembers; those of its base classes are added. A part whose state is
    more than attributes overrides `save_state` and `restore_state`.

    Attributes
    ----------
    SAVED : tuple of str
        Attributes with values, or with lists, dicts, deques or arrays of values, which are copied.
    SAVED_TIMES : tuple of str
        Attributes with sim times (s), or None: restored later, they are later by as much.
    SAVED_PARTS : tuple of str
        Attributes with a part, with several parts, or None.
    """

    __slots__ = ()
    SAVED: ClassVar[Names] = ()
    SAVED_TIMES: ClassVar[Names] = ()
    SAVED_PARTS: ClassVar[Names] = ()
    _declared: ClassVar[Tuple[Names, Names, Names]] = ((), (), ())

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        cls._declared = (
            _gathered(cls, "SAVED"),
            _gathered(cls, "SAVED_TIMES"),
            _gathered(cls, "SAVED_PARTS"),
        )

    @classmethod
    def has_state(cls) -> bool:
        """Whether anything is declared."""
        return any(cls._declared)

    def save_state(self) -> Any:
        """Return the present state; it does not change any more."""
        values, times, _ = self._declared
        return (
            [_copied(getattr(self, name)) for name in values],
            [getattr(self, name) for name in times],
            [part.save_state() for part in self._parts()],
        )

    def restore_state(self, saved: Any, elapsed: float) -> None:
        """Take a state up again.

        Parameters
        ----------
        saved : object
            What `save_state` returned; it may be restored any number of times.
        elapsed : float
            Sim time since then (s).
        """
        names, moments, _ = self._declared
        values, times, parts = saved
        for name, value in zip(names, values):
            setattr(self, name, _copied(value))
        for name, time in zip(moments, times):
            setattr(self, name, None if time is None else time + elapsed)
        for part, state in zip(self._parts(), parts):
            part.restore_state(state, elapsed)

    def _parts(self) -> Iterator[Stateful]:
        for name in self._declared[2]:
            found = getattr(self, name)
            if isinstance(found, Stateful):
                yield found
            elif found is not None:
                yield from found


def _gathered(cls: type, kind: str) -> Names:
    names = (name for each in reversed(cls.__mro__) for name in vars(each).get(kind, ()))
    return tuple(dict.fromkeys(names))


def _copied(value: Any) -> Any:
    if isinstance(value, (list, dict, set, deque, np.ndarray)):
        return value.copy()
    return value
