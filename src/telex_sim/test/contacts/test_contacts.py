"""Contacts as a body has them, whichever of the two PyBullet made first."""

from types import SimpleNamespace

import pybullet
import pytest

from telex_sim.engine.contacts import contacts, directed_contacts

WEIGHT, PUSH = 20.0, 6.0  # N


@pytest.fixture
def client():
    number = pybullet.connect(pybullet.DIRECT)
    pybullet.setGravity(0.0, 0.0, -10.0, physicsClientId=number)
    yield number
    pybullet.disconnect(physicsClientId=number)


def box(client, mass, half, height):
    shape = pybullet.createCollisionShape(
        pybullet.GEOM_BOX, halfExtents=half, physicsClientId=client
    )
    uid = pybullet.createMultiBody(mass, shape, -1, [0.0, 0.0, height], physicsClientId=client)
    pybullet.changeDynamics(uid, -1, lateralFriction=1.0, physicsClientId=client)
    return SimpleNamespace(uid=uid, client=client)


def floor(client):
    return box(client, 0.0, [2.0, 2.0, 0.5], -0.5)


def load(client):
    return box(client, 0.1 * WEIGHT, [0.1, 0.1, 0.05], 0.05)


def push(body):
    """Push it along x, less than friction holds, until all is at rest."""
    for _ in range(240):
        pybullet.applyExternalForce(
            body.uid,
            -1,
            [PUSH, 0.0, 0.0],
            pybullet.getBasePositionAndOrientation(body.uid, physicsClientId=body.client)[0],
            pybullet.WORLD_FRAME,
            physicsClientId=body.client,
        )
        pybullet.stepSimulation(physicsClientId=body.client)


def pushed_box(client, floor_first):
    """Floor and box, made in this order or the other one; the box is pushed."""
    if floor_first:
        ground, pushed = floor(client), load(client)
    else:
        pushed, ground = load(client), floor(client)
    push(pushed)
    return ground, pushed


def force_on(found):
    """Sum of all forces (N)."""
    return [
        sum(each.force * each.normal[axis] + each.friction[axis] for each in found)
        for axis in range(3)
    ]


@pytest.mark.parametrize("floor_first", [True, False])
def test_directed_contacts_hold_a_pushed_box_where_it_is(client, floor_first):
    ground, pushed = pushed_box(client, floor_first)
    on_load, on_floor = list(directed_contacts(pushed)), list(directed_contacts(ground))
    assert force_on(on_load) == pytest.approx([-PUSH, 0.0, WEIGHT], abs=0.1)
    assert force_on(on_floor) == pytest.approx([PUSH, 0.0, -WEIGHT], abs=0.1)
    assert {each.other for each in on_load} == {(ground.uid, -1)}
    assert {each.other for each in on_floor} == {(pushed.uid, -1)}


@pytest.mark.parametrize("floor_first", [True, False])
def test_quick_contacts_differ_in_the_sign_of_friction_at_most(client, floor_first):
    ground, pushed = pushed_box(client, floor_first)
    for body in (pushed, ground):
        quick, directed = list(contacts(body)), list(directed_contacts(body))
        assert len(quick) == len(directed) > 0
        signs = set()
        for one, other in zip(quick, directed):
            assert one._replace(friction=None) == other._replace(friction=None)
            signs.add(one.friction == pytest.approx(other.friction))
            assert [abs(a) for a in one.friction] == pytest.approx([abs(a) for a in other.friction])
        assert len(signs) == 1


def test_contacts_of_one_link_only(client):
    floor(client)
    pushed = load(client)
    push(pushed)
    assert list(contacts(pushed, -1)) == list(contacts(pushed))
    assert list(directed_contacts(pushed, -1)) == list(directed_contacts(pushed))
    assert list(directed_contacts(pushed, 0)) == []
