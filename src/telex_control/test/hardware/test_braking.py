"""How hard a robot may brake: by its attitude, its joints and its load."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest

from telex_control.base.braking import BrakingConfig, BrakingLimit
from telex_control.common.params import ConfigError, read_config
from telex_control.hardware.hardware_interface import JointStateHandle
from telex_control.kinematics import KinematicsError
from telex_control.urdf.joints import parse_urdf

G = 9.81
HULL, ARM, REACH = 80.0, 10.0, 1.0  # kg, kg, m
GROUND, SUPPORT, RESERVE = 0.1, 0.3, 0.2

URDF = f"""
<robot name="crane">
  <link name="base_link"><inertial><origin xyz="0 0 0.1"/><mass value="{HULL}"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="arm"><inertial><origin xyz="{0.5 * REACH} 0 0"/><mass value="{ARM}"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="hand"/>
  <joint name="boom" type="revolute"><parent link="base_link"/><child link="arm"/>
    <origin xyz="0 0 0.3"/><axis xyz="0 -1 0"/>
    <limit lower="-3" upper="3" velocity="1" effort="500"/><dynamics friction="5"/></joint>
  <joint name="wrist" type="fixed"><parent link="arm"/><child link="hand"/>
    <origin xyz="{REACH} 0 0"/></joint>
