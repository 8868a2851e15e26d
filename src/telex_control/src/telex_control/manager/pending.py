"""Values that callbacks hand over to the control loop."""

from __future__ import annotations

from typing import Deque, Iterator, TypeVar

Item = TypeVar("Item")


def drain(items: Deque[Item]) -> Iterator[Item]:
    """Take everything out, oldest first; several threads may, and each item goes to one."""
    while True:
        try:
            yield items.popleft()
        except IndexError:
            return
