import math

import numpy as np
import pytest

from telex_control.common.geometry.matrices import inverse, pose_matrices
from telex_control.common.geometry.quaternions import quaternion_from_rpy
from telex_sim.scene.addresses import AddressError, resolve_address
from telex_sim.scene.visual_scene import Daylight, Visual, VisualLamp, VisualScene, VisualShape


def package_path(name):
    if name != "robot":
        raise KeyError(name)
    return "/opt/robot"


class TestTransforms:
    def test_quarter_turn_about_z(self):
        half = math.sqrt(0.5)
        (matrix,) = pose_matrices([[1.0, 2.0, 3.0, 0.0, 0.0, half, half]])
        np.testing.assert_allclose(matrix @ [1.0, 0.0, 0.0, 1.0], [1.0, 3.0, 3.0, 1.0], atol=1e-12)

    def test_quaternion_of_any_length_gives_a_rotation(self):
        (matrix,) = pose_matrices([[0.0, 0.0, 0.0, 0.3, -2.0, 0.7, 1.1]])
        np.testing.assert_allclose(matrix[:3, :3] @ matrix[:3, :3].T, np.eye(3), atol=1e-12)
        assert np.linalg.det(matrix) == pytest.approx(1.0)

    def test_fixed_axis_angles(self):
        roll, pitch, yaw = 0.3, -0.8, 2.0
        rotation_x = [[1, 0, 0], [0, math.cos(roll), -math.sin(roll)]]
        rotation_x.append([0, math.sin(roll), math.cos(roll)])
        rotation_y = [[math.cos(pitch), 0, math.sin(pitch)], [0, 1, 0]]
        rotation_y.append([-math.sin(pitch), 0, math.cos(pitch)])
        rotation_z = [[math.cos(yaw), -math.sin(yaw), 0], [math.sin(yaw), math.cos(yaw), 0]]
        rotation_z.append([0, 0, 1])
        expected = np.array(rotation_z) @ rotation_y @ rotation_x
        (matrix,) = pose_matrices([[0, 0, 0, *quaternion_from_rpy((roll, pitch, yaw))]])
        np.testing.assert_allclose(matrix[:3, :3], expected, atol=1e-12)

    def test_inverse(self):
        (matrix,) = pose_matrices([[1.0, -2.0, 0.5, 0.1, 0.2, 0.3, 0.9]])
        np.testing.assert_allclose(inverse(matrix) @ matrix, np.eye(4), atol=1e-12)

    @pytest.mark.parametrize(
        ("poses", "complaint"),
        [
            ([[0.0] * 6], "shape"),
            ([[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], [math.nan] + [0.0] * 5 + [1.0]], "pose 1"),
            ([[0.0, math.inf, 0.0, 0.0, 0.0, 0.0, 1.0]], "not finite"),
            ([[0.0] * 7], "zero quaternion"),
        ],
    )
    def test_refuses_what_is_no_pose(self, poses, complaint):
        with pytest.raises(ValueError, match=complaint):
            pose_matrices(np.array(poses))

    def test_no_poses_at_all(self):
        assert pose_matrices(np.zeros((0, 7))).shape == (0, 4, 4)


