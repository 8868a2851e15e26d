import math
from dataclasses import asdict
from pathlib import Path

import pytest
import yaml

from telex_control.common.params import ConfigError, read_config
from telex_sim.cameras.cameras_config import CamerasConfig
from telex_sim.cameras.optics.lens import LensMap
from telex_sim.cameras.ros import cameras_node
from telex_sim.cameras.ros.live_parameters import as_yaml, changed

FRONT = {"frame": "front_camera_optical_frame", "width": 640, "height": 480, "horizontal_fov": 1.5}

OVERVIEW = {"width": 640, "height": 480, "horizontal_fov": 1.0}

BARREL = [-0.05, 0.0, 0.0, 0.0, 0.0]


def read(camera=FRONT, **params):
    return read_config(CamerasConfig, {"cameras": {"front": camera}, **params}, "/telex/cameras")


def test_shipped_cameras_are_accepted():
    path = Path(__file__).parents[3] / "telex_description" / "config" / "cameras.yaml"
    config = read_config(CamerasConfig, yaml.safe_load(path.read_text()), str(path))
    assert set(config.cameras) == {"gripper", "arm", "turret", "front", "rear", "mast"}
    for name, camera in config.cameras.items():
        assert camera.frame == f"{name}_camera_optical_frame"
        assert any(camera.distortion)
    assert {camera.priority for camera in config.cameras.values()} == {0}
    assert config.overview.follow == "base_link"


def test_defaults_and_optics():
    camera = read().cameras["front"]
    assert (camera.rate, camera.jpeg_quality) == (25.0, 80)
    optics = camera.optics()
    assert (optics.width, optics.height, optics.distortion) == (640, 480, (0.0,) * 5)
    assert optics.focal_length == pytest.approx(320.0 / math.tan(0.75))
    assert (optics.near, optics.far) == (camera.near, camera.far)
    assert not camera.exposure.auto
    assert (camera.shutter, camera.noise, camera.radiation.dose_rate) == (0.0, 0.0, 0.0)
    assert not camera.depth


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
        ({"distortion": [0.1, 0.0]}, "front/distortion has 2 elements; 5 are needed"),
        ({"distortion": [math.nan, 0.0, 0.0, 0.0, 0.0]}, r"distortion\[0\] is nan"),
        ({"distortion": [-0.6, 0.0, 0.0, 0.0, 0.0]}, "folds the picture 0.6.. rad off its middle"),
        ({"distortion": [-0.3, 0.0, 0.0, 0.0, 0.0]}, "shows nothing at pixel"),
        ({"detail": 0.0}, "detail is 0.0; it must be at least 0.1 and at most 4"),
        (
            {"width": 4096, "height": 3072, "detail": 4.0},
            "detail is 4.0; with width 4096 and height 3072, 16384x12288 pixels are drawn, and at "
            "most 8192 along a side are possible",
        ),
        (
            {"horizontal_fov": 2.2, "width": 4000, "detail": 2.0, "distortion": BARREL},
            "detail is 2.0; with width 4000 and height 480, 9",
        ),
        (
            {"width": 1600, "height": 1200, "detail": 4.0, "shutter": 0.02, "shutter_samples": 64},
            "shutter_samples is 64; with width 1600 and height 1200, 6400x4800 pixels are drawn "
            "at detail 4.0, and at most 8 samples of them are possible",
        ),
        ({"priority": -1}, "priority is -1"),
        ({"noise": -1.0}, "noise is -1"),
        ({"shutter": 2.0}, "shutter is 2.0; it must be at least 0 and at most 1"),
        ({"shutter_samples": 1}, "shutter_samples is 1"),
        ({"exposure": {"auto": "yes"}}, "front/exposure/auto is 'yes'; true or false is needed"),
        ({"exposure": {"ev": math.inf}}, "front/exposure/ev is inf"),
        ({"exposure": {"min_ev": 3.0}}, "min_ev is 3.0; it must not be above max_ev, which is 2.0"),
        ({"exposure": {"time_constant": -1.0}}, "front/exposure: time_constant is -1"),
        ({"radiation": {"dose_rate": -1.0}}, "front/radiation: dose_rate is -1"),
        ({"radiation": {"dose": math.nan}}, "front/radiation/dose is nan"),
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
        ({"niceness": 20}, "niceness is 20; it must be at least -20 and at most 19"),
        ({"software_threads": -1}, "software_threads is -1"),
        ({"egl_device": -1}, "egl_device is -1"),
        ({"renderer": "tiny"}, "renderer is 'tiny'; auto, opengl are possible"),
        ({"tiny_detail": 0.5}, "/telex/cameras/tiny_detail is unknown"),
        ({"max_pose_age": math.nan}, "max_pose_age is nan"),
        ({"shadow_period": -1.0}, "shadow_period is -1"),
        ({"smallest": 0.0}, "smallest is 0"),
        ({"smallest": 1.5}, "smallest is 1.5"),
        ({"largest": 0.5}, "largest is 0.5"),
        ({"largest": math.nan}, "largest is nan"),
        ({"seed": -1}, "seed is -1"),
        ({"seed": 2**31}, "seed is 2147483648"),
        ({"cameras": {"overview": FRONT}}, "'overview', which is the instructor's camera"),
        ({"overview": {"width": 640}}, "/telex/cameras/overview/"),
        ({"overview": {**OVERVIEW, "follow": ""}}, "frame is ''"),
        ({"overview": {**OVERVIEW, "smoothing": -1.0}}, "smoothing is -1"),
        ({"overview": {**OVERVIEW, "start": {"mode": "fly"}}}, "mode is 'fly'; follow, orbit"),
        ({"overview": {**OVERVIEW, "start": {"elevation": 2.0}}}, "elevation is 2.0; it must be"),
        ({"overview": {**OVERVIEW, "start": {"distance": 0.0}}}, "distance is 0"),
        ({"overview": {**OVERVIEW, "start": {"center": [1e9, 0, 0]}}}, "center is .1000000000"),
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


