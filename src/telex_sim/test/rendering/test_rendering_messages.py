import math

import cv2
import numpy as np
import pytest
from genpy import Time
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from std_msgs.msg import ColorRGBA, Header
from telex_msgs.msg import SceneDescription, SceneLamp, ScenePoses, SceneVisual

from telex_sim.cameras.optics.lens import LensCamera
from telex_sim.cameras.ros.messages import (
    camera_info_message,
    compressed_image_message,
    depth_message,
    frames_from_message,
    image_message,
    scene_from_message,
)
from telex_sim.scene.visual_scene import Daylight, VisualLamp, VisualShape


def visual(**changes):
    values = {
        "frame": 1,
        "shape": SceneVisual.BOX,
        "size": Vector3(1.0, 2.0, 3.0),
        "pose": Pose(Point(0.0, 0.0, 1.0), Quaternion(0.0, 0.0, 0.0, 1.0)),
        "color": ColorRGBA(1.0, 0.5, 0.0, 1.0),
        **changes,
    }
    return SceneVisual(**values)


def scene(*visuals):
    return SceneDescription(revision=3, frames=["world", "telex/arm"], visuals=list(visuals))


def picture():
    pixels = np.full((48, 64, 4), 255, np.uint8)
    pixels[:, :32, :3] = (200, 30, 10)
    return pixels


class TestScene:
    def test_everything_arrives(self):
        result, problems = scene_from_message(
            scene(visual(texture="a", texture_scale=2.0, glow=0.5))
        )
        assert problems == []
        assert result.revision == 3
        (box,) = result.visuals
        assert (box.frame, box.shape, box.size) == ("telex/arm", VisualShape.BOX, (1.0, 2.0, 3.0))
        assert (box.position, box.orientation) == ((0.0, 0.0, 1.0), (0.0, 0.0, 0.0, 1.0))
        assert box.color == (1.0, 0.5, 0.0, 1.0)
        assert (box.texture, box.texture_scale, box.glow) == ("a", 2.0, 0.5)

    def test_a_scale_of_zero_is_once_over_each_face(self):
        result, _ = scene_from_message(scene(visual(texture="a")))
        assert result.visuals[0].texture_scale == 0.0

    def test_light_arrives(self):
        message = scene()
        message.lamps = [
            SceneLamp(
                frame=1,
                position=Point(1.0, 2.0, 3.0),
                direction=Vector3(0.0, 0.0, -2.0),
                angle=1.5,
                intensity=4.0,
                reach=6.0,
                color=ColorRGBA(1.0, 0.5, 0.25, 0.0),
            )
        ]
        message.to_sun = Vector3(0.0, 0.6, 0.8)
        message.sun = ColorRGBA(2.0, 1.5, 1.0, 0.0)
        message.ambient, message.visibility = 0.5, 25.0
        message.fog = ColorRGBA(0.75, 0.5, 0.25, 0.0)
        result, problems = scene_from_message(message)
        assert problems == []
        assert result.lamps == (
            VisualLamp(
                "telex/arm", (1.0, 2.0, 3.0), (0.0, 0.0, -2.0), 1.5, 4.0, 6.0, (1.0, 0.5, 0.25)
            ),
        )
        assert result.daylight == Daylight(
            (0.0, 0.6, 0.8), (2.0, 1.5, 1.0), 0.5, 25.0, (0.75, 0.5, 0.25)
        )

    @pytest.mark.parametrize(
        ("changes", "complaint"),
        [
            ({"frame": 7}, "frame 7 of a scene with 2"),
            ({"direction": Vector3()}, "direction is zero"),
            ({"reach": math.nan}, "not finite"),
        ],
    )
    def test_one_bad_lamp_alone_is_left_out(self, changes, complaint):
        good = {"direction": Vector3(x=1.0), "angle": 1.0, "intensity": 1.0, "reach": 1.0}
        message = scene()
        message.lamps = [SceneLamp(**good), SceneLamp(**{**good, **changes})]
        result, (problem,) = scene_from_message(message)
        assert len(result.lamps) == 1
        assert problem.startswith("lamp 1 is left out")
        assert complaint in problem

    def test_light_that_makes_no_sense_is_the_day(self):
        message = scene()
        message.ambient = math.nan
        result, (problem,) = scene_from_message(message)
        assert result.daylight == Daylight()
        assert "not finite" in problem

    @pytest.mark.parametrize(
        ("changes", "complaint"),
        [
            ({"frame": 2}, "frame 2 of a scene with 2"),
            ({"shape": 9}, "9 is not a valid VisualShape"),
            ({"size": Vector3(1.0, math.nan, 1.0)}, "not finite"),
            ({"pose": Pose()}, "quaternion"),
        ],
    )
    def test_one_bad_visual_alone_is_left_out(self, changes, complaint):
        result, problems = scene_from_message(scene(visual(), visual(**changes), visual()))
        assert len(result.visuals) == 2
        (problem,) = problems
        assert problem.startswith("visual 1 is left out")
        assert complaint in problem

    def test_bad_frames_are_refused(self):
        with pytest.raises(ValueError, match="twice"):
            scene_from_message(SceneDescription(frames=["a", "a"]))


