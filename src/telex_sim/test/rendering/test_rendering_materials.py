"""Colours and textures that mesh files bring along."""

import cv2
import numpy as np
import pytest

from telex_control.common.geometry.matrices import pose_matrices
from telex_sim.cameras.drawing.light.daylight import Lighting
from telex_sim.cameras.drawing.quality import TIERS
from telex_sim.cameras.optics.pinhole import PinholeCamera
from telex_sim.cameras.preview.still import Still, looking
from telex_sim.scene.meshes.mesh_files import MeshFileError, load_mesh, load_parts
from telex_sim.scene.visual_scene import Visual, VisualScene, VisualShape

# Two squares in the plane x = 0; as seen from -x, the left one is red, the right one has a picture.
OBJ = """
mtllib things.mtl
v 0 1 0
v 0 0 0
v 0 0 1
v 0 1 1
v 0 -1 0
v 0 -1 1
vt 0 0
vt 1 0
vt 1 1
vt 0 1
usemtl red
f 1/1 2/2 3/3 4/4
usemtl painted
f 2/1 5/2 6/3 3/4
"""
MTL = """
newmtl red
Kd 0.8 0.05 0.05
d 1.0
newmtl painted
Kd 0.1 0.1 0.1
map_Kd -s 1 1 1 my\\picture.png
"""
# One triangle with its normal along -x once it stands upright, in centimetres.
DAE = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
  <asset><unit name="centimeter" meter="0.01"/><up_axis>Y_UP</up_axis></asset>
  <library_effects><effect id="e"><profile_COMMON><technique sid="t"><lambert>
    <diffuse><color>0.1 0.2 0.9 1</color></diffuse>
  </lambert></technique></profile_COMMON></effect></library_effects>
  <library_materials><material id="m"><instance_effect url="#e"/></material></library_materials>
  <library_geometries><geometry id="g"><mesh>
    <source id="p"><float_array id="pa" count="9">0 0 0 0 100 0 0 0 100</float_array>
      <technique_common><accessor source="#pa" count="3" stride="3">
        <param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
      </accessor></technique_common></source>
    <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
    <triangles count="1" material="s"><input semantic="VERTEX" source="#v" offset="0"/>
      <p>0 2 1</p></triangles>
  </mesh></geometry></library_geometries>
  <library_visual_scenes><visual_scene id="w"><node id="n">
    <translate>0 0 200</translate>
    <instance_geometry url="#g"><bind_material><technique_common>
      <instance_material symbol="s" target="#m"/>
    </technique_common></bind_material></instance_geometry>
  </node></visual_scene></library_visual_scenes>
  <scene><instance_visual_scene url="#w"/></scene>
</COLLADA>
"""


@pytest.fixture
def things(tmp_path):
    (tmp_path / "things.obj").write_text(OBJ)
    (tmp_path / "things.mtl").write_text(MTL)
    (tmp_path / "my").mkdir()
    cv2.imwrite(str(tmp_path / "my" / "picture.png"), np.full((4, 4, 3), (20, 200, 20), np.uint8))
    return tmp_path / "things.obj"


def shown(visual):
    """What is seen at the left and at the right, and what could not be loaded."""
    still = Still(TIERS["software"], Lighting(), lambda name: name)
    try:
        problems = still.load(VisualScene(1, ("world",), (visual,)))
        camera = PinholeCamera(160, 120, 1.0, 0.05, 20.0)
        pose = looking((-3.0, 0.0, 0.5), (0.0, 0.0, 0.5))
        frames = pose_matrices([(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)])
        picture = still.picture(camera, pose, frames, (0.0, 0.0, 0.0)).astype(int)
    finally:
        still.release()
    return picture[60, 60], picture[60, 100], problems


def mesh(path, own):
    gray = (0.5, 0.5, 0.5, 1.0)
    return Visual(
        "world",
        VisualShape.MESH,
        (1.0, 1.0, 1.0),
        mesh=f"file://{path}",
        color=gray,
        texture_scale=0.0,
        mesh_materials=own,
    )


def test_parts_of_an_obj_have_the_colours_and_textures_of_its_library(things):
    left, right, problems = shown(mesh(things, True))
    assert problems == []
    assert left[0] > 2 * left[1:].max()
    assert right[1] > 2 * right[[0, 2]].max()


def test_a_colour_that_the_robot_gives_stands_over_those_of_the_mesh(things):
    left, right, problems = shown(mesh(things, False))
    assert problems == []
    assert np.ptp(left) < 25
    assert np.abs(left - right).max() < 8


def test_without_its_library_a_mesh_is_shown_plain_and_said_to_be(things):
    (things.parent / "things.mtl").unlink()
    left, _, problems = shown(mesh(things, True))
    assert np.ptp(left) < 25
    (problem,) = problems
    assert "things.mtl" in problem
    assert "has no materials" in problem


def test_a_broken_library_is_refused_with_its_line(things):
    (things.parent / "things.mtl").write_text("newmtl red\nKd 0.8 nan 0.1\n")
    with pytest.raises(MeshFileError, match=r"things\.mtl, line 2"):
        load_parts(things)


def test_collada_is_in_metres_with_its_axes_and_its_colour(tmp_path):
    path = tmp_path / "thing.dae"
    path.write_text(DAE)
    (part,) = load_parts(path)
    assert part.color == pytest.approx((0.1, 0.2, 0.9, 1.0))
    # Moved by 200 along z; that y is up in it counts for nothing, as in rviz.
    expected = np.array([(0.0, 0.0, 2.0), (0.0, 1.0, 2.0), (0.0, 0.0, 3.0)])
    found = part.mesh.positions
    assert len(found) == 3
    assert np.abs(found[:, None] - expected).max(axis=2).min(axis=0) == pytest.approx(0.0, abs=1e-6)
    assert load_mesh(path).triangles.shape == (1, 3)


@pytest.mark.parametrize("text", ["<COLLADA/>", "no xml at all", DAE.replace("0 2 1", "0 2 7")])
def test_a_broken_collada_file_is_refused(tmp_path, text):
    path = tmp_path / "thing.dae"
    path.write_text(text)
    with pytest.raises(MeshFileError, match=r"thing\.dae"):
        load_parts(path)
