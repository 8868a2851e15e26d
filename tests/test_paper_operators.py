"""The scripted operators of figures 9 and 10: what they see, how they drive, what they ask for."""

from __future__ import annotations

import contextlib
import math
from pathlib import Path
from typing import Any, Dict, List

import cv2
import numpy as np
import pytest
import rospy
import yaml
from geometry_msgs.msg import PoseStamped, Twist
from sensor_msgs.msg import CompressedImage, JointState
from telex_msgs.msg import FlipperPresetHold, TrackTeleopStatus

from telex_control.kinematics import Chain
from telex_control.ros.local_node_handle import LocalNodeHandle
from telex_experiments.mobility.scripted_operator import NotManagedError
from telex_experiments.operators import EXPERIMENTS, course, cube, driving, vision
from telex_experiments.operators.briefcase import Briefcase
from telex_experiments.operators.cube import BLUE, EDGE, GREEN, RED, CubeToBox
from telex_experiments.operators.film import WIDTH, Film
from telex_experiments.operators.handling import aimed
from telex_experiments.operators.pallet import PalletSide
from telex_experiments.operators.runs import SCENES
from telex_experiments.operators.station import FLIPPERS, Keys, Link, Station
from telex_sim.offline.simulation import robot_description
from telex_sim.scene.files.scene_file import load_scene
from telex_sim.scene.library.terrain.maze import perfect_maze

MATRIX = np.array([[417.0, 0.0, 320.0], [0.0, 417.0, 240.0], [0.0, 0.0, 1.0]])
LENS = np.array([-0.14, 0.03, 0.0005, -0.0002, 0.0])


class FlatFloor(Link):
    """A robot that does at once what track_teleop is told; flippers and arm stay."""

    def __init__(self) -> None:
        self.node = LocalNodeHandle()
        self.urdf = ""
        self.repeat = lambda: None
        self.x = self.y = self.yaw = self.time = 0.0
        self.deaf = False
        self.speeds: List[Any] = []
        self.told = Twist()
        self.node.subscribe("track_teleop/cmd_vel", Twist, self.obey)
        self.pose = self.node.advertise("sim/base_pose", PoseStamped)
        self.joints = self.node.advertise("joint_states", JointState)

    def obey(self, message: Twist) -> None:
        self.told = message

    def now(self) -> float:
        return self.time

    def call(self, service: str, kind: Any, **request: Any) -> Any:
        raise AssertionError(f"{service} was called")

    def publish(self) -> None:
        message = PoseStamped()
        message.pose.position.x, message.pose.position.y = self.x, self.y
        message.pose.position.z = 0.11
        message.pose.orientation.z = math.sin(0.5 * self.yaw)
        message.pose.orientation.w = math.cos(0.5 * self.yaw)
        self.pose.publish(message)
        self.joints.publish(JointState(name=FLIPPERS, position=[0.1] * len(FLIPPERS)))

    def advance(self, seconds: float) -> None:
        speed = self.told
        self.time += seconds
        if not self.deaf:
            self.speeds.append(speed)
            self.yaw += seconds * speed.angular.z
            self.x += seconds * speed.linear.x * math.cos(self.yaw)
            self.y += seconds * speed.linear.x * math.sin(self.yaw)
        self.publish()


@pytest.fixture
def link() -> FlatFloor:
    return FlatFloor()


@pytest.fixture
def station(link: FlatFloor) -> Station:
    made = Station(link)
    link.publish()
    return made


def camera(tool: np.ndarray) -> np.ndarray:
    """Pose of a camera 15 cm behind a tool and 6 cm beside it, tilted towards its tip."""
    mount = np.eye(4)
    # Optical frame: z along the tool's x, x to its right.
    mount[:3, :3] = np.array([[0, 0, 1], [-1, 0, 0], [0, -1, 0]], dtype=float)
    mount[:3, 3] = (-0.15, 0.0, 0.06)
    tilt = np.eye(4)
    tilt[:3, :3] = cv2.Rodrigues(np.array([-math.radians(18.0), 0.0, 0.0]))[0]
    return tool @ mount @ tilt


