import math
from pathlib import Path

import pytest
import yaml

from telex_control.params import ConfigError, read_config
from telex_sim.rendering.cameras_config import CamerasConfig

FRONT = {"frame": "front_camera_optical_frame", "width": 640, "height": 480, "horizontal_fov": 1.5}


def read(camera=FRONT, **params):
    return read_config(CamerasConfig, {"cameras": {"front": camera}, **params}, "/telex/cameras")


def test_shipped_cameras_are_accepted():
    path = Path(__file__).parents[2] / "telex_description" / "config" / "cameras.yaml"
    config = read_config(CamerasConfig, yaml.safe_load(path.read_text()), str(path))
    assert set(config.cameras) == {"gripper", "arm", "turret", "front", "rear", "mast"}
    for name, camera in config.cameras.items():
        assert camera.frame == f"{name}_camera_optical_frame"


def test_defaults_and_optics():
    camera = read().cameras["front"]
    assert (camera.rate, camera.jpeg_quality) == (25.0, 80)
    optics = camera.optics()
    assert (optics.width, optics.height, optics.horizontal_fov) == (640, 480, 1.5)
    assert (optics.near, optics.far) == (camera.near, camera.far)


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"frame": ""}, "frame is ''"),
        ({"frame": "/front"}, "frame is '/front'"),
        ({"frame": 3}, "cameras/front/frame is 3"),
        ({"width": 8}, "width is 8; it must be at least 16 and at most 4096"),
        ({"width": 640.5}, "cameras/front/width is 640.5"),
        ({"height": 5000}, "height is 5000"),
        ({"height": True}, "cameras/front/height is True"),
        ({"horizontal_fov": 0.0}, "horizontal_fov is 0"),
        ({"horizontal_fov": 3.2}, "horizontal_fov is 3.2"),
        ({"horizontal_fov": math.nan}, "horizontal_fov is nan"),
        ({"near": 0.0}, "near is 0"),
        ({"near": 1.0, "far": 1.0}, "far is 1.0; it must be beyond near, which is 1.0"),
        ({"far": math.inf}, "far is inf"),
        ({"rate": 0.0}, "rate is 0"),
        ({"rate": 1000.0}, "rate is 1000"),
        ({"jpeg_quality": 0}, "jpeg_quality is 0; it must be at least 1 and at most 100"),
        ({"zoom_max": 0.5}, "zoom_max is 0.5; it must be at least 1"),
        ({"zoom_max": math.inf}, "zoom_max is inf"),
        ({"zoom": 2.0}, "cameras/front/zoom is unknown"),
    ],
)
def test_bad_camera(changes, complaint):
    with pytest.raises(ConfigError, match=complaint):
        read({**FRONT, **changes})


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"cameras": {}}, "cameras is empty"),
        ({"cameras": {"front camera": FRONT}}, "cameras has the key 'front camera'"),
        ({"cameras": [FRONT]}, "a struct is needed"),
        ({"model": ""}, "model is ''; it must not be empty"),
        ({"quality": "ultra"}, "quality is 'ultra'; auto, software, gpu are possible"),
        ({"shadow_radius": 0.0}, "shadow_radius is 0"),
        ({"repeat_rate": -1.0}, "repeat_rate is -1"),
        ({"niceness": 20}, "niceness is 20; it must be at least 0 and at most 19"),
        ({"software_threads": -1}, "software_threads is -1"),
        ({"egl_device": -1}, "egl_device is -1"),
        ({"colour": "red"}, "/telex/cameras/colour is unknown"),
    ],
)
def test_bad_parameter_of_the_node(changes, complaint):
    with pytest.raises(ConfigError, match=complaint):
        read(**changes)


def test_cameras_are_needed():
    with pytest.raises(ConfigError, match="/telex/cameras/cameras is missing"):
        read_config(CamerasConfig, {}, "/telex/cameras")


LAMP = {"frame": "front_lamp_link"}


def test_a_lamp_shines_along_the_x_axis_of_its_link():
    lamp = read(lamps={"head": {**LAMP, "level": 0.3}}).lamps["head"].lamp("head", "telex")
    assert (lamp.frame, lamp.name) == ("telex/front_lamp_link", "head")
    assert (lamp.position, lamp.direction) == ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0))


def test_zoom_multiplies_the_focal_length():
    camera = read({**FRONT, "zoom_max": 10.0}).cameras["front"]
    assert camera.optics(7.0).focal_length == pytest.approx(7.0 * camera.optics().focal_length)


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"frame": ""}, "lamps/head: frame is ''"),
        ({"angle": 0.0}, "angle is 0.0; it must be above 0"),
        ({"intensity": -1.0}, "intensity is -1"),
        ({"reach": math.nan}, "reach is nan"),
        ({"color": [1.0, 2.0, 0.0]}, r"color is \[1.0, 2.0, 0.0\]; numbers from 0 to 1"),
        ({"level": 1.5}, "level is 1.5"),
        ({"power": 3.0}, "lamps/head/power is unknown"),
    ],
)
def test_bad_lamp(changes, complaint):
    with pytest.raises(ConfigError, match=complaint):
        read(lamps={"head": {**LAMP, **changes}})


def test_bad_name_of_a_lamp():
    with pytest.raises(ConfigError, match="lamps has the key 'a/b'"):
        read(lamps={"a/b": LAMP})
