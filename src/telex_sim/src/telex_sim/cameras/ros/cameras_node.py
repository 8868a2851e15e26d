"""The ``cameras`` node: shows the simulator's scene as the robot's cameras see it."""

from __future__ import annotations

import gc
import math
import os
import sys
import time
from dataclasses import replace
from typing import Callable, Dict, List, NamedTuple, Optional, Tuple

import cv2
import numpy as np
import rospy
from telex_msgs.msg import SceneDescription, ScenePoses

from telex_control.common.file_catalog import package_path
from telex_control.common.params import ConfigError, read_config
from telex_control.common.scheduling import add_niceness, may_come_first
from telex_control.ros.node_start import init_node, until_shutdown

from ...engine.simulator_config import read_simulator_config
from ...scene.content_store import shared_store
from ..cameras_config import CamerasConfig
from ..drawing.gl_context import NoContextError, create_context
from ..drawing.light.daylight import Lighting
from ..drawing.quality import choose_quality, is_card
from ..drawing.renderer import Renderer
from ..optics.camera_sensor import CameraSensor
from ..optics.exposure import exposure_factor
from ..optics.lens import bending_threads
from .camera_topics import CameraStream, StreamView, Wanted
from .frame_pacer import next_due
from .robot_cameras import RobotCameras
from .scene_inbox import Arrival, SceneInbox
from .scene_mirror import SceneMirror
from .size_by_load import SizeByLoad

_NICENESS, _NICENESS_BESIDE_ORDINARY = -5, 10
"""Of this process beside a simulator that comes first, and beside one that does not."""

# Longest wait for the simulator before looking at who listens again (s).
_PATIENCE = 0.1

# How long poses are still followed when nobody looks any more (s): whoever takes a snapshot now and
# then need not wait for a new connection each time.
_FOLLOW_ON = 5.0

# More than the largest message, so that rospy reads on to the newest of those that wait.
_BUFFER_SIZE = 2**24

# With fewer processors, what is to spare is needed by the physics and by what shows the pictures.
_MANY_PROCESSORS = 4

MakeRenderer = Callable[[CamerasConfig], Renderer]


class _Frozen(NamedTuple):
    """What a frozen camera goes on sending, in full size.

    Attributes
    ----------
    freezes : int
        How often it had frozen then.
    depth : ndarray, optional
        None where it offered none.
    """

    freezes: int
    picture: np.ndarray
    depth: Optional[np.ndarray]