def picture(pose: np.ndarray, center: np.ndarray, yaw: float) -> vision.View:
    """A green cube in a red box, as outlines filled with noisy colours."""
    view = vision.View(np.zeros((480, 640, 3), np.uint8), MATRIX, LENS, pose)
    image = view.image
    image[:] = (40, 40, 170)
    c, s = math.cos(yaw), math.sin(yaw)
    grid = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    corners = 0.5 * EDGE * grid @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    hull = cv2.convexHull(vision.project(view, center + corners).astype(np.float32))
    cv2.fillConvexPoly(image, np.round(hull).astype(np.int32), (30, 180, 40))
    noise = np.random.default_rng(3).normal(0.0, 4.0, image.shape)
    image[:] = np.clip(image + noise, 0, 255).astype(np.uint8)
    return view


class TestSeeing:
    @pytest.mark.parametrize("yaw", [-0.6, -0.1, 0.25, 0.7])
    def test_a_cube_is_found_by_its_outline(self, yaw: float) -> None:
        center = np.array([0.95, 0.15, 0.173])
        view = picture(camera(aimed(0.88, 0.12, 0.41, 0.0, 1.4)), center, yaw)
        blob = vision.find(view.image, GREEN)
        assert blob is not None
        assert blob.whole
        found, turned, overlap = vision.cube_place(view, blob, center[2], EDGE)
        assert np.linalg.norm(found - center) < 0.002
        assert abs(math.remainder(turned - yaw, 0.5 * math.pi)) < math.radians(3.0)
        assert overlap > 0.93

    def test_what_is_no_cube_does_not_look_like_one(self) -> None:
        center = np.array([0.95, 0.15, 0.173])
        view = picture(camera(aimed(0.88, 0.12, 0.41, 0.0, 1.4)), center, 0.0)
        view.image[:] = (40, 40, 170)
        cv2.rectangle(view.image, (100, 100), (500, 140), (30, 180, 40), -1)
        blob = vision.find(view.image, GREEN)
        assert blob is not None
        assert vision.cube_place(view, blob, center[2], EDGE)[2] < 0.5

    def test_a_line_of_sight_leads_back_to_its_point(self) -> None:
        view = vision.View(
            np.zeros((480, 640, 3), np.uint8), MATRIX, LENS, camera(aimed(0.8, 0, 0.5, 0.1, 1.2))
        )
        point = np.array([0.95, -0.12, 0.1])
        ray = vision.ray(view, vision.project(view, point[None])[0])
        assert np.allclose(ray.at_height(0.1), point, atol=1e-4)
        with pytest.raises(ValueError, match="does not meet the plane at 9 m"):
            ray.at_height(9.0)

    def test_colours_are_told_apart(self) -> None:
        image = np.full((120, 200, 3), 128, np.uint8)
        for left, color in ((0, (40, 40, 170)), (70, (30, 180, 40)), (140, (170, 60, 30))):
            image[40:80, left : left + 50] = color
        centers = [vision.find(image, color) for color in (RED, GREEN, BLUE)]
        assert [blob is not None and round(blob.center[0]) for blob in centers] == [24, 94, 164]
        assert [blob is not None and blob.whole for blob in centers] == [False, True, True]
        assert vision.find(np.full((50, 50, 3), 128, np.uint8), GREEN) is None


