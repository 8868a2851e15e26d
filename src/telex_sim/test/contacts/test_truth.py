"""What the simulation tells of a robot and a scene for scoring: samples and the contact ledger."""

import math

import pybullet
import pytest
from geometry_msgs.msg import Twist
from hypothesis import given
from hypothesis import strategies as st

from telex_sim.offline.simulation import OfflineSimulation, robot_description
from telex_sim.truth.ledger import FLOOR, GRIPPER, TRACKS, ContactLedger
from telex_sim.truth.sampler import NOTHING, TruthSampler

pytestmark = pytest.mark.slow

SCENE = """
name: tried
objects:
  - {type: cube, name: cube, position: [2.0, 1.0, 0.3]}
  - {type: wall, name: wall, position: [1.6, 0.0, 0.0], yaw: 1.5708}
  - {type: valve, name: valve, position: [0.0, 4.0, 0.0]}
  - {type: connector, name: connector, position: [0.0, -4.0, 0.0]}
"""


def contact(link, other, force, point=(0.0, 0.0, 0.0), body=1):
    """A tuple as `getContactPoints` gives them, as far as it is read."""
    return (0, body, other, link, -1, point, point, (0.0, 0.0, 1.0), 0.0, force)


@pytest.fixture(scope="module")
def urdf():
    return robot_description()


@pytest.fixture
def offline(urdf):
    simulation = OfflineSimulation(urdf, world=SCENE)
    yield simulation
    simulation.simulation.close()


@pytest.fixture
def sampler(offline):
    simulation = offline.simulation
    made = TruthSampler(simulation, simulation.robots[0])
    yield made
    made.close()


def sampled(offline, sampler, seconds):
    """Samples at 50 Hz while the simulation goes on."""
    samples = []
    for _ in range(round(seconds * 50)):
        offline.run(0.02)
        samples.append(sampler.sample())
    return samples


