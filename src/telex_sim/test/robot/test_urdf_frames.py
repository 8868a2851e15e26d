"""Links that PyBullet is spared: where they are all the same, and what of them stays."""

from __future__ import annotations

import math
from xml.etree import ElementTree

import numpy as np
import pybullet
import pytest

from telex_sim.engine.world import World
from telex_sim.robot.urdf.frames import take_out_frames, take_out_wheels

LINKS = """
<robot name="cart">
  <link name="base">
    <inertial><origin xyz="0.1 0 0.02"/><mass value="3"/>
      <inertia ixx="0.2" iyy="0.3" izz="0.4" ixy="0.01" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size="0.4 0.2 0.1"/></geometry></collision>
  </link>
  <link name="plate"><inertial><mass value="1e-6"/>
    <inertia ixx="1e-9" iyy="1e-9" izz="1e-9" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><origin xyz="0 0 0.1"/><geometry><box size="0.1 0.1 0.1"/></geometry></visual></link>
  <link name="lens"/>
  <link name="bracket"/>
  <link name="arm"><inertial><mass value="1"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="tip"/>
  <link name="wheel"><inertial><origin xyz="0 0 0.03"/><mass value="2"/>
    <inertia ixx="0.05" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="plate_mount" type="fixed"><parent link="base"/><child link="plate"/>
    <origin xyz="0.2 0 0.1" rpy="0 0 1.2"/></joint>
  <joint name="lens_mount" type="fixed"><parent link="plate"/><child link="lens"/>
    <origin xyz="0.05 0.02 0" rpy="-1.57 0.3 0"/></joint>
  <joint name="bracket_mount" type="fixed"><parent link="base"/><child link="bracket"/>
    <origin xyz="0 0.1 0"/></joint>
  <joint name="swing" type="revolute"><parent link="bracket"/><child link="arm"/>
    <origin xyz="0 0 0.1"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" effort="10" velocity="1"/></joint>
  <joint name="tip_mount" type="fixed"><parent link="arm"/><child link="tip"/>
    <origin xyz="0.3 0 0"/></joint>
  <joint name="spin" type="continuous"><parent link="base"/><child link="wheel"/>
    <origin xyz="0.1 0.2 0" rpy="0 0 0.7"/><axis xyz="0 1 0"/></joint>
</robot>
"""
ANGLES = {"swing": 0.8}


@pytest.fixture
def world():
    made = World(0.002, 10)
    yield made
    made.close()


def test_every_link_is_where_pybullet_would_have_it(world):
    """Against the same robot with all its links, which a mass keeps in PyBullet."""
    body = world.load_robot(LINKS, str, (1.0, 2.0, 3.0), 0.6, ANGLES, wheels=["spin"])
    root = ElementTree.fromstring(LINKS)
    for link in root.findall("link"):
        for inertial in link.findall("inertial"):
            if link.get("name") != "base":
                link.remove(inertial)
        if link.get("name") != "base":
            inertial = ElementTree.SubElement(link, "inertial")
            ElementTree.SubElement(inertial, "mass", value="0.1")
            moments = {"ixx": "1", "iyy": "1", "izz": "1", "ixy": "0", "ixz": "0", "iyz": "0"}
            ElementTree.SubElement(inertial, "inertia", moments)
    text = ElementTree.tostring(root, encoding="unicode")
    whole = world.load_robot(text, str, (1.0, 2.0, 3.0), 0.6, {**ANGLES, "spin": 0.9})
    body.wheels["spin"] = 0.9
    assert set(body.links) == {"base", "bracket", "arm"}
    assert set(whole.links) == set(body.link_names())
    ours, theirs = (
        dict(zip(each.link_names(), np.reshape(each.link_poses(), (-1, 7))))
        for each in (body, whole)
    )
    for link in ours:
        assert ours[link][:3] == pytest.approx(theirs[link][:3], abs=1e-6), link
        turned, expected = ours[link][3:], theirs[link][3:]
        expected = expected if turned @ expected > 0.0 else -expected
        assert turned == pytest.approx(expected, abs=1e-6), link
        if link != "wheel":
            assert body.pose(link)[0] == pytest.approx(theirs[link][:3], abs=1e-6), link


def test_a_wheel_leaves_its_mass_and_inertia(world):
    body = world.load_robot(LINKS, str, (0.0, 0.0, 1.0), 0.0, {}, wheels=["spin"])
    mass, _, moments, center = pybullet.getDynamicsInfo(body.uid, -1, physicsClientId=world.client)[
        :4
    ]
    assert mass == pytest.approx(5.0)
    expected = (3.0 * np.array([0.1, 0.0, 0.02]) + 2.0 * np.array([0.1, 0.2, 0.03])) / 5.0
    assert center == pytest.approx(expected)
    turn = np.array([[math.cos(0.7), -math.sin(0.7), 0], [math.sin(0.7), math.cos(0.7), 0]])
    turn = np.vstack([turn, [0, 0, 1]])
    total = np.array([[0.2, 0.01, 0], [0.01, 0.3, 0], [0, 0, 0.4]])
    total = total + turn @ np.diag([0.05, 0.02, 0.02]) @ turn.T
    for share, place in ((3.0, [0.1, 0.0, 0.02]), (2.0, [0.1, 0.2, 0.03])):
        away = np.array(place) - expected
        total = total + share * (away @ away * np.eye(3) - np.outer(away, away))
    assert sorted(moments) == pytest.approx(sorted(np.linalg.eigvalsh(total)), rel=1e-6)


def test_what_is_seen_of_a_frame_goes_to_its_carrier():
    root = ElementTree.fromstring(LINKS)
    frames = take_out_frames(root)
    assert set(frames) == {"plate", "lens", "tip"}
    (visual,) = (link for link in root.findall("link") if link.get("name") == "base")
    place = visual.find("visual/origin").get("xyz").split()
    assert [float(value) for value in place] == pytest.approx([0.2, 0.0, 0.2])


@pytest.mark.parametrize(
    ("old", "new"),
    [
        # Solid, heavy, carrying something, or placed by what only PyBullet makes sense of.
        ('<link name="lens"/>', '<link name="lens"><collision/></link>'),
        (
            '<link name="lens"/>',
            '<link name="lens"><inertial><mass value="0.1"/></inertial></link>',
        ),
        ('xyz="0.05 0.02 0"', 'xyz="$(arg x) 0 0"'),
    ],
)
def test_what_counts_stays_with_all_that_carries_it(old, new):
    assert old in LINKS
    assert set(take_out_frames(ElementTree.fromstring(LINKS.replace(old, new)))) == {"tip"}


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('<link name="wheel">', '<link name="wheel"><collision/>'),
        ('<parent link="bracket"/>', '<parent link="wheel"/>'),
    ],
)
def test_a_wheel_that_touches_or_carries_something_stays(old, new):
    assert old in LINKS
    assert take_out_wheels(ElementTree.fromstring(LINKS.replace(old, new)), ["spin"]) == {}