class CamerasNode:
    """Renders the cameras that somebody looks at, in the thread that calls ``run``.

    ROS's own threads only leave messages in an inbox, because OpenGL belongs to one thread.

    Parameters
    ----------
    make_renderer
        Makes what draws; called by the thread that constructs the node, which must be the one that
        calls ``run``, and again when what it depends on is changed.
    """

    def __init__(self, config: CamerasConfig, make_renderer: MakeRenderer) -> None:
        self._config = config
        self._make_renderer = make_renderer
        self._renderer = make_renderer(config)
        robots = [RobotCameras(config), *(_further(robot) for robot in config.robots)]
        self._robots = {stream: robot for robot in robots for stream in robot.streams}
        self._lit = robots
        self._frozen: Dict[CameraStream, _Frozen] = {}
        # What took each camera's last picture.
        self._last: Dict[CameraStream, CameraSensor] = {}
        self._mirror = SceneMirror(
            self._renderer,
            [frame for robot in robots for frame in robot.frames],
            [lamp for robot in robots for lamp in robot.lamps],
            [stream.scene_frame for stream in self._robots],
        )
        self._sizes = SizeByLoad(config.smallest, self._largest())
        self._inbox = SceneInbox()
        self._placed: Optional[Arrival] = None
        # Whether the last picture of full size was the one before it once more.
        self._resting = False
        # Of which poses the shadows are, and since when.
        self._cast: Optional[Arrival] = None
        self._cast_time = -math.inf
        self._service = robots[0].service
        self._scene_subscriber = rospy.Subscriber(
            "sim/scene", SceneDescription, self._inbox.put_scene, queue_size=1
        )
        self._poses_subscriber: Optional[rospy.Subscriber] = None
        self._last_wanted = -math.inf

    def _largest(self) -> float:
        """Scale up to which full pictures may grow on this machine."""
        spare = len(os.sched_getaffinity(0)) >= _MANY_PROCESSORS
        return self._config.largest if self._renderer.on_card or spare else 1.0

    def run(self) -> None:
        """Serve until ROS shuts down."""
        while not rospy.is_shutdown():
            self._take_news()
            now = time.monotonic()
            wanted = [
                each
                for stream, robot in self._robots.items()
                if robot.works(stream)
                for each in stream.wanted
            ]
            self._follow_poses(bool(wanted), now)
            self._choose_sizes(wanted, now)
            # News come first after every picture: when there is more to show than time, one is
            # always due.
            if not self._show_next(wanted, now):
                self._inbox.wait(_PATIENCE)
                self._sizes.rested(time.monotonic() - now)

    def release(self) -> None:
        """Free what draws."""
        self._renderer.release()

    def _take_news(self) -> None:
        config = self._service.config
        if config is not self._config:
            self._configure(config)
        scene = self._inbox.take_scene()
        if scene is not None:
            self._mirror.load(scene)
            self._placed = None
        for stream in self._robots:
            stream.advertise(self._mirror.has(stream.scene_frame))

    def _configure(self, config: CamerasConfig) -> None:
        """Take over parameters that all cameras have in common."""
        before, self._config = self._config, config
        if (config.quality, config.shadow_radius) == (before.quality, before.shadow_radius):
            return
        self._renderer.release()
        self._renderer = self._make_renderer(config)
        self._mirror.change_renderer(self._renderer)
        self._placed = None

    def _choose_sizes(self, wanted: List[Wanted], now: float) -> None:
        """Have pictures lose detail where there is no time for previews."""
        before = self._sizes.step
        self._sizes.judge(now, sum(each.pacer.rate for each in wanted if each.is_preview))
        step = self._sizes.step
        if step != before:
            rospy.loginfo(
                "pictures of full size are scaled by %g, detail of previews by %g",
                step.scale,
                step.preview_detail,
            )
            for stream in self._robots:
                stream.give_way(step)

    def _follow_poses(self, wanted: bool, now: float) -> None:
        """Listen to the poses only while somebody looks: they come many times a second."""
        if wanted:
            self._last_wanted = now
            if self._poses_subscriber is None:
                self._poses_subscriber = rospy.Subscriber(
                    "sim/poses",
                    ScenePoses,
                    self._inbox.put_poses,
                    queue_size=1,
                    buff_size=_BUFFER_SIZE,
                    tcp_nodelay=True,
                )
        elif self._poses_subscriber is not None and now - self._last_wanted > _FOLLOW_ON:
            self._poses_subscriber.unregister()
            self._poses_subscriber = None
            self._inbox.drop_poses()

    def _show_next(self, wanted: List[Wanted], now: float) -> bool:
        """Take the picture that is due first, if any, of poses that are fresh enough."""
        newest = self._inbox.newest_poses()
        if newest is None:
            return False
        woken = self._first_of_a_motion(wanted, newest)
        due = woken or next_due(wanted, now, newest.poses.header.stamp.to_nsec())
        if due is None or not self._place(newest, due, now, recast=woken is None):
            return False
        self._take(due, now)
        return True

    def _first_of_a_motion(self, wanted: List[Wanted], newest: Arrival) -> Optional[Wanted]:
        """Choose a full picture that need not wait for its turn, because something begins to move.

        Its shadows come with the next one.
        """
        if not self._resting or not self._mirror.moves(newest.poses):
            return None
        self._resting = False
        full = [each for each in wanted if not each.is_preview and each.stream.wants_picture]
        return max(full, key=lambda each: each.weight) if full else None

    def _place(self, newest: Arrival, due: Wanted, now: float, recast: bool) -> bool:
        """Have poses placed that a camera may be shown; returns whether there are any."""
        period = self._config.shadow_period * self._sizes.step.shadow_spacing
        recast = recast and now - self._cast_time >= period
        placed = self._placed
        if placed is not None:
            if placed.poses is newest.poses:
                if self._cast is placed or not recast:
                    return True
            elif (
                now - placed.time <= self._config.max_pose_age
                and placed.poses.header.stamp.to_nsec() != due.pacer.stamp
            ):
                return True
        if not self._mirror.place(newest.poses, recast=recast):
            return False
        levels: Dict[str, float] = {}
        for robot in self._lit:
            levels.update(robot.levels())
        self._renderer.set_lamp_levels(levels)
        self._placed = newest
        if recast:
            self._cast, self._cast_time = newest, now
        return True

    def _take(self, due: Wanted, now: float) -> None:
        """Take a picture of the poses that are placed, and publish it."""
        assert self._placed is not None
        stream, stamp = due.stream, self._placed.poses.header.stamp
        view = stream.begin(due.is_preview, stamp, now)
        sensor = view.sensor
        if due.is_preview:
            self._sizes.shown()
            picture, _ = self._picture(stream, view, self._placed, now, False)
            stream.publish_preview(sensor, picture, stamp)
        elif stream.wants_picture:
            picture, depth = self._picture(stream, view, self._placed, now, stream.wants_depth)
            self._resting = self._renderer.repeats
            stream.publish(sensor, picture, depth, stamp, now)

    def _picture(
        self, stream: CameraStream, view: StreamView, placed: Arrival, now: float, deep: bool
    ) -> Tuple[np.ndarray, Optional[np.ndarray]]:
        """Show the scene as a camera sees it, or saw it when it froze; with depths if `deep`."""
        robot = self._robots[stream]
        if not robot.flaws(stream).frozen:
            self._frozen.pop(stream, None)
            picture = self._seen(stream, view, placed, now)
            return picture, self._depth(view.sensor) if deep else None
        kept = self._frozen.get(stream)
        if kept is None or kept.freezes != robot.freezes(stream):
            whole = stream.full_sensor()
            picture = self._seen(stream, StreamView(whole, False), placed, now).copy()
            depth = self._depth(whole) if stream.config.depth else None
            kept = self._frozen[stream] = _Frozen(robot.freezes(stream), picture, depth)
        shape = (view.sensor.config.width, view.sensor.config.height)
        picture = cv2.resize(kept.picture, shape, interpolation=cv2.INTER_AREA)
        if not deep or kept.depth is None:
            return picture, None
        return picture, cv2.resize(kept.depth, shape, interpolation=cv2.INTER_NEAREST)

    def _depth(self, sensor: CameraSensor) -> np.ndarray:
        """Measure how far what the last picture shows is, which this sensor took."""
        return sensor.depth(self._renderer.depth(sensor.pinhole))

    def _seen(
        self, stream: CameraStream, view: StreamView, placed: Arrival, now: float
    ) -> np.ndarray:
        """Show the scene as a camera sees it: where its frame is, exposed, drawn, developed."""
        sensor, coarse = view
        stamp = placed.poses.header.stamp.to_nsec()
        ev = sensor.expose(stamp)
        pictures = []
        for back in sensor.moments:
            if len(sensor.moments) > 1:
                self._mirror.place(placed.poses, placed.earlier, back)
            pose = stream.locate(self._mirror.frame_in_world(stream.scene_frame), now)
            picture = self._renderer.render(sensor.pinhole, pose, exposure_factor(ev), coarse)
            # The next picture would overwrite it.
            pictures.append(picture.copy() if back > 0.0 else picture)
        robot = self._robots[stream]
        received = robot.received(stream)
        exposed = (received.dose_rate, received.dose)
        flaws = robot.flaws(stream)
        # The renderer may repeat what a sensor of the same view has shown, after this one's last.
        before, self._last[stream] = self._last.get(stream), sensor
        repeated = self._renderer.repeats and before is sensor
        return sensor.develop(pictures, repeated, ev, stamp, exposed, flaws)