class TestLedger:
    def ledger(self, step_size=0.002):
        made = ContactLedger(1, {-1: 0, 0: TRACKS, 5: GRIPPER}, step_size)
        made.others = {7: 0, 8: 1}
        return made

    def test_forces_of_a_group_on_an_object_are_summed_within_a_step(self):
        ledger = self.ledger()
        for _ in range(10):
            ledger.note([contact(0, 7, 30.0), contact(0, 7, 12.0)])
        (entry,) = ledger.take()
        assert (entry.group, entry.other, entry.steps) == (TRACKS, 0, 10)
        assert entry.peak == pytest.approx(42.0)
        assert entry.impulse == pytest.approx(42.0 * 0.02)

    @pytest.mark.parametrize("step_size", [0.0005, 0.001, 0.002])
    def test_a_knock_of_one_step_weighs_by_its_impulse(self, step_size):
        ledger = self.ledger(step_size)
        ledger.note([contact(0, 7, 3.0 / step_size)])
        for _ in range(round(0.05 / step_size)):
            ledger.note([])
        (entry,) = ledger.take()
        assert entry.peak == pytest.approx(3.0 / 0.02)
        assert entry.impulse == pytest.approx(3.0)

    def test_a_window_goes_on_over_a_sample(self):
        ledger = self.ledger()
        for _ in range(5):
            ledger.note([contact(0, 7, 100.0)])
        assert ledger.take()[0].peak == pytest.approx(50.0)
        for _ in range(5):
            ledger.note([contact(0, 7, 100.0)])
        assert ledger.take()[0].peak == pytest.approx(100.0)

    def test_the_impulse_ends_after_the_first_fifth_of_a_second(self):
        ledger = self.ledger()
        total = 0.0
        for _ in range(50):
            for _ in range(10):
                ledger.note([contact(0, 7, 10.0)])
            total += sum(entry.impulse for entry in ledger.take())
        assert total == pytest.approx(10.0 * 0.2)

    def test_a_contact_begins_anew_once_the_window_is_empty(self):
        ledger = self.ledger()
        impulses = []
        for _ in range(2):
            for _ in range(200):
                ledger.note([contact(0, 7, 10.0)])
            for _ in range(11):
                ledger.note([])
            impulses.append(sum(entry.impulse for entry in ledger.take()))
        assert impulses == pytest.approx([2.0, 2.0])

    def test_what_a_held_object_touches_the_gripper_touches(self):
        ledger = self.ledger()
        held = [
            contact(-1, 8, 20.0, body=7),
            contact(-1, 1, 50.0, body=7),
            contact(-1, 99, 5.0, body=7),
        ]
        for _ in range(10):
            ledger.note([contact(5, 7, 50.0)], held, (7,))
        found = {(entry.group, entry.other): entry.peak for entry in ledger.take()}
        assert found == {
            (GRIPPER, 0): pytest.approx(50.0),
            (GRIPPER, 1): pytest.approx(20.0),
            (GRIPPER, FLOOR): pytest.approx(5.0),
        }

    def test_the_point_is_a_mean_by_forces(self):
        ledger = self.ledger()
        ledger.note([contact(0, 7, 1.0, (0.0, 0.0, 0.0)), contact(0, 7, 3.0, (4.0, 0.0, 8.0))])
        assert ledger.take()[0].point == pytest.approx((3.0, 0.0, 6.0))

    def test_nothing_is_told_twice(self):
        ledger = self.ledger()
        ledger.note([contact(0, 7, 1.0)])
        assert len(ledger.take()) == 1
        assert ledger.take() == []

    @given(
        st.lists(
            st.lists(
                st.tuples(
                    st.sampled_from([-1, 0, 5]), st.sampled_from([7, 8, 99]), st.floats(0.0, 1e5)
                ),
                max_size=4,
            ),
            max_size=60,
        )
    )
    def test_no_peak_is_above_the_largest_step_nor_below_the_mean(self, steps):
        ledger = self.ledger()
        totals = {}
        for touched in steps:
            step = {}
            for link, other, force in touched:
                key = ({-1: 0, 0: TRACKS, 5: GRIPPER}[link], {7: 0, 8: 1}.get(other, FLOOR))
                step[key] = step.get(key, 0.0) + force
            for key, force in step.items():
                totals[key] = max(totals.get(key, 0.0), force)
            ledger.note([contact(*each) for each in touched])
        for entry in ledger.take():
            largest = totals[entry.group, entry.other]
            assert largest / 10 * (1 - 1e-9) - 1e-6 <= entry.peak <= largest * (1 + 1e-9) + 1e-6


