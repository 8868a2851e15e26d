"""A `StepRig` over ROS: the controllers of a simulator, or a robot, that runs."""

from __future__ import annotations

import contextlib
import threading
import time
from typing import Any, Callable, Dict, Iterator, List, Optional, Sequence, Tuple

import numpy as np
import rospy
from control_msgs.msg import JointControllerState
from rosgraph import Master
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Float64

from ..manager.client import BEST_EFFORT, STRICT, ControllerManagerClient
from ..urdf.joints import UrdfError, UrdfJoint, joints, parse_urdf
from .analysis import StepRecording, StepRecordingError
from .runner import StepError

CONTROLLER_TYPE = "effort_controllers/JointPositionController"
SHAPING = ("command_limits", "command_filter_frequency")
"""Parameters of a controller that keep it from following a command as it comes."""

_LIST_SERVICE = "/controller_manager/list_controllers"
_ANSWER = 5.0
"""Wall time (s) in which a running simulator sends its joint states, and its clock goes on."""
_LEAD = 0.1
"""Sim time (s) that a recording holds from before its step."""


def find_namespace() -> str:
    """Return the namespace of the controller manager on this master; this node's comes first.

    Raises
    ------
    StepError
        There is none, or several.
    """
    services = Master(rospy.get_name()).getSystemState()[2]
    found = sorted(
        name[: -len(_LIST_SERVICE)] for name, _ in services if name.endswith(_LIST_SERVICE)
    )
    own = rospy.get_namespace().rstrip("/")
    if own in found:
        return own
    if not found:
        raise StepError("no controller manager is there; start the simulator first")
    if len(found) > 1:
        names = ", ".join(each or "/" for each in found)
        raise StepError(
            f"there are {len(found)} controller managers, in {names}; choose one by --namespace"
        )
    return found[0]


