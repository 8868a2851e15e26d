"""What `benchmarks/console` makes of what the pages have counted."""

from __future__ import annotations

from types import SimpleNamespace

import pytest


def test_rates_are_those_of_every_window():
    from telex_experiments.console.views import rates, slowest

    assert rates([20] * 12, 12.3) == [20.0] * 3
    # A second without a picture counts in all windows that it is part of, the last ones as well.
    assert rates([20] * 10, 12.0) == [20.0, 18.0, 16.0]
    assert rates([8, 8, 8], 3.5) == [8.0]
    assert rates([], 0.4) == []
    tally = {"length": 30.0, "cameras": {"front": {"seconds": [25] * 30}}}
    assert slowest(tally, ["front"]) == 25.0
    assert slowest(tally, ["front", "rear"]) == 0.0


def test_the_browser_knows_all_keys_that_are_held():
    from telex_experiments.console.views import PHASES
    from telex_experiments.rigs.chromium import _KEYS

    assert {code for phase in PHASES for codes, _ in phase.keys for code in codes} <= set(_KEYS)


def test_the_way_of_a_picture_is_cut_into_stages():
    from telex_experiments.console.views import stages_of

    picture = {"captured": 100.0, "received": 150.0, "decoded": 155.0, "painted": 165.0}
    served = {"made": 0.03, "age": 0.07, "round_trip": 0.03, "rate": 25.0}
    unknown = {**picture, "captured": None}
    stages = stages_of([unknown, picture], served)
    assert stages == pytest.approx([30.0, 10.0, 10.0, 5.0, 10.0, 65.0])
    assert stages_of([unknown], served) == stages_of([picture], {}) == []


@pytest.mark.parametrize(
    ("moves_at", "end"),
    [
        (5.03, 1005.15),  # the picture of 5.04 is the first that may show it
        (5.045, 1005.20),
        (4.9, None),  # before the key
        (5.2, None),  # no picture since
    ],
)
def test_the_first_picture_that_shows_a_motion(moves_at, end):
    from telex_experiments.console.first_picture import first_picture
    from telex_experiments.console.rig import Heard

    still, moving = Heard(moves_at - 0.01, 0.01), Heard(moves_at, 0.03)
    stamps = SimpleNamespace(
        ahead=1000.0, velocities=[still, moving], pictures=[5.0, 5.04, 5.08, 5.12]
    )
    # A picture's own time is up to 10 ms late.
    painted = [
        {"captured": 1005.0095, "painted": 1005.12},
        {"captured": 1005.041, "painted": 1005.15},
        {"captured": 1005.085, "painted": 1005.20},
    ]
    assert first_picture(1005.01, 0.5, stamps, painted) == end