class TestPoses:
    def test_in_order(self):
        poses = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0]
        frames = frames_from_message(ScenePoses(poses=poses), 2)
        assert frames[1, :3, 3].tolist() == [1.0, 2.0, 3.0]

    def test_a_moment_before(self):
        half = math.sqrt(0.5)
        now = ScenePoses(poses=[1.0, 0.0, 0.0, 0.0, 0.0, half, half])
        before = ScenePoses(poses=[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0])
        now.header.stamp, before.header.stamp = Time(5, 0), Time(4, 980_000_000)
        (frame,) = frames_from_message(now, 1, before, 0.01)
        assert frame[0, 3] == pytest.approx(0.5)
        assert math.atan2(frame[1, 0], frame[0, 0]) == pytest.approx(math.pi / 4.0)
        assert (frames_from_message(now, 1, before, 0.0) == frames_from_message(now, 1)).all()

    def test_poses_far_apart_say_nothing_of_the_time_between(self):
        now = ScenePoses(poses=[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
        before = ScenePoses(poses=[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
        now.header.stamp, before.header.stamp = Time(5, 0), Time(4, 0)
        assert frames_from_message(now, 1, before, 0.01)[0, 0, 3] == 1.0
        assert frames_from_message(now, 1, None, 0.01)[0, 0, 3] == 1.0

    @pytest.mark.parametrize(
        "poses", [[], [0.0] * 6, [0.0] * 7, [math.nan] + [0.0] * 5 + [1.0], [0.0] * 14]
    )
    def test_nonsense_is_refused(self, poses):
        with pytest.raises(ValueError, match="numbers|finite|quaternion"):
            frames_from_message(ScenePoses(poses=poses), 1)


class TestPictures:
    header = Header(frame_id="front_camera_optical_frame")

    def test_camera_info_is_that_of_the_projection(self):
        distortion = (-0.1, 0.02, 0.001, -0.002, 0.0)
        camera = LensCamera.of_field(64, 48, 1.2, distortion, 0.1, 10.0)
        info = camera_info_message(camera, self.header)
        point = np.array([0.4, -0.3, 1.0])
        pixel, _ = cv2.projectPoints(
            point, np.zeros(3), np.zeros(3), np.reshape(info.K, (3, 3)), np.array(info.D)
        )
        np.testing.assert_allclose(pixel.reshape(2), camera.project([point])[0])
        u, v, w = np.reshape(info.P, (3, 4)) @ [*point, 1.0]
        rectified = cv2.undistortPoints(
            pixel,
            np.reshape(info.K, (3, 3)),
            np.array(info.D),
            R=np.reshape(info.R, (3, 3)),
            P=np.reshape(info.P, (3, 4)),
        )
        np.testing.assert_allclose([u / w, v / w], rectified.reshape(2), atol=0.02)
        assert (info.width, info.height) == (64, 48)
        assert (info.distortion_model, tuple(info.D)) == ("plumb_bob", distortion)
        assert list(info.R) == [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]

    def test_jpeg(self):
        message = compressed_image_message(picture(), 90, self.header)
        # "<encoding>; jpeg compressed <encoding in the JPEG>": image_transport's convention.
        assert message.format == "rgb8; jpeg compressed bgr8"
        decoded = cv2.imdecode(np.frombuffer(message.data, np.uint8), cv2.IMREAD_COLOR)
        np.testing.assert_allclose(decoded[24, 16], (10, 30, 200), atol=6)
        np.testing.assert_allclose(decoded[24, 48], (255, 255, 255), atol=6)

    def test_raw(self):
        message = image_message(picture(), self.header)
        assert (message.encoding, message.step) == ("rgb8", 3 * 64)
        pixels = np.frombuffer(message.data, np.uint8).reshape(48, 64, 3)
        assert pixels[0, 0].tolist() == [200, 30, 10]
        assert pixels[47, 63].tolist() == [255, 255, 255]

    def test_depth(self):
        depth = np.array([[1.5, np.inf, 0.25], [2.0, 3.0, 4.0]])
        message = depth_message(depth, self.header)
        assert (message.encoding, message.step, message.is_bigendian) == ("32FC1", 12, 0)
        values = np.frombuffer(message.data, np.float32).reshape(message.height, message.width)
        np.testing.assert_array_equal(values, depth)
