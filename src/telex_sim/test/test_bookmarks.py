"""Bookmarks: what is restored, that it is the same each time, and when they end."""

from __future__ import annotations

import math

import pybullet
import pytest

from telex_control.common.params import ConfigError
from telex_control.common.stateful import Stateful
from telex_sim.engine.bookmarks import MOST, Bookmarks
from telex_sim.offline.robot import OfflineRobot
from telex_sim.stability.monitor import StabilityMonitor

pytestmark = pytest.mark.slow

CRATE = "{type: crate, position: [3, 2, 0]}"


class Bench:
    """A robot with bookmarks, and a way to command it."""

    def __init__(self, offline):
        self.offline = offline
        self.simulation = offline.simulation
        self.robot = OfflineRobot(offline)
        self.bookmarks = Bookmarks(self.simulation)

    def work(self, seconds):
        """Drive and move the arm, the same each time; returns the state of everything 10 Hz."""
        seen = []
        for number in range(round(10 * seconds)):
            self.robot.drive(0.4 if number < 15 else -0.2, 0.3 if number % 10 < 5 else -0.4)
            self.robot.move({"turret_joint": 0.3, "shoulder_joint": 0.2})
            self.offline.run(0.1)
            seen.append(self.state())
        return seen

    def state(self):
        client = self.simulation.world.client
        found = []
        for uid in self.simulation.world.bodies():
            joints = range(pybullet.getNumJoints(uid, physicsClientId=client))
            found.append(pybullet.getBasePositionAndOrientation(uid, physicsClientId=client))
            found.append(pybullet.getBaseVelocity(uid, physicsClientId=client))
            found += [
                pybullet.getJointState(uid, joint, physicsClientId=client)[:2] for joint in joints
            ]
        hw = self.simulation.hw
        handles = [hw.drive(name) for name in hw.joint_positions()]
        found += [(each.handle.command, each.state.effort, each.force) for each in handles]
        found += [imu.handle.angular_velocity for imu in hw.imus]
        return found


@pytest.fixture
def bench(robot):
    def make(**changes):
        return Bench(robot(**changes))

    return make


def test_two_restores_lead_to_the_same_to_the_last_bit(bench):
    bench = bench(world="manipulation_bench")
    bench.work(0.5)
    bench.bookmarks.save("there")
    ran_on = bench.work(1.0)
    bench.bookmarks.restore("there")
    first = bench.work(1.0)
    # Long enough for what rests to fall asleep, and elsewhere.
    bench.robot.drive(-0.3, 0.0)
    bench.offline.run(2.3)
    bench.bookmarks.restore("there")
    assert bench.work(1.0) == first
    assert first != ran_on  # the engine's memory of contacts is not brought back


def test_it_goes_on_as_the_run_that_went_on(bench):
    bench = bench(world="floor")
    bench.work(1.0)
    bench.bookmarks.save()
    bench.work(5.0)
    places = bench.robot.base_pose(), bench.offline.positions()
    bench.bookmarks.restore()
    bench.work(5.0)
    (position, turned), joints = places
    now, turned_now = bench.robot.base_pose()
    assert math.dist(position, now) < 1e-3
    angle = pybullet.getDifferenceQuaternion(turned, turned_now)
    assert 2.0 * math.acos(min(1.0, abs(angle[3]))) < 0.01
    for name, value in bench.offline.positions().items():
        if "track" not in name:
            assert value == pytest.approx(joints[name], abs=0.01), name


def test_sim_time_goes_on_and_keeps_the_place_in_the_control_cycle(bench):
    bench = bench(world="floor", timing__step_size=0.001)
    bench.simulation.step()
    assert not bench.simulation.at_cycle_start
    bench.bookmarks.save()
    bench.simulation.step()
    before = bench.simulation.steps
    bench.bookmarks.restore()
    assert bench.simulation.steps == before + 1
    assert not bench.simulation.at_cycle_start


IGNORED = {
    "_cycle",  # counts cycles to a message
    "_cursor",  # finds its place again
    "_decay",  # of the last period
    "_efforts",  # kept for one step, or computed anew
    "_time",  # of the last cycle
    "_serial",
    "_obeyed",
    "_command",  # commands of before the restore count as obeyed
    "_until_look",
    "_numbers",
    "index",
    "contacts",  # made anew in each step, as are the next ones
    "touches",
    "forces",
    "running",
    "_figures",
    "_poses",
    "_known",
    "_wheel_speeds",  # told anew
    "_contacts",
    "_pull",
}


