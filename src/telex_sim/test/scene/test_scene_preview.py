"""Pictures of scenes, as ``scene preview`` draws them."""

import itertools
import math

import cv2
import numpy as np
import pytest

from telex_sim.cameras.drawing.quality import TIERS
from telex_sim.cameras.optics.pinhole import PinholeCamera
from telex_sim.cameras.preview.scene_preview import (
    framed,
    main,
    photograph,
    robot_camera,
    settled,
    with_lamps,
)
from telex_sim.cameras.preview.still import looking

pytestmark = pytest.mark.slow

SCENE = """
floor: {surface: {color: [0.5, 0.5, 0.5, 1.0], texture: ""}}
objects:
  - {type: cube, name: cube, position: [1.5, 0.0, 0.3], edge: 0.3, color: [0.9, 0.05, 0.05]}
views:
  - {eye: [1.5, -2.0, 0.8], target: [1.5, 0.0, 0.1], fov: 0.6}
"""
SMALL = ["--size", "160x120", "--quality", "software"]


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    path = tmp_path_factory.mktemp("scenes") / "one_cube.yaml"
    path.write_text(SCENE)
    return str(path)


@pytest.fixture(scope="module")
def subject(scene):
    return settled(scene)


def reddish(picture):
    picture = picture.astype(int)
    return picture[..., 0] > 2 * np.maximum(picture[..., 1], picture[..., 2])


def test_things_are_drawn_where_they_have_come_to_rest(subject):
    # The cube falls 0.3 m.
    assert subject.frame("cube/cube")[2, 3] == pytest.approx(0.0, abs=0.01)
    camera = PinholeCamera(160, 120, 0.6, 0.05, 100.0)
    eye, target = (1.5, -2.0, 0.15), (1.5, 0.0, 0.15)
    picture = photograph(subject, camera, looking(eye, target), TIERS["software"], 1)
    rows, columns = np.nonzero(reddish(picture))
    assert columns.mean() == pytest.approx(79.5, abs=2)
    assert rows.mean() == pytest.approx(59.5, abs=4)


def test_its_numbers_are_those_that_the_cameras_node_gets(subject):
    # What is prepared with other ones, it does not find.
    light = subject.scene.daylight
    for number in (*light.sun, *light.fog, *(c for v in subject.scene.visuals for c in v.color)):
        assert number == np.float32(number)


def test_oversampling_smooths_and_changes_nothing_else(subject):
    camera = PinholeCamera(160, 120, 0.6, 0.05, 100.0)
    view = looking((0.0, -2.0, 1.0), (0.5, 0.0, 0.3))
    fine, plain = (
        photograph(subject, camera, view, TIERS["gpu"], oversampling).astype(int)
        for oversampling in (2, 1)
    )
    assert fine.shape == plain.shape == (120, 160, 3)
    assert 0.0 < np.abs(fine - plain).mean() < 3.0


def test_the_antenna_of_the_operator_is_seen(tmp_path):
    path = tmp_path / "scene.yaml"
    path.write_text("antenna: [-2.0, 3.0, 1.5]\nobjects: []\n")
    camera = PinholeCamera(160, 120, 0.6, 0.05, 100.0)
    pose = looking((-2.0, 0.0, 1.5), (-2.0, 3.0, 1.5))
    picture = photograph(settled(str(path)), camera, pose, TIERS["software"], 1)
    rows, columns = np.nonzero(reddish(picture))
    assert (rows.mean(), columns.mean()) == pytest.approx((59.5, 79.5), abs=2)


def test_the_robot_can_be_left_out(subject):
    bare = subject.without_robot()
    assert len(bare.scene.visuals) == 2
    assert len(subject.scene.visuals) > 20
    assert subject.frame("telex/base_link") is not None


def test_its_cameras_and_lamps_are_those_of_the_robot(subject):
    config, pose = robot_camera(subject, "front")
    assert config.frame == "front_camera_optical_frame"
    # It looks ahead, along the world's x.
    assert pose[0, 2] > 0.7
    lamps = with_lamps(subject, 0.5).scene.lamps
    assert lamps
    assert {lamp.frame.partition("/")[0] for lamp in lamps} == {"telex"}


