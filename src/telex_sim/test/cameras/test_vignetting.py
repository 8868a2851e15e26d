"""A lens lets less light through to the corners of its picture, and the middle stays."""

from __future__ import annotations

import math

import numpy as np
import pytest

from telex_control.common.params import ConfigError
from telex_sim.cameras.cameras_config import CameraConfig
from telex_sim.cameras.optics.camera_sensor import CameraSensor
from telex_sim.cameras.optics.exposure import ExposureControl

STAMP = 10**9


def grey(width, height, value=200):
    picture = np.full((height, width, 4), value, np.uint8)
    picture[..., 3] = 255
    return picture


def sensor(width=320, height=240, fov=1.2, **optics):
    config = CameraConfig(width, height, fov, frame="optical", **optics)
    return CameraSensor(config, 1.0, 7, ExposureControl())


def develop(camera, picture=None, repeated=False):
    pinhole = camera.pinhole
    picture = grey(pinhole.width, pinhole.height) if picture is None else picture
    return camera.develop([picture], repeated, 0.0, STAMP)


@pytest.mark.parametrize("loss", [0.1, 0.35, 0.9])
@pytest.mark.parametrize("size", [(320, 240), (16, 400), (641, 33)])
def test_corners_lack_the_share_and_the_middle_nothing(loss, size):
    width, height = size
    picture = develop(sensor(width, height, vignetting=loss))
    # A picture shows the square root of light; rounding takes up to a level.
    for row in (0, -1):
        for column in (0, -1):
            assert picture[row, column, :3] == pytest.approx(200 * math.sqrt(1 - loss), abs=1.0)
    assert (picture[height // 2, width // 2] == (200, 200, 200, 255)).all()
    assert (picture[..., 3] == 255).all()


def test_light_falls_by_the_fourth_power_of_a_cosine():
    loss = 0.75  # (1/2)^2 of the light is left in the corner: a cosine of sqrt(1/2), 45 degrees
    light = (develop(sensor(vignetting=loss))[120, :, 1].astype(float) / 200.0) ** 2
    tangents = np.linspace(-1.0, 1.0, 320) * 320.0 / math.hypot(320.0, 240.0)
    assert light == pytest.approx(np.cos(np.arctan(tangents)) ** 4, abs=0.012)


def test_distorted_pictures_have_it_in_their_own_corners():
    camera = sensor(vignetting=0.35, distortion=(-0.12, 0.02, 0.0, 0.0, 0.0), detail=0.8)
    picture = develop(camera)
    assert picture[0, 0, :3] == pytest.approx(200 * math.sqrt(0.65), abs=1.0)
    assert picture[120, 160, 0] == 200


def test_pictures_of_a_still_scene_are_darkened_once():
    """The renderer repeats its picture; what was made of it before is not made anew of that."""
    camera = sensor(vignetting=0.35)
    first = develop(camera).copy()
    for _ in range(3):
        assert (develop(camera, repeated=True) == first).all()


def test_without_it_a_picture_stays_as_it_is():
    camera = sensor()
    picture = grey(320, 240)
    assert develop(camera, picture) is picture
    assert (picture[..., :3] == 200).all()


def test_small_and_reduced_pictures_have_the_same():
    config = CameraConfig(640, 480, 1.2, frame="optical", vignetting=0.4)
    assert config.small().vignetting == config.reduced(256).vignetting == 0.4


@pytest.mark.parametrize("loss", [-0.1, 0.95, math.nan])
def test_what_no_lens_does_is_refused(loss):
    with pytest.raises(ConfigError, match="vignetting"):
        CameraConfig(640, 480, 1.2, frame="optical", vignetting=loss)
