"""ROS edge of joy_teleop: sensor_msgs/Joy in, commands for the teleoperation nodes out."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass
from typing import Any, Dict, FrozenSet, Optional

import rospy
from rospy.core import is_shutdown_requested
from sensor_msgs.msg import Joy
from std_msgs.msg import String

from telex_control.common.params import ConfigError, Declared, number, parameter, word
from telex_control.ros.node_start import init_node, until_shutdown
from telex_teleop.actions.grammar import Action, Command, Lamps
from telex_teleop.joy.core import JoyTeleop
from telex_teleop.joy.maps import JoyMap
from telex_teleop.joy.pads import InvalidJoy, Pad, Pads
from telex_teleop.joy.source_node import DEVICE_TOPIC
from telex_teleop.motion.speed import MAX_ZOOM, STEP, STEP_RANGE, ZOOM_RATE
from telex_teleop.operating.commander import Commander
from telex_teleop.operating.operated_robot import OperatedRobot
from telex_teleop.ros.common import WARNING_PERIOD, private_settings, warn_dropped

AUTO = "auto"
QUEUE = 10  # messages; each of them may hold a press


@dataclass(frozen=True)
class JoyTeleopSettings(Declared):
    """Parameters of joy_teleop.

    Raises
    ------
    telex_control.common.params.ConfigError
        When one is out of range.
    """

    map: str = parameter("", "Path of the file; empty: that of the package.")
    pads: str = parameter("", "The same.")
    pad: str = word(
        AUTO,
        "Name of a pad in the file; ``auto``: the one that recognizes what the node joy reads.",
    )
    robot: str = parameter(
        "", "Namespace of the robot; empty: the node's own, ``/telex`` for a node in the root."
    )
    joy_timeout: float = number(
        0.3, "Time (s) without a message after which everything stops.", 0.05, 0.3
    )
    longest_gap: float = number(
        0.2, "When the node was held up for longer (s), everything counts as let go.", 0.05, 1.0
    )
    send_rate: float = number(50.0, "Commands per second while something moves.", 10.0, 200.0)
    speed_step: float = number(
        STEP, "One step of the speed scale, as a share of the full speed.", *STEP_RANGE
    )
    zoom_rate: float = number(
        ZOOM_RATE, "How fast the camera zooms (1/s, of the factor's logarithm).", above=0.0
    )
    max_zoom: float = number(MAX_ZOOM, "Largest zoom factor.", 1.0, 100.0)


class LoggedRobot(OperatedRobot):
    """A `OperatedRobot` whose messages for the operator go to the log."""

    def _tell(self, text: str) -> None:
        super()._tell(text)
        if text:
            rospy.logwarn_throttle_identical(WARNING_PERIOD, text)


class JoyTeleopNode:
    """Feeds the core and sends what it demands.

    Parameters
    ----------
    namespace
        Of the robot.

    Raises
    ------
    telex_control.common.params.ConfigError
        When the pad is unknown, or lacks what the map needs.
    """

    def __init__(
        self, settings: JoyTeleopSettings, joy_map: JoyMap, pads: Pads, namespace: str
    ) -> None:
        self._settings = settings
        self._map = joy_map
        self._pads = pads
        self._lock = threading.Lock()
        self._core: Optional[JoyTeleop] = None
        self._pad = ""
        self._robot = LoggedRobot(namespace, joy_map.lamps, settings.zoom_rate, settings.max_zoom)
        self._commander = Commander(self._robot)
        self._demanded: FrozenSet[Action] = frozenset()
        self._sent_at = self._stepped_at = time.monotonic()
        self._mode_publisher = rospy.Publisher("~mode", String, queue_size=1, latch=True)
        if settings.pad != AUTO:
            self._use(settings.pad, pads.called(settings.pad))
        else:
            rospy.Subscriber(DEVICE_TOPIC, String, self._on_device, queue_size=1)
        rospy.Subscriber("joy", Joy, self._on_joy, queue_size=QUEUE, tcp_nodelay=True)
        rospy.on_shutdown(self.stop)

    def run(self) -> None:
        """Send commands until the node is shut down."""
        period = 1.0 / self._settings.send_rate
        with until_shutdown():
            while not (rospy.is_shutdown() or is_shutdown_requested()):
                # wall time, as fingers have it; the simulation may be paused
                time.sleep(period)
                with self._lock:
                    self._step(time.monotonic())

    def stop(self) -> None:
        """Stop what moves."""
        with self._lock:
            self._core = None
            self._robot.send(self._commander.update({}))

    def _use(self, name: str, pad: Pad) -> None:
        if name == self._pad:
            # plugged in again: the mode stays what it was
            return
        core = JoyTeleop(self._map, pad, self._settings.joy_timeout)
        missing = self._map.missing_on(pad)
        rospy.loginfo(f"pad {name}: {pad.description}")
        if missing:
            rospy.logwarn(f"pad {name} has no {', '.join(missing)}; what they do is out of reach")
        with self._lock:
            self._core, self._pad = core, name
            self._announce()

    def _on_device(self, message: Any) -> None:
        if not message.data:
            return
        try:
            self._use(*self._pads.recognized(message.data))
        except ConfigError as error:
            with self._lock:
                self._core, self._pad = None, ""
            rospy.logerr(str(error))

    def _on_joy(self, message: Any) -> None:
        with self._lock:
            now = time.monotonic()
            if self._core is None:
                rospy.logwarn_throttle(
                    10.0 * WARNING_PERIOD,
                    "joy messages, but no known pad: choose one with ~pad, or use the node joy, "
                    f"which tells its name on {rospy.resolve_name(DEVICE_TOPIC)}",
                )
                return
            self._check_gap(now)
            try:
                presses = self._core.take(message.axes, message.buttons, now)
            except InvalidJoy as error:
                warn_dropped("joy", str(error))
                return
            for action in presses:
                self._do(action)
            self._step(now)

    def _check_gap(self, now: float) -> None:
        if self._core is not None and now - self._stepped_at > self._settings.longest_gap:
            self._core.interrupt(now)
        self._stepped_at = now

    def _step(self, now: float) -> None:
        """Send what is demanded: at once when it is something else, else at the send rate."""
        self._check_gap(now)
        core, robot = self._core, self._robot
        if core is None:
            demands: Dict[Action, float] = {}
        else:
            core.set_e_stop(robot.e_stop)
            if core.follow_arm(robot.mode):
                self._announce()
            demands = core.demands(now)
            self._explain(core, now)
        demanded = frozenset(demands)
        due = now - self._sent_at >= 1.0 / self._settings.send_rate
        if demanded != self._demanded or (due and (demanded or self._commander.busy)):
            self._demanded, self._sent_at = demanded, now
            commands = self._commander.update(demands)
            robot.send(commands)
            if commands.unknown:
                rospy.logwarn_throttle_identical(
                    WARNING_PERIOD,
                    f"{', '.join(commands.unknown)}: the robot has not said how fast it may move; "
                    "it has none, or its teleoperation node is not running",
                )

    def _explain(self, core: JoyTeleop, now: float) -> None:
        if self._commander.busy and not core.alive(now):
            rospy.logwarn_throttle(
                WARNING_PERIOD,
                f"no joy message for {self._settings.joy_timeout:g} s: stopped (ROS's joy_node "
                "repeats what is held with autorepeat_rate:=20)",
            )
        waiting = core.waiting(now)
        if waiting:
            rospy.logwarn_throttle_identical(
                WARNING_PERIOD, f"let go first, nothing moves by it: {', '.join(waiting)}"
            )

    def _do(self, action: Action) -> None:
        robot, step = self._robot, self._settings.speed_step
        if action is Command.E_STOP:
            robot.set_e_stop(True)
        if action is Command.E_STOP or action is Command.STOP:
            robot.send(self._commander.stop(self._map.actions))
        elif action is Command.RELEASE_E_STOP:
            robot.set_e_stop(False)
        elif action is Command.FASTER:
            robot.change_speed(1, step)
        elif action is Command.SLOWER:
            robot.change_speed(-1, step)
        elif action is Command.FRAME:
            robot.next_frame()
        elif action is Command.HOLD_TOOL:
            robot.toggle_hold()
        elif action is Command.GUARD:
            robot.toggle_guard()
        elif action is Command.BOOKMARK:
            robot.set_bookmark()
        elif action is Command.GO_BACK:
            robot.go_back()
        elif action is Command.MODE:
            self._change_mode()
        elif isinstance(action, Lamps):
            robot.switch_lamps(action.names)

    def _change_mode(self) -> None:
        assert self._core is not None
        wanted = self._core.mode.arm_mode
        if wanted and wanted != self._robot.mode:
            self._robot.set_mode(wanted)
        self._announce()

    def _announce(self) -> None:
        assert self._core is not None
        name = self._core.mode.name
        self._mode_publisher.publish(String(name))
        rospy.loginfo(f"mode {name}")


def joy_teleop_main() -> int:
    """Run joy_teleop until it is shut down.

    Returns
    -------
    int
        Exit status: 1 when its parameters or files are wrong.
    """
    init_node("joy_teleop", prompt=True)
    try:
        settings = private_settings(JoyTeleopSettings)
        node = JoyTeleopNode(
            settings,
            JoyMap.read(settings.map),
            Pads.read(settings.pads),
            _robot_namespace(settings.robot or rospy.get_namespace()),
        )
    except ConfigError as error:
        rospy.logfatal(f"{rospy.get_name()} cannot start: {error}")
        return 1
    node.run()
    return 0


def _robot_namespace(name: str) -> str:
    return "/" + (name.strip("/") or "telex")
