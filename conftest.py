"""Distribution of the tests among pytest-xdist's workers (``-n 3 --dist loadgroup``).

What needs a ROS master, a browser or wall time and works the machine hard runs one after the other
in one worker; what needs them and mostly waits, in a second one. The other workers meanwhile run
what depends on no clock, at low priority: that may wait, and the rest may not. Without ``-n``, all
tests run one after the other.
"""

from __future__ import annotations

import os
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, List, Tuple

import pytest
from hypothesis import HealthCheck, settings

if TYPE_CHECKING:
    from xdist.scheduler import LoadGroupScheduling

# How long an example takes says nothing on a machine that has other things to do.
settings.register_profile("telex", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("telex")

pytest_plugins = ["own_ros"]

ROOT = Path(__file__).resolve().parent
NEEDS_THE_MACHINE = ("ros", "browser", "real_time")
"""Markers of tests that others may not hold up."""
HEAVY, LIGHT = "real_time", "waiting"
"""Lanes of such tests: one after the other in each."""
WAITING = (
    "src/telex_control/test/test_node_start.py",
    "tests/test_private_master.py",
    "src/telex_control/test/test_scheduling.py",
    "src/telex_control/test/test_xmlrpc_guard.py",
    "src/telex_description/test/test_no_warnings.py",
    "src/telex_teleop/test/test_arm_teleop_ros.py",
    "src/telex_teleop/test/test_joy_ros.py",
    "src/telex_teleop/test/test_keyboard_pty.py",
    "src/telex_teleop/test/test_teleop_ros.py",
    "src/telex_teleop/test/test_web_bridge_clients.py",
    "src/telex_teleop/test/test_web_bridge_server.py",
    "src/telex_teleop/test/test_web_deadman.py",
    "src/telex_teleop/test/test_web_ros.py",
    "src/telex_teleop/test/test_web_video.py",
    "tests/test_kinematics_agreement.py",
    "tests/test_paper_report.py",
    "tests/test_robot_state_publisher.py",
)
"""Files of such tests that start small nodes and mostly wait for them."""
WAITING_SUITES = ("controller_manager", "controllers")
"""Suites of ``tests/rostest`` of that kind."""
SLOW = (
    "src/telex_control/test/test_ik_properties.py",
    "src/telex_control/test/test_ik_solver.py",
    "src/telex_control/test/test_ik_track.py",
    "src/telex_control/test/test_tracked_drive.py",
    "src/telex_description/test/test_arm_model.py",
    "src/telex_description/test/test_generated_model.py",
    "src/telex_sim/test/test_camera_sensor.py",
    "src/telex_sim/test/test_control_stability.py",
    "src/telex_sim/test/test_drive_friction.py",
    "src/telex_sim/test/test_flippers.py",
    "src/telex_sim/test/test_proximity.py",
    "src/telex_sim/test/test_rendering_generated.py",
    "src/telex_sim/test/test_rendering_pictures.py",
    "src/telex_sim/test/test_scene_command_line.py",
    "src/telex_sim/test/test_scene_preview.py",
    "src/telex_sim/test/test_scene_simulation.py",
    "src/telex_sim/test/test_self_collision.py",
    "src/telex_sim/test/test_shipped_actions.py",
    "src/telex_sim/test/test_shipped_scenes.py",
    "src/telex_sim/test/test_shipped_variants.py",
    "src/telex_sim/test/test_simulation.py",
    "src/telex_sim/test/test_tracks_drive.py",
    "src/telex_sim/test/test_tracks_robot.py",
    "src/telex_sim/test/test_turning.py",
    "src/telex_teleop/test/test_arm_clearance.py",
    "src/telex_teleop/test/test_arm_teleop.py",
    "src/telex_teleop/test/test_arm_telex.py",
    "src/telex_teleop/test/test_arm_tool_motion.py",
    "src/telex_teleop/test/test_teleop_reference.py",
    "src/telex_training/test/exercises/test_check.py",
    "src/telex_training/test/exercises/test_exercise_file.py",
    "src/telex_training/test/judging/test_judge.py",
    "src/telex_training/test/test_rehearsal.py",
    "tests/test_benchmarks_smoke.py",
    "tests/test_mobility.py",
    "tests/test_paper_lockstep.py",
    "tests/test_stopping.py",
)
"""Files of more than 3 s of CPU time, which ``test.sh --fast`` leaves out; its closing table of
durations names those that belong here.
"""
PATIENCE = 15
"""Niceness of a worker from its first test that can wait."""


def in_a_worker() -> bool:
    """Whether this is one of the processes among which the tests are distributed."""
    return "PYTEST_XDIST_WORKER" in os.environ


def needs_the_machine(item: pytest.Item) -> bool:
    """Whether a test has to go on in wall time."""
    return any(item.get_closest_marker(name) for name in NEEDS_THE_MACHINE)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: List[pytest.Item]) -> None:
    """Mark the slow tests; keep those together that may not run side by side."""
    gone = [name for name in (*WAITING, *SLOW) if not (ROOT / name).is_file()]
    if gone:
        raise pytest.UsageError(f"conftest.py names what is not there: {', '.join(gone)}")
    slow, waiting = ({ROOT / name for name in names} for names in (SLOW, WAITING))
    suites = {f"tests/test_rostests.py::test_suite[{name}]" for name in WAITING_SUITES}
    for item in items:
        if item.path in slow:
            item.add_marker(pytest.mark.slow)
        if needs_the_machine(item):
            mostly_waits = item.path in waiting or item.nodeid in suites
            item.add_marker(pytest.mark.xdist_group(LIGHT if mostly_waits else HEAVY))


@lru_cache(maxsize=None)
def step_back() -> None:
    """Lower the priority of this process, once: it cannot be raised again.

    It gets a session of its own: the nodes of a launch have theirs, and Linux shares the processors
    among sessions first.
    """
    from telex_control.common.scheduling import step_back as lower

    os.setsid()
    lower(PATIENCE)


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Step back before the first test that can wait."""
    if in_a_worker() and not needs_the_machine(item):
        step_back()


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Name tests without the group that xdist appends: so they can be run again by that name."""
    for lane in (HEAVY, LIGHT):
        if not in_a_worker() and report.nodeid.endswith(f"@{lane}"):
            report.nodeid = report.nodeid[: -len(f"@{lane}")]


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: object) -> LoadGroupScheduling:
    """Begin with the tests that need the machine; then hand out files in their order."""
    from xdist.scheduler import LoadGroupScheduling

    class Scheduling(LoadGroupScheduling):
        """Files are not torn apart: their tests share costly fixtures."""

        def _split_scope(self, nodeid: str) -> str:
            group = super()._split_scope(nodeid)
            return group if group in {HEAVY, LIGHT} else nodeid.split("::", 1)[0]

        def _assign_work_unit(self, node: object) -> None:
            order = {self._split_scope(nodeid): None for nodeid in self.collection}
            ranks = {scope: rank for rank, scope in enumerate(order)}

            def rank(scope: str) -> Tuple[bool, bool, int]:
                return scope != HEAVY, scope != LIGHT, ranks[scope]

            # A worker that has once stepped back cannot come forward again for these.
            self.workqueue.move_to_end(min(self.workqueue, key=rank), last=False)
            super()._assign_work_unit(node)

    return Scheduling(config, log)
