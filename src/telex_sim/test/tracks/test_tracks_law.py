"""The traction law by itself: properties that hold whatever is touched."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from telex_sim.tracks.law import Patch, TractionLaw, belt_directions, edge_share

STIFFNESS, DAMPING = 1.0e5, 1500.0
RATIO = 0.7**2
X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)

velocities = st.floats(-3.0, 3.0)
touches = st.lists(
    st.builds(
        lambda load, grip, slip_along, slip_across: (
            load,
            grip,
            0.7 * grip,
            slip_along,
            slip_across,
            X,
            Y,
            (0.0, 0.0, 0.0),
        ),
        st.floats(0.1, 2000.0),
        st.floats(0.05, 2.0),
        velocities,
        velocities,
    ),
    min_size=1,
    max_size=6,
)
bends = st.floats(-0.01, 0.01)
steps = st.sampled_from([0.004, 0.002, 0.001])


def patch_of(contacts, step, along=0.0, across=0.0, softness=1.0):
    patch = Patch()
    patch.along, patch.across = along, across
    patch.touches = list(contacts)
    law = TractionLaw(STIFFNESS, DAMPING, step)
    patch.prepare(law, patch.load, (softness, softness), RATIO)
    return patch


@given(touches, velocities, bends, bends, steps)
def test_force_lies_in_the_friction_ellipse(contacts, speed, along, across, step):
    patch = patch_of(contacts, step, along, across)
    patch.pull(speed)
    for (load, grip, lateral, *_), (force, sideways) in zip(contacts, patch.forces):
        assert math.hypot(force / (grip * load), sideways / (lateral * load)) <= 1.0 + 1e-9


@given(touches, velocities, velocities, bends, bends, steps)
def test_force_never_decreases_with_the_belts_speed(contacts, one, other, along, across, step):
    patch = patch_of(contacts, step, along, across)
    slow, fast = sorted((one, other))
    below, above = patch.pull(slow), patch.pull(fast)
    assert below <= above + 1e-9 * max(1.0, abs(above))


@given(touches, velocities, bends, bends, steps)
def test_left_and_right_forward_and_backward_are_alike(contacts, speed, along, across, step):
    here = patch_of(contacts, step, along, across)
    here.pull(speed)
    mirrored = [(*touch[:4], -touch[4], *touch[5:]) for touch in contacts]
    there = patch_of(mirrored, step, along, -across)
    there.pull(speed)
    assert there.forces == [(force, -sideways) for force, sideways in here.forces]
    backward = [(*touch[:3], -touch[3], *touch[4:]) for touch in contacts]
    behind = patch_of(backward, step, -along, across)
    behind.pull(-speed)
    assert behind.forces == [(-force, sideways) for force, sideways in here.forces]


@given(touches, velocities, bends, bends, steps)
def test_all_slipping_gives_all_that_friction_can(contacts, speed, along, across, step):
    fast = 1.0e4
    pulled = patch_of(contacts, step, along, across).pull(fast)
    assert pulled == pytest.approx(sum(touch[0] * touch[1] for touch in contacts), rel=1e-3)


@settings(deadline=None, max_examples=25)
@given(st.floats(15.0, 40.0), st.floats(0.1, 1.5), velocities, velocities, bends, bends, steps)
def test_a_braked_track_gives_no_energy(mass, grip, along, across, bend, sideways, step):
    """A mass on one track that does not run, left alone: it comes to rest, and stays."""
    load = 9.81 * mass
    patch = Patch()
    patch.along, patch.across = bend, sideways
    law = TractionLaw(STIFFNESS, DAMPING, step)

    def push():
        patch.touches = [(load, grip, 0.7 * grip, along, across, X, Y, (0.0, 0.0, 0.0))]
        patch.prepare(law, load, (1.0, 1.0), RATIO)
        patch.pull(0.0)
        patch.commit()
        return patch.forces[0]

    def energy():
        spring = patch.along**2 + RATIO * patch.across**2
        return 0.5 * mass * (along**2 + across**2) + 0.5 * STIFFNESS * spring

    stretch = grip * load / STIFFNESS
    push()
    # What the first step bends the bristles by is work done by the moving mass.
    start = 0.5 * mass * (along**2 + across**2) + 0.5 * STIFFNESS * stretch**2
    seconds = 0.8 + math.hypot(along, across) / (0.7 * grip * 9.81)
    for _ in range(min(round(seconds / step), 2000)):
        force, lateral = push()
        assert energy() <= start * (1.0 + 1e-9)
        along += force / mass * step
        across += lateral / mass * step
    if seconds / step <= 2000:
        assert energy() < 1e-4 * start


@given(st.floats(0.05, 1.0), bends, bends)
def test_bristles_keep_their_force_when_they_soften(softness, along, across):
    contact = (1.0e6, 1.0, 0.7, 0.0, 0.0, X, Y, (0.0, 0.0, 0.0))
    stiff = patch_of([contact], 0.002, along, across)
    stiff.pull(0.0)
    stiff.commit()
    before = stiff.forces[0]
    stiff.touches = [contact]
    soft = (softness, softness)
    stiff.prepare(TractionLaw(STIFFNESS, DAMPING, 0.002), 1.0e6, soft, RATIO)
    stiff.pull(0.0)
    assert stiff.forces[0] == pytest.approx(before, rel=1e-9, abs=1e-9)


def test_a_light_body_bears_less_unless_it_is_pressed():
    law = TractionLaw(STIFFNESS, DAMPING, 0.002)
    assert law.softness(1000.0, 9810.0, 100.0, 100.0) == (1.0, 1.0)
    spring, damper = law.softness(0.5, 4.9, 4.9, 4.9)
    assert spring == damper
    # A damper on a free mass is stable as long as it takes less than twice the velocity a step:
    # of four tracks, at a corner, where a box offers a quarter of its mass.
    assert 4.0 * damper * DAMPING * 0.002 / (0.25 * 0.5) < 2.0
    # What is pressed on may still roll: a pipe under a robot that falls on it must not be spun.
    assert law.softness(0.5, 4.9, 49.0, 49.0) == pytest.approx((10.0 * spring, damper))
    # The bristles that press on it are a tenth of the track's.
    assert law.softness(0.5, 4.9, 4.9, 49.0) == pytest.approx((10.0 * spring, 10.0 * damper))


angles = st.floats(-math.pi, math.pi)


def turned(vector, yaw):
    x, y, z = vector
    return (
        x * math.cos(yaw) - y * math.sin(yaw),
        x * math.sin(yaw) + y * math.cos(yaw),
        z,
    )


@given(angles, angles, angles)
def test_directions_turn_with_the_world(pitch, lean, yaw):
    ahead = (math.cos(pitch), 0.0, -math.sin(pitch))
    normal = (math.sin(lean), 0.3 * math.cos(lean), math.cos(lean))
    length = math.sqrt(sum(value * value for value in normal))
    normal = tuple(value / length for value in normal)
    face, forward, sideways = belt_directions(Y, ahead, normal)
    there = belt_directions(turned(Y, yaw), turned(ahead, yaw), turned(normal, yaw))
    assert there[0] == face
    assert there[1] == pytest.approx(turned(forward, yaw), abs=1e-9)
    assert there[2] == pytest.approx(turned(sideways, yaw), abs=1e-9)
    for first, second in ((forward, sideways), (forward, normal), (sideways, normal)):
        assert sum(a * b for a, b in zip(first, second)) == pytest.approx(0.0, abs=1e-9)


def test_the_belt_runs_round_its_track():
    assert belt_directions(Y, X, Z) == (0, X, Y)
    _, above, across = belt_directions(Y, X, (0.0, 0.0, -1.0))
    assert above == (-1.0, 0.0, 0.0)
    assert across == Y
    # At the front end, which a wall touches, the belt runs downwards: the robot is driven up.
    assert belt_directions(Y, X, (-1.0, 0.0, 0.0))[1] == (0.0, 0.0, 1.0)


@pytest.mark.parametrize("side", [1, -1])
def test_a_flank_does_not_run(side):
    face, forward, _ = belt_directions(Y, X, (0.0, float(side), 0.0))
    assert face == side
    assert forward == X


def test_an_edge_is_what_leans_from_all_faces():
    assert edge_share(1.0) == 0.0
    assert edge_share(math.cos(math.radians(9.0))) == 0.0
    assert 0.0 < edge_share(math.cos(math.radians(15.0))) < 1.0
    assert edge_share(math.cos(math.radians(45.0))) == 1.0
