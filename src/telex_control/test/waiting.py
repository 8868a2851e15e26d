"""Waiting for a condition in a test: one contract for all of them.

When it does not come in time, an `AssertionError` says what was awaited, in words or else by the
condition's source, and the last value that was seen. An element that is not there yet (LookupError)
is not yet so.
"""

from __future__ import annotations

import asyncio
import inspect
import time
from typing import Any, Callable, Iterator, Union

What = Union[None, str, Callable[[], str]]

PERIOD = 0.01
"""Time (s) between two looks."""
LONGEST_SHOWN = 2000
"""Characters of the last value that a failure shows."""


def wait_until(
    condition: Callable[[], Any],
    what: What = None,
    timeout: float = 10.0,
    period: float = PERIOD,
) -> Any:
    """Return the first true value of a condition.

    Parameters
    ----------
    condition
        Called again and again. LookupError counts as false; any other exception ends the wait.
    what
        What is awaited, for the failure's message; a function is called when it has failed. By
        default, the source of the condition.
    timeout
        Time (s) after which the wait fails. The condition is looked at once more after it.
    period
        Time (s) between two looks.

    Raises
    ------
    AssertionError
        It was not so in time.
    """
    for value in _looks(condition, what, timeout):
        if value:
            return value
        time.sleep(period)
    raise AssertionError("unreachable: the looks end by a value or by an error")


async def wait_until_async(
    condition: Callable[[], Any],
    what: What = None,
    timeout: float = 10.0,
    period: float = 0.5 * PERIOD,
) -> Any:
    """Do the same in an event loop, which goes on meanwhile."""
    for value in _looks(condition, what, timeout):
        if value:
            return value
        await asyncio.sleep(period)
    raise AssertionError("unreachable: the looks end by a value or by an error")


def _looks(condition: Callable[[], Any], what: What, timeout: float) -> Iterator[Any]:
    """Yield what a condition says, until the time is over."""
    deadline = time.monotonic() + timeout
    while True:
        last_look = time.monotonic() >= deadline
        try:
            value = seen = condition()
        except LookupError as error:
            value, seen = None, error
        yield value
        if last_look:
            words = what() if callable(what) else what or _source_of(condition)
            raise AssertionError(
                f"not within {timeout:g} s: {words}; last seen: {repr(seen)[:LONGEST_SHOWN]}"
            )


def _source_of(condition: Callable[[], Any]) -> str:
    try:
        return " ".join(inspect.getsource(condition).split())
    except (OSError, TypeError):
        return repr(condition)