</robot>
"""


class Crane:
    """A boom that lies forward at 0, and points up at 90 degrees."""

    def __init__(self, **changes):
        self.boom = JointStateHandle("boom")
        settings = {"support": SUPPORT, "reserve": RESERVE, "load_link": "hand", **changes}
        self.config = read_config(BrakingConfig, settings, "/braking")
        self.limit = BrakingLimit(
            self.config,
            parse_urdf(URDF),
            "base_link",
            GROUND,
            {"boom": self.boom},
            lambda joint: lambda time: self.own_effort(),
        )
        self.time = 0.0

    def own_effort(self):
        return ARM * G * 0.5 * REACH * math.cos(self.boom.position)

    def carry(self, mass, friction=0.0):
        self.boom.effort = self.own_effort() + friction
        self.boom.effort += mass * G * REACH * math.cos(self.boom.position)

    def ask(self, speed=1.0, pitch=0.0, acceleration=0.0, seconds=0.04):
        """Drive for a while, nose down by `pitch`."""
        up = (-math.sin(pitch), 0.0, math.cos(pitch))
        for _ in range(round(seconds / 0.04)):
            self.time += 0.04
            found = self.limit.limit(self.time, speed, acceleration, up)
        return found


def expected(load, angle=0.0, way=1.0, pitch=0.0):
    """By hand: the deceleration at which the force points `RESERVE` before the edge."""
    x, z = math.cos(angle), math.sin(angle)
    mass = HULL + ARM + load
    forward = (ARM * 0.5 + load) * REACH * x / mass
    height = (HULL * 0.1 + ARM * (0.3 + 0.5 * REACH * z) + load * (0.3 + REACH * z)) / mass
    edge = math.atan2(SUPPORT - way * forward, height + GROUND)
    return G * (math.tan(edge - RESERVE) * math.cos(pitch) - way * math.sin(pitch))


@pytest.mark.parametrize("angle", [0.0, 0.7, 1.4])
@pytest.mark.parametrize("load", [0.0, 3.0])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_it_is_reckoned_from_masses_joints_and_load(angle, load, way):
    crane = Crane()
    crane.boom.position = angle
    crane.carry(load)
    found = crane.ask(0.5 * way)
    # A load over the boom's axis pulls at nothing.
    assert found == pytest.approx(expected(load, angle, way), rel=0.02 if angle < 1.0 else 0.2)


@pytest.mark.parametrize(("pitch", "way"), [(0.15, 1.0), (-0.15, 1.0), (0.15, -1.0)])
def test_it_is_less_down_a_slope_and_more_up(pitch, way):
    crane = Crane()
    crane.carry(0.0)
    found = crane.ask(way, pitch)
    assert found == pytest.approx(expected(0.0, 0.0, way, pitch), rel=1e-3)
    level = expected(0.0, 0.0, way)
    assert (found < level) is (pitch * way > 0.0)


@pytest.mark.parametrize("roll", [-0.5, -0.45, -0.3, 0.3, 0.45, 0.5])
def test_across_a_slope_it_brakes_softly(roll):
    """A fifth of the deceleration rocks it over its side."""
    half_width = 0.25
    crane = Crane(half_width=half_width)
    crane.boom.position = 0.5 * math.pi
    up = (0.0, math.sin(roll), math.cos(roll))
    found = crane.limit.limit(1.0, 1.0, 0.0, up)
    edge = math.atan2(half_width, (HULL * 0.1 + ARM * (0.3 + 0.5 * REACH)) / (HULL + ARM) + GROUND)
    aside = G * (math.tan(edge - RESERVE) * math.cos(roll) - math.sin(abs(roll))) / 0.2
    along = G * math.tan(math.atan2(SUPPORT, half_width / math.tan(edge)) - RESERVE) * up[2]
    assert found == pytest.approx(max(1.25, min(along, aside)), rel=1e-3)
    assert (found < along) is (abs(roll) > 0.4)
    # Without knowing how wide it is:
    assert Crane().limit.limit(1.0, 1.0, 0.0, up) > 1.25


@pytest.mark.parametrize("pitch", [0.8, 1.5, math.pi])
def test_there_is_always_some(pitch):
    crane = Crane(least_deceleration=0.7)
    assert crane.ask(1.0, pitch) == 0.7


def test_nothing_is_limited_at_rest_nor_without_sensor_on_a_slope():
    crane = Crane()
    crane.carry(0.0)
    assert crane.ask(0.0) == math.inf
    assert crane.limit.limit(9.0, 1.0, 0.0, None) == pytest.approx(expected(0.0), rel=1e-3)


def test_friction_is_no_load_and_a_push_from_below_is_none():
    for friction in (4.9, -4.9, -200.0):
        crane = Crane()
        crane.carry(0.0, friction)
        crane.ask()
        assert crane.limit.load == 0.0


def test_a_load_is_seen_at_rest_and_later_in_steady_drive_only():
    crane = Crane()
    crane.carry(3.0)
    crane.ask(acceleration=2.0)
    assert crane.limit.load == pytest.approx(3.0, rel=0.05)
    crane.carry(0.0)
    crane.ask(acceleration=-2.0, seconds=1.0)
    assert crane.limit.load == pytest.approx(3.0, rel=0.05)
    crane.ask(seconds=0.3)
    assert 0.5 < crane.limit.load < 2.0
    crane.ask(seconds=2.0)
    assert crane.limit.load < 0.1


def test_without_load_link_no_load_is_looked_for():
    crane = Crane(load_link="")
    crane.carry(10.0)
    assert crane.ask() == pytest.approx(expected(0.0), rel=1e-3)


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"support": 0.0}, "/braking: support is 0.0"),
        ({"support": None}, "/braking/support is None"),
        ({"reserve": -0.1}, "/braking: reserve is -0.1"),
        ({"least_deceleration": 0.0}, "/braking: least_deceleration is 0.0"),
        ({"half_width": 0.0}, "/braking: half_width is 0.0"),
        ({"load": "hand"}, "/braking/load is unknown"),
    ],
)
def test_wrong_parameters_are_named(changes, named):
    with pytest.raises(ConfigError, match=named):
        Crane(**changes)


def test_a_link_that_is_not_there_is_named():
    with pytest.raises(KinematicsError, match="no link 'claw'"):
        Crane(load_link="claw")


def test_a_robot_without_masses_is_refused():
    bare = parse_urdf('<robot name="r"><link name="base_link"/></robot>')
    config = BrakingConfig(SUPPORT)
    with pytest.raises(KinematicsError, match="no link has a mass"):
        BrakingLimit(config, bare, "base_link", GROUND, {}, SimpleNamespace)