class TestSamples:
    def test_names_say_what_there_is(self, sampler):
        names = sampler.names
        assert names.objects[:2] == ("cube", "wall")
        assert "cube/cube" in names.bodies
        assert not any(body.startswith("wall/") for body in names.bodies)
        assert "valve/wheel_hinge" in names.mechanisms
        assert any(name.startswith("connector/") for name in names.latches)
        groups = dict(zip(names.links, (names.groups[number] for number in names.group_of)))
        assert groups["base_link"] == "base"
        assert groups["front_left_flipper_link"] == "tracks"
        assert groups["elbow_link"] == "arm"
        assert groups["left_finger_tip_link"] == "gripper"

    def test_joints_are_as_after_the_step(self, offline, sampler):
        offline.run(0.5)
        sample, body = sampler.sample(), offline.simulation.body
        for name, value in zip(sampler.names.joints, sample.joints):
            if name in body.joints:
                exact = pybullet.getJointState(
                    body.uid, body.joints[name], physicsClientId=body.client
                )[0]
                assert value == exact, name

    def test_the_twist_is_that_of_the_root_links_frame(self, offline, sampler):
        publisher = offline.node.advertise("track_controller/cmd_vel", Twist)
        message = Twist()
        message.angular.z = 0.6
        poses = []
        for _ in range(60):
            publisher.publish(message)
            offline.run(0.02)
            poses.append(sampler.sample())
        step = 0.02
        for before, at, after in zip(poses[20:], poses[21:], poses[22:]):
            for axis in range(2):
                mean = (after.base[axis] - before.base[axis]) / (2.0 * step)
                assert at.twist[axis] == pytest.approx(mean, abs=0.02)
        assert poses[-1].twist[5] == pytest.approx(0.6, abs=0.15)

    def test_only_what_moves_has_its_pose_told_but_once_a_second(self, offline, sampler):
        offline.run(6.0)  # the cube falls, and sleeps
        samples = sampled(offline, sampler, 2.0)
        whole = [sample for sample in samples if sample.whole]
        assert len(whole) == 2
        bodies = len(sampler.names.bodies)
        assert all(len(sample.moved) == bodies for sample in whole)
        assert all(sample.moved == [] for sample in samples if not sample.whole)
        cube = sampler.names.bodies.index("cube/cube")
        assert whole[0].poses[7 * cube : 7 * cube + 2] == pytest.approx([2.0, 1.0], abs=0.01)

    def test_mechanisms_and_latches_are_told(self, offline, sampler):
        objects = offline.simulation.objects
        wheel = sampler.names.mechanisms.index("valve/wheel_hinge")
        (joint,) = [each for each in objects.joints() if each.name == "valve/wheel_hinge"]
        pybullet.resetJointState(joint.uid, joint.joint, 1.25, physicsClientId=objects._client)
        latch = sampler.names.latches.index(objects.latches()[0].name)
        assert sampler.sample().latched[latch] is True
        objects.latches()[0].latch.release()
        sample = sampler.sample()
        assert sample.mechanisms[wheel] == pytest.approx(1.25)
        assert sample.latched[latch] is False

    def test_the_tracks_touch_the_floor_with_the_robots_weight(self, offline, sampler):
        offline.run(1.0)
        sampler.sample()
        offline.run(0.2)
        entries = sampler.sample().contacts
        (floor,) = [entry for entry in entries if (entry.group, entry.other) == (TRACKS, FLOOR)]
        body = offline.simulation.body
        mass = sum(
            pybullet.getDynamicsInfo(body.uid, index, physicsClientId=body.client)[0]
            for index in range(-1, pybullet.getNumJoints(body.uid, physicsClientId=body.client))
        )
        assert floor.peak == pytest.approx(9.81 * mass, rel=0.05)
        assert floor.steps == 100

    def test_driving_into_a_wall_is_a_contact_with_it(self, offline, sampler):
        publisher = offline.node.advertise("track_controller/cmd_vel", Twist)
        message = Twist()
        message.linear.x = 0.5
        wall = sampler.names.objects.index("wall")
        entries = []
        for _ in range(200):
            publisher.publish(message)
            offline.run(0.02)
            entries += [entry for entry in sampler.sample().contacts if entry.other == wall]
        assert max(entry.peak for entry in entries) > 100.0
        assert all(math.isfinite(number) for entry in entries for number in entry.point)

    def test_nothing_is_held_at_the_start(self, sampler):
        sample = sampler.sample()
        assert (sample.held, sample.grip) == (NOTHING, 0.0)

    def test_a_spawned_object_and_a_reset_are_learnt(self, offline, sampler):
        simulation = offline.simulation
        assert not sampler.refresh()
        simulation.spawn(simulation.plan("{type: cube, position: [0, 3, 0]}", "late"))
        assert sampler.refresh()
        assert "late" in sampler.names.objects
        simulation.reset()
        assert sampler.refresh()
        assert "late" not in sampler.names.objects
        offline.run(0.5)
        assert any(entry.group == TRACKS for entry in sampler.sample().contacts)

    def test_steps_are_the_same_with_and_without_a_sampler(self, urdf):
        states = []
        for watched in (False, True):
            offline = OfflineSimulation(urdf, world=SCENE)
            simulation = offline.simulation
            made = TruthSampler(simulation, simulation.robots[0]) if watched else None
            for _ in range(50):
                offline.run(0.02)
                if made:
                    made.sample()
            states.append(simulation.link_poses())
            simulation.close()
        assert states[0] == states[1]

    def test_a_robot_without_tracks_reads_its_contacts_itself(self, urdf):
        offline = OfflineSimulation(urdf, world=SCENE, tracks={})
        simulation = offline.simulation
        made = TruthSampler(simulation, simulation.robots[0])
        offline.run(1.0)
        assert any(entry.other == FLOOR for entry in made.sample().contacts)
        made.close()
        simulation.close()