class RosRig:
    """The position controllers that run in a namespace.

    Parameters
    ----------
    namespace : str
        Of the robot, without a slash at its end.
    only : sequence of str, optional
        Joints whose controllers are wanted; those of others are not listened to, which would cost
        simulator and client some hundred messages a second. Left out: all.

    Raises
    ------
    StepError
        From here and from every method: the simulator does not run, is paused, or its emergency
        stop is pressed; or no position controller runs.
    """

    def __init__(self, namespace: str, only: Optional[Sequence[str]] = None) -> None:
        self._namespace = namespace
        self._manager = ControllerManagerClient(namespace)
        self._stopped = False
        self._states: Dict[str, JointControllerState] = {}
        self._positions: Dict[str, float] = {}
        self._samples: List[Tuple[float, float, float]] = []
        self._recorded: Optional[str] = None
        self._lock = threading.Lock()
        running = self._running_controllers()
        self._controllers = {
            joint: name for joint, name in running.items() if only is None or joint in only
        }
        rospy.Subscriber(f"{namespace}/e_stop", Bool, self._on_e_stop)
        rospy.Subscriber(
            f"{namespace}/joint_states", JointState, self._on_joint_states, tcp_nodelay=True
        )
        self._commands = {}
        for joint, name in self._controllers.items():
            rospy.Subscriber(
                f"{namespace}/{name}/state",
                JointControllerState,
                self._keeper(joint),
                tcp_nodelay=True,
            )
            self._commands[joint] = rospy.Publisher(
                f"{namespace}/{name}/command", Float64, queue_size=1, tcp_nodelay=True
            )
        self._until(
            lambda: set(self._controllers) <= set(self._positions),
            "no joint states arrive; is the simulator paused?",
        )
        for joint in self._controllers:
            self._await_controller(joint)

    def joints(self) -> Dict[str, UrdfJoint]:
        """Joints whose position controllers run."""
        try:
            text = rospy.get_param(f"{self._namespace}/robot_description")
            described = joints(parse_urdf(text))
        except (KeyError, UrdfError) as error:
            raise StepError(f"{self._namespace}/robot_description: {error}") from error
        return {joint: described[joint] for joint in self._controllers}

    def position(self, joint: str) -> float:
        """See `StepRig`."""
        return self._positions[joint]

    def reference(self, joint: str) -> float:
        """See `StepRig`."""
        return float(self._states[joint].set_point)

    def command(self, joint: str, position: float) -> None:
        """See `StepRig`."""
        self._commands[joint].publish(Float64(position))

    def wait(self, seconds: float) -> None:
        """See `StepRig`."""
        end = rospy.get_time() + seconds
        last, seen = -1.0, time.monotonic()
        while True:
            now = rospy.get_time()
            if self._stopped:
                raise StepError("the emergency stop is pressed; release it, then start again")
            if now >= end:
                return
            if now != last:
                last, seen = now, time.monotonic()
            elif time.monotonic() - seen > _ANSWER:
                raise StepError("sim time stands still; is the simulator paused?")
            time.sleep(0.002)

    def record(self, joint: str, target: float, seconds: float) -> StepRecording:
        """See `StepRig`."""
        start = self.reference(joint)
        with self._lock:
            self._samples = []
            self._recorded = joint
        self.wait(_LEAD)
        sent = rospy.get_time()
        held = self._states[joint]
        self.command(joint, target)
        end = sent + seconds
        # On a busy machine the command may take some cycles to arrive.
        while self._states[joint].set_point == start and rospy.get_time() < end:
            held = self._states[joint]
            self.wait(0.002)
        stepped = max(sent, held.header.stamp.to_sec())
        self.wait(stepped + seconds - rospy.get_time())
        with self._lock:
            self._recorded = None
            samples = self._samples
        if not samples:
            raise StepError(f"no joint states of {joint} arrived while it was stepped")
        times, positions, efforts = map(np.array, zip(*samples))
        try:
            return StepRecording(times - stepped, positions, efforts, start, target)
        except StepRecordingError as error:
            raise StepError(f"{joint}: {error}") from error

    @contextlib.contextmanager
    def raw(self, joint: str) -> Iterator[None]:
        """See `StepRig`.

        The controller is loaded anew without what shapes its reference, and afterwards as it was,
        also when that or the step breaks off.
        """
        name = self._controllers[joint]
        key = f"{self._namespace}/{name}"
        params = rospy.get_param(key)
        bare = {each: value for each, value in params.items() if each not in SHAPING}
        try:
            self._reload(joint, key, bare, STRICT)
            yield
        except BaseException:
            try:
                self._reload(joint, key, params, BEST_EFFORT)
            except (StepError, rospy.ServiceException) as error:
                # What broke the step off is what the program ends with.
                rospy.logwarn("%s, loaded as it was: %s", name, error)
            raise
        self._reload(joint, key, params, BEST_EFFORT)

    def _reload(self, joint: str, key: str, params: Dict[str, Any], strictness: int) -> None:
        """Load a controller with other parameters.

        With BEST_EFFORT it may be stopped, or not loaded at all.
        """
        name = self._controllers[joint]
        rospy.set_param(key, params)
        self._states.pop(joint, None)
        gone = self._manager.switch([], [name], strictness) and self._manager.unload(name)
        done = (
            (gone or strictness == BEST_EFFORT)
            and self._manager.load(name)
            and self._manager.switch([name], [])
        )
        if not done:
            raise StepError(f"{name} cannot be loaded anew; the controller manager's log says why")
        self._states.pop(joint, None)
        self._await_controller(joint)

    def _running_controllers(self) -> Dict[str, str]:
        """Position controllers that run, by joint."""
        found = {}
        for each in self._manager.list_controllers():
            if each.type == CONTROLLER_TYPE and each.state == "running":
                found[str(rospy.get_param(f"{self._namespace}/{each.name}/joint"))] = each.name
        if not found:
            raise StepError(
                f"no {CONTROLLER_TYPE} runs in {self._namespace or '/'}; "
                "start them, e.g. by controller_group switch manual"
            )
        return found

    def _await_controller(self, joint: str) -> None:
        """Wait until a controller is heard, and hears."""
        name = self._controllers[joint]
        self._until(
            lambda: joint in self._states and self._commands[joint].get_num_connections() > 0,
            f"{name} does not publish its state; is the simulator paused?",
        )

    def _until(self, condition: Callable[[], bool], otherwise: str) -> None:
        end = time.monotonic() + _ANSWER
        while not condition():
            if self._stopped:
                raise StepError("the emergency stop is pressed; release it, then start again")
            if time.monotonic() > end:
                raise StepError(otherwise)
            time.sleep(0.01)

    def _keeper(self, joint: str) -> Callable[[JointControllerState], None]:
        def keep(message: JointControllerState) -> None:
            self._states[joint] = message

        return keep

    def _on_e_stop(self, message: Bool) -> None:
        self._stopped = message.data

    def _on_joint_states(self, message: JointState) -> None:
        self._positions.update(zip(message.name, message.position))
        with self._lock:
            if self._recorded is None or self._recorded not in message.name:
                return
            index = message.name.index(self._recorded)
            effort = message.effort[index] if message.effort else float("nan")
            self._samples.append((message.header.stamp.to_sec(), message.position[index], effort))


def require_running(joints_wanted: Sequence[str], running: Sequence[str]) -> None:
    """Raise a `StepError` when a joint has no position controller that runs."""
    without = [joint for joint in joints_wanted if joint not in running]
    if without:
        raise StepError(
            f"no position controller runs for {', '.join(without)}; there are: {', '.join(running)}"
        )
