"""Hinges, slides and latches of objects, in physics."""

from __future__ import annotations

import math
from dataclasses import replace

import pybullet
import pytest

from telex_control.common.params import ConfigError
from telex_sim.scene.model import (
    Closer,
    Detents,
    Form,
    Geometry,
    Joint,
    Link,
    Motion,
    ObjectModel,
    Part,
    SceneObject,
)
from telex_sim.scene.objects.latches import wake

WIDTH, MASS = 0.9, 25.0
LEAF_INERTIA = MASS * (WIDTH**2 / 3.0 + 0.04**2 / 12.0)
"""Of the leaf below about its hinge (kg m2)."""


def box(size, position=(0.0, 0.0, 0.0)):
    return Part(Geometry(Form.BOX, size), position)


def hinged(**joint):
    """A leaf of 25 kg and 0.9 m on a vertical hinge."""
    settings = {"lower": 0.0, "upper": 1.6, **joint}
    return SceneObject(
        "door",
        ObjectModel(
            (
                Link("frame", 0.0, (box((0.1, 0.1, 2.0), (0.0, 0.0, 1.0)),)),
                Link("leaf", MASS, (box((WIDTH, 0.04, 1.9), (WIDTH / 2.0, 0.0, 1.0)),)),
            ),
            (Joint("hinge", Motion.HINGE, "frame", "leaf", (0.0, 0.0, 0.05), **settings),),
            static=True,
        ),
        position=(2.0, 1.0, 0.0),
        orientation=(0.0, 0.0, math.sin(0.4), math.cos(0.4)),
    )


def sliding(**joint):
    """A drawer of 2 kg that moves along x."""
    settings = {"lower": 0.0, "upper": 0.4, "axis": (1.0, 0.0, 0.0), **joint}
    return SceneObject(
        "cabinet",
        ObjectModel(
            (
                Link("body", 0.0, (box((0.4, 0.5, 0.4), (0.0, 0.0, 0.2)),)),
                Link("drawer", 2.0, (box((0.3, 0.4, 0.1)),)),
            ),
            (Joint("slide", Motion.SLIDE, "body", "drawer", (0.3, 0.0, 0.2), **settings),),
            static=True,
        ),
    )


def plug(hold=30.0, **joint):
    """A plug of 0.2 kg in the front of a box, held by a latch."""
    return SceneObject(
        "connector",
        ObjectModel(
            (
                Link("socket", 0.0, (box((0.1, 0.2, 0.4), (0.0, 0.0, 0.2)),)),
                Link("plug", 0.2, (box((0.06, 0.03, 0.03)),)),
            ),
            (
                Joint(
                    "latch",
                    Motion.LATCH,
                    "socket",
                    "plug",
                    (0.081, 0.0, 0.25),
                    axis=(1.0, 0.0, 0.0),
                    hold=hold,
                    **joint,
                ),
            ),
            static=True,
        ),
    )


def turn(stage, name, torque):
    """Something that applies a torque about z to the only joint, in each step."""
    uid, client = stage.uid(name), stage.client

    def apply():
        wake(client, uid)  # as the contact would that brings such a torque
        pybullet.applyExternalTorque(
            uid, 0, (0.0, 0.0, torque), pybullet.WORLD_FRAME, physicsClientId=client
        )

    return apply


def push(stage, uid, link, force):
    """Something that pushes a link at its centre of mass (N, in the world)."""
    client = stage.client

    def apply():
        wake(client, uid)
        if link < 0:
            at = pybullet.getBasePositionAndOrientation(uid, physicsClientId=client)[0]
        else:
            at = pybullet.getLinkState(uid, link, physicsClientId=client)[0]
        pybullet.applyExternalForce(
            uid, link, force, at, pybullet.WORLD_FRAME, physicsClientId=client
        )

    return apply


@pytest.mark.parametrize(("share", "moves"), [(0.98, False), (1.02, True)])
def test_a_hinge_breaks_away_at_its_friction(stage, share, moves):
    tested = stage(hinged(friction=8.0, start=0.5))
    tested.run(1.0, turn(tested, "door", 8.0 * share))
    turned = tested.objects.joint_position("door", "hinge") - 0.5
    assert (abs(turned) > 1e-3) == moves
    if moves:
        # What is left of the torque accelerates the leaf.
        assert turned == pytest.approx(0.5 * 0.16 / LEAF_INERTIA, rel=0.05)


@pytest.mark.parametrize(("share", "moves"), [(0.98, False), (1.02, True)])
def test_a_slide_breaks_away_at_its_friction(stage, share, moves):
    tested = stage(sliding(friction=6.0, start=0.1))
    tested.run(0.5, push(tested, tested.uid("cabinet"), 0, (6.0 * share, 0.0, 0.0)))
    moved = tested.objects.joint_position("cabinet", "slide") - 0.1
    assert (moved > 1e-3) == moves


