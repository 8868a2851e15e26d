"""The radio signal: path loss by distance, shadows of bodies."""

from __future__ import annotations

import pybullet
import pytest

from telex_control.common.params import ConfigError, read_struct
from telex_sim.engine.radio import signal_at
from telex_sim.offline.simulation import OfflineSimulation, robot_description
from telex_sim.radio.radio_config import RadioConfig
from telex_sim.radio.reception import signal_of, thicknesses_between

BEGIN, END = (0.0, 0.0, 1.0), (10.0, 0.0, 1.0)


@pytest.fixture
def client():
    client = pybullet.connect(pybullet.DIRECT)
    yield client
    pybullet.disconnect(client)


def box(client, x, thickness, y=0.0):
    half = [thickness / 2, 1.0, 2.0]
    shape = pybullet.createCollisionShape(
        pybullet.GEOM_BOX, halfExtents=half, physicsClientId=client
    )
    return pybullet.createMultiBody(
        baseCollisionShapeIndex=shape, basePosition=[x, y, 1.0], physicsClientId=client
    )


def test_the_signal_falls_with_the_distance_and_with_every_body():
    config = RadioConfig()
    assert signal_of(config, 0.2, ()).power == -40.0
    near, far = signal_of(config, 10.0, ()), signal_of(config, 100.0, ())
    assert (near.power, far.power) == (pytest.approx(-65.0), pytest.approx(-90.0))
    assert (near.quality, far.quality) == (pytest.approx(5 / 6), 0.0)
    behind = signal_of(config, 10.0, (0.2, 5.0))
    assert behind.power == pytest.approx(-65.0 - 8.0 - 25.0)
    assert (behind.walls, behind.quality) == (2, 0.0)


def test_bodies_in_between_are_found_with_their_thickness(client):
    box(client, 3.0, 0.2)
    box(client, 7.0, 0.5)
    box(client, 5.0, 0.3, y=4.0)
    robot = box(client, 9.8, 0.6)
    found = thicknesses_between(client, BEGIN, END, {robot})
    assert found == [pytest.approx(0.2, abs=0.01), pytest.approx(0.5, abs=0.01)]
    assert thicknesses_between(client, BEGIN, BEGIN, ()) == ()


@pytest.mark.parametrize(
    ("scene", "distance"),
    # The robot's antenna stands 0.6 m above its root link.
    [("", 0.9), ("antenna: [30.0, 0.0, 1.5]\n", 30.0), ("start: {x: 3.0, ground: 0.0}\n", 0.9)],
)
def test_the_antenna_stands_where_the_scene_says_or_above_the_start(tmp_path, scene, distance):
    path = tmp_path / "scene.yaml"
    path.write_text(f"{scene}objects: []\n")
    simulation = OfflineSimulation(robot_description(), world=str(path)).simulation
    try:
        signal = signal_at(simulation, simulation.robots[0])
    finally:
        simulation.close()
    base = 0.12  # m, of the root link above the ground
    height = 0.9 - base
    expected = height if distance < 1.0 else (distance**2 + height**2) ** 0.5
    assert signal.distance == pytest.approx(expected, abs=0.1)
    assert signal.walls == 0


def test_a_body_around_the_antenna_counts_by_what_is_before_it(client):
    box(client, 0.0, 2.0)
    (thickness,) = thicknesses_between(client, END, BEGIN, ())
    assert thickness == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize(
    ("params", "said"),
    [
        ({"antenna": [1.0, 2.0, 3.0]}, "antenna is unknown"),
        ({"antenna_height": float("nan")}, "antenna_height is nan"),
        ({"good": -95.0}, "good is -95.0; it must be above -90"),
        ({"rate": -1.0}, "rate is -1.0"),
        ({"height": 1.0}, "height is unknown"),
    ],
)
def test_parameters_that_cannot_be_are_refused(params, said):
    with pytest.raises(ConfigError) as error:
        read_struct(RadioConfig, params)
    assert said in str(error.value)
