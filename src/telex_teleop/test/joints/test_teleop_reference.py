"""The reference generator: bounds under any commands, exact behaviour of a joint that follows."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from telex_teleop.motion.reference import MotionLimits, ReferenceGenerator

pytestmark = pytest.mark.slow

DT = 0.01


def limits(**changes):
    values = {
        "lower": -1.0,
        "upper": 1.0,
        "max_velocity": 0.6,
        "max_acceleration": 2.0,
        "max_lead": 0.2,
        "hold_tolerance": 0.02,
    }
    values.update(changes)
    return MotionLimits(**values)


class Following:
    """A joint that is where its reference was one update ago."""

    def __init__(self, motion=None, position=0.0):
        self.generator = ReferenceGenerator(motion or limits())
        self.position = position
        self.references = []

    def run(self, duration, scale=1.0):
        for _ in range(round(duration / DT)):
            reference = self.generator.update(DT, self.position, scale)
            if reference is not None:
                self.references.append(reference)
                self.position = reference
        return self.position


def test_idle_generator_says_nothing():
    joint = Following(position=0.3)
    joint.run(0.1)
    assert joint.references == []
    assert joint.generator.reference is None


def test_jog_moves_at_the_commanded_rate_after_the_ramp():
    joint = Following()
    joint.generator.jog(0.3)
    start = joint.run(0.5)
    assert joint.run(1.0) - start == pytest.approx(0.3, rel=1e-9)


def test_rate_is_clamped_then_scaled():
    joint = Following()
    joint.generator.jog(100.0)
    start = joint.run(0.5, scale=0.5)
    assert joint.run(1.0, scale=0.5) - start == pytest.approx(0.3, rel=1e-9)


def test_stop_takes_the_braking_distance_then_rests_exactly():
    joint = Following()
    joint.generator.jog(0.6)
    start = joint.run(0.6)
    joint.generator.stop()
    end = joint.run(0.6 / 2.0 + DT)
    assert end - start == pytest.approx(0.6**2 / (2 * 2.0), abs=0.6 * DT)
    assert not joint.generator.moving
    assert joint.generator.update(DT, end) is None


def test_reversal_is_smooth():
    joint = Following()
    joint.generator.jog(0.6)
    joint.run(0.5)
    joint.generator.jog(-0.6)
    joint.run(0.8)
    velocities = [(b - a) / DT for a, b in zip(joint.references, joint.references[1:])]
    changes = [abs(b - a) for a, b in zip(velocities, velocities[1:])]
    assert max(changes) <= 2.0 * DT + 1e-9
    assert velocities[-1] == pytest.approx(-0.6)


def test_comes_to_rest_at_the_position_limit_and_says_so():
    joint = Following()
    joint.generator.jog(0.6)
    joint.run(5.0)
    assert joint.position == pytest.approx(1.0, abs=1e-6)
    assert max(joint.references) <= 1.0
    assert joint.generator.limited


def test_leaves_the_limit_again():
    joint = Following(position=1.0)
    joint.generator.jog(-0.3)
    joint.run(0.5)
    assert joint.position < 0.95
    assert not joint.generator.limited


def test_joint_found_outside_its_limits_moves_inwards_only():
    joint = Following(position=1.2)
    joint.generator.jog(0.6)
    joint.run(0.5)
    assert joint.position == 1.2
    joint.generator.jog(-0.6)
    joint.run(0.5)
    assert joint.position < 1.2
    assert max(joint.references) == 1.2


def test_waits_for_a_blocked_joint_at_the_lead_then_goes_on():
    generator = ReferenceGenerator(limits())
    generator.jog(0.6)
    references = [generator.update(DT, 0.0) for _ in range(300)]
    assert max(references) == pytest.approx(0.2, abs=1e-6)
    assert max(references) <= 0.2
    assert generator.limited
    position = 0.0
    for _ in range(100):
        position = generator.update(DT, position)
    assert position > 0.5


def test_stops_at_once_when_the_joint_is_thrown_back():
    generator = ReferenceGenerator(limits())
    generator.jog(0.6)
    for _ in range(50):
        position = generator.update(DT, generator.reference or 0.0)
    after = generator.update(DT, position - 0.5)
    assert after == position
    assert generator.velocity == 0.0


def test_new_motion_goes_on_from_the_last_reference_within_the_lead():
    generator = ReferenceGenerator(limits())
    generator.jog(0.6)
    while generator.update(DT, 0.0) < 0.15:
        pass
    generator.stop()
    while generator.update(DT, 0.0) is not None:
        pass
    held = generator.reference
    generator.jog(-0.1)
    assert generator.update(DT, 0.0) == pytest.approx(held, abs=0.1 * DT)


def test_new_motion_starts_at_the_joint_when_the_last_reference_is_far():
    joint = Following()
    joint.generator.jog(0.6)
    joint.run(0.5)
    joint.generator.stop()
    joint.run(0.5)
    joint.generator.jog(0.1)
    elsewhere = joint.position - 0.3
    assert joint.generator.update(DT, elsewhere) == pytest.approx(elsewhere, abs=0.1 * DT)


def test_new_motion_starts_at_the_joint_when_somebody_else_moved_it_while_idle():
    joint = Following()
    joint.generator.jog(0.3)
    joint.run(0.5)
    joint.generator.stop()
    joint.run(0.5)
    moved = joint.position + 0.1  # less than the lead
    for step in range(1, 11):
        joint.generator.update(DT, joint.position + 0.01 * step)
    joint.generator.jog(0.1)
    assert joint.generator.update(DT, moved) == pytest.approx(moved, abs=0.1 * DT)


def test_displacement_reaches_its_goal_exactly_and_ends():
    joint = Following()
    joint.generator.displace(0.25)
    joint.run(2.0)
    assert joint.position == pytest.approx(0.25, abs=1e-8)
    assert not joint.generator.moving


def test_displacements_add_up_and_stay_within_limits():
    joint = Following()
    joint.generator.displace(0.1)
    joint.run(0.1)
    joint.generator.displace(0.1)
    joint.run(2.0)
    assert joint.position == pytest.approx(0.2, abs=1e-8)
    joint.generator.displace(5.0)
    joint.run(6.0)
    assert joint.position == pytest.approx(1.0, abs=1e-6)


def test_displacement_of_a_blocked_joint_is_given_up():
    generator = ReferenceGenerator(limits())
    generator.displace(0.5)
    for _ in range(500):
        generator.update(DT, 0.0)
    assert not generator.moving
    assert generator.reference <= 0.2


def test_drop_forgets_everything():
    joint = Following()
    joint.generator.jog(0.6)
    joint.run(0.5)
    joint.generator.drop()
    assert joint.generator.update(DT, 0.4) is None
    assert joint.generator.reference is None


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"lower": 1.0}, "below"),
        ({"max_velocity": 0.0}, "max_velocity"),
        ({"max_acceleration": math.inf}, "max_acceleration"),
        ({"max_lead": math.nan}, "max_lead"),
        ({"hold_tolerance": -1.0}, "hold_tolerance"),
        ({"max_lead": 0.05}, "braking"),
    ],
)
def test_contradicting_limits_are_refused(changes, named):
    with pytest.raises(ValueError, match=named):
        limits(**changes)


steps = st.lists(
    st.tuples(
        st.sampled_from(["jog", "displace", "stop", "go on", "go on", "go on"]),
        st.floats(-2.0, 2.0),  # rate or increment
        st.floats(0.0005, 0.5),  # dt
        st.floats(-1.5, 1.5),  # position, or lag of the joint
        st.floats(0.05, 1.0),  # speed scale
    ),
    min_size=1,
    max_size=60,
)


def command(generator, kind, value):
    if kind == "jog":
        generator.jog(value)
    elif kind == "displace":
        generator.displace(value)
    elif kind == "stop":
        generator.stop()


@settings(max_examples=300, deadline=None)
@given(steps)
def test_bounds_hold_for_a_joint_that_is_thrown_about(sequence):
    motion = limits()
    generator = ReferenceGenerator(motion)
    for kind, value, dt, position, scale in sequence:
        start = generator.reference if generator.moving else generator.start_from(position)
        before = generator.velocity
        command(generator, kind, value)
        reference = generator.update(dt, position, scale)
        if reference is None:
            continue
        assert abs(generator.velocity) <= motion.max_velocity + 1e-9
        assert abs(reference - start - generator.velocity * dt) <= 1e-9
        # never further out than it was, or than the limit
        assert reference <= max(start, motion.upper) + 1e-12
        assert reference >= min(start, motion.lower) - 1e-12
        # never further ahead than it was, or than the lead
        assert reference - position <= max(start - position, motion.max_lead) + 1e-9
        assert position - reference <= max(position - start, motion.max_lead) + 1e-9
        # only the lead may stop it faster than the acceleration limit
        waited = abs(abs(reference - position) - motion.max_lead) < 1e-9 or reference == start
        assert waited or abs(generator.velocity - before) <= motion.max_acceleration * dt + 1e-9


@settings(max_examples=300, deadline=None)
@given(steps)
def test_acceleration_limit_is_never_broken_for_a_joint_that_follows_or_sticks(sequence):
    motion = limits()
    generator = ReferenceGenerator(motion)
    position, before = 0.0, 0.0
    for kind, value, dt, share, scale in sequence:
        command(generator, kind, value)
        reference = generator.update(dt, position, scale)
        after = generator.velocity if reference is not None else 0.0
        assert abs(after - before) <= motion.max_acceleration * dt + 1e-9
        before = after
        if reference is not None:
            assert motion.lower <= reference <= motion.upper
            assert abs(reference - position) <= motion.max_lead + 1e-9
            # between not at all and fully
            position += (reference - position) * min(1.0, abs(share))


@settings(max_examples=100, deadline=None)
@given(st.floats(-0.6, 0.6), st.integers(1, 200), st.floats(0.001, 0.05))
def test_always_comes_to_rest_within_the_braking_time(rate, count, dt):
    motion = limits()
    generator = ReferenceGenerator(motion)
    generator.jog(rate)
    position = 0.0
    for _ in range(count):
        reference = generator.update(dt, position)
        position = position if reference is None else reference
    generator.stop()
    for _ in range(math.ceil(motion.max_velocity / motion.max_acceleration / dt) + 1):
        generator.update(dt, position)
    assert not generator.moving


@pytest.mark.parametrize("position", [0.01 * step for step in range(40)])
def test_pressed_joint_starts_again_from_its_reference_whatever_rounding_does(position):
    generator = ReferenceGenerator(limits())
    generator.jog(-0.6)
    for _ in range(300):
        generator.update(DT, position)
    generator.stop()
    for _ in range(100):
        generator.update(DT, position)
    assert generator.reference == pytest.approx(position - 0.2, abs=1e-6)
    assert generator.start_from(position) == generator.reference
