"""Waiting in the tests of the web nodes, in threads and on a loop; a failure says for what."""

from __future__ import annotations

import asyncio
import inspect
import time

MOST_SHOWN = 300
"""Characters of a condition, and of what it gave last, in the message of a failure."""


def wait_until(condition, timeout=10.0, period=0.02):
    """Return the first true value of a condition.

    An element that is not there yet (LookupError) counts as false; other exceptions end the wait.

    Raises
    ------
    AssertionError
        It has not become true within `timeout` (s); the text has its source and its last value.
    """
    for value in _looks(condition, timeout):
        if value:
            return value
        time.sleep(period)
    raise AssertionError("a wait ends by a value or by an error")


async def becomes(condition, timeout=5.0, period=0.005):
    """Do what `wait_until` does, on a loop that goes on meanwhile."""
    for value in _looks(condition, timeout):
        if value:
            return value
        await asyncio.sleep(period)
    raise AssertionError("a wait ends by a value or by an error")


def _looks(condition, timeout):
    """Yield what a condition gives, once more when the time is over."""
    deadline = time.monotonic() + timeout
    over = False
    while not over:
        over = time.monotonic() >= deadline
        try:
            value = seen = condition()
        except LookupError as error:
            value, seen = None, error
        yield value
    raise AssertionError(
        f"not within {timeout:g} s: {_source(condition)}; it gave {_short(repr(seen))}"
    )


def _source(condition):
    """Return the lines in which a condition stands, as one."""
    try:
        return _short(inspect.getsource(condition))
    except (OSError, TypeError):  # of what was made without a file
        return repr(condition)


def _short(text):
    text = " ".join(text.split())
    return text if len(text) <= MOST_SHOWN else f"{text[:MOST_SHOWN]}…"
