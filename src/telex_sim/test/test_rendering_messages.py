import math

import cv2
import numpy as np
import pytest
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from std_msgs.msg import ColorRGBA, Header
from telex_msgs.msg import SceneDescription, ScenePoses, SceneVisual

from telex_sim.rendering.camera import PinholeCamera
from telex_sim.rendering.messages import (
    camera_info_message,
    compressed_image_message,
    frames_from_message,
    image_message,
    scene_from_message,
)
from telex_sim.rendering.scene import Shape

CAMERA = PinholeCamera(64, 48, 1.2, 0.1, 50.0)


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
        result, problems = scene_from_message(scene(visual(texture="checker", texture_scale=2.0)))
        assert problems == []
        assert result.revision == 3
        (box,) = result.visuals
        assert (box.frame, box.shape, box.size) == ("telex/arm", Shape.BOX, (1.0, 2.0, 3.0))
        assert (box.position, box.orientation) == ((0.0, 0.0, 1.0), (0.0, 0.0, 0.0, 1.0))
        assert box.color == (1.0, 0.5, 0.0, 1.0)
        assert (box.texture, box.texture_scale) == ("checker", 2.0)

    def test_a_scale_that_was_left_at_zero_is_one_metre(self):
        result, _ = scene_from_message(scene(visual(texture="checker")))
        assert result.visuals[0].texture_scale == 1.0

    @pytest.mark.parametrize(
        ("changes", "complaint"),
        [
            ({"frame": 2}, "frame 2 of a scene with 2"),
            ({"shape": 9}, "9 is not a valid Shape"),
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

    @pytest.mark.parametrize(
        "poses", [[], [0.0] * 6, [0.0] * 7, [math.nan] + [0.0] * 5 + [1.0], [0.0] * 14]
    )
    def test_nonsense_is_refused(self, poses):
        with pytest.raises(ValueError, match="numbers|finite|quaternion"):
            frames_from_message(ScenePoses(poses=poses), 1)


class TestPictures:
    header = Header(frame_id="front_camera_optical_frame")

    def test_camera_info_is_that_of_the_projection(self):
        info = camera_info_message(CAMERA, self.header)
        point = np.array([0.2, -0.1, 2.0])
        u, v, w = np.reshape(info.P, (3, 4)) @ [*point, 1.0]
        np.testing.assert_allclose([u / w, v / w], CAMERA.project([point])[0])
        assert np.reshape(info.P, (3, 4))[:, :3].reshape(-1).tolist() == list(info.K)
        assert (info.width, info.height) == (64, 48)
        assert (info.distortion_model, list(info.D)) == ("plumb_bob", [0.0] * 5)
        assert list(info.R) == [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]

    def test_jpeg(self):
        message = compressed_image_message(picture(), 90, self.header)
        assert message.format == "jpeg"
        decoded = cv2.imdecode(np.frombuffer(message.data, np.uint8), cv2.IMREAD_COLOR)
        np.testing.assert_allclose(decoded[24, 16], (10, 30, 200), atol=6)
        np.testing.assert_allclose(decoded[24, 48], (255, 255, 255), atol=6)

    def test_raw(self):
        message = image_message(picture(), self.header)
        assert (message.encoding, message.step) == ("rgb8", 3 * 64)
        pixels = np.frombuffer(message.data, np.uint8).reshape(48, 64, 3)
        assert pixels[0, 0].tolist() == [200, 30, 10]
        assert pixels[47, 63].tolist() == [255, 255, 255]