class TestDriving:
    def test_drives_to_a_place_and_turns(self, station: Station, link: FlatFloor) -> None:
        driving.drive_to(station, (1.2, -0.7))
        driving.turn_to(station, 2.0)
        assert math.hypot(link.x - 1.2, link.y + 0.7) < 0.03
        assert abs(math.remainder(link.yaw - 2.0, 2.0 * math.pi)) < 0.03
        assert link.speeds[-1].linear.x == link.speeds[-1].angular.z == 0.0

    def test_drives_backwards(self, station: Station, link: FlatFloor) -> None:
        driving.run_to(station, (-1.0, 0.05), 0.5, backwards=True)
        assert abs(link.x + 1.0) < 0.03
        assert abs(link.y - 0.05) < 0.03
        assert min(speed.linear.x for speed in link.speeds) < -0.3

    def test_says_what_it_tried_and_where_it_was(self, station: Station, link: FlatFloor) -> None:
        link.deaf = True
        with pytest.raises(NotManagedError, match=r"x 1\.00 y 0\.00 m; at .* s, x 0\.00 y 0\.00"):
            driving.drive_to(station, (1.0, 0.0))

    def test_a_course_may_lie_anywhere(self, station: Station, link: FlatFloor) -> None:
        link.x, link.y, link.yaw = 2.0, 1.0, 0.5 * math.pi
        link.publish()
        station.enter((2.0, 0.0, 0.5 * math.pi))
        assert (station.pose.x, station.pose.y) == pytest.approx((1.0, 0.0))
        assert station.pose.yaw == pytest.approx(0.0)

    def test_a_key_that_is_not_obeyed_is_pressed_anew(
        self, station: Station, link: FlatFloor
    ) -> None:
        status = link.node.advertise("track_teleop/status", TrackTeleopStatus)
        station.drive(0.5)
        station.tick()
        status.publish(TrackTeleopStatus(message="release the key and press it again"))
        station.wait(0.4)
        assert [speed.linear.x for speed in link.speeds[-8:]] == [0.0] * 8
        station.wait(0.5)
        assert link.speeds[-1].linear.x == 0.5

    def test_a_preset_and_flipper_keys_are_not_held_together(
        self, station: Station, link: FlatFloor
    ) -> None:
        sent: List[FlipperPresetHold] = []
        link.node.subscribe("flipper_teleop/preset_cmds", FlipperPresetHold, sent.append)
        Keys(station).hold("climb")
        station.tick()
        assert [message.preset for message in sent] == ["climb"]
        station.move(front_left_flipper=0.1)
        station.tick()
        assert len(sent) == 1
        with pytest.raises(NotManagedError, match="shoulder is none of the flippers"):
            station.move(shoulder=0.2)


class TestCourse:
    def test_the_script_knows_the_scene(self) -> None:
        entries = yaml.safe_load((SCENES / course.WORLD).read_text())["objects"]
        scene: Dict[str, Dict[str, Any]] = {entry["name"]: entry for entry in entries}
        maze = scene["maze"]
        assert tuple(maze["position"][:2]) == course.MAZE_AT
        for key in ("columns", "rows", "corridor", "thickness", "height", "seed"):
            assert maze[key] == getattr(course.MAZE, key)
        for known in (course.BARRIER, course.STAIRS, course.STEP):
            for entry in known.objects():
                shown = scene[entry["name"]]
                assert shown["position"] == pytest.approx(entry["position"])
                for key in {"height", "length", "rise", "run", "steps", "landing"} & set(entry):
                    assert shown[key] == entry[key]
        down = scene["ramp_down"]
        assert down["position"][0] + 0.5 * down["length"] == pytest.approx(course.RAMP_END)
        assert down["height"] == course.RAMP_HEIGHT

    def test_the_way_goes_through_open_passages(self) -> None:
        maze = course.MAZE
        passages = perfect_maze(maze.columns, maze.rows, maze.seed)
        points = course.way_through(maze, course.MAZE_AT)
        assert len(points) >= 7
        place = (course.MAZE_AT[0] - 0.5 * maze.columns * maze.pitch - 0.5, points[0][1])
        crossed = set()
        for point in points:
            for share in np.linspace(0.0, 1.0, 50):
                x, y = np.add(place, share * np.subtract(point, place)) - course.MAZE_AT
                cell = (
                    math.floor(x / maze.pitch + 0.5 * maze.columns),
                    math.floor(y / maze.pitch + 0.5 * maze.rows),
                )
                crossed.add(cell)
            place = point
        inside = {cell for cell in crossed if 0 <= cell[0] < maze.columns}
        assert {(0, 0), (maze.columns - 1, maze.rows - 1)} <= inside
        open_ways = {frozenset(each) for each in passages}
        assert sum(each <= inside for each in open_ways) == len(inside) - 1

    @pytest.mark.parametrize("name", [course.WORLD, "paper_grasping.yaml"])
    def test_the_scenes_are_right(self, name: str) -> None:
        assert load_scene(SCENES / name).objects


