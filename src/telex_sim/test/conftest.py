from __future__ import annotations

import pytest

from telex_sim.offline import OfflineSimulation, robot_description


@pytest.fixture(scope="session")
def urdf():
    return robot_description()


@pytest.fixture
def robot(urdf):
    """Makes shipped robots, and closes them."""
    made = []

    def make(**changes):
        offline = OfflineSimulation(urdf, **changes)
        made.append(offline)
        return offline

    yield make
    for offline in made:
        offline.simulation.close()