def test_a_laser_is_a_lamp_with_a_beam():
    lamp = read(lamps={"left": {**LAMP, "beam": True}}).lamps["left"].lamp("left", "telex")
    assert lamp.beam


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
        ({"beam": "thin"}, "lamps/head/beam is 'thin'"),
        ({"power": 3.0}, "lamps/head/power is unknown"),
    ],
)
def test_bad_lamp(changes, complaint):
    with pytest.raises(ConfigError, match=complaint):
        read(lamps={"head": {**LAMP, **changes}})


def test_the_field_of_view_holds_with_the_distortion():
    camera = read({**FRONT, "distortion": [-0.12, 0.02, 0.0, 0.0, 0.0]}).cameras["front"]
    ((left, _), (right, _)) = camera.optics().rays([(-0.5, 239.5), (639.5, 239.5)])
    assert math.atan(right) - math.atan(left) == pytest.approx(1.5, abs=1e-6)


class TestPreviews:
    def small(self, **changes):
        return read({**FRONT, "distortion": [-0.1, 0.02, 0.0, 0.0, 0.0], **changes}).cameras[
            "front"
        ]

    def test_show_the_same_field_in_fewer_pixels(self):
        full = self.small(noise=2.0)
        small = full.small()
        assert (small.width, small.height, small.rate, small.jpeg_quality) == (320, 240, 10.0, 75)
        assert small.optics().field() == pytest.approx(full.optics().field(), rel=1e-9)
        assert small.noise == 1.0
        assert small.frame == full.frame

    def test_zoom_with_the_camera(self):
        camera = self.small(zoom_max=3.0)
        ratio = camera.small().optics(2.0).focal_length / camera.optics(2.0).focal_length
        assert ratio == pytest.approx(0.5)

    def test_are_never_larger_than_the_pictures_and_keep_their_shape(self):
        small = self.small(width=200, height=100).small()
        assert (small.width, small.height) == (200, 100)
        small = self.small(width=960, height=540, preview={"width": 240, "rate": 4}).small()
        assert (small.width, small.height, small.rate) == (240, 135, 4.0)

    @pytest.mark.parametrize(
        ("size", "largest"),
        [((2560, 1920), (4096, 3072)), ((1500, 2001), (3070, 4095)), ((4096, 64), (4096, 64))],
    )
    def test_what_is_enlarged_stays_as_small_as_pictures_may_be(self, size, largest):
        width, height = size
        enlarged = self.small(width=width, height=height, noise=2.0).reduced(3 * width)
        assert (enlarged.width, enlarged.height) == largest
        assert enlarged.noise == 2.0

    @pytest.mark.parametrize(
        "changes",
        [
            {"width": 1600, "height": 1200, "detail": 3.9, "zoom_max": 6.0},
            {"width": 1201, "height": 1600, "detail": 4.0},
            {"width": 640, "height": 16, "detail": 4.0, "shutter": 0.1, "shutter_samples": 64},
            {"detail": 2.0, "shutter": 0.1, "shutter_samples": 64},
        ],
    )
    def test_what_is_enlarged_can_be_drawn(self, changes):
        camera = self.small(**changes)
        for scale in (1.5, 2.0, 4.0):
            enlarged = camera.reduced(round(scale * camera.width))
            for zoom in (1.0, camera.zoom_max):
                pinhole = LensMap(enlarged.optics(zoom), enlarged.detail).pinhole
                assert max(pinhole.width, pinhole.height) <= 8192
        assert enlarged.width > 1.05 * camera.width
        assert camera.reduced(camera.width).width == camera.width

    @pytest.mark.parametrize(
        ("changes", "complaint"),
        [
            ({"width": 8}, "width is 8"),
            ({"rate": 0}, "rate is 0"),
            ({"rate": math.nan}, "rate is nan"),
            ({"jpeg_quality": 101}, "jpeg_quality is 101"),
            ({"height": 240}, "height is unknown"),
        ],
    )
    def test_that_make_no_sense_are_refused(self, changes, complaint):
        with pytest.raises(ConfigError, match=complaint):
            self.small(preview=changes)