class TestFilm:
    @staticmethod
    def film(station: Station, link: FlatFloor, pictures: int) -> Film:
        film = Film(station)
        camera = link.node.advertise("cameras/overview/image_raw/compressed", CompressedImage)
        data = cv2.imencode(".jpg", np.full((36, 64, 3), 128, np.uint8))[1].tobytes()
        for number in range(pictures):
            message = CompressedImage(data=data)
            message.header.stamp = rospy.Time.from_sec(1.0 + number)
            camera.publish(message)
        return film

    @pytest.mark.parametrize(("pictures", "rows"), [(30, 2), (5, 2), (4, 1)])
    def test_a_strip_has_as_many_pictures_as_there_are(
        self, station: Station, link: FlatFloor, tmp_path: Path, pictures: int, rows: int
    ) -> None:
        with contextlib.closing(self.film(station, link, pictures)) as film:
            film.wait()
            film.strip(tmp_path / "strip.jpg", 8, 4)
        strip = cv2.imread(str(tmp_path / "strip.jpg"))
        assert strip.shape[1] > 4 * WIDTH
        height = 36 * WIDTH // 64
        assert rows * height < strip.shape[0] < (rows + 1) * height

    def test_a_strip_of_less_than_half_is_none(
        self, station: Station, link: FlatFloor, tmp_path: Path
    ) -> None:
        with contextlib.closing(self.film(station, link, 3)) as film, pytest.raises(
            NotManagedError, match="gave 3 pictures"
        ):
            film.strip(tmp_path / "strip.jpg", 8, 4)

    def test_it_says_that_no_picture_comes(self, station: Station) -> None:
        with contextlib.closing(Film(station)) as film, pytest.raises(
            NotManagedError, match="a picture of camera overview"
        ):
            film.wait()


class TestRuns:
    @pytest.mark.parametrize("make", [PalletSide, Briefcase, CubeToBox])
    def test_starts_differ_and_can_be_repeated(self, make: Any) -> None:
        first, again, other = (make().lay_out(np.random.default_rng(seed)) for seed in (1, 1, 2))
        assert first == again
        assert first[make.subject] != other[make.subject]

    def test_the_cube_starts_inside_its_box(self) -> None:
        for seed in range(50):
            things = CubeToBox().lay_out(np.random.default_rng(seed))
            box, cube = things["red_box"], things["cube"]
            off = np.subtract(cube["position"], box["position"])[:2]
            c, s = math.cos(box["yaw"]), math.sin(box["yaw"])
            along, across = c * off[0] + s * off[1], c * off[1] - s * off[0]
            assert abs(along) < 0.5 * box["size"][0] - EDGE
            assert abs(across) < 0.5 * box["size"][1] - EDGE

    def test_the_fingertips_stay_off_the_floor_of_the_box(self) -> None:
        urdf = robot_description()
        chain = Chain.from_urdf(urdf, "gripper_link", "left_finger_tip_link")
        tool = Chain.from_urdf(urdf, "gripper_link", "tool_link").forward([])
        pads_end = 0.066  # m, from the joint of the fingertip to its end
        for opening in np.linspace(0.0, cube.OPENING, 9):
            tip = chain.forward([opening, opening, -2.0 * opening])
            reach = tip[0, 3] + pads_end - tool[0, 3]
            assert reach + 0.005 < 0.5 * EDGE + cube.GRASP_ABOVE < reach + EDGE

    def test_the_experiments_of_figures_9_and_10_are_there(self) -> None:
        assert [each.name for each in EXPERIMENTS] == [
            "fig9_pallet",
            "fig9_briefcase",
            "fig9_cube",
            "fig10_course",
        ]
        assert sum(each.seconds for each in EXPERIMENTS) <= 15 * 60