def _further(namespace: str) -> RobotCameras:
    """Make the cameras of a further robot, by the parameters in its namespace.

    Raises
    ------
    ConfigError
        Something in them is wrong.
    """
    place = rospy.resolve_name(f"/{namespace}/cameras")
    config = read_config(CamerasConfig, rospy.get_param(place, {}), place)
    return RobotCameras(replace(config, model=namespace), f"/{namespace}")


def _niceness(config: CamerasConfig) -> int:
    if config.niceness is not None:
        return config.niceness
    name = rospy.resolve_name("simulator")
    try:
        priority = read_simulator_config(rospy.get_param(name, {}), name).realtime_priority
    except ConfigError:  # about which that node says more
        priority = 0
    return _NICENESS if may_come_first(priority) else _NICENESS_BESIDE_ORDINARY


def main() -> None:
    """Run the node; a mistake in the configuration ends it with one line that says what to do."""
    init_node("cameras")
    try:
        config = read_config(CamerasConfig, rospy.get_param("~", {}), rospy.get_name())
        add_niceness(_niceness(config))
        # Mesa would otherwise start a thread for each core, which the physics needs.
        os.environ.setdefault("LP_NUM_THREADS", str(config.software_threads))
        node = CamerasNode(config, make_renderer)
    except (ConfigError, NoContextError) as error:
        rospy.logfatal("%s", error)
        sys.exit(1)
    # What imports have made stays: a collection that looks at it keeps a picture waiting.
    gc.freeze()
    try:
        with until_shutdown():
            node.run()
    finally:
        node.release()


def make_renderer(config: CamerasConfig) -> Renderer:
    """Make what draws, by the configuration and by what the machine has.

    Raises
    ------
    NoContextError
        There is no OpenGL.
    """
    context = create_context(config.egl_device)
    name = context.info["GL_RENDERER"]
    rospy.loginfo("rendering with %s, quality %s", name, config.quality)
    # OpenCV, too, would otherwise start a thread for each core.
    cv2.setNumThreads(bending_threads(is_card(name)))
    return Renderer(
        context,
        choose_quality(config.quality, name),
        replace(Lighting(), shadow_radius=config.shadow_radius),
        package_path,
        shared_store(),
    )