def values(part, path="", seen=None):
    """Numbers, texts and tuples of all objects of the product that hang on one, by their paths."""
    seen = set() if seen is None else seen
    found = {}
    if id(part) in seen:
        return found
    seen.add(id(part))
    names = list(getattr(part, "__dict__", ()))
    for kind in type(part).__mro__:
        names += [name for name in vars(kind).get("__slots__", ()) if hasattr(part, name)]
    for name in names:
        value = getattr(part, name)
        if name in IGNORED or (isinstance(part, Stateful) and name in part._declared[1]):
            continue
        where = f"{path}.{name}"
        if isinstance(value, (bool, int, float, str, type(None))):
            found[where] = value
        elif isinstance(value, (list, tuple)) and all(
            isinstance(each, (bool, int, float, str, type(None))) for each in value
        ):
            found[where] = tuple(value)
        else:
            several = value.items() if isinstance(value, dict) else [("", value)]
            if isinstance(value, (list, tuple)):
                several = enumerate(value)
            for key, each in several:
                if isinstance(each, Stateful):
                    found.update(values(each, f"{where}[{key}]", seen))
    return found


def test_nothing_that_changes_is_left_out(bench):
    """What is not declared as state shows here once it differs after a restore."""
    bench = bench(world="manipulation_bench")
    robot = bench.simulation.robots[0]
    monitor = StabilityMonitor(robot)
    robot.watchers = (monitor,)

    def watch():
        monitor.observe(bench.simulation.time)
        monitor.margin(bench.simulation.time)

    def everything():
        manager = robot.controllers
        parts = {info.name: manager.controller(info.name) for info, _ in manager.list_controllers()}
        parts.update(hw=robot.hw, tracks=robot.tracks, gripper=robot.gripper_contacts)
        parts.update(monitor=monitor, malfunctions=robot.malfunctions)
        parts.update(
            {str(number): each for number, each in enumerate(bench.simulation.objects._active)}
        )
        return {name: values(part) for name, part in parts.items()}

    bench.work(0.5)
    watch()
    bench.bookmarks.save()
    saved = everything()
    bench.work(2.0)
    watch()
    bench.bookmarks.restore()
    restored = everything()
    for name, part in saved.items():
        differing = [path for path, value in part.items() if restored[name].get(path) != value]
        assert not differing, (name, differing)


def test_a_latch_holds_again_what_was_pulled_away(bench):
    bench = bench(world="manipulation_bench")
    found = bench.simulation.objects.latches()
    assert found
    latch = found[0].latch
    assert latch.holds
    bench.bookmarks.save()
    latch.release()
    bench.offline.run(0.1)
    bench.bookmarks.restore()
    assert latch.holds
    bench.offline.run(0.5)
    assert latch.holds


def test_an_emergency_stop_that_is_set_stays_set(bench):
    bench = bench(world="floor")
    bench.work(0.5)
    bench.bookmarks.save()
    bench.simulation.request_e_stop(True)
    bench.offline.run(0.1)
    bench.bookmarks.restore()
    bench.offline.run(1.0)
    before = bench.robot.base_pose()[0]
    assert bench.simulation.hw.e_stop
    bench.robot.drive(0.3, 0.0)
    bench.offline.run(0.2)
    assert math.dist(bench.robot.base_pose()[0], before) < 1e-3
    bench.simulation.request_e_stop(False)
    bench.offline.run(0.2)
    assert math.dist(bench.robot.base_pose()[0], before) < 1e-3


def test_after_a_stop_that_was_saved_controllers_hold_where_it_is(bench):
    bench = bench(world="floor")
    bench.simulation.request_e_stop(True)
    bench.offline.run(0.1)
    bench.bookmarks.save()
    joints = bench.offline.positions()
    bench.simulation.request_e_stop(False)
    bench.offline.run(0.1)
    bench.robot.move({"turret_joint": 0.5})
    bench.offline.run(1.0)
    bench.bookmarks.restore()
    bench.offline.run(1.0)
    assert not bench.simulation.hw.e_stop
    turned = bench.offline.positions()["turret_joint"]
    assert turned == pytest.approx(joints["turret_joint"], abs=0.005)


def test_a_command_of_before_moves_nothing(bench):
    bench = bench(world="floor")
    bench.offline.run(1.0)
    bench.bookmarks.save()
    bench.robot.drive(0.5, 0.0)
    bench.bookmarks.restore()
    place = bench.robot.base_pose()[0]
    bench.offline.run(0.5)
    assert math.dist(bench.robot.base_pose()[0], place) < 1e-3


@pytest.mark.parametrize("change", ["spawn", "delete", "load"])
def test_bookmarks_end_when_the_scene_changes_and_are_refused_by_name(bench, change):
    bench = bench(world="floor")
    simulation = bench.simulation
    if change == "delete":
        simulation.spawn(simulation.plan(CRATE, "crate"))
    bench.bookmarks.save("there")
    words = "scene floor was loaded"
    if change == "spawn":
        simulation.spawn(simulation.plan(CRATE, "crate"))
        words = "'crate' was spawned"
    elif change == "delete":
        simulation.delete("crate")
        words = "'crate' was deleted"
    else:
        simulation.put_scene(simulation.plan_scene("floor"))
    with pytest.raises(ConfigError, match=f"bookmark 'there' has ended: {words}"):
        bench.bookmarks.restore("there")
    with pytest.raises(ConfigError, match="bookmark 'there' has ended"):
        bench.bookmarks.restore()
    assert bench.bookmarks.names() == []
    assert bench.bookmarks.save("there") == "there"
    assert bench.bookmarks.restore() == "there"


