"""The node ``replay``: recordings of trials, drawn again.

It publishes what was in a namespace of its own, such as ``replay/sim/scene``, with the stamps
that were recorded, and never a clock.
"""

from __future__ import annotations

import contextlib
import os
import threading
import time
from pathlib import Path
from typing import Any, Optional

import rospy
from telex_msgs.msg import ReplayState, TrainingState
from telex_msgs.srv import OpenReplay, OpenReplayResponse, SeekReplay, SeekReplayResponse

from telex_control.common.file_catalog import package_path
from telex_control.common.params import ConfigError, read_config
from telex_control.ros.node_start import init_node
from telex_sim.cameras.cameras_config import shipped_params

from ...judging.trial_record import BETWEEN, PREPARING, RUNNING, WAITING
from ...recording.writer import RecordingError
from ...replay.replay import Replay
from ..channels import hear_decoded
from ..library import Library
from .drawing import Drawing
from .ghosts import Ghosts
from .pages import ReplayPages
from .settings import ReplaySettings
from .shelf import NotHereError, Shelf

_OWN = "cameras"
"""Private parameters of this name are those of the cameras' node that this one starts."""
_FASTEST = 8.0
_PLAY_PERIOD = 0.04
_TOLD_EVERY = 0.2
_RESTING = 0.25
_IN_A_TRIAL = (PREPARING, WAITING, RUNNING, BETWEEN)


class ReplayNode:
    """Services, topics and pages of the replay."""

    def __init__(self, settings: ReplaySettings) -> None:
        self._phase = ""
        package = Path(package_path("telex_training"))
        folder = Path(settings.folder).expanduser()
        library = Library(folder)
        self._shelf = Shelf(library, settings.file, shipped_params())
        self._drawing = Drawing(settings.niceness, settings.idle)
        self._busy_period = settings.busy_period
        self.pages = ReplayPages(
            self._shelf,
            Ghosts(library, self._shelf, folder),
            self._drawing,
            package / "pages" / "replay",
            settings.port,
            self.is_busy,
            settings.busy_period,
        )
        # Held by who says what is shown until it is placed: nothing of before comes after it.
        self._showing = threading.Lock()
        self._lock = threading.Lock()
        self._replay: Optional[Replay] = None
        self._time = self._speed = 0.0
        self._wake = threading.Event()
        self._state = rospy.Publisher("~state", ReplayState, queue_size=1, latch=True)
        hear_decoded("training/state", TrainingState, self._hear_training)
        rospy.Service("~open", OpenReplay, self._open)
        rospy.Service("~seek", SeekReplay, self._seek)
        self._tell()

    def is_busy(self) -> bool:
        """Whether a trial runs on this machine."""
        return self._phase in _IN_A_TRIAL

    def _hear_training(self, state: TrainingState) -> None:
        self._phase = state.phase

    def open(self, trial: str) -> OpenReplayResponse:
        """Open a recording, and show its first moment.

        Raises
        ------
        NotHereError, RecordingError
        """
        found = self._shelf.open(trial)
        replay = found.replay
        with self._showing:
            with self._lock:
                self._replay, self._time, self._speed = replay, 0.0, 0.0
            self._drawing.place(replay, replay.timeline.at(0))
        self._tell()
        timeline = replay.timeline
        return OpenReplayResponse(
            success=True,
            message=" ".join(found.problems),
            trial=replay.trial.trial,
            duration=timeline.duration,
            frames=len(timeline.times),
        )

    def _open(self, request: Any) -> OpenReplayResponse:
        try:
            return self.open(request.trial)
        except NotHereError:
            return OpenReplayResponse(
                message=f"trial is '{request.trial}'; there is no recording of this name"
            )
        except RecordingError as error:
            return OpenReplayResponse(message=str(error))

    def _seek(self, request: Any) -> SeekReplayResponse:
        with self._lock:
            replay = self._replay
        if replay is None:
            return SeekReplayResponse(message="no recording is open; replay/open opens one")
        # Also false for NaN.
        if not 0.0 <= request.speed <= _FASTEST:
            return SeekReplayResponse(
                message=f"speed is {request.speed:g}; 0 to {_FASTEST:g} is possible"
            )
        try:
            moment = replay.timeline.moment(request.time)
        except ValueError as error:
            return SeekReplayResponse(message=str(error))
        try:
            with self._showing:
                with self._lock:
                    if self._replay is not replay:
                        return SeekReplayResponse(message="another recording was opened meanwhile")
                    self._time, self._speed = moment.time, 0.0
                self._drawing.place(replay, moment)
                with self._lock:
                    self._speed = request.speed
        except RecordingError as error:
            self._tell()
            return SeekReplayResponse(message=str(error))
        self._tell()
        self._wake.set()
        return SeekReplayResponse(success=True, time=moment.time)

    def _tell(self) -> None:
        with self._lock:
            replay, at, speed = self._replay, self._time, self._speed
        message = ReplayState(speed=speed)
        message.header.frame_id = "world"
        if replay is not None:
            moment = replay.timeline.moment(at)
            message.trial, message.time = replay.trial.trial, moment.time
            message.duration = replay.timeline.duration
            message.header.stamp = rospy.Time(moment.stamp // 10**9, moment.stamp % 10**9)
        self._state.publish(message)

    def run(self) -> None:
        """Play what is to be played, until ROS shuts down."""
        told_at = last = time.monotonic()
        while not rospy.is_shutdown():
            playing = self._play(time.monotonic() - last)
            last = time.monotonic()
            if playing and last - told_at >= _TOLD_EVERY:
                told_at = last
                self._tell()
            self._drawing.rest()
            period = max(_PLAY_PERIOD, self._busy_period if self.is_busy() else 0.0)
            self._wake.wait(period if playing else _RESTING)
            if self._wake.is_set():
                # What passed while it stood still is no time of the replay.
                self._wake.clear()
                last = time.monotonic()

    def _play(self, passed: float) -> bool:
        """Go on by the wall time that has passed (s); returns whether it plays."""
        with self._showing:
            return self._play_on(passed)

    def _play_on(self, passed: float) -> bool:
        with self._lock:
            replay = self._replay
            if replay is None or self._speed == 0.0:
                return False
            self._time = min(self._time + self._speed * passed, replay.timeline.duration)
            at, ended = self._time, self._time >= replay.timeline.duration
            if ended:
                self._speed = 0.0
        try:
            self._drawing.place(replay, replay.timeline.moment(at))
        except RecordingError as error:
            rospy.logerr("replay: %s", error)
            ended = True
            with self._lock:
                if self._replay is replay:
                    self._speed = 0.0
        if ended:
            self._tell()
        return not ended

    def close(self) -> None:
        """End what draws, and the pages."""
        self.pages.close()
        self._drawing.close()


def replay_main() -> int:
    """Run the node."""
    init_node("replay")
    given = rospy.get_param("~", {})
    if isinstance(given, dict):
        given = {key: value for key, value in given.items() if key != _OWN}
    try:
        settings = read_config(ReplaySettings, given, rospy.get_name())
    except ConfigError as error:
        rospy.logfatal("%s", error)
        return os.EX_CONFIG
    node = ReplayNode(settings)
    node.pages.start()
    if settings.video_server:
        node.pages.show_at(settings.video_server)
    try:
        if settings.file:
            try:
                rospy.loginfo("%s", node.open("").message)
            except RecordingError as error:
                rospy.logfatal("replay: %s", error)
                return os.EX_DATAERR
        with contextlib.suppress(rospy.ROSException):
            node.run()
    finally:
        node.close()
    return 0
