"""Malfunctions of a robot as telex_msgs/Malfunctions."""

from __future__ import annotations

import genpy
from telex_msgs.msg import ActiveMalfunction, PossibleMalfunction
from telex_msgs.msg import Malfunctions as MalfunctionsMessage

from .malfunctions import Malfunctions


def malfunctions_message(malfunctions: Malfunctions) -> MalfunctionsMessage:
    """Make the message, but its stamp."""
    return MalfunctionsMessage(
        active=[
            ActiveMalfunction(
                what=each.what,
                group=each.group,
                kind=each.kind,
                value=each.value,
                announced=each.announced,
                since=genpy.Time.from_sec(each.since),
            )
            for each in malfunctions.active
        ],
        possible=[
            PossibleMalfunction(
                what=each.what,
                group=each.group,
                kind=each.kind.name,
                text=each.kind.text,
                unit=each.kind.unit,
                default_value=each.kind.default,
                least=each.kind.least,
                most=each.kind.most,
            )
            for each in malfunctions.possible()
        ],
        unpowered=list(malfunctions.unpowered),
    )
