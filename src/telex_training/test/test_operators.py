"""Scripted operators: what they see, how they drive, where their tasks begin."""

from __future__ import annotations

import math
from typing import Any

import cv2
import numpy as np
import pytest
from flat_floor import FlatFloor

from telex_control.kinematics import Chain
from telex_sim.offline.simulation import robot_description
from telex_sim.scene.library.terrain.maze import perfect_maze
from telex_training.operators import driving, vision
from telex_training.operators.handling import aimed
from telex_training.operators.port import Drive, FlipperPreset, Jog, Notice, NotManagedError
from telex_training.operators.station import Keys, Station
from telex_training.operators.tasks import course, cube
from telex_training.operators.tasks.briefcase import Briefcase
from telex_training.operators.tasks.cube import BLUE, EDGE, GREEN, RED, CubeToBox
from telex_training.operators.tasks.pallet import PalletSide

MATRIX = np.array([[417.0, 0.0, 320.0], [0.0, 417.0, 240.0], [0.0, 0.0, 1.0]])
LENS = np.array([-0.14, 0.03, 0.0005, -0.0002, 0.0])


@pytest.fixture
def floor() -> FlatFloor:
    return FlatFloor()


@pytest.fixture
def station(floor: FlatFloor) -> Station:
    return Station(floor)


def camera(tool: np.ndarray) -> np.ndarray:
    """Pose of a camera 15 cm behind a tool and 6 cm beside it, tilted towards its tip."""
    mount = np.eye(4)
    # Optical frame: z along the tool's x, x to its right.
    mount[:3, :3] = np.array([[0, 0, 1], [-1, 0, 0], [0, -1, 0]], dtype=float)
    mount[:3, 3] = (-0.15, 0.0, 0.06)
    tilt = np.eye(4)
    tilt[:3, :3] = cv2.Rodrigues(np.array([-math.radians(18.0), 0.0, 0.0]))[0]
    return tool @ mount @ tilt


def picture(pose: np.ndarray, center: np.ndarray, yaw: float) -> vision.SeenPicture:
    """A green cube in a red box, as outlines filled with noisy colours."""
    view = vision.SeenPicture(np.zeros((480, 640, 3), np.uint8), MATRIX, LENS, pose)
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
        view = vision.SeenPicture(
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
    def test_drives_to_a_place_and_turns(self, station: Station, floor: FlatFloor) -> None:
        driving.drive_to(station, (1.2, -0.7))
        driving.turn_to(station, 2.0)
        assert math.hypot(floor.x - 1.2, floor.y + 0.7) < 0.03
        assert abs(math.remainder(floor.yaw - 2.0, 2.0 * math.pi)) < 0.03
        assert floor.speeds[-1] == Drive()

    def test_what_takes_long_between_two_looks_costs_no_patience(
        self, station: Station, floor: FlatFloor
    ) -> None:
        station.tick()
        floor.time += 60.0  # a service answered late, on a busy machine
        driving.turn_to(station, 0.6)
        assert floor.yaw == pytest.approx(0.6, abs=0.05)
        floor.time += 60.0
        station.work_on(lambda: floor.time > 130.0, [(0.0, 0.0)], 15.0, "two minutes")

    def test_drives_backwards(self, station: Station, floor: FlatFloor) -> None:
        driving.run_to(station, (-1.0, 0.05), 0.5, backwards=True)
        assert abs(floor.x + 1.0) < 0.03
        assert abs(floor.y - 0.05) < 0.03
        assert min(speed.linear for speed in floor.speeds) < -0.3

    def test_drives_backwards_onto_a_line_beside_it(
        self, station: Station, floor: FlatFloor
    ) -> None:
        driving.run_to(station, (-2.5, 0.2), 0.4, backwards=True, heading=0.0)
        assert abs(floor.y - 0.2) < 0.03
        assert abs(floor.yaw) < 0.1

    def test_says_what_it_tried_and_where_it_was(self, station: Station, floor: FlatFloor) -> None:
        floor.deaf = True
        with pytest.raises(NotManagedError, match=r"x 1\.00 y 0\.00 m; at .* s, x 0\.00 y 0\.00"):
            driving.drive_to(station, (1.0, 0.0))

    def test_a_course_may_lie_anywhere(self, station: Station, floor: FlatFloor) -> None:
        floor.x, floor.y, floor.yaw = 2.0, 1.0, 0.5 * math.pi
        station.enter((2.0, 0.0, 0.5 * math.pi))
        assert (station.pose.x, station.pose.y) == pytest.approx((1.0, 0.0))
        assert station.pose.yaw == pytest.approx(0.0)

    def test_a_key_that_is_not_obeyed_is_pressed_anew(
        self, station: Station, floor: FlatFloor
    ) -> None:
        station.drive(0.5)
        station.tick()
        floor.notices["track_teleop"] = Notice(1, "release the key and press it again")
        station.wait(0.4)
        assert [speed.linear for speed in floor.speeds[-8:]] == [0.0] * 8
        station.wait(0.5)
        assert floor.speeds[-1].linear == 0.5

    def test_a_preset_and_flipper_keys_are_not_held_together(
        self, station: Station, floor: FlatFloor
    ) -> None:
        Keys(station).hold("climb")
        station.tick()
        presets = [each for each in floor.sent if isinstance(each, FlipperPreset)]
        assert presets == [FlipperPreset("climb")]
        floor.sent.clear()
        station.move(front_left_flipper=0.3)
        station.tick()
        (jog,) = (each for each in floor.sent if not isinstance(each, Drive))
        assert isinstance(jog, Jog)
        assert jog.node == "flipper_teleop"
        assert jog.rates == pytest.approx({"front_left_flipper_joint": 0.8})
        with pytest.raises(NotManagedError, match="shoulder is none of the flippers"):
            station.move(shoulder=0.2)


class TestTasks:
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
