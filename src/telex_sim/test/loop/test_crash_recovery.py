"""A simulator that follows one that has crashed."""

from __future__ import annotations

import pytest

from telex_control.ros.local_node_handle import LocalNodeHandle
from telex_control.ros.run_memory import RunMemory
from telex_sim.offline.simulation import shipped_config
from telex_sim.ros.crash_recovery import CrashRecovery


@pytest.fixture
def memory(tmp_path):
    """Opens the memory anew, as each process does."""
    return lambda: RunMemory(str(tmp_path / "memory.json"))


def test_a_first_start_begins_at_zero(robot, memory):
    simulation = robot().simulation
    recovery = CrashRecovery(memory())
    recovery.restore(simulation)
    assert (recovery.happened, recovery.resets, simulation.steps) == (False, 0, 0)


def test_after_a_crash_the_clock_goes_on_and_the_stop_holds(robot, memory):
    first = robot()
    first.simulation.request_e_stop(True)
    for _ in range(700):
        first.simulation.step()
    CrashRecovery(memory()).note(first.simulation, resets=2)

    second = robot()
    recovery = CrashRecovery(memory())
    recovery.restore(second.simulation)
    assert recovery.happened
    assert recovery.resets == 3
    # 1.4 s had passed: the next whole second after one more.
    assert second.simulation.time == 3.0
    assert second.simulation.at_cycle_start
    second.simulation.step()
    assert second.simulation.hw.e_stop


def test_a_released_stop_stays_released(robot, memory):
    simulation = robot().simulation
    simulation.request_e_stop(True)
    simulation.request_e_stop(False)
    CrashRecovery(memory()).note(simulation, resets=0)
    CrashRecovery(memory()).restore(simulation)
    assert not simulation.robots[0].e_stop_wanted


def test_a_further_robot_that_was_stopped_is_so_until_it_has_come_again(robot, urdf, memory):
    simulation = robot().simulation
    node = LocalNodeHandle({"robot_description": urdf}, "/second")
    config = shipped_config(model="second", start__beside=True)
    simulation.add_robot(simulation.plan_robot(config, urdf, node))
    simulation.robots[1].request_e_stop(True)
    CrashRecovery(memory()).note(simulation, resets=0)
    simulation.remove_robot("/second")
    for _ in range(2):  # also through a second crash
        recovery = CrashRecovery(memory())
        recovery.restore(simulation)
        recovery.note(simulation, resets=1)
    assert [recovery.was_stopped(name) for name in ("/third", "/second", "/second")] == [
        *(False, True, False)
    ]
    assert not simulation.robots[0].e_stop_wanted


def test_an_end_in_order_leaves_nothing(robot, memory):
    simulation = robot().simulation
    recovery = CrashRecovery(memory())
    recovery.note(simulation, resets=1)
    recovery.forget()
    another = CrashRecovery(memory())
    another.restore(simulation)
    assert not another.happened


def test_what_makes_no_sense_is_not_restored(robot, memory):
    simulation = robot().simulation
    memory().keep(steps="many", resets=1)
    recovery = CrashRecovery(memory())
    recovery.restore(simulation)
    assert (recovery.happened, simulation.steps) == (False, 0)


def test_a_change_is_noted_at_once_and_the_time_twice_a_second(robot, memory):
    simulation = robot().simulation
    recovery = CrashRecovery(memory())

    def noted(steps):
        simulation.steps = steps
        recovery.note(simulation, resets=0)
        return memory().recall()["steps"]

    assert [noted(steps) for steps in (5, 10, 254, 255, 260)] == [5, 5, 5, 255, 255]
    simulation.request_e_stop(True)
    assert noted(265) == 265
    assert memory().recall()["e_stop"] is True
