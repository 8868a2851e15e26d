"""Parameters that say how often something comes."""

from __future__ import annotations

from typing import Any

from telex_control.common.params import checked, require

LEAST_RATE = 1e-3
"""Hz of sim time; what would come more seldom comes in no run."""


def rate_or_never(default: float, text: str, maximum: float) -> Any:
    """Declare a rate that may be 0, for never; parameters as of `params.number`."""

    def check(config: Any, name: str) -> None:
        value = getattr(config, name)
        require(
            value == 0.0 or LEAST_RATE <= value <= maximum,
            f"{name} is {value}; it must be 0, for never, or at least {LEAST_RATE:g} and at most "
            f"{maximum:g}",
        )

    return checked(default, text, check)
