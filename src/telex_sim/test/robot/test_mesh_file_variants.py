"""What mesh files of other programs contain: every variant with the parts that it must give."""

import struct

import numpy as np
import pybullet
import pytest

from telex_sim.engine.world import World
from telex_sim.scene.meshes.mesh_files import load_mesh, load_parts

WHITE = (1.0, 1.0, 1.0, 1.0)
A, B, C, D, E = (0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (-1, 0.5, 0)
SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
UVS = "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
HALVES = [(A, B, C), (A, C, D)]

# Files by name; then by material its triangles, and (optionally) their texture coordinates.
OBJ = {
    "materials that come back": (
        {
            "a.obj": "mtllib a.mtl\n" + SQUARE + "v -1 0.5 0\nusemtl r\nf 1 2 3\nusemtl g\nf 1 3 4"
            "\nusemtl r\nf 1 4 5\n",
            "a.mtl": "newmtl r\nKa 1 1 1\nKd 1 0 0\nTr 0.25\nnewmtl g\nKd 0 1 0\nd 0.5\n",
        },
        [
            ((1.0, 0.0, 0.0, 0.75), None, [(A, B, C), (A, D, E)]),
            ((0.0, 1.0, 0.0, 0.5), None, [(A, C, D)]),
        ],
    ),
    "materials without a library": (
        {"a.obj": SQUARE + "usemtl r\nf 1 2 3\nusemtl g\nf 1 3 4\n"},
        [(None, None, HALVES)],
    ),
    "a material that the library lacks": (
        {
            "a.obj": "mtllib a.mtl\n" + SQUARE + "usemtl r\nf 1 2 3\nusemtl g\nf 1 3 4\n",
            "a.mtl": "newmtl r\nKd 1 0 0\n",
        },
        [((1.0, 0.0, 0.0, 1.0), None, [(A, B, C)]), (None, None, [(A, C, D)])],
    ),
    "two libraries, the later definition counts": (
        {
            "a.obj": "mtllib a.mtl\nmtllib b.mtl\n" + SQUARE + "usemtl r\nf 1 2 3\nusemtl g\n"
            "f 1 3 4\n",
            "a.mtl": "newmtl r\nKd 1 0 0\n",
            "b.mtl": "newmtl g\nKd 0 1 0\nnewmtl r\nKd 0 0 1\n",
        },
        [
            ((0.0, 0.0, 1.0, 1.0), None, [(A, B, C)]),
            ((0.0, 1.0, 0.0, 1.0), None, [(A, C, D)]),
        ],
    ),
    "a quad": ({"a.obj": SQUARE + "f 1 2 3 4\n"}, [(None, None, HALVES)]),
    "polygons and triangles": (
        {"a.obj": SQUARE + "v -1 0.5 0\nv 0 0 1\nf 1 2 3 4 5\nf 1 2 6\n"},
        [(None, None, [*HALVES, (A, D, E), (A, B, (0, 0, 1))])],
    ),
    "negative indices between the vertices": (
        {
            "a.obj": "v 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\nv 0 1 0\nf -4 -2 -1\nv 9 9 9\n",
        },
        [(None, None, HALVES)],
    ),
    "texture coordinates with a seam": (
        {"a.obj": SQUARE + UVS + "f 1/1 2/2 3/3\nf 1/2 3/4 4/1\n"},
        [(None, None, HALVES, [((0, 0), (1, 0), (1, 1)), ((1, 0), (0, 1), (0, 0))])],
    ),
    "texture coordinates on some faces only": (
        {"a.obj": SQUARE + UVS + "f 1/1 2/2 3/3\nf 1 3 4\n"},
        [(None, None, HALVES, None)],
    ),
    "slashes in all their forms": (
        {
            "a.obj": SQUARE + UVS + "vn 0 0 1\nf 1/1/1 2/2/1 3/3/1\nf 1//1 3//1 4//1\n",
        },
        [(None, None, HALVES, None)],
    ),
    "a picture in a folder, with options and the name's blanks": (
        {
            "a.obj": "mtllib my things/a b.mtl\n" + SQUARE + UVS + "usemtl r\nf 1/1 2/2 3/3 4/4\n",
            "my things/a b.mtl": "newmtl r\nKd 0.2 0.2 0.2\nd 0.5\n"
            "map_Kd -o 0 0 0 -clamp on -s 2 2 1 pic\\the wood.png\n",
        },
        [
            (
                (1.0, 1.0, 1.0, 0.5),
                "my things/pic/the wood.png",
                HALVES,
                [((0, 0), (1, 0), (1, 1)), ((0, 0), (1, 1), (0, 1))],
            )
        ],
    ),
    "carriage returns alone": (
        {"a.obj": (SQUARE + "f 1 2 3\nf 1 3 4\n").replace("\n", "\r")},
        [(None, None, HALVES)],
    ),
    "objects, groups and smoothing": (
        {
            "a.obj": "o one\ng left\ns 1\n" + SQUARE + "f 1 2 3\no two\ng right\ns off\nf 1 3 4\n",
        },
        [(None, None, HALVES)],
    ),
    "colours beside the points, weights, carriage returns, comments, continued lines": (
        {
            "a.obj": "# made by hand\r\nv 0 0 0 1 0 0\r\nv 1.0E+0 0 0 1.0\r\nv 1 1 -0 0.1 0.2 0.3"
            "\r\nv 0 100e-2 0\r\n  f 1 2 \\\n3 4\r\nl 1 2\r\np 1\r\n",
        },
        [(None, None, HALVES)],
    ),
}

ROBOT = """<robot name="r"><link name="base"><collision><geometry><mesh filename="{}"/></geometry>
</collision></link></robot>"""
HEAD = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
  <asset>{asset}</asset>
  <library_images><image id="i"><init_from>pic/the%20wood.png</init_from></image></library_images>
  <library_effects>
    <effect id="re"><profile_COMMON><technique sid="t"><lambert>
      <diffuse><color>1 0 0 1</color></diffuse></lambert></technique></profile_COMMON></effect>
    <effect id="ge"><profile_COMMON><technique sid="t"><phong>
      <diffuse><color>0 1 0 1</color></diffuse></phong></technique></profile_COMMON></effect>
    <effect id="we"><profile_COMMON>
      <newparam sid="s1"><surface type="2D"><init_from>i</init_from></surface></newparam>
      <newparam sid="s2"><sampler2D><source>s1</source></sampler2D></newparam>
      <technique sid="t"><lambert><diffuse><texture texture="s2" texcoord="UV"/></diffuse>
      </lambert></technique></profile_COMMON></effect>
  </library_effects>
  <library_materials><material id="r"><instance_effect url="#re"/></material>
    <material id="g"><instance_effect url="#ge"/></material>
    <material id="w"><instance_effect url="#we"/></material></library_materials>
  <library_geometries><geometry id="g1"><mesh>
    <source id="p"><float_array id="pa" count="12">0 0 0 1 0 0 1 1 0 0 1 0</float_array>
      <technique_common><accessor source="#pa" count="4" stride="3">
        <param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
      </accessor></technique_common></source>
    <source id="u"><float_array id="ua" count="8">0 0 1 0 1 1 0 1</float_array>
      <technique_common><accessor source="#ua" count="4" stride="2">
        <param name="S" type="float"/><param name="T" type="float"/>
      </accessor></technique_common></source>
    <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
    {primitives}
  </mesh></geometry></library_geometries>
  <library_visual_scenes><visual_scene id="s">{nodes}</visual_scene></library_visual_scenes>
  <scene><instance_visual_scene url="#s"/></scene>
</COLLADA>
"""
TRIANGLES = """<triangles count="1" material="m"><input semantic="VERTEX" source="#v" offset="0"/>
  <p>0 1 2</p></triangles>"""
TWO_MATERIALS = TRIANGLES + TRIANGLES.replace('"m"', '"n"').replace("0 1 2", "0 2 3")
QUAD = """<polylist count="1" material="m"><input semantic="VERTEX" source="#v" offset="0"/>
  <input semantic="TEXCOORD" source="#u" offset="1" set="0"/>
  <vcount>4</vcount><p>0 0 1 1 2 2 3 3</p></polylist>"""


def instance(**materials):
    bound = "".join(
        f'<instance_material symbol="{symbol}" target="#{name}"/>'
        for symbol, name in materials.items()
    )
    return (
        '<instance_geometry url="#g1"><bind_material><technique_common>'
        f"{bound}</technique_common></bind_material></instance_geometry>"
    )


def dae(primitives, nodes, asset="<up_axis>Z_UP</up_axis>"):
    return {"a.dae": HEAD.format(asset=asset, primitives=primitives, nodes=nodes)}


RED, GREEN = (1.0, 0.0, 0.0, 1.0), (0.0, 1.0, 0.0, 1.0)
DAE = {
    "centimetres, whatever is up": (
        dae(
            TRIANGLES,
            f"<node>{instance(m='r')}</node>",
            '<unit name="centimeter" meter="0.01"/><up_axis>Y_UP</up_axis>',
        ),
        [(RED, None, [((0, 0, 0), (0.01, 0, 0), (0.01, 0.01, 0))])],
    ),
    "x up": (
        dae(TRIANGLES, f"<node>{instance(m='r')}</node>", "<up_axis>X_UP</up_axis>"),
        [(RED, None, [(A, B, C)])],
    ),
    "nothing said of what is up": (
        dae(TRIANGLES, f"<node>{instance(m='r')}</node>", ""),
        [(RED, None, [(A, B, C)])],
    ),
    "an instance within moved, turned and scaled nodes": (
        dae(
            TRIANGLES,
            "<node><translate>0 0 5</translate><node><rotate>0 0 1 90</rotate>"
            f"<scale>2 2 2</scale>{instance(m='r')}</node></node>",
        ),
        [(RED, None, [((0, 0, 5), (0, 2, 5), (-2, 2, 5))])],
    ),
    "a mirrored instance, whose outside stays outside": (
        dae(QUAD, f"<node><scale>-1 1 1</scale>{instance(m='r')}</node>"),
        [
            (
                RED,
                None,
                [((0, 0, 0), (-1, 1, 0), (-1, 0, 0)), ((0, 0, 0), (0, 1, 0), (-1, 1, 0))],
                [((0, 0), (1, 1), (1, 0)), ((0, 0), (0, 1), (1, 1))],
            )
        ],
    ),
    "one geometry, twice, of other materials": (
        dae(
            TRIANGLES,
            f"<node>{instance(m='r')}</node>"
            f"<node><translate>3 0 0</translate>{instance(m='g')}</node>",
        ),
        [(RED, None, [(A, B, C)]), (GREEN, None, [((3, 0, 0), (4, 0, 0), (4, 1, 0))])],
    ),
    "two materials in one geometry": (
        dae(TWO_MATERIALS, f"<node>{instance(m='r', n='g')}</node>"),
        [(RED, None, [(A, B, C)]), (GREEN, None, [(A, C, D)])],
    ),
    "a quad with a picture whose name is escaped": (
        dae(QUAD, f"<node>{instance(m='w')}</node>"),
        [
            (
                WHITE,
                "pic/the wood.png",
                HALVES,
                [((0, 0), (1, 0), (1, 1)), ((0, 0), (1, 1), (0, 1))],
            )
        ],
    ),
}


def facet(corners, normal="0 0 1"):
    points = "".join(f"vertex {x} {y} {z}\n" for x, y, z in corners)
    return f"facet normal {normal}\nouter loop\n{points}endloop\nendfacet\n"


def binary(title, triangles):
    content = title.ljust(80, b"\0") + struct.pack("<I", len(triangles))
    for triangle in triangles:
        content += struct.pack("<12fH", 0, 0, -1, *np.ravel(triangle), 7)
    return content


STL = {
    "binary, with wrong normals and attributes": (
        {"a.stl": binary(b"part", HALVES)},
        [(None, None, HALVES)],
    ),
    "binary that begins like text": (
        {"a.stl": binary(b"solid part\n", HALVES)},
        [(None, None, HALVES)],
    ),
    "text of two solids": (
        {
            "a.stl": f"solid a\n{facet(HALVES[0])}endsolid a\n"
            f"solid b\n{facet(HALVES[1])}endsolid b\n"
        },
        [(None, None, HALVES)],
    ),
    "text in capitals, with exponents and wrong normals": (
        {
            "a.stl": "SOLID A\n"
            + facet(HALVES[0], "0 0 -1").upper().replace("VERTEX 1 ", "VERTEX 1.0E+00 ")
            + facet(HALVES[1], "0 0 0").upper()
            + "ENDSOLID\n"
        },
        [(None, None, HALVES)],
    ),
}


def written(folder, files):
    """Write the files; the path of the first, which is the mesh."""
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return folder / next(iter(files))


def rows(corners, uvs):
    """Every triangle as one row, from its smallest corner on, in an order of their own."""
    found = []
    for place, triangle in enumerate(np.asarray(corners, dtype=float).round(5) + 0.0):
        values = np.hstack([triangle, uvs[place]]) if uvs is not None else triangle
        turns = [tuple(np.roll(values, -turn, axis=0).ravel().tolist()) for turn in range(3)]
        found.append(min(turns))
    return sorted(found)


CASES = [pytest.param(*case, id=name) for cases in (OBJ, STL, DAE) for name, case in cases.items()]


@pytest.mark.parametrize(("files", "expected"), CASES)
def test_a_file_of_another_program_gives_its_parts(tmp_path, files, expected):
    path = written(tmp_path, files)
    parts = load_parts(path)
    assert [(part.color, part.texture) for part in parts] == [
        (color, texture and tmp_path / texture) for color, texture, *_ in expected
    ]
    for part, (_, _, triangles, *uvs) in zip(parts, expected):
        corners = part.mesh.positions[part.mesh.triangles]
        found = None if part.mesh.uvs is None else part.mesh.uvs[part.mesh.triangles]
        wanted = np.array(uvs[0], dtype=float) if uvs and uvs[0] else None
        assert (found is None) == (wanted is None)
        assert rows(corners, found) == rows(triangles, wanted)
        # Flat parts: whatever a file says otherwise, each corner's normal is the triangle's.
        edges = np.diff(corners, axis=1)
        across = np.cross(edges[:, 0], edges[:, 1]).astype(float)
        across /= np.linalg.norm(across, axis=1, keepdims=True)
        if path.suffix != ".obj" or not path.read_text().count("f 1 2 6"):
            normals = part.mesh.normals[part.mesh.triangles]
            np.testing.assert_allclose(normals, np.repeat(across[:, None], 3, axis=1), atol=1e-5)
    total = sum(len(triangles) for _, _, triangles, *_ in expected)
    assert len(load_mesh(path).triangles) == total


@pytest.mark.parametrize(("files", "expected"), CASES)
def test_a_robot_collides_by_what_is_drawn_of_a_file(tmp_path, closing, files, expected):
    world = closing(Holder)().world
    urdf = ROBOT.format(written(tmp_path, files))
    body = world.load_robot(urdf, str, (0.0, 0.0, 0.0), 0.0, {}, fixed_base=True)
    found = pybullet.getAABB(body.uid, -1, physicsClientId=world.client)
    points = np.concatenate([np.reshape(part[2], (-1, 3)) for part in expected])
    # PyBullet adds 2 or 3 mm of margin.
    assert np.array(found) == pytest.approx(np.array([points.min(0), points.max(0)]), abs=3.1e-3)


class Holder:
    def __init__(self):
        self.world = World(0.002, 50)
