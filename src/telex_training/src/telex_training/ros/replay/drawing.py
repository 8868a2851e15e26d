"""Has the cameras' node draw moments of recordings, and takes its pictures."""

from __future__ import annotations

import contextlib
import threading
import time
from typing import Callable, Dict, Iterator, NamedTuple, Optional, Sequence, Set, Tuple

import rospy
from sensor_msgs.msg import CompressedImage, JointState
from std_msgs.msg import Float64
from telex_msgs.msg import CameraRadiation, Malfunctions, SceneDescription, ScenePoses

from telex_control.common.geometry.matrices import pose_matrix, quaternion_tuple
from telex_control.common.geometry.quaternions import Pose
from telex_control.ros.rospy_fixes.connections import has_answer
from telex_sim.cameras.cameras_config import ORBIT, ViewConfig
from telex_sim.cameras.ros.overview_rig import OverviewRig

from ...recording.writer import RecordingError
from ...replay.cameras import OUTSIDE, replay_config
from ...replay.ghost import Ghost
from ...replay.replay import MetricCondition, Replay
from ...replay.scenery import base_of, joints_of
from ...replay.timeline import Moment
from .cameras_process import CamerasProcess

_STARTING, _DRAWING = 40.0, 8.0
"""Wall time that a picture may take (s): the first one of a camera in a scene, and others."""
_CONNECTING = 0.005
"""Wall time (s) between two looks whether the picture's publisher is connected."""
_TOLD_APART = 1000
"""Pictures of one sample that the last digits of a stamp tell apart: the stamps that were recorded
are whole microseconds, and the digits below are the order of what was asked for."""
_USUAL_VIEW = ViewConfig(mode=ORBIT, azimuth=2.6, elevation=0.5, distance=4.0)


class DrawingError(RuntimeError):
    """There is no picture; the message says why."""


@contextlib.contextmanager
def _showing(replay: Replay) -> Iterator[None]:
    """Say of what fails that the recording cannot be drawn.

    Raises
    ------
    DrawingError, RecordingError
    """
    try:
        yield
    except DrawingError:
        raise
    except Exception as error:  # content that is malformed raises whatever it leads to
        if rospy.is_shutdown():
            raise
        raise RecordingError(
            f"{replay.path}: it cannot be drawn: {type(error).__name__}: {error}"
        ) from error


class _Shown(NamedTuple):
    """By what a scene is told from another one."""

    replay: Replay
    robot: str
    objects: Tuple[str, ...]
    ghost: Optional[Ghost]
    light: Tuple[float, float]


