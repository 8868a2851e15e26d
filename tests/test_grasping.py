"""What contact and friction hold in the gripper; benchmarks/grasping has the rest."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Tuple

import pytest

from telex_experiments.grasping import statics, suite, tasks
from telex_experiments.grasping.holding import (
    LOST,
    at_limit,
    block,
    force_error,
    hold,
    rig_for,
    sway,
)
from telex_experiments.grasping.rig import OBLIQUE, TOP, GraspRig
from telex_experiments.grasping.things import PAD_FRICTION, THINGS

pytestmark = pytest.mark.slow


def test_the_pads_press_as_they_are_told_and_let_go() -> None:
    thing = THINGS["cube 5 cm"]
    with rig_for(thing) as rig:
        assert rig.contact().opening == pytest.approx(thing.opening, abs=2e-3)
        name = rig.present(thing.entry(), 10.0)
        for force in (10.0, 80.0, 250.0):
            assert force_error(rig, force) < 0.05 * force
        felt = rig.contact()
        assert felt.object == name
        assert [pad.objects for pad in felt.pads] == [(name,), (name,)]
        assert felt.force == min(pad.normal_force for pad in felt.pads)
        assert felt.opening == pytest.approx(thing.width, abs=5e-4)
        assert not felt.slipping

        height = rig.pose(name)[0][2]
        rig.command_pads(thing.opening, 0.0)
        rig.wait(0.7)
        felt = rig.contact()
        assert (felt.object, felt.force, felt.slipping) == ("", 0.0, False)
        assert rig.pose(name)[0][2] < height - 0.3


def test_the_weight_of_the_fingers_does_not_count() -> None:
    """Pointing down, with a thin thing between the pads, it would open them with 4 N."""
    thing = replace(THINGS["flat plate"], mass=0.05)
    with rig_for(thing, TOP) as rig:
        rig.present(thing.entry(), 20.0)
        assert force_error(rig, 10.0) < 0.5


@pytest.mark.parametrize(
    ("name", "force"), [("cube 5 cm", 100.0), ("briefcase", 150.0), ("sphere", 30.0)]
)
def test_what_is_held_stays_where_it_is(name: str, force: float) -> None:
    thing = THINGS[name]
    with rig_for(thing) as rig:
        found = hold(rig, rig.present(thing.entry(), force), 5.0)
    assert not found.lost
    assert found.slip.distance < 0.02e-3
    # A ball between two pads could spin about the line that joins them.
    assert found.slip.angle < math.radians(0.1)
    assert found.jitter < 1e-3


def test_what_is_held_is_shaken_and_driven_about() -> None:
    thing = THINGS["cube 5 cm"]
    with rig_for(thing, OBLIQUE) as rig:
        name = rig.present(thing.entry(), 60.0)
        rig.wait(1.0)
        assert sway(rig, name, lambda: rig.shake((0, 0, 1), 0.05, 1.0, 3.0)).most < 0.5e-3
        assert sway(rig, name, lambda: rig.drive(0.0, 0.5, 1.0)).most < 1e-3


@pytest.mark.parametrize("share", [0.8, 1.1])
def test_friction_holds_what_coulomb_says(share: float) -> None:
    found = at_limit(50.0, share, 2.0)
    assert found.lost == (share > 1.0)
    if not found.lost:
        assert found.slip.distance < 0.1e-3


def test_a_thin_plate_gets_the_whole_force() -> None:
    """The command closes the pads all the way, and the plate stops them 1 cm before."""
    thing = THINGS["flat plate"]
    with rig_for(thing) as rig:
        rig.present(thing.entry(), 20.0)
        assert force_error(rig, 250.0) < 0.05 * 250.0


def test_slipping_is_felt() -> None:
    force = 50.0
    thing = block(1.15 * 2.0 * PAD_FRICTION * force / 9.81)
    with rig_for(thing) as rig:
        name = rig.present(thing.entry(), force)
        rig.wait(0.1)
        felt = rig.contact()
        assert felt.object == name
        assert felt.slipping
        before = rig.held_at(name)
        rig.wait(rig.step_size)
        speed = rig.slip(name, before).distance / rig.step_size
        assert rig.contact().slip_speed == pytest.approx(speed, rel=0.2)
        assert max(pad.friction_use for pad in felt.pads) == pytest.approx(1.0, abs=0.05)
        rig.grip(200.0)
        rig.wait(0.3)
        felt = rig.contact()
        assert felt.object == name
        assert not felt.slipping
        assert max(pad.friction_use for pad in felt.pads) < 0.9


def test_a_thing_is_picked_from_above_as_far_as_friction_carries() -> None:
    thing = THINGS["block 10 kg"]
    held = suite.grasp(thing, TOP, 0.8)
    assert (held.predicted, held.lifted) == (True, True)
    assert held.slip < 0.5e-3
    dropped = suite.grasp(thing, TOP, 0.4)
    assert (dropped.predicted, dropped.lifted) == (False, False)


def test_a_pull_along_the_fingers_takes_what_statics_say() -> None:
    """Pads that swing on arcs give way to it; the joints' efforts cannot tell."""
    thing = replace(THINGS["flat plate"], mass=3.0)
    force = thing.force(0.6)
    with rig_for(thing, TOP) as rig:
        rig.present(thing.entry(), force)
        rig.wait(0.5)
        felt = rig.contact().force
    said = statics.pad_force(force, 0.5 * thing.weight, thing.width)
    assert said < 0.85 * force
    assert felt == pytest.approx(said, abs=statics.friction_band(thing.width))


def test_a_lever_is_turned_by_friction_alone() -> None:
    turned = tasks.valve(8.0)
    assert turned.angle == pytest.approx(turned.wanted, rel=0.05)


def state_of_a_grasp() -> Tuple[float, ...]:
    thing = THINGS["briefcase"]
    with rig_for(thing) as rig:
        name = rig.present(thing.entry(), 150.0)
        rig.wait(0.5)
        assert rig.slip(name, rig.held_at(name)).distance < LOST
        return (*rig.simulation.link_poses(), rig.speed(name), *_forces(rig))


def _forces(rig: GraspRig) -> Tuple[float, ...]:
    return tuple(pad.normal_force for pad in rig.contact().pads)


def test_the_same_grasp_gives_bit_identical_states() -> None:
    assert state_of_a_grasp() == state_of_a_grasp()
