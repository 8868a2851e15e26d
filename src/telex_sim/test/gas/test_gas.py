"""Gas around leaks: the closed form, a scene's leaks, the sensor."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, Iterator

import numpy as np
import pytest

from telex_control.common.params import ConfigError
from telex_sim.engine.gas_sensor import GasSensor
from telex_sim.gas.plume import DIFFUSIVITY, NEAREST, shares
from telex_sim.gas.sensor_config import GasSensorConfig
from telex_sim.offline.simulation import OfflineSimulation, robot_description

FLOW = 2.0e-5  # m3/s: 1.2 l/min
ALONG_Y = np.array([0.0, 0.5, 0.0])
SCENE = """
start: {x: -0.9, y: 0.0}
objects:
  - {type: flange_line, name: line, position: [0.0, 1.0, 0.0], leak: LEAK, drift: 0.1}
"""


def share(way: Any, drift: Any = (0.0, 0.0, 0.0)) -> float:
    return float(shares(np.array([way]), np.array([FLOW]), np.array([drift]))[0])


class TestPlume:
    def test_in_still_air_it_falls_with_the_distance(self) -> None:
        assert share((0.3, 0.0, 0.4)) == pytest.approx(FLOW / (4.0 * math.pi * DIFFUSIVITY * 0.5))
        assert share((0.0, 0.0, 0.0)) == share((0.0, 0.0, NEAREST))

    def test_straight_behind_the_leak_the_drift_changes_nothing(self) -> None:
        assert share((0.7, 0.0, 0.0), (0.5, 0.0, 0.0)) == pytest.approx(share((0.7, 0.0, 0.0)))

    def test_before_the_leak_there_is_less(self) -> None:
        # |u| r - u d = 2 |u| r straight against the drift.
        expected = share((0.0, 0.7, 0.0)) * math.exp(-0.1 * 0.7 / DIFFUSIVITY)
        assert share((0.0, -0.7, 0.0), (0.0, 0.1, 0.0)) == pytest.approx(expected)

    def test_what_drifts_through_a_plane_is_what_leaks(self) -> None:
        # Advection less diffusion through a plane half a metre behind the leak.
        step, edge, drift = 0.02, 3.0, 0.2
        side = np.arange(-edge, edge, step) + 0.5 * step
        y, z = np.meshgrid(side, side)

        def at(x: float) -> np.ndarray:
            ways = np.stack([np.full(y.size, x), y.ravel(), z.ravel()], axis=1)
            count = len(ways)
            return shares(ways, np.full(count, FLOW), np.tile([drift, 0.0, 0.0], (count, 1)))

        slope = (at(0.51) - at(0.49)) / 0.02
        assert float((drift * at(0.5) - DIFFUSIVITY * slope).sum()) * step**2 == pytest.approx(
            FLOW, rel=0.01
        )

    def test_there_is_never_more_than_all(self) -> None:
        assert shares(np.zeros((1, 3)), np.array([1.0]), np.zeros((1, 3)))[0] == 1.0


@pytest.mark.parametrize(
    "wrong", [{"rate": 0.0}, {"rate": math.nan}, {"response": -1.0}, {"response": math.inf}]
)
def test_a_sensor_that_cannot_be_is_refused(wrong: Any) -> None:
    with pytest.raises(ConfigError, match=next(iter(wrong))):
        GasSensorConfig(**wrong)


@pytest.fixture
def started(tmp_path: Path) -> Iterator[Any]:
    made = []

    def start(text: str) -> OfflineSimulation:
        path = tmp_path / "scene.yaml"
        path.write_text(text)
        made.append(OfflineSimulation(robot_description(), world=str(path)))
        return made[-1]

    yield start
    for each in made:
        each.simulation.close()


@pytest.mark.slow
class TestSensor:
    def test_it_follows_the_gas_at_the_tool_with_its_delay(self, started: Any) -> None:
        offline = started(SCENE.replace("LEAK", "4"))
        simulation = offline.simulation
        robot = simulation.robots[0]
        sensor = GasSensor(robot)
        assert sensor.observe(simulation) == 0.0
        for _ in range(5):
            offline.run(0.2)
            reading = sensor.observe(simulation)
        there = simulation.gas.share(robot.body.pose("tool_link")[0])
        assert reading == pytest.approx((1.0 - math.exp(-1.0)) * there, rel=0.05)
        saved = sensor.save_state()
        offline.run(0.4)
        assert sensor.observe(simulation) > reading
        sensor.restore_state(saved, 0.4)
        assert sensor.observe(simulation) == pytest.approx(reading, rel=1e-6)

    def test_without_a_leak_there_is_nothing_to_read(self, started: Any) -> None:
        simulation = started(SCENE.replace("LEAK", "0")).simulation
        assert simulation.gas is None
        assert GasSensor(simulation.robots[0]).observe(simulation) is None

    def test_a_leak_turns_with_its_object(self, started: Any) -> None:
        text = SCENE.replace("LEAK", "8").replace("drift: 0.1", "drift: 0.1, yaw: 1.5708")
        gas = started(text).simulation.gas
        # The eighth of eight flanges stands along y now, by 3.5 spacings, where the air drifts to.
        place = np.array([0.0, 1.0 + 3.5 * 0.7, 0.95 + 1.75 * 0.05])
        behind, before = gas.share(place + ALONG_Y), gas.share(place - ALONG_Y)
        assert behind == pytest.approx(share((0.5, 0.0, 0.0)), rel=1e-3)
        assert before < 0.1 * behind
