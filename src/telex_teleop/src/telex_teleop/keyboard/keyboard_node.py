"""Main function of keyboard_teleop."""

from __future__ import annotations

import logging
import os
import signal
import sys
import time
from typing import Any, List

import rosgraph
import rospy
import yaml

from telex_control.common.params import ConfigError
from telex_control.common.yaml_files import load_yaml
from telex_control.ros.node_start import init_node
from telex_teleop.actions.vocabulary import Vocabulary
from telex_teleop.files import shipped_file
from telex_teleop.keyboard.map import KeyboardSettings
from telex_teleop.keyboard.robot_status import ShownRobot
from telex_teleop.keyboard.teleop import KeyboardTeleop
from telex_teleop.keyboard.terminal import Terminal, TerminalError

USAGE = """\
Drive a Telex robot from the keys of this terminal.

  rosrun telex_teleop keyboard_teleop [_robot:=/telex] [_config:=FILE] [_actions:=FILE]

_robot    namespace of the robot
_config   YAML file with times and keys of one's own, instead of config/keyboard_teleop.yaml
_actions  YAML file of what can be done, and by which keys, instead of config/actions.yaml
"""
FAREWELL_TIME = 0.1  # s for the last zeros to leave before the connections close


class _LastMessage(logging.Handler):
    """Puts warnings of rospy on the screen: printed, they would destroy it."""

    def __init__(self, robot: ShownRobot) -> None:
        super().__init__(logging.WARNING)
        self._robot = robot

    def emit(self, record: logging.LogRecord) -> None:
        self._robot.notice = record.getMessage()


def keyboard_main() -> int:
    """Run the keyboard until the operator quits.

    Returns
    -------
    int
        Exit status: 1 when it could not start.
    """
    arguments = rospy.myargv()[1:]
    if arguments:
        asked = arguments[0] in ("-h", "--help")
        print(USAGE if asked else f"keyboard_teleop: unknown argument {arguments[0]!r}\n\n{USAGE}")
        return 0 if asked else 2
    if not rosgraph.is_master_online():
        master = os.environ.get("ROS_MASTER_URI", "unset")
        return _fail(f"no ROS master at ROS_MASTER_URI={master}; start the simulator first")
    # two operators may have a keyboard each, so the name is anonymous
    init_node("keyboard_teleop", anonymous=True, own_signals=True, prompt=True)
    try:
        settings = _read_settings()
        robot = ShownRobot(
            _robot_namespace(), settings.lamps, settings.zoom_rate, settings.max_zoom
        )
        with Terminal(sys.stdin.fileno(), sys.stdout.fileno()) as terminal:
            _divert_logs(robot)
            interruptions = _count_interruptions()
            KeyboardTeleop(settings, robot, terminal).run(
                lambda: bool(interruptions) or rospy.is_shutdown()
            )
    except (ConfigError, TerminalError) as error:
        return _fail(str(error))
    finally:
        time.sleep(FAREWELL_TIME)
        rospy.signal_shutdown("keyboard_teleop ended")
    return 0


def _fail(problem: str) -> int:
    print(f"keyboard_teleop: {problem}", file=sys.stderr)
    return 1


def _robot_namespace() -> str:
    namespace = str(rospy.get_param("~robot", "/telex"))
    return "/" + namespace.strip("/") if namespace.strip("/") else ""


def _read_settings() -> KeyboardSettings:
    default = shipped_file("keyboard_teleop.yaml")
    path = str(rospy.get_param("~config", default))
    try:
        with open(path, encoding="utf-8") as file:
            content = load_yaml(file)
    except (OSError, yaml.YAMLError) as error:
        raise ConfigError(f"{path}: cannot be read: {error}") from error
    vocabulary = Vocabulary.read(str(rospy.get_param("~actions", "")))
    return KeyboardSettings.read(content, vocabulary, path)


def _divert_logs(robot: ShownRobot) -> None:
    """Take rospy's messages off the terminal and show the last one on our screen."""
    for name in ("", "rosout", "rospy"):
        logger = logging.getLogger(name)
        for handler in list(logger.handlers):
            # the log file stays: its handler has a file of its own
            if not isinstance(handler, logging.FileHandler):
                logger.removeHandler(handler)
    logging.getLogger("rosout").addHandler(_LastMessage(robot))


def _count_interruptions() -> List[int]:
    """Return a list that grows with every signal that asks us to end."""
    received: List[int] = []

    def note(number: int, _frame: Any) -> None:
        received.append(number)

    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, note)
    return received