def test_joints_stop_at_their_limits(stage):
    tested = stage(hinged(start=1.0), sliding(start=0.2))
    for torque, force, angle, place in ((40.0, 20.0, 1.6, 0.4), (-40.0, -20.0, 0.0, 0.0)):
        door = turn(tested, "door", torque)
        drawer = push(tested, tested.uid("cabinet"), 0, (force, 0.0, 0.0))
        tested.run(3.0, lambda door=door, drawer=drawer: (door(), drawer()))
        assert tested.objects.joint_position("door", "hinge") == pytest.approx(angle, abs=2e-3)
        assert tested.objects.joint_position("cabinet", "slide") == pytest.approx(place, abs=1e-3)


def test_a_door_closer_closes_and_then_rests(stage):
    tested = stage(hinged(start=1.5, closer=Closer(4.0, 6.0), damping=25.0, friction=0.5))
    angles = []
    tested.run(8.0, lambda: angles.append(tested.objects.joint_position("door", "hinge")))
    assert angles[1000] > 0.3, "it does not slam"
    shut = next(number for number, angle in enumerate(angles) if angle < 0.0)
    assert all(b < a for a, b in zip(angles[:shut], angles[1:shut])), "it only closes"
    assert max(map(abs, angles[shut:])) < 1e-3, "it does not spring back from its stop"
    assert angles[-1] == pytest.approx(0.0, abs=1e-5)
    assert angles[-1] == angles[-500]


@pytest.mark.parametrize(("torque", "opens"), [(4.4, False), (4.6, True)])
def test_a_closed_door_stays_closed_up_to_preload_and_friction(stage, torque, opens):
    tested = stage(hinged(closer=Closer(4.0), friction=0.5))
    tested.run(1.0, turn(tested, "door", torque))
    assert (tested.objects.joint_position("door", "hinge") > 1e-4) == opens


def test_a_spring_returns_a_joint_to_a_rest_between_its_limits(stage):
    tested = stage(sliding(start=0.3, closer=Closer(5.0, 50.0, 0.15), damping=15.0))
    tested.run(4.0)
    assert tested.objects.joint_position("cabinet", "slide") == pytest.approx(0.15, abs=1e-4)
    resting = tested.objects.joint_position("cabinet", "slide")
    tested.run(0.5)
    assert tested.objects.joint_position("cabinet", "slide") == pytest.approx(resting, abs=1e-7)


def test_a_strong_damper_does_not_diverge(stage):
    # An explicit one would, above 2 I / dt = 6750 N m s/rad.
    tested = stage(hinged(start=0.2, damping=1.0e6))
    angles = []
    tested.run(
        0.5,
        lambda: (
            turn(tested, "door", 100.0)(),
            angles.append(tested.objects.joint_position("door", "hinge")),
        ),
    )
    assert all(0.0 <= b - a < 1e-3 for a, b in zip(angles, angles[1:]))


@pytest.mark.parametrize(("share", "leaves"), [(0.97, False), (1.03, True)])
def test_a_detent_holds_up_to_its_effort(stage, share, leaves):
    notches = Detents((0.0, 0.8, 1.6), effort=5.0, width=0.1)
    tested = stage(hinged(start=0.8, detents=notches, friction=1.0))
    tested.run(3.5, turn(tested, "door", 6.0 * share))
    assert (tested.objects.joint_position("door", "hinge") > 0.9) == leaves


def test_a_detent_draws_a_joint_in(stage):
    notches = Detents((0.0, 0.8, 1.6), effort=5.0, width=0.1)
    tested = stage(hinged(start=0.73, detents=notches, friction=1.0))
    tested.run(3.0)
    assert tested.objects.joint_position("door", "hinge") == pytest.approx(0.8, abs=1e-3)


def test_a_closer_that_cannot_be_simulated_is_refused(stage):
    with pytest.raises(ConfigError, match=r"joint 'hinge': closer/stiffness is 1e\+07"):
        stage(hinged(closer=Closer(0.0, 1.0e7)))


def released_at(tested, direction):
    """Force along `direction` that a slowly growing pull needs to free the plug (N)."""
    uid, latch = tested.uid("connector", 1), tested.objects.latch("connector", "latch")
    force = 0.0
    while latch.holds and force < 100.0:
        force += 20.0 * tested.step_size
        pull = tuple(force * number for number in direction)
        tested.run(tested.step_size, push(tested, uid, -1, pull))
    return force


