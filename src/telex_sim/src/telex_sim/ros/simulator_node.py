"""The ``simulator`` node: the loop, its clock and its services."""

from __future__ import annotations

import copy
import math
import os
import sys
import threading
import time as wall
from typing import Any, Callable, Iterator, List, Optional, Tuple

import rospy
from rosgraph_msgs.msg import Clock
from std_srvs.srv import Empty, EmptyResponse
from telex_msgs.msg import SceneFile, SceneLight, ScenePoses, SimStatus
from telex_msgs.srv import (
    AddRobot,
    AddRobotResponse,
    Bookmark,
    BookmarkResponse,
    Delete,
    DeleteResponse,
    ListBookmarks,
    ListBookmarksResponse,
    ListScenes,
    ListScenesResponse,
    LoadScene,
    LoadSceneResponse,
    RemoveRobot,
    RemoveRobotResponse,
    Restore,
    RestoreResponse,
    Spawn,
    SpawnResponse,
    Step,
    StepResponse,
)

from telex_control.common.file_catalog import package_path
from telex_control.common.interpreter import prepare_for_loop
from telex_control.common.params import ConfigError
from telex_control.common.scheduling import LoopPriority
from telex_control.ros.node_start import init_node, until_shutdown
from telex_control.ros.robot_description import offer_globally, wait_for_robot_description
from telex_control.ros.ros_node_handle import RosNodeHandle
from telex_control.ros.run_memory import RunMemory
from telex_control.urdf.joints import UrdfError

from ..engine.bookmarks import Bookmarks
from ..engine.loop_requests import Action, LoopRequests
from ..engine.pacing import RealTimeFactor, RealTimePacer
from ..engine.simulation import Simulation
from ..engine.simulator_config import SimulatorConfig, read_robot_config, read_simulator_config
from ..engine.world import WorldError
from ..rehearsal.client import RehearsalClient
from ..robot.body import RobotBody
from ..robot.robot import Robot
from ..robot.urdf.visuals import UrdfVisual
from ..scene.addresses import resolve_address
from ..scene.files.scene_file import SceneError
from ..scene.planning import PlannedScene
from .arranging import Arranging
from .crash_recovery import CrashRecovery
from .robot_presence import RobotPresence
from .scene_messages import SceneMessages
from .scene_publisher import ScenePublisher

_PAUSED_PERIOD = 0.01
"""Wall time between two looks at the requests while paused (s)."""
_PAUSED_REPEAT = 0.2
"""Wall time between repeated clock and pose messages while paused (s): for late subscribers."""
_STATUS_PERIOD = 1.0
"""Wall time between status messages (s)."""
_BATTERY_RATE = 1.0
"""Hz of sim time at which the battery's charge is told."""
_MAX_STEPS = 1_000_000
_STEPS_AT_ONCE = 50
"""Steps of ``sim/step`` between two looks at the requests."""
_LONG_STAND = 0.1
"""Wall time (s) without a step after which a running robot begins anew, standing."""
_STAND_TOLD = 5.0
"""Wall time (s) for which the status tells of that."""
_SLOW = 0.95
"""Share of the wanted real-time factor below which the status warns."""


class _Stepping:
    """Steps of a paused simulation that are still to be made."""

    def __init__(self, steps: int) -> None:
        self.remaining = steps
        self.done = threading.Event()


