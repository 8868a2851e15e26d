"""Doses of a robot's parts as messages."""

from __future__ import annotations

from typing import Iterable, Tuple

from telex_msgs.msg import ComponentDoses


def doses_message(components: Iterable[Tuple[str, float, float, bool]]) -> ComponentDoses:
    """Make the message of parts, without its stamp.

    Parameters
    ----------
    components : iterable of tuple
        Name, dose rate (Gy/h), dose (Gy) and whether it has died.
    """
    names, rates, doses, failed = zip(*components)
    return ComponentDoses(
        names=list(names), dose_rate=list(rates), dose=list(doses), failed=list(failed)
    )