class Drawing:
    """Publishes what was, in the node's own namespace, and waits for its picture.

    Parameters
    ----------
    niceness : int
        See `ReplaySettings`.
    idle : float
        See `ReplaySettings`.
    """

    def __init__(self, niceness: int, idle: float) -> None:
        self._niceness, self._idle = niceness, idle
        self._namespace = rospy.get_name()
        self._process = CamerasProcess(self._namespace)
        self._turn = threading.Lock()
        self._come = threading.Condition()
        self._picture: Optional[CompressedImage] = None
        self._scene = self._publisher("sim/scene", SceneDescription)
        self._poses = self._publisher("sim/poses", ScenePoses)
        self._joints = self._publisher("joint_states", JointState)
        self._radiation = self._publisher("cameras/radiation", CameraRadiation)
        self._malfunctions = self._publisher("sim/malfunctions", Malfunctions)
        self._condition: Optional[MetricCondition] = None
        self._switches: Dict[str, rospy.Publisher] = {}
        self._levels: Dict[str, float] = {}
        self._subscriber: Optional[rospy.Subscriber] = None
        self._camera = ""
        self._shown: Optional[_Shown] = None
        self._revision = self._number = 0
        self._view = _USUAL_VIEW
        self._drawn_at = 0.0
        # Cameras that have shown a picture of this scene: only the first one of each takes long.
        self._draws: Set[str] = set()

    def _publisher(self, topic: str, kind: type) -> rospy.Publisher:
        # Latched: the cameras' node comes later, and listens only while somebody looks.
        return rospy.Publisher(
            f"{self._namespace}/{topic}", kind, queue_size=1, latch=True, tcp_nodelay=True
        )

    def start(self, replay: Replay) -> None:
        """Start what draws, so that the first picture comes sooner.

        Raises
        ------
        RecordingError
            It cannot be drawn.
        """
        with self._turn, _showing(replay):
            self._prepare(replay, replay.timeline.at(0))
            self._drawn_at = time.monotonic()

    def place(self, replay: Replay, moment: Moment) -> None:
        """Publish scene, poses, joints, lamps and what fails at a moment, whoever listens.

        Raises
        ------
        RecordingError
            It cannot be drawn.
        """
        with self._turn, _showing(replay):
            self._prepare(replay, moment)
            self._publish_equipment(replay, moment)
            self._publish_poses(replay, moment)
            self._drawn_at = time.monotonic()

    def picture(
        self,
        replay: Replay,
        moment: Moment,
        camera: str,
        view: Optional[ViewConfig] = None,
        spacing: float = 0.0,
        ghost: Optional[Ghost] = None,
    ) -> bytes:
        """Draw a moment.

        Parameters
        ----------
        camera : str
            One of the configuration's, see `replay_config`.
        view : ViewConfig, optional
            Of the outside camera; None: as it was last.
        spacing : float
            Time since the last picture that has to pass (s).
        ghost : Ghost, optional
            Another run, which the outside camera alone sees.

        Returns
        -------
        bytes
            JPEG.

        Raises
        ------
        DrawingError, RecordingError
        """
        with self._turn, _showing(replay):
            time.sleep(max(0.0, min(spacing, self._drawn_at + spacing - time.monotonic())))
            self._view = view or self._view
            self._prepare(replay, moment, ghost)
            limit = _DRAWING if camera in self._draws else _STARTING
            self._look_through(camera)
            changed = self._publish_equipment(replay, moment)
            others = _others(ghost, moment, camera)
            drawn = self._draw(replay, moment, others, limit)
            if changed:
                # What fails goes by topics of its own: only the next picture surely has it.
                drawn = self._draw(replay, moment, others, limit)
            self._drawn_at = time.monotonic()
            return drawn

    def rest(self) -> None:
        """End what draws where nobody has looked for long; call now and then."""
        # Whoever has it looks just now.
        if not self._turn.acquire(blocking=False):
            return
        try:
            if self._process.runs and time.monotonic() - self._drawn_at > self._idle:
                self._release()
        finally:
            self._turn.release()

    def close(self) -> None:
        """End what draws."""
        with self._turn:
            self._release()

    def _release(self) -> None:
        if self._subscriber is not None:
            self._subscriber.unregister()
        self._subscriber, self._camera, self._shown = None, "", None
        self._process.end()

    # --- one at a time ---------------------------------------------------------------------------

    def _prepare(self, replay: Replay, moment: Moment, ghost: Optional[Ghost] = None) -> None:
        """Have the scene of a moment shown, which may take a while."""
        part = moment.part
        if self._process.require(replay_config(replay.cameras, part.robot, self._niceness)):
            self._draws.clear()
        light = replay.light(moment)
        shown = _Shown(replay, part.robot, part.names.objects, ghost, light)
        if shown == self._shown:
            return
        self._revision += 1
        robot = None if ghost is None else ghost.robot
        self._scene.publish(replay.scenery.description(moment, self._revision, robot, light))
        self._shown = shown
        self._draws.clear()

    def _look_through(self, camera: str) -> None:
        if camera == self._camera:
            return
        if self._subscriber is not None:
            self._subscriber.unregister()
        self._camera = camera
        self._subscriber = rospy.Subscriber(
            f"{self._namespace}/cameras/{camera}/image_raw/compressed",
            CompressedImage,
            self._take,
            queue_size=1,
            buff_size=2**22,
            tcp_nodelay=True,
        )

    def _take(self, message: CompressedImage) -> None:
        with self._come:
            self._picture = message
            self._come.notify_all()

    def _publish_equipment(self, replay: Replay, moment: Moment) -> bool:
        """Have cameras and lamps as they were; returns whether anything has changed."""
        condition = replay.condition(moment)
        worse = condition != self._condition
        if worse:
            self._radiation.publish(condition.radiation)
            self._malfunctions.publish(condition.malfunctions)
            self._condition = condition
        return self._publish_switches(replay, moment) or worse

    def _publish_switches(self, replay: Replay, moment: Moment) -> bool:
        """Set lamps and zooms as they were; returns whether any has changed."""
        wanted = replay.switches(moment)
        changed = {topic: level for topic, level in wanted.items() if level != self._level(topic)}
        for topic, level in changed.items():
            if topic not in self._switches:
                self._switches[topic] = self._publisher(topic, Float64)
            self._switches[topic].publish(level)
            self._levels[topic] = level
        return bool(changed)

    def _level(self, topic: str) -> Optional[float]:
        return self._levels.get(topic)

    def _publish_poses(self, replay: Replay, moment: Moment, others: Sequence[Pose] = ()) -> int:
        """Publish where everything was; returns the stamp (ns)."""
        self._number = (self._number + 1) % _TOLD_APART
        stamp = moment.stamp // _TOLD_APART * _TOLD_APART + self._number
        outside = _outside(self._view, base_of(moment))
        poses = replay.scenery.poses(moment, self._revision, stamp, outside, others)
        self._poses.publish(poses)
        joints = joints_of(moment)
        message = JointState(name=list(joints), position=list(joints.values()))
        message.header.stamp = rospy.Time(moment.stamp // 10**9, moment.stamp % 10**9)
        self._joints.publish(message)
        return stamp

    def _draw(self, replay: Replay, moment: Moment, others: Sequence[Pose], limit: float) -> bytes:
        end = time.monotonic() + limit
        # Each pose is drawn once. A publisher may still count a listener that has gone: the picture
        # would go to that one, if it were drawn before this one is connected.
        self._wait_for(self._is_connected, end, limit, _CONNECTING)
        stamp = self._publish_poses(replay, moment, others)

        def has_come() -> bool:
            return self._picture is not None and self._picture.header.stamp.to_nsec() == stamp

        self._wait_for(has_come, end, limit, 0.5)
        assert self._picture is not None
        self._draws.add(self._camera)
        return bytes(self._picture.data)

    def _is_connected(self) -> bool:
        return self._subscriber is not None and has_answer(self._subscriber)

    def _wait_for(self, done: Callable[[], bool], end: float, limit: float, period: float) -> None:
        """Wait until something is so, at most until a time (s).

        Raises
        ------
        DrawingError
            It has not become so, or what draws has ended.
        """
        with self._come:
            while not done():
                if rospy.is_shutdown() or not self._process.runs:
                    raise DrawingError("what draws has ended; the log says why")
                left = end - time.monotonic()
                if left <= 0.0:
                    raise DrawingError(
                        f"no picture of the camera '{self._camera}' came within {limit:g} s"
                    )
                self._come.wait(min(left, period))


def _others(ghost: Optional[Ghost], moment: Moment, camera: str) -> Sequence[Pose]:
    """Poses of the ghost's links: out of sight for what the operator's cameras showed."""
    if ghost is None:
        return ()
    return ghost.poses(moment.time) if camera == OUTSIDE else ghost.away()


def _outside(view: ViewConfig, base: Pose) -> Pose:
    """Pose of the free camera (m, quaternion x y z w)."""
    matrix = OverviewRig(view, 0.0).pose(pose_matrix(*base), 0.0)
    x, y, z = matrix[:3, 3].tolist()
    return (x, y, z), quaternion_tuple(matrix)
