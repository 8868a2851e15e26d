"""Figures 9 and 10: their scenes, their films, their experiments."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import Any, Dict

import cv2
import numpy as np
import pytest
import rospy
import yaml
from flat_floor import FlatFloor
from sensor_msgs.msg import CompressedImage

from telex_control.ros.local_node_handle import LocalNodeHandle
from telex_experiments.paper.tasks import EXPERIMENTS
from telex_experiments.paper.tasks.film import WIDTH, Film
from telex_experiments.workspace import SCENES
from telex_sim.scene.files.scene_file import load_scene
from telex_training.operators.port import NotManagedError
from telex_training.operators.station import Station
from telex_training.operators.tasks import course


@pytest.fixture
def node() -> LocalNodeHandle:
    return LocalNodeHandle()


@pytest.fixture
def station() -> Station:
    return Station(FlatFloor())


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

    @pytest.mark.parametrize("name", [course.WORLD, "paper_grasping.yaml"])
    def test_the_scenes_are_right(self, name: str) -> None:
        assert load_scene(SCENES / name).objects


class TestFilm:
    @staticmethod
    def film(station: Station, node: LocalNodeHandle, pictures: int) -> Film:
        film = Film(station, node)
        camera = node.advertise("cameras/overview/image_raw/compressed", CompressedImage)
        data = cv2.imencode(".jpg", np.full((36, 64, 3), 128, np.uint8))[1].tobytes()
        for number in range(pictures):
            message = CompressedImage(data=data)
            message.header.stamp = rospy.Time.from_sec(1.0 + number)
            camera.publish(message)
        return film

    @pytest.mark.parametrize(("pictures", "rows"), [(30, 2), (5, 2), (4, 1)])
    def test_a_strip_has_as_many_pictures_as_there_are(
        self, station: Station, node: LocalNodeHandle, tmp_path: Path, pictures: int, rows: int
    ) -> None:
        with contextlib.closing(self.film(station, node, pictures)) as film:
            film.wait()
            film.strip(tmp_path / "strip.jpg", 8, 4)
        strip = cv2.imread(str(tmp_path / "strip.jpg"))
        assert strip.shape[1] > 4 * WIDTH
        height = 36 * WIDTH // 64
        assert rows * height < strip.shape[0] < (rows + 1) * height

    def test_a_strip_of_less_than_half_is_none(
        self, station: Station, node: LocalNodeHandle, tmp_path: Path
    ) -> None:
        with contextlib.closing(self.film(station, node, 3)) as film, pytest.raises(
            NotManagedError, match="gave 3 pictures"
        ):
            film.strip(tmp_path / "strip.jpg", 8, 4)

    def test_it_says_that_no_picture_comes(self, station: Station, node: LocalNodeHandle) -> None:
        with contextlib.closing(Film(station, node)) as film, pytest.raises(
            NotManagedError, match="a picture of camera overview"
        ):
            film.wait()


def test_the_experiments_of_figures_9_and_10_are_there() -> None:
    assert [each.name for each in EXPERIMENTS] == [
        "fig9_pallet",
        "fig9_briefcase",
        "fig9_cube",
        "fig10_course",
    ]
    assert sum(each.seconds for each in EXPERIMENTS) <= 15 * 60