class TestVisual:
    @pytest.mark.parametrize(
        "changes",
        [
            {"size": (1.0, 1.0, math.nan)},
            {"size": (1.0, -1.0, 1.0)},
            {"shape": VisualShape.SPHERE, "size": (0.0, 0.0, 0.0)},
            {"shape": VisualShape.CYLINDER, "size": (1.0, 0.0, 0.0)},
            {"shape": VisualShape.PLANE, "size": (1.0, 0.0, 0.0)},
            {"shape": VisualShape.MESH},
            {"shape": VisualShape.MESH, "mesh": "file:///a.obj", "size": (1.0, 0.0, 1.0)},
            {"position": (math.inf, 0.0, 0.0)},
            {"orientation": (0.0, 0.0, 0.0, 0.0)},
            {"color": (1.2, 0.0, 0.0, 1.0)},
            {"texture_scale": -1.0},
            {"texture_scale": math.nan},
            {"glow": 1.1},
            {"glow": math.nan},
        ],
    )
    def test_refuses_nonsense(self, changes):
        values = {"frame": "a", "shape": VisualShape.BOX, "size": (1.0, 1.0, 1.0), **changes}
        with pytest.raises(ValueError, match="of frame 'a'"):
            Visual(**values)

    def test_needs_only_the_lengths_that_its_shape_has(self):
        assert Visual("a", VisualShape.SPHERE, (0.1, 0.0, 0.0)).size[0] == 0.1
        assert Visual("a", VisualShape.PLANE, (1.0, 2.0, 0.0)).size[1] == 2.0

    def test_only_what_has_a_back_casts_a_shadow(self):
        assert Visual("a", VisualShape.BOX, (1.0, 1.0, 1.0)).casts_shadow
        assert not Visual("a", VisualShape.PLANE, (1.0, 1.0, 0.0)).casts_shadow


class TestScene:
    def test_refuses_a_frame_named_twice(self):
        with pytest.raises(ValueError, match="twice"):
            VisualScene(1, ("a", "a"), ())

    def test_refuses_a_visual_on_an_unknown_frame(self):
        with pytest.raises(ValueError, match="no such frame"):
            VisualScene(1, ("a",), (Visual("b", VisualShape.SPHERE, (1.0, 0.0, 0.0)),))

    def test_refuses_a_lamp_on_an_unknown_frame(self):
        with pytest.raises(ValueError, match="lamp of frame 'b': no such frame"):
            VisualScene(1, ("a",), (), (VisualLamp("b", (0.0, 0.0, 1.0)),))


class TestLamp:
    @pytest.mark.parametrize(
        "changes",
        [
            {"position": (math.nan, 0.0, 0.0)},
            {"direction": (0.0, 0.0, 0.0)},
            {"angle": 0.0},
            {"intensity": -1.0},
            {"intensity": math.inf},
            {"reach": 0.0},
            {"color": (1.0, 2.0, 0.0)},
        ],
    )
    def test_refuses_nonsense(self, changes):
        with pytest.raises(ValueError, match="lamp head of frame 'a'"):
            VisualLamp(**{"frame": "a", "position": (0.0, 0.0, 0.0), "name": "head", **changes})


class TestDaylight:
    @pytest.mark.parametrize(
        "changes",
        [
            {"to_sun": (0.0, 0.0, 0.0)},
            {"sun": (-1.0, 0.0, 0.0)},
            {"ambient": math.nan},
            {"visibility": -2.0},
            {"visibility": 1e-38},
            {"fog": (math.inf, 0.0, 0.0)},
        ],
    )
    def test_refuses_nonsense(self, changes):
        with pytest.raises(ValueError, match="the light: "):
            Daylight(**changes)

    def test_without_sun_it_needs_no_direction(self):
        assert Daylight(to_sun=(0.0, 0.0, 0.0), sun=(0.0, 0.0, 0.0)).ambient == 1.0


class TestAddresses:
    def test_package(self):
        path = resolve_address("package://robot/meshes/a%20b.obj", package_path)
        assert path == "/opt/robot/meshes/a b.obj"

    def test_file(self):
        assert resolve_address("file:///tmp/a.stl", package_path) == "/tmp/a.stl"

    @pytest.mark.parametrize(
        "address",
        [
            "",
            "meshes/a.obj",
            "http://host/a.obj",
            "package://robot",
            "package:///a.obj",
            "package://unknown/a.obj",
            "file://a.obj",
            "file:///a%00.obj",
            "package://robot/a%00.obj",
        ],
    )
    def test_refuses_others_and_names_them(self, address):
        with pytest.raises(AddressError, match=f"'{address}'"):
            resolve_address(address, package_path)