def test_a_refused_spawn_ends_none(bench):
    bench = bench(world="floor")
    bench.bookmarks.save("there")
    plans = bench.simulation.plan("{type: crate, position: [0, 0, 0]}", "crate")
    with pytest.raises(ConfigError):
        bench.simulation.spawn(plans)
    assert bench.bookmarks.restore("there") == "there"


def test_a_reset_keeps_them_unless_it_brings_something_back(bench):
    bench = bench(world="manipulation_bench")
    simulation = bench.simulation
    bench.work(0.5)
    bench.bookmarks.save("there")
    place = bench.robot.base_pose()[0]
    simulation.reset()
    assert math.dist(bench.robot.base_pose()[0], place) > 0.01
    bench.bookmarks.restore("there")
    assert math.dist(bench.robot.base_pose()[0], place) < 1e-9
    simulation.spawn(simulation.plan(CRATE, "parcel"))
    bench.bookmarks.save("with parcel")
    simulation.reset()
    with pytest.raises(ConfigError, match="has ended: a reset brought back what was loaded"):
        bench.bookmarks.restore("with parcel")


def test_the_newest_ten_are_kept_by_names_that_are_given_or_count(bench):
    bench = bench(world="floor")
    bookmarks = bench.bookmarks
    with pytest.raises(ConfigError, match="there is no bookmark to go back to"):
        bookmarks.restore()
    assert [bookmarks.save() for _ in range(2)] == ["1", "2"]
    bookmarks.save("1")
    assert bookmarks.names() == ["2", "1"]
    assert bookmarks.restore() == "1"
    for number in range(MOST - 1):
        bookmarks.save(f"step {number}")
    assert len(bookmarks.names()) == MOST
    with pytest.raises(ConfigError, match="bookmark '2' has ended: 10 newer ones"):
        bookmarks.restore("2")
    with pytest.raises(ConfigError, match="name is 'x'; bookmarks that there are: '1', 'step 0'"):
        bookmarks.restore("x")
    with pytest.raises(ConfigError, match="at most 80 characters"):
        bookmarks.save("a\nb")


def test_one_may_take_the_place_of_another_so_that_many_do_not_push_all_out(bench):
    bookmarks = bench(world="floor").bookmarks
    for number in range(MOST):
        bookmarks.save(f"mark {number}")
    bookmarks.save("step 1", replaces="gone already")
    for number in range(2, 20):
        bookmarks.save(f"step {number}", replaces=f"step {number - 1}")
    assert bookmarks.names() == [*(f"mark {number}" for number in range(1, MOST)), "step 19"]
    with pytest.raises(ConfigError, match="'step 18' has ended: 'step 19' has taken its place"):
        bookmarks.restore("step 18")


def test_a_reset_leads_to_the_same_each_time_and_fills_no_world_anew(bench):
    bench = bench(world="manipulation_bench")
    simulation = bench.simulation
    changes, start = simulation.changes, simulation.link_poses()
    latch = simulation.objects.latches()[0].latch
    monitor = StabilityMonitor(simulation.robots[0])
    simulation.robots[0].watchers = (monitor,)
    runs = []
    for _ in range(2):
        bench.work(0.5)
        monitor.observe(simulation.time)
        latch.release()
        before = simulation.time
        simulation.reset()
        assert simulation.time == before
        assert simulation.link_poses() == pytest.approx(start, abs=1e-6)
        assert latch.holds
        simulation.hw.read(simulation.time, 0.002)
        # What PyBullet tells of the forces of before counts no more.
        assert {simulation.hw.joint_state(name).effort for name in bench.offline.positions()} == {0}
        runs.append(bench.work(0.5))
        monitor.observe(simulation.time)
    assert runs[0] == runs[1]
    assert simulation.changes == changes


def test_a_reset_fills_the_world_anew_where_objects_or_robots_have_come_or_gone(bench):
    bench = bench(world="floor")
    simulation = bench.simulation
    simulation.spawn(simulation.plan(CRATE, "crate"))
    for anew in (True, False):
        before = simulation.changes
        simulation.reset()
        assert simulation.objects.objects() == []
        assert (simulation.changes != before) == anew
    bench.bookmarks.save("there")
    simulation.reset()
    assert bench.bookmarks.restore() == "there"


def test_an_emergency_stop_outlives_a_reset(bench):
    bench = bench(world="floor")
    bench.work(0.5)
    bench.simulation.request_e_stop(True)
    bench.offline.run(0.1)
    bench.simulation.reset()
    place = bench.robot.base_pose()[0]
    bench.robot.drive(0.3, 0.0)
    bench.offline.run(0.3)
    assert bench.simulation.hw.e_stop
    assert math.dist(bench.robot.base_pose()[0], place) < 5e-3