def test_without_views_all_of_a_scene_is_framed(subject):
    view = framed(subject, 0.9, 4.0 / 3.0)
    camera = PinholeCamera(160, 120, view.fov, 0.05, 100.0)
    optical_from_world = np.linalg.inv(looking(view.eye, view.target))
    for frame in ("cube/cube", "telex/base_link"):
        point = optical_from_world @ subject.frame(frame)[:, 3]
        u, v = camera.project([point[:3]])[0]
        assert 10 < u < 150
        assert 10 < v < 110


TALL = """
objects:
  - {type: sign, name: sign, position: [3.0, 3.0, 0.0]}
  - {type: wall, name: wall, position: [0.0, 9.0, 0.0], yaw: 0.8, length: 12.0, height: 3.0}
"""


@pytest.mark.parametrize(("fov", "aspect"), [(0.6, 4.0 / 3.0), (1.1, 16.0 / 9.0), (0.9, 0.5)])
def test_what_is_framed_fills_the_picture_and_is_not_cut(tmp_path, fov, aspect):
    """Long walls at an angle and high signs have their own extents, not those of spheres."""
    path = tmp_path / "tall.yaml"
    path.write_text(TALL)
    subject = settled(str(path)).without_robot()
    low, high = subject.bounds()
    assert high[2] == pytest.approx(3.0, abs=0.1)
    assert high[0] - low[0] == pytest.approx(12.0 * math.cos(0.8), abs=0.4)
    view = framed(subject, fov, aspect)
    camera = PinholeCamera(round(200 * aspect), 200, view.fov, 0.05, 100.0)
    optical_from_world = np.linalg.inv(looking(view.eye, view.target))
    corners = np.array(list(itertools.product(*zip(low, high), (1.0,))))
    shown = camera.project((corners @ optical_from_world.T)[:, :3])
    reach = np.abs(shown - (0.5 * camera.width, 100.0)).max(axis=0) / (0.5 * camera.width, 100.0)
    assert reach.max() == pytest.approx(0.96, abs=0.03)


def test_the_command_writes_the_first_view(scene, tmp_path, capsys):
    path = tmp_path / "picture.png"
    assert main([scene, *SMALL, "-o", str(path), "--no-robot"]) == 0
    assert str(path) in capsys.readouterr().out
    picture = cv2.imread(str(path))[..., ::-1]
    assert picture.shape == (120, 160, 3)
    assert reddish(picture[40:80, 60:100]).mean() > 0.3
    assert not reddish(picture[:, :30]).any()


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["nowhere"], "there is no scene 'nowhere'"),
        (["SCENE", "--view", "2"], "view is 2; the scene has 1, counted from 1"),
        (["SCENE", "--camera", "nose"], "camera is 'nose'; there are arm, front"),
        (["SCENE", "--pose", "lying"], "pose is 'lying'; there are"),
        (["SCENE", "--variant", "giant"], "no variant 'giant'"),
        (["SCENE", "--option", "tool:=saw"], "tool is 'saw'"),
        (["SCENE", "-o", "FOLDER/a.xyz"], "a.xyz: unknown kind of picture"),
        (["SCENE", "-o", "FOLDER/no/such/folder.png"], "folder.png: it cannot be written"),
    ],
)
def test_mistakes_are_named(scene, tmp_path, capsys, words, complaint):
    words = [word.replace("SCENE", scene).replace("FOLDER", str(tmp_path)) for word in words]
    output = [] if "-o" in words else ["-o", str(tmp_path / "a.png")]
    assert main([*words, *output, *SMALL, "--settle", "0"]) == 1
    told = capsys.readouterr().err
    assert complaint in told
    assert "Traceback" not in told


@pytest.mark.parametrize(
    "words",
    [
        ["--size", "8x8"],
        ["--size", "wide"],
        ["--eye", "1,2"],
        ["--eye", "1,nan,2"],
        ["--fov", "4"],
        ["--lamps", "2"],
        ["--settle", "-1"],
    ],
)
def test_words_that_make_no_sense_end_with_usage(scene, words, capsys):
    with pytest.raises(SystemExit) as ended:
        main([scene, *words])
    assert ended.value.code == 2
    assert words[0] in capsys.readouterr().err


def test_a_picture_that_lacks_its_mesh_is_not_made(scene, tmp_path, capsys):
    broken = tmp_path / "broken.yaml"
    broken.write_text(SCENE.replace('texture: ""', 'texture: "file:///no/where.png"'))
    assert main([str(broken), *SMALL, "-o", str(tmp_path / "a.png")]) == 1
    assert "where.png" in capsys.readouterr().err
