"""Masses and inertias that PyBullet would not move as the description means it."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pybullet
import pytest

from telex_control.urdf.joints import parse_urdf
from telex_sim.engine.world import World
from telex_sim.robot.urdf.masses import complete_masses, massless_joints


@pytest.fixture
def world():
    made = World(0.002, 10)
    yield made
    made.close()


SLED = """
<robot name="sled">
  <link name="footprint">{root}</link>
  <link name="hull"><inertial><origin xyz="0.1 0 0.2"/><mass value="{hull}"/>
    <inertia ixx="1" iyy="2" izz="3" ixy="0.1" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size="0.8 0.4 0.2"/></geometry></collision></link>
  <link name="slide"/>
  <link name="boom"><inertial><origin xyz="0.3 0 0"/><mass value="4"/>
    <inertia ixx="0.1" iyy="0.2" izz="0.2" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="mount" type="fixed"><parent link="footprint"/><child link="hull"/>
    <origin xyz="0.1 0 0.1" rpy="0 0 0.4"/></joint>
  <joint name="out" type="prismatic"><parent link="hull"/><child link="slide"/>
    <axis xyz="1 0 0"/><limit lower="0" upper="1" effort="10" velocity="1"/></joint>
  <joint name="turn" type="continuous"><parent link="slide"/><child link="boom"/>
    <origin xyz="0 0 0.3"/><axis xyz="0 1 0"/></joint>
</robot>
"""
NO_MASS = (
    '<inertial><mass value="0"/>'
    '<inertia ixx="0.5" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial>'
)


@pytest.mark.parametrize("root", ["", NO_MASS])
def test_a_root_without_mass_moves_as_what_is_fixed_to_it(world, root):
    """Against the same robot without that frame, pushed and turned at the same place."""
    whole = (
        SLED.format(root="", hull=20)
        .replace('<link name="footprint"></link>', "")
        .replace('<joint name="mount"', "<!--")
        .replace('rpy="0 0 0.4"/></joint>', "-->", 1)
    )
    bodies = [
        world.load_robot(SLED.format(root=root, hull=20), str, (0.0, 0.0, 1.0), 0.0, {}),
        world.load_robot(whole, str, (0.1, 5.0, 1.1), 0.4, {}),
    ]
    for _ in range(50):
        for body in bodies:
            hull = body.links["hull"]
            turn = body.joints["turn"]
            pybullet.setJointMotorControl2(
                body.uid, turn, pybullet.TORQUE_CONTROL, force=3.0, physicsClientId=world.client
            )
            pybullet.applyExternalForce(
                body.uid,
                hull,
                (60.0, 20.0, 0.0),
                np.add(body.pose("hull")[0], (0.0, 0.3, 0.2)),
                pybullet.WORLD_FRAME,
                physicsClientId=world.client,
            )
        world.step()
    for link in ("hull", "boom"):
        (first, turned), (second, expected) = (body.pose(link) for body in bodies)
        assert np.subtract(second, first) == pytest.approx((0.0, 5.0, 0.0), abs=1e-5), link
        assert abs(np.dot(turned, expected)) == pytest.approx(1.0, abs=1e-7), link
    assert bodies[0].pose("footprint")[0][2] < 0.97


def test_what_has_no_mass_is_told():
    masses = complete_masses(ElementTree.fromstring(SLED.format(root=NO_MASS, hull=20)), False)
    assert not masses.fixed
    assert masses.remarks == ["link 'footprint' has the mass 0, so its <inertia> does not count"]


def test_joints_that_move_no_mass_are_found():
    described = parse_urdf(
        SLED.format(root="", hull=20).replace(
            "</robot>",
            '<link name="tip"/><joint name="tilt" type="revolute"><parent link="boom"/>'
            '<child link="tip"/></joint></robot>',
        )
    )
    assert massless_joints(described) == ["tilt"]


def test_a_robot_that_no_mass_carries_is_held(world):
    text = SLED.format(root="", hull=0)
    masses = complete_masses(ElementTree.fromstring(text), False)
    assert masses.fixed
    assert "'footprint' is the root, and neither it nor what is fixed" in masses.remarks[-1]
    body = world.load_robot(text, str, (0.0, 0.0, 1.0), 0.0, {})
    for _ in range(20):
        world.step()
    assert body.pose("hull")[0] == pytest.approx((0.1, 0.0, 1.1))


@pytest.mark.parametrize(
    ("moments", "possible", "told"),
    [
        # One below 0, as CAD writes them, one above the sum of the others, a thin plate, a rod.
        ((2e-8, 6e-8, 1e-8, 3e-8, 1e-8, 4e-8), None, 1),
        ((1e-6, 0.0, 0.0, 2e-6, 0.0, 5e-6), (5e-6 / 3, 8e-6 / 3, 13e-6 / 3), 1),
        ((9e-6, -1e-6, 0.0, 1e-6, 0.0, 1e-5), (8.769e-7, 9.123e-6, 1e-5), 0),
        ((0.0, 0.0, 0.0, 0.1, 0.0, 0.1), (1e-5, 0.1, 0.1), 0),
    ],
)
def test_an_inertia_that_no_body_has_counts_as_the_nearest(world, moments, possible, told):
    keys = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    inertia = " ".join(f'{key}="{value}"' for key, value in zip(keys, moments))
    text = (
        '<robot name="r"><link name="a"><inertial><origin rpy="0.3 0.2 0.1"/><mass value="0.01"/>'
        f"<inertia {inertia}/></inertial></link></robot>"
    )
    remarks = complete_masses(ElementTree.fromstring(text), False).remarks
    assert len(remarks) == told
    assert all("link 'a' has an inertia that no body can have" in remark for remark in remarks)
    body = world.load_robot(text, str, (0.0, 0.0, 1.0), 0.0, {})
    found = sorted(pybullet.getDynamicsInfo(body.uid, -1, physicsClientId=world.client)[2])
    assert found[0] >= -1e-15
    assert 0.0 < found[2] <= found[0] + found[1] + 1e-12
    if possible:
        assert found == pytest.approx(possible, rel=1e-3)
