"""Times at which a joystick's state is published."""

from __future__ import annotations

from typing import List, Optional


class PublishPacer:
    """Publishes a button at once, an axis together with others that move in the same moment.

    Parameters
    ----------
    autorepeat_rate
        Messages per second while nothing changes; 0: none.
    coalesce_interval
        Time (s) for which an axis that has moved waits for others.
    """

    def __init__(self, autorepeat_rate: float, coalesce_interval: float) -> None:
        self._period = 1.0 / autorepeat_rate if autorepeat_rate > 0.0 else None
        self._coalesce = coalesce_interval
        self._changed_until: Optional[float] = None
        self._sent: Optional[float] = None

    def changed(self, now: float, at_once: bool) -> None:
        """Take that something has changed at `now` (monotonic time, s)."""
        until = now if at_once else now + self._coalesce
        if self._changed_until is None or until < self._changed_until:
            self._changed_until = until

    def wait(self, now: float) -> Optional[float]:
        """Return the time (s) until something is to be published, 0 for now, None for never."""
        times: List[float] = [] if self._changed_until is None else [self._changed_until]
        if self._period is not None:
            times.append(now if self._sent is None else self._sent + self._period)
        return max(0.0, min(times) - now) if times else None

    def sent(self, now: float) -> None:
        """Take that the state was published at `now` (monotonic time, s)."""
        self._changed_until = None
        self._sent = now
