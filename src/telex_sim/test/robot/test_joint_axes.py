"""Axes of joints that are no unit vectors: bodies move as far as joint states and frames say."""

from __future__ import annotations

import math
from pathlib import Path

import pybullet
import pytest

from telex_control.kinematics import Chain
from telex_control.urdf.joints import parse_urdf
from telex_sim.engine.world import World

BODY = (
    '<inertial><mass value="1"/>'
    '<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>'
)


def robot(kind, axis):
    return f"""
<robot name="press">
  <link name="base">{BODY}</link><link name="plate">{BODY}</link><link name="rim">{BODY}</link>
  <joint name="moves" type="{kind}"><parent link="base"/><child link="plate"/>
    <axis xyz="{axis}"/><limit lower="-3" upper="3" effort="10" velocity="1"/></joint>
  <joint name="rim_mount" type="fixed"><parent link="plate"/><child link="rim"/>
    <origin xyz="1 0 0"/><axis xyz="0 0 0"/></joint>
</robot>"""


@pytest.fixture
def world():
    made = World(0.002, 10)
    yield made
    made.close()


@pytest.mark.parametrize(
    ("axis", "place"),
    [
        ("0 0 2", (1.0, 0.0, 0.1)),
        ("0 -0.5 0", (1.0, -0.1, 0.0)),
        ("3 0 4", (1.06, 0.0, 0.08)),
        ("0 0 1", (1.0, 0.0, 0.1)),
    ],
)
def test_a_slide_moves_by_its_position(world, axis, place):
    body = world.load_robot(robot("prismatic", axis), str, (0.0, 0.0, 0.0), 0.0, {"moves": 0.1})
    assert body.pose("rim")[0] == pytest.approx(place, abs=1e-6)


@pytest.mark.parametrize("axis", ["0 0 2", "0 0 0.1", "1 2 -2", "0 0 1"])
def test_a_hinge_turns_as_the_kinematics_have_it(world, axis):
    urdf = robot("revolute", axis)
    body = world.load_robot(urdf, str, (0.0, 0.0, 0.0), 0.0, {"moves": 0.5})
    expected = Chain(parse_urdf(urdf), "base", "rim").forward([0.5])[:3, 3]
    assert body.pose("rim")[0] == pytest.approx(tuple(expected), abs=1e-6)


def test_a_wheel_that_only_shows_how_something_runs_turns_by_its_angle(world):
    urdf = robot("continuous", "0 0 2").replace('parent link="plate"', 'parent link="base"')
    body = world.load_robot(urdf, str, (0.0, 0.0, 0.0), 0.0, {}, wheels=["moves"])
    body.wheels["moves"] = 0.5
    poses = dict(zip(body.link_names(), zip(*[iter(body.link_poses())] * 7)))
    turned = (0.0, 0.0, math.sin(0.25), math.cos(0.25))
    assert poses["plate"][3:] == pytest.approx(turned, abs=1e-6)


@pytest.mark.parametrize(
    "axis", ["0 0 1", "1.0 0  -0", "0.6 0.8 0", "0.7071067811865476 0 7.071067811865476e-1"]
)
def test_an_axis_of_unit_length_is_left_as_it_is_written(world, axis, monkeypatch):
    loaded, load = [], pybullet.loadURDF

    def reads(path, **rest):
        loaded.append(Path(path).read_text())
        return load(path, **rest)

    monkeypatch.setattr(pybullet, "loadURDF", reads)
    world.load_robot(robot("revolute", axis), str, (0.0, 0.0, 0.0), 0.0, {})
    assert f'<axis xyz="{axis}"' in loaded[0]
    assert '<axis xyz="0 0 0"' in loaded[0]