class SimulatorNode:
    """Runs a `Simulation` and speaks ROS for it.

    All ROS callbacks leave their work in a queue; only `run`, in the main thread, touches the
    simulation.
    """

    def __init__(self, simulation: Simulation, recovery: CrashRecovery, paused: bool) -> None:
        self._simulation = simulation
        self._recovery = recovery
        self._paused = paused
        config = simulation.config
        self._step_ns = round(config.timing.step_size * 1e9)
        self._requests = LoopRequests()
        self._bookmarks = Bookmarks(simulation)
        self._stepping: Optional[_Stepping] = None
        self._pacer = RealTimePacer(config.timing.real_time_factor)
        self._factor = RealTimeFactor()
        self._late_cycles = 0
        # Until when (wall time, s) the status tells of a time in which the simulation stood.
        self._stood = (0.0, "")
        self._resets = recovery.resets
        first = simulation.robots[0]
        self._scene = SceneMessages(
            first.model, first.body.link_names(), first.urdf, simulation.scene
        )
        self._scene.show(simulation.objects.objects())
        # Held while objects and robots come and go, so that each knows the names that there are.
        self._spawning = threading.Lock()
        self._rehearsal = RehearsalClient(config)
        self._clock = rospy.Publisher("/clock", Clock, queue_size=4, tcp_nodelay=True)
        self._scene_publisher = ScenePublisher(lambda: self._scene.description(self._now()))
        self._poses = rospy.Publisher("sim/poses", ScenePoses, queue_size=1, tcp_nodelay=True)
        self._light = rospy.Publisher("sim/light", SceneLight, queue_size=1, latch=True)
        self._light_told: Optional[Tuple[float, float]] = None
        # Replaced as a whole, never changed: the loop reads it without a lock.
        self._presences: Tuple[RobotPresence, ...] = (self._present(first, recovery.happened),)
        self._next_status = 0.0
        self._clock_every = self._steps_between(config.publish.clock_rate)
        self._poses_every = self._steps_between(config.publish.poses_rate)
        self._base_pose_every = self._steps_between(config.publish.base_pose_rate)
        self._stability_every = self._steps_between(config.publish.stability_rate)
        self._truth_every = self._steps_between(config.publish.truth_rate)
        self._battery_every = self._steps_between(_BATTERY_RATE)
        self._scene_publisher.publish_soon()
        self._publish_light()
        self._services: List[Any] = [
            rospy.Service("sim/pause", Empty, lambda _: self._empty(self._pause)),
            rospy.Service("sim/unpause", Empty, lambda _: self._empty(self._unpause)),
            rospy.Service("sim/reset", Empty, self._on_reset),
            rospy.Service("sim/bookmark", Bookmark, self._on_bookmark),
            rospy.Service("sim/restore", Restore, self._on_restore),
            rospy.Service("sim/list_bookmarks", ListBookmarks, self._on_list_bookmarks),
            rospy.Service("sim/step", Step, self._on_step),
            rospy.Service("sim/list_scenes", ListScenes, self._on_list_scenes),
            rospy.Service("sim/load_scene", LoadScene, self._on_load_scene),
            rospy.Service("sim/spawn", Spawn, self._on_spawn),
            rospy.Service("sim/delete", Delete, self._on_delete),
            rospy.Service("sim/add_robot", AddRobot, self._on_add_robot),
            rospy.Service("sim/remove_robot", RemoveRobot, self._on_remove_robot),
        ]
        self._arranging = Arranging(
            simulation, self._scene, self._rehearsal, self._change, self._publish_scene
        )

    def _present(self, robot: Robot, after_crash: bool = False) -> RobotPresence:
        return RobotPresence(robot, self._change, self._now, after_crash)

    def _steps_between(self, rate: float) -> int:
        """Steps from one message to the next, so that the rate is never exceeded."""
        steps = 1.0 / (rate * self._simulation.config.timing.step_size)
        return max(1, math.ceil(steps - 1e-6))

    def _now(self) -> rospy.Time:
        return rospy.Time(0, self._simulation.steps * self._step_ns)

    # --- callbacks: other threads ------------------------------------------------------------

    def _empty(self, action: Callable[[], None]) -> EmptyResponse:
        self._requests.carry_out(action)
        return EmptyResponse()

    def _on_reset(self, _request: Any) -> EmptyResponse:
        self._find_cameras()
        return self._empty(self._reset)

    def _find_cameras(self) -> None:
        for presence in self._presences:
            presence.radiation.find_cameras()

    def _on_step(self, request: Any) -> StepResponse:
        steps = request.steps or 1
        if steps > _MAX_STEPS:
            return StepResponse(
                success=False,
                message=f"steps is {steps}; at most {_MAX_STEPS} at once are possible",
                sim_time=self._now(),
            )
        stepping = _Stepping(steps)
        problem: List[str] = []

        def begin() -> None:
            if not self._paused:
                problem.append("the simulation is running; call sim/pause first")
            elif self._stepping is not None:
                problem.append("another call of sim/step is not finished yet")
            else:
                self._stepping = stepping

        self._requests.carry_out(begin)
        while not problem and not stepping.done.wait(0.1):
            if rospy.is_shutdown():
                raise rospy.ServiceException("the simulator shuts down")
        if stepping.remaining and not problem:
            problem.append(f"{stepping.remaining} steps were left when sim/unpause was called")
        return StepResponse(success=not problem, message=" ".join(problem), sim_time=self._now())

    def _on_bookmark(self, request: Any) -> BookmarkResponse:
        name: List[str] = []
        names: List[str] = []

        def save() -> None:
            name.append(self._bookmarks.save(request.name, request.replaces))
            names.extend(self._bookmarks.names())

        try:
            self._change(save)
        except ConfigError as error:
            rospy.logwarn("sim/bookmark: %s", error)
            return BookmarkResponse(success=False, message=str(error))
        return BookmarkResponse(
            success=True, message=f"bookmark '{name[0]}' is set", name=name[0], names=names
        )

    def _on_restore(self, request: Any) -> RestoreResponse:
        name: List[str] = []
        try:
            self._change(lambda: name.append(self._restore(request.name)))
        except ConfigError as error:
            rospy.logwarn("sim/restore: %s", error)
            return RestoreResponse(success=False, message=str(error))
        message = f"back at bookmark '{name[0]}'"
        rospy.loginfo("%s", message)
        return RestoreResponse(success=True, message=message, name=name[0])

    def _on_list_bookmarks(self, _request: Any) -> ListBookmarksResponse:
        names: List[str] = []
        self._requests.carry_out(lambda: names.extend(self._bookmarks.names()))
        return ListBookmarksResponse(names=names)

    def _on_list_scenes(self, _request: Any) -> ListScenesResponse:
        try:
            scenes = self._rehearsal.listing()
        except ConfigError as error:
            raise rospy.ServiceException(str(error)) from error
        listed = [
            SceneFile(
                name=scene.name,
                path=scene.path,
                description=scene.description,
                problem=scene.problem,
                hidden=scene.hidden,
                picture=scene.picture,
            )
            for scene in scenes
        ]
        return ListScenesResponse(scenes=listed, current=str(self._simulation.scene_path))

    def _figures(self) -> List[RobotBody]:
        return [robot.figure for robot in self._simulation.robots]

    def _on_load_scene(self, request: Any) -> LoadSceneResponse:
        done: List[str] = []
        try:
            with self._spawning:
                planned = self._rehearsal.scene(request.world, self._figures())
                self._find_cameras()
                self._change(lambda: done.append(self._load_scene(planned)))
        except (ConfigError, SceneError) as error:
            rospy.logwarn("sim/load_scene: %s", error)
            return LoadSceneResponse(success=False, message=str(error))
        rospy.loginfo("%s", done[0])
        return LoadSceneResponse(success=True, message=done[0])

    def _load_scene(self, planned: PlannedScene) -> str:
        """Change the scene; returns what was done, in words."""
        began = wall.monotonic()
        self._simulation.put_scene(planned)
        self._scene.change_scene(planned.scene, self._simulation.objects.objects())
        self._publish_scene()
        self._after_reset()
        name, count = planned.scene.name, len(planned.assemblies)
        return f"scene {name}: {count} objects in {wall.monotonic() - began:.2f} s"

    def _on_spawn(self, request: Any) -> SpawnResponse:
        simulation = self._simulation
        try:
            with self._spawning:
                plans = self._rehearsal.entry(
                    request.object,
                    request.name,
                    request.folder,
                    simulation.objects.names(),
                    [robot.model for robot in simulation.robots],
                    simulation.scene.floor,
                )
                self._change(lambda: simulation.spawn_gradually(plans))
        except ConfigError as error:
            rospy.logwarn("sim/spawn: %s", error)
            return SpawnResponse(success=False, message=str(error))
        names = [plan.source.name for plan in plans]
        return SpawnResponse(success=True, message=f"spawned: {', '.join(names)}", names=names)

    def _on_delete(self, request: Any) -> DeleteResponse:
        gone: List[str] = []
        try:
            self._change(lambda: gone.extend(self._simulation.delete(request.name)))
        except ConfigError as error:
            rospy.logwarn("sim/delete: %s", error)
            return DeleteResponse(success=False, message=str(error))
        return DeleteResponse(success=True, message=f"gone: {', '.join(gone)}")

    def _on_add_robot(self, request: Any) -> AddRobotResponse:
        name = rospy.resolve_name(request.name).rstrip("/")
        try:
            with self._spawning:
                robot, visuals = self._plan_robot(name)
                try:
                    self._change(lambda: self._add_robot(robot, visuals))
                    presence = self._present_added(robot)
                except Exception:
                    robot.close()
                    raise
                self._presences = (*self._presences, presence)
        except (ConfigError, UrdfError, WorldError) as error:
            rospy.logwarn("sim/add_robot: %s: %s", name, error)
            return AddRobotResponse(success=False, message=str(error))
        self._status_soon()
        return AddRobotResponse(success=True, message=f"added: {name} as '{robot.model}'")

    def _plan_robot(self, name: str) -> Tuple[Robot, List[UrdfVisual]]:
        """Read all that its namespace says of a robot, and try it."""
        node = RosNodeHandle(name or "/")
        if any(robot.namespace == node.namespace for robot in self._simulation.robots):
            raise ConfigError(
                f"there is a robot in {name or '/'} already; sim/remove_robot takes out one that "
                "was added"
            )
        urdf = node.find_param("robot_description", None)
        if not isinstance(urdf, str):
            raise ConfigError(f"parameter {node.resolve('robot_description')} is missing")
        params = node.find_param("simulation", {})
        config = read_robot_config(params, node.resolve("simulation"))
        figure = RobotBody.of(urdf, config, node.namespace)
        visuals = self._rehearsal.robot(figure, self._simulation.scene.start)
        return self._simulation.plan_robot(config, urdf, node), visuals

    def _add_robot(self, robot: Robot, visuals: List[UrdfVisual]) -> None:
        began = wall.monotonic()
        self._simulation.add_robot(robot)
        self._scene.add_robot(robot.model, robot.body.link_names(), visuals)
        self._publish_scene()
        stood = wall.monotonic() - began
        if stood > _LONG_STAND:
            # What was commanded before it is as old as that, and operators saw nothing meanwhile.
            for each in self._simulation.robots:
                each.controllers.interrupt(self._simulation.time)
            self._stood = (
                wall.monotonic() + _STAND_TOLD,
                f"the simulation stood for {stood:.2f} s, while robot {robot.model} was added; "
                "what was commanded before is forgotten",
            )
            # Messages may have waited for it, and count as new: who streams has to begin anew.
            self._after_reset()
        rospy.loginfo("robot %s: added in %.3f s", robot.model, stood)

    def _present_added(self, robot: Robot) -> RobotPresence:
        """Open the topics of a robot that was added; where that fails, it is taken out again."""
        stopped = self._recovery.was_stopped(robot.namespace)
        if stopped:
            robot.request_e_stop(True)
        try:
            return self._present(robot, stopped)
        except Exception:
            self._change(lambda: self._remove_robot(robot))
            if stopped:
                self._recovery.keep_stopped(robot.namespace)
            raise

    def _on_remove_robot(self, request: Any) -> RemoveRobotResponse:
        name = rospy.resolve_name(request.name).rstrip("/")
        with self._spawning:
            added = self._presences[1:]
            gone = next((each for each in added if each.robot.namespace == name), None)
            if gone is None:
                names = ", ".join(each.robot.namespace for each in added)
                message = f"name is '{name}'; robots that were added: {names or 'none'}"
                return RemoveRobotResponse(success=False, message=message)
            self._presences = tuple(each for each in self._presences if each is not gone)
            gone.unload_controllers()
            self._change(lambda: self._remove_robot(gone.robot))
            gone.close()
        return RemoveRobotResponse(success=True, message=f"gone: {name}")

    def _remove_robot(self, robot: Robot) -> None:
        self._simulation.remove_robot(robot.namespace)
        self._scene.remove_robot(robot.model)
        self._publish_scene()

    def _change(self, action: Action) -> None:
        """Have the loop's thread change the scene.

        Raises
        ------
        ConfigError, SceneError
            What the change was refused for.
        rospy.ServiceException
            The node shuts down.
        """
        refused: List[Exception] = []

        def change() -> Iterator[None]:
            try:
                rest = action()
                if rest is not None:
                    yield from rest
            except (ConfigError, SceneError) as error:
                refused.append(error)
            else:
                self._show_scene()

        self._requests.carry_out(change)
        if refused:
            raise refused[0]

    # --- the loop's thread -------------------------------------------------------------------

    def run(self) -> None:
        """Run until ROS shuts down."""
        priority = _come_first(self._simulation.config)
        self._restart_pace()
        self._publish_all()
        repeat_at = 0.0
        while not rospy.is_shutdown():
            self._requests.serve()
            if wall.monotonic() >= self._next_status or self._robots_changed():
                self._publish_status()
            if not self._paused:
                begins_cycle = self._simulation.at_cycle_start
                self._step()
                late = self._pacer.wait(self._simulation.time)
                if not late:
                    priority.rest()
                if begins_cycle and late > self._simulation.config.timing.control_period:
                    self._late_cycles += 1
                continue
            if self._stepping is not None:
                self._step_while_paused(self._stepping)
                continue
            self._simulation.idle()
            if wall.monotonic() >= repeat_at:
                repeat_at = wall.monotonic() + _PAUSED_REPEAT
                self._publish_all()
            wall.sleep(_PAUSED_PERIOD)
            priority.rest()

    def _step_while_paused(self, stepping: _Stepping) -> None:
        """Make some of the steps, so that requests are served in between."""
        for _ in range(min(stepping.remaining, _STEPS_AT_ONCE)):
            self._step()
            stepping.remaining -= 1
        if not stepping.remaining:
            self._end_stepping()

    def _end_stepping(self) -> None:
        if self._stepping is not None:
            self._stepping.done.set()
            self._stepping = None
            self._status_soon()

    def close(self) -> None:
        """Take the services back and release PyBullet."""
        for service in self._services:
            service.shutdown()
        self._arranging.close()
        for presence in self._presences:
            presence.close()
        self._rehearsal.close()
        self._scene_publisher.close()
        self._simulation.close()

    def _pause(self) -> None:
        self._paused = True
        self._status_soon()

    def _unpause(self) -> None:
        self._paused = False
        self._end_stepping()
        self._restart_pace()
        self._status_soon()

    def _reset(self) -> None:
        self._simulation.reset()
        self._show_scene()
        self._after_reset()

    def _restore(self, name: str) -> str:
        """Go back to a bookmark; returns its name."""
        found = self._bookmarks.restore(name)
        # Commands from before are of another state: whoever streams has to begin anew.
        self._after_reset()
        return found

    def _after_reset(self) -> None:
        self._resets += 1
        self._restart_pace()
        self._publish_all()
        self._status_soon()

    def _show_scene(self) -> None:
        """Tell renderers what has come and gone, and where it is."""
        if self._scene.show(self._simulation.objects.objects()):
            self._publish_scene()

    def _publish_scene(self) -> None:
        self._scene_publisher.publish_soon()
        self._publish_light()
        self._publish_poses()

    def _publish_light(self) -> None:
        """Tell what share of the scene's light there is, where that has changed."""
        light = self._scene.light
        if light != self._light_told:
            self._light_told = light
            self._light.publish(SceneLight(*light))

    def _restart_pace(self) -> None:
        self._pacer.restart(self._simulation.time)
        self._factor.restart(self._simulation.time)

    def _robots_changed(self) -> bool:
        """Whether the last status tells of a robot what is no longer so."""
        return any(presence.changed() for presence in self._presences)

    def _status_soon(self) -> None:
        self._next_status = 0.0

    def _step(self) -> None:
        simulation = self._simulation
        simulation.step()
        steps = simulation.steps
        if steps % self._clock_every == 0:
            self._publish_clock()
        if steps % self._poses_every == 0:
            self._publish_poses()
        if steps % self._base_pose_every == 0:
            self._publish_base_pose()
        if steps % self._stability_every == 0:
            for presence in self._presences:
                presence.observe(simulation.time)
                presence.malfunctions.publish()
                presence.microphone.publish()
            self._publish_stability()
        if steps % self._battery_every == 0:
            for presence in self._presences:
                presence.malfunctions.publish_battery()
        if steps % self._truth_every == 0:
            for presence in self._presences:
                presence.publish_truth(simulation, self._now(), self._resets)
        for presence in self._presences:
            config = presence.robot.config
            if self._is_due(config.dosimetry.rate):
                presence.radiation.publish(simulation, self._now())
            if self._is_due(config.radio.rate):
                presence.radio.publish(simulation, self._now())
            if self._is_due(config.gas.rate):
                presence.gas.publish(simulation, self._now())
            if self._is_due(presence.equipment.rate):
                presence.equipment.publish_range(self._now())
        simulation.timer.end("publish")
        for presence in self._presences:
            robot = presence.robot
            if robot.proximity.joints and self._is_due(robot.config.proximity.rate):
                presence.publish_proximity(self._now(), simulation.proximity)
        simulation.timer.end("proximity")
        for presence in self._presences:
            if self._is_due(presence.robot.config.gripper_contact.rate):
                presence.publish_gripper_contact(self._now(), simulation.gripper_contact)
        simulation.timer.end("publish")

    def _is_due(self, rate: float) -> bool:
        """Whether what is told at a rate (Hz of sim time; 0: never) is to be told at this step."""
        return rate > 0.0 and self._simulation.steps % self._steps_between(rate) == 0

    def _publish_all(self) -> None:
        self._publish_clock()
        self._publish_poses()
        self._publish_base_pose()
        self._publish_stability()
        for presence in self._presences:
            presence.radiation.publish(self._simulation, self._now())
            presence.radio.publish(self._simulation, self._now())
            presence.gas.publish(self._simulation, self._now())
            presence.equipment.publish_range(self._now())
            presence.malfunctions.publish()
            presence.malfunctions.publish_battery()

    def _publish_clock(self) -> None:
        self._recovery.note(self._simulation, self._resets)
        self._clock.publish(Clock(self._now()))

    def _publish_poses(self) -> None:
        if self._poses.get_num_connections():
            self._poses.publish(self._scene.poses(self._now(), self._simulation.link_poses()))

    def _publish_base_pose(self) -> None:
        for presence in self._presences:
            presence.publish_base_pose(self._now())

    def _publish_stability(self) -> None:
        for presence in self._presences:
            presence.publish_stability(self._now())

    def _publish_status(self) -> None:
        self._next_status = wall.monotonic() + _STATUS_PERIOD
        simulation = self._simulation
        timing = simulation.config.timing
        means = simulation.timer.take_means()
        factor = 0.0 if self._paused else self._factor.since_last(simulation.time)
        message = SimStatus(
            paused=self._paused,
            world=simulation.scene.name,
            step_size=timing.step_size,
            control_period=timing.control_period,
            target_real_time_factor=timing.real_time_factor,
            real_time_factor=factor,
            resets=self._resets,
            steps=simulation.steps,
            late_cycles=self._late_cycles,
            phases=[phase for phase, _ in means],
            phase_cpu=[cpu for _, cpu in means],
            warnings=self._warnings(factor),
        )
        message.header.stamp = self._now()
        for presence in self._presences:
            presence.publish_status(copy.copy(message))

    def _warnings(self, factor: float) -> List[str]:
        wanted = self._simulation.config.timing.real_time_factor
        until, stood = self._stood
        said = [stood] if wall.monotonic() < until else []
        if self._paused or not factor or factor >= _SLOW * wanted:
            return said
        return [*said, f"this computer is too slow: real-time factor {factor:.2f} of {wanted:g}"]