@pytest.mark.parametrize("direction", [(1.0, 0.0, 0.0), (0.6, 0.8, 0.0), (0.0, 1.0, 0.0)])
def test_a_latch_lets_go_at_its_force_whatever_the_direction(stage, direction):
    tested = stage(plug(hold=30.0))
    tested.run(0.2)
    assert released_at(tested, direction) == pytest.approx(30.0, rel=0.1)


@pytest.mark.parametrize(
    ("direction", "force"),
    [((1.0, 0.0, 0.0), 10.0), ((0.0, 1.0, 0.0), 40.0), ((-1.0, 0.0, 0.0), 40.0)],
)
def test_a_seated_piece_comes_out_along_its_axis_only(stage, direction, force):
    tested = stage(plug(hold=10.0, across=4.0))
    tested.run(0.2)
    assert released_at(tested, direction) == pytest.approx(force, rel=0.15)


def test_a_latch_holds_in_place_and_takes_its_body_again(stage):
    tested = stage(plug())
    tested.run(1.0)
    held = tested.pose("connector/plug")
    assert math.dist(held[0], (0.081, 0.0, 0.25)) < 1e-5
    released_at(tested, (1.0, 0.0, 0.0))
    latch, uid = tested.objects.latch("connector", "latch"), tested.uid("connector", 1)
    tested.run(1.0)
    assert not latch.holds
    assert tested.pose("connector/plug")[0][2] < 0.1, "it has fallen"

    def put(position, orientation):
        pybullet.resetBasePositionAndOrientation(
            uid, position, orientation, physicsClientId=tested.client
        )

    # not straight: tilted by 0.2 rad
    put(held[0], (0.0, math.sin(0.1), 0.0, math.cos(0.1)))
    tested.run(0.02)
    assert not latch.holds
    # straight, turned about its axis, 2 mm off
    rolled = (math.sin(0.4), 0.0, 0.0, math.cos(0.4))
    put((0.083, 0.0, 0.25), rolled)
    tested.run(0.02)
    assert latch.holds
    tested.run(1.0)
    position, orientation = tested.pose("connector/plug")
    assert math.dist(position, held[0]) < 1e-4
    assert orientation == pytest.approx(rolled, abs=1e-3)
    assert released_at(tested, (1.0, 0.0, 0.0)) == pytest.approx(30.0, rel=0.1)


def test_a_released_body_is_not_taken_again_before_it_has_left(stage):
    tested = stage(plug())
    tested.objects.latch("connector", "latch").release()
    tested.run(0.02)
    assert not tested.objects.latch("connector", "latch").holds


def test_a_held_body_touches_no_body_of_a_large_parent(stage):
    model = plug().model
    away = [box((0.02, 0.02, 0.02), (0.0, 1.0 + 0.1 * n, 0.01)) for n in range(16)]
    round_plug = box((0.1, 0.05, 0.05), (0.081, 0.0, 0.25))
    socket = Link("socket", 0.0, (*away, round_plug))
    tested = stage(SceneObject("connector", replace(model, links=(socket, model.links[1]))))
    _, further, held = tested.objects.bodies_of("connector")
    latch = tested.objects.latch("connector", "latch")

    def touch():
        tested.run(tested.step_size)
        return bool(pybullet.getContactPoints(further, held, physicsClientId=tested.client))

    assert not touch()
    latch.release()
    assert touch()


def test_a_latch_on_a_part_that_moves(stage):
    drawer = sliding(friction=1.0)
    model = drawer.model
    tested = stage(
        SceneObject(
            "cabinet",
            ObjectModel(
                (*model.links, Link("key", 0.1, (box((0.02, 0.02, 0.02)),))),
                (
                    *model.joints,
                    Joint("grip", Motion.LATCH, "drawer", "key", (0.17, 0.0, 0.0), hold=10.0),
                ),
                static=True,
            ),
        )
    )
    uid = tested.uid("cabinet")
    tested.run(1.0, push(tested, uid, 0, (3.0, 0.0, 0.0)))
    position = tested.objects.joint_position("cabinet", "slide")
    assert position > 0.1
    assert tested.pose("cabinet/key")[0][0] == pytest.approx(0.3 + position + 0.17, abs=1e-3)
    assert tested.objects.latch("cabinet", "grip").holds


def test_the_same_pushes_give_bit_identical_states(stage):
    def run():
        tested = stage(
            hinged(start=1.2, closer=Closer(4.0, 6.0), damping=25.0),
            sliding(friction=2.0, detents=Detents((0.0, 0.2), 3.0, 0.02)),
            plug(),
        )
        tested.run(0.5, push(tested, tested.uid("cabinet"), 0, (8.0, 0.0, 0.0)))
        released_at(tested, (1.0, 0.0, 0.0))
        tested.run(0.5)
        return tested.objects.poses()

    assert run() == run()