class TestChanged:
    def test_some_values_and_values_within(self):
        before = read({**FRONT, "exposure": {"auto": True, "ev": 1.0}}).cameras["front"]
        after = changed(before, "{rate: 5, exposure: {ev: -1}}", ["frame"])
        assert (after.rate, after.exposure.auto, after.exposure.ev) == (5.0, True, -1.0)
        assert changed(after, "{rate: 25, exposure: {ev: 1}}", []) == before

    @pytest.mark.parametrize("text", ["", "  ", "{}", "{frame: front_camera_optical_frame}"])
    def test_nothing(self, text):
        before = read().cameras["front"]
        assert changed(before, text, ["frame"]) == before

    @pytest.mark.parametrize(
        ("text", "complaint"),
        [
            ("{rate: 1000}", "rate is 1000.0; it must be above 0 and at most 240"),
            ("{rate: .nan}", "rate is nan; it must be finite"),
            ("{rate: fast}", "rate is 'fast'; a number is needed"),
            ("{speed: 5}", "speed is unknown; known are .*rate"),
            ("{exposure: {iso: 100}}", "exposure/iso is unknown; known are auto, ev"),
            ("{exposure: 3}", "exposure is 3; a struct is needed"),
            ("{frame: other}", "frame cannot be changed while the node runs"),
            ("[1, 2]", r"parameters are \[1, 2\]; a struct is needed, e.g. {rate: 5}"),
            ("{rate: 5", r"parameters: line \d: no YAML"),
            ("[" * 2000, "parameters: line 1: nested deeper"),
            ("{1: 2}", "1 is unknown"),
            ("{width: 320, distortion: [-1, 0, 0, 0, 0]}", "folds the picture"),
            (
                "{width: 1600, height: 16, horizontal_fov: 2.0, distortion: [-0.1, 0, 0, 0, 0],"
                " preview: {width: 16}}",
                "preview/width is 16: distortion .* shows nothing at pixel .* of 16x16",
            ),
        ],
    )
    def test_what_is_wrong_changes_nothing(self, text, complaint):
        with pytest.raises(ConfigError, match=complaint):
            changed(read().cameras["front"], text, ["frame"])

    def test_is_written_as_it_can_be_read(self):
        camera = read({**FRONT, "distortion": [-0.1, 0.0, 0.0, 0.0, 0.0]}).cameras["front"]
        assert changed(read().cameras["front"], as_yaml(asdict(camera)), []) == camera


def test_bad_name_of_a_lamp():
    with pytest.raises(ConfigError, match="lamps has the key 'a/b'"):
        read(lamps={"a/b": LAMP})


@pytest.mark.parametrize(
    ("simulator", "granted", "niceness"),
    [
        ({}, True, -5),
        ({"paused": True, "timing": {"realtime_priority": 3}}, True, -5),
        ({}, False, 10),
        ({"timing": {"realtime_priority": 0}}, True, 10),
        ({"timing": {"real_time_factor": 2.0}}, True, 10),
        ({"gui": True}, True, 10),
        ({"gui": "perhaps"}, True, 10),
    ],
)
def test_cameras_step_back_where_the_simulator_does_not_come_first(
    monkeypatch, simulator, granted, niceness
):
    monkeypatch.setattr(cameras_node.rospy, "resolve_name", lambda name: f"/telex/{name}")
    monkeypatch.setattr(cameras_node.rospy, "get_param", {"/telex/simulator": simulator}.get)
    monkeypatch.setattr(cameras_node, "may_come_first", lambda priority: granted and priority > 0)
    assert cameras_node._niceness(read()) == niceness
    assert cameras_node._niceness(read(niceness=2)) == 2