def _come_first(config: SimulatorConfig) -> LoopPriority:
    """Put this process before ordinary ones, and say so; one that is not to rest remains one."""
    wanted = config.realtime_priority
    priority = LoopPriority(wanted)
    why_not = priority.take()
    if not why_not:
        rospy.loginfo("simulator: real-time priority %d", wanted)
    elif wanted:
        rospy.loginfo(
            "simulator: no real-time priority %d (%s): beside what fills all processors it may "
            "fall behind; docs/operator/troubleshooting.md",
            wanted,
            why_not,
        )
    else:
        rospy.loginfo("simulator: no real-time priority")
    return priority


def main() -> None:
    """Run the node; a mistake in the configuration ends it with one line that says what to do."""
    init_node("simulator", coarse_clock=True)  # the loop has its own
    try:
        paused = bool(rospy.get_param("~paused", False))
        description = wait_for_robot_description()
        if rospy.get_param("~global_description", True):
            offer_globally(description)
        simulation = Simulation(
            read_simulator_config(rospy.get_param("~", {}), rospy.get_name()),
            description,
            RosNodeHandle(),
            lambda address: resolve_address(address, package_path),
        )
        recovery = CrashRecovery(RunMemory.of_this_node())
        recovery.restore(simulation)
        node = SimulatorNode(simulation, recovery, paused)
    except rospy.ROSInterruptException:
        return
    except (ConfigError, SceneError, UrdfError, WorldError) as error:
        rospy.logfatal("%s", error)
        sys.exit(os.EX_CONFIG)
    prepare_for_loop()
    if recovery.happened:
        rospy.logwarn(
            "simulator: the one before has crashed; the scene begins anew, the clock goes on at "
            "%.0f s, the emergency stop is %s",
            simulation.time,
            "set" if simulation.robots[0].e_stop_wanted else "released",
        )
    rospy.loginfo("simulator: ready")
    try:
        with until_shutdown():
            node.run()
        recovery.forget()
    finally:
        node.close()
