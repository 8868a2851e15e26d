"""Scene files: what they say, and that every mistake is named before anything is made of it."""

from __future__ import annotations

import math
import re
from pathlib import Path

import cv2
import numpy as np
import pytest

from telex_control.common.params import ConfigError
from telex_sim.scene.assets import Assets
from telex_sim.scene.catalog import find_scene, scenes
from telex_sim.scene.files.scene_file import SceneError, load_scene
from telex_sim.scene.files.yaml_text import read_yaml
from telex_sim.scene.library import RESERVED, object_types
from telex_sim.scene.model import MOST_OBJECTS
from telex_sim.scene.planning import plan_entry, plan_scene
from telex_sim.scene.visual_scene import Daylight

CUSTOM = "{type: custom, links: [{name: rock, mass: 2, parts: [{sphere: 0.2}]}]}"
PICTURE = cv2.imencode(".png", np.arange(3072, dtype=np.uint8).reshape(32, 32, 3))[1].tobytes()
TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "rock.obj").write_text(TETRAHEDRON)
    (tmp_path / "novel.obj").write_text("It was a dark and stormy night.\n")
    (tmp_path / "picture.stl").write_bytes(b"\x89PNG" * 100)
    (tmp_path / "flat.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (tmp_path / "nan.obj").write_text(TETRAHEDRON.replace("v 1 0 0", "v nan 0 0"))
    (tmp_path / "text.png").write_text("no picture")
    (tmp_path / "whole.png").write_bytes(PICTURE)
    (tmp_path / "cut.png").write_bytes(PICTURE[: len(PICTURE) // 2])
    with open(tmp_path / "huge.obj", "wb") as file:
        file.truncate(65 * 1024 * 1024)
    return tmp_path


def planned(folder, text, name="scene.yaml"):
    path = folder / name
    path.write_text(text)
    return plan_scene(path, Assets())


def refusal(folder, text):
    with pytest.raises(SceneError) as caught:
        planned(folder, text)
    message = str(caught.value)
    assert message.startswith(f"{folder / 'scene.yaml'}: ")
    assert "\n" not in message
    return message[len(str(folder / "scene.yaml")) + 2 :]


def test_a_picture_of_ones_own_is_a_texture(folder):
    scene = planned(folder, "floor: {surface: {texture: whole.png}}\n").scene
    assert scene.floor.surface.texture == f"file://{folder / 'whole.png'}"


def test_a_scene_with_everything(folder):
    scene = planned(
        folder,
        """
name: workshop
description: >
  A rock,
  and another.
floor: {friction: 0.6, size: 20, surface: {color: [0.5, 0.5, 0.5, 1], texture: text.png}}
lights:
  sun: {azimuth: 0.5, elevation: 1.0, intensity: 0.2}
  ambient: 0.3
  lamps: [{position: [0, 0, 3]}]
  fog: {visibility: 30}
start: {x: 1, y: -2, ground: 0.3, yaw: 1.5, pose: stow}
views: [{eye: [3, 0, 2], target: [0, 0, 0]}]
objects:
  - {type: mesh, name: stone, mesh: rock.obj, mass: 3, position: [4, 5, 6], rpy: [0, 0, 0.6]}
  - {type: mesh, mesh: rock.obj, scale: [2, 2, 2], static: true, yaw: 0.6}
""".replace("texture: text.png", "texture: 'generated:concrete'"),
    ).scene
    assert (scene.name, scene.description) == ("workshop", "A rock, and another.")
    assert (scene.floor.friction, scene.floor.size) == (0.6, 20.0)
    assert (scene.lights.sun.intensity, scene.lights.fog.visibility) == (0.2, 30.0)
    assert (scene.start.ground, scene.start.pose) == (0.3, "stow")
    stone, other = scene.objects
    assert (stone.name, other.name) == ("stone", "mesh_1")
    assert stone.position == (4.0, 5.0, 6.0)
    assert stone.orientation == pytest.approx((0.0, 0.0, math.sin(0.3), math.cos(0.3)))
    assert other.orientation == pytest.approx(stone.orientation)
    assert stone.model.links[0].parts[0].geometry.mesh == f"file://{folder}/rock.obj"
    assert other.model.static


@pytest.mark.parametrize(("visibility", "possible"), [(1e-38, False), (0.01, True), (0, True)])
def test_fog_that_nothing_is_seen_through_is_refused(folder, visibility, possible):
    text = f"lights: {{fog: {{visibility: {visibility}}}}}"
    if possible:
        assert planned(folder, text).scene.lights.fog.visibility == visibility
        # As it arrives in a message.
        Daylight(visibility=float(np.float32(visibility)))
    else:
        with pytest.raises(SceneError, match="visibility is 1e-38; it must be 0, .* at least 0.01"):
            planned(folder, text)


def test_names_that_are_left_out_avoid_those_given(folder):
    scene = planned(
        folder,
        f"objects:\n  - {CUSTOM}\n  - {CUSTOM.replace('type', 'name: custom_1, type')}\n",
    ).scene
    assert [item.name for item in scene.objects] == ["custom_2", "custom_1"]


def test_the_objects_of_one_entry_are_named_after_it_and_placed_with_it(folder):
    scene = planned(
        folder, "objects: [{type: pallet_stack, name: pile, position: [2, 1, 0], yaw: 1.57}]"
    ).scene
    assert len(scene.objects) > 1
    assert all(item.name.startswith("pile_") for item in scene.objects)
    assert {item.entry for item in scene.objects} == {"pile"}
    assert all(item.position[:2] == pytest.approx((2.0, 1.0)) for item in scene.objects)
    heights = [item.position[2] for item in scene.objects]
    assert heights == sorted(set(heights))


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ("{type: crate, name: box_2, mass: -1}", "(crate 'box_2'): mass is -1"),
        ("{type: crate, mass: -1}", "objects[0] (crate): mass is -1"),
        ("{type: crate, mass: .nan}", "mass is nan; it must be finite"),
        ("{type: crate, position: [.nan, 0, 0]}", "position[0] is nan; it must be finite"),
        ("{type: crate, position: [0, .inf, 0]}", "position[1] is inf; it must be finite"),
        ("{type: crate, position: [0, 0]}", "position has 2 elements; 3 are needed"),
        ("{type: crate, position: [0, 0, 1000000000]}", "finite numbers, of at most 10000"),
        ("{type: crate, position: here}", "position is 'here'; a list is needed"),
        ("{type: crate, rpy: [0, 0, .nan]}", "rpy[2] is nan"),
        ("{type: crate, yaw: 1, rpy: [0, 0, 1]}", "yaw and rpy are both given"),
        ("{type: crate, mass: '8'}", "mass is '8'; a number is needed"),
        ("{type: crate, mass: true}", "mass is True; a number is needed"),
        ("{type: crate, colour: red}", "colour is unknown; known are"),
        ("{type: crat}", "type is 'crat'; there are: crate, "),
        ("{type: dragon}", "type is 'dragon'; there are: "),
        ("{name: box}", "type is missing"),
        ("{type: crate, name: 'a/b'}", "name is 'a/b'; a letter, then letters"),
        ("{type: crate, name: 7}", "name is 7; a string is needed"),
        ("crate", "'crate'; a struct with type is needed"),
        ("{type: crate, size: [0.4, 0.3, 1" + "0" * 400 + "]}", "it must be finite"),
        ("{type: mesh}", "mesh is missing"),
        ("{type: mesh, mesh: no.obj}", "no.obj: there is no such file"),
        ("{type: mesh, mesh: 'package://nowhere/a.obj'}", "package 'nowhere' is not found"),
        ("{type: mesh, mesh: novel.obj}", "novel.obj: there is no face"),
        ("{type: mesh, mesh: picture.stl}", "picture.stl: "),
        ("{type: mesh, mesh: text.png}", "unknown kind of mesh"),
        ("{type: mesh, mesh: huge.obj}", "68157440 bytes; at most 67108864 are read"),
        ("{type: mesh, mesh: nan.obj}", "not finite"),
        ("{type: mesh, mesh: flat.obj}", "enclose no volume"),
        ("{type: mesh, mesh: .}", "it is no file"),
        ("{type: mesh, mesh: rock.obj, scale: [1, 0, 1]}", "none may be 0"),
        ("{type: mesh, mesh: rock.obj, texture: no.png}", "no.png: there is no such file"),
        ("{type: mesh, mesh: rock.obj, texture: text.png}", "no picture that OpenCV can read"),
        ("{type: mesh, mesh: rock.obj, texture: cut.png}", "no picture that OpenCV can read"),
        ("{type: mesh, mesh: rock.obj, texture: 'generated:gold'}", "generated:gold"),
        ("{type: mesh, mesh: rock.obj, solid: false}", "must be static"),
        ("{type: custom}", "links is missing"),
        ("{type: custom, links: []}", "there are 0 links"),
        (
            "{type: custom, links: [{name: a, parts: [{box: [1, 1, 1]}]}]}",
            "link 'a': mass is 0.0; 0.0001 kg or more is needed",
        ),
        (
            "{type: custom, links: [{name: a, mass: 1, parts: [{box: [1, 1, -1]}]}]}",
            "link 'a': size is [1.0, 1.0, -1.0]; every length of a box must be above 0",
        ),
        (
            "{type: custom, links: [{name: a, mass: 1, parts: [{box: [1, 1, 1], sphere: 1}]}]}",
            "links[0]/parts[0]: one of box, sphere, cylinder and mesh is needed",
        ),
        (
            "{type: custom, links: [{name: a, mass: 1, parts: [{sphere: 1, solid: false}]}]}",
            "link 'a' can move, but has no solid part",
        ),
        (
            "{type: custom, links: [{name: a, mass: 1, parts: [{sphere: 1}]}],"
            " joints: [{name: j, motion: spin, parent: a, child: b}]}",
            "motion is 'spin'; hinge, slide, latch are possible",
        ),
        (
            "{type: custom, links: [{name: a, mass: 1, parts: [{sphere: 1}]},"
            " {name: b, mass: 1, parts: [{sphere: 1}]}],"
            " joints: [{name: j, motion: hinge, parent: a, child: b, lower: 1}]}",
            "joint 'j': lower is 1.0 and upper is 0.0",
        ),
        (
            "{type: custom, links: [{name: a, mass: 1, parts: [{sphere: 1}]},"
            " {name: b, mass: 1, parts: [{sphere: 1}]}],"
            " joints: [{name: j, motion: hinge, parent: a, child: b, upper: 1, axis: [0, 0, 2]}]}",
            "axis is [0.0, 0.0, 2.0], of length 2; it must have length 1",
        ),
        (
            "{type: custom, links: [{name: a, mass: 1, parts: [{sphere: 1}]},"
            " {name: b, mass: 1, parts: [{sphere: 1}]}]}",
            "joints must move every link but the root 'a'",
        ),
        (
            "{type: custom, links: [{name: a, mass: 1, parts: [{sphere: 1}]},"
            " {name: b, mass: 1, parts: [{sphere: 1}]}, {name: c, mass: 1, parts: [{sphere: 1}]}],"
            " joints: [{name: i, motion: hinge, parent: c, child: b, upper: 1},"
            " {name: j, motion: hinge, parent: b, child: c, upper: 1}]}",
            "does not lead to the root 'a'",
        ),
    ],
)
def test_a_mistake_in_an_object_is_named_from_a_file_and_when_spawned(folder, entry, said):
    message = refusal(folder, f"objects:\n  - {entry}\n")
    assert message.startswith("objects[0] (")
    assert said in message.replace("objects[0]: ", "")
    with pytest.raises(ConfigError) as caught:
        plan_entry(entry, "", str(folder), [], Assets())
    assert "\n" not in str(caught.value)
    if "objects[0]" not in said and "'box_2'" not in said and "'crate'" not in said:
        assert said in str(caught.value)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "a struct with the key 'objects' is needed"),
        ("- a\n- b\n", "a struct with the key 'objects' is needed"),
        ("objects: 5\n", "objects: a list is needed"),
        (
            "object: []\n",
            "object is unknown; known are antenna, description, floor, hidden, history",
        ),
        ("antenna: [1, 2]\n", "antenna has 2 elements; 3 are needed"),
        ("antenna: [1, 2, .nan]\n", "antenna[2] is nan"),
        ("antenna: [1, 2, 1e9]\n", "antenna is [1.0, 2.0, 1000000000.0]"),
        ("floor: {frition: 1}\n", "floor/frition is unknown"),
        ("floor: {friction: -1}\n", "floor: friction is -1.0"),
        ("floor: {surface: {texture: no.png}}\n", "no.png: there is no such file"),
        ("lights: {sun: {elevation: 3}}\n", "lights/sun: elevation is 3.0"),
        ("lights: {lamps: [{position: [0, 0, 1], reach: 0}]}\n", "lights/lamps[0]: reach is 0.0"),
        ("lights: {lamps: [{}]}\n", "lights/lamps[0]/position is missing"),
        ("start: {x: .nan}\n", "start/x is nan"),
        ("views: [{eye: [0, 0, 0], target: [0, 0, 0]}]\n", "views[0]: eye and target"),
        ("name: 'two words'\n", "name is 'two words'"),
        ("description: 5\n", "description is 5; a string is needed"),
        (f"objects:\n - {CUSTOM}\n - {{type\n", "line 4: no YAML"),
        ("name: a\nname: b\n", "line 2: 'name' stands twice"),
        ("a: &x [1]\nb: *x\n", "line 1: anchors and aliases"),
        ("name: !!python/object/apply:os.system [ls]\n", "no YAML: could not determine"),
        ("name: \x07\n", "no YAML"),
        ("start: {x: 2020-13-45}\n", "a value cannot be read"),
        ("\nhidden: !!bool maybe\n", "line 2: a value is 'maybe'; it does not fit its tag !!bool"),
        ('start: {x: !!int ""}\n', "line 1: a value is ''; it does not fit its tag !!int"),
        ('start: {x: !!float ""}\n', "line 1: a value is ''; it does not fit its tag !!float"),
        ("name: !!timestamp x\n", "line 1: a value is 'x'; it does not fit its tag !!timestamp"),
        ("objects: " + "[" * 50 + "]" * 50, "nested deeper than 24 levels"),
        (
            f"objects:\n - {CUSTOM.replace('type', 'name: a, type')}\n"
            f" - {CUSTOM.replace('type', 'name: a, type')}\n",
            "objects[1] (custom 'a'): name is 'a'; objects[0] has it already",
        ),
        (
            "objects:\n" + f" - {CUSTOM}\n" * (MOST_OBJECTS + 1),
            f"there are more than {MOST_OBJECTS} objects",
        ),
        ("lights: {lamps: [" + "{position: [0, 0, 1]}," * 65 + "]}\n", "at most 64"),
    ],
)
def test_a_mistake_in_a_scene_is_named(folder, text, said):
    assert said in refusal(folder, text)


def test_aliases_cannot_grow_without_end():
    laughs = "a: &a [x, x]\n" + "".join(
        f"{b}: &{b} [*{a}, *{a}, *{a}, *{a}]\n" for a, b in zip("abcdefgh", "bcdefghi")
    )
    with pytest.raises(ConfigError, match="line 1: anchors and aliases"):
        read_yaml(laughs)


def test_numbers_may_be_written_as_anywhere():
    assert read_yaml("[1e-3, 2E5, -1e1, 1.5e+2, 7, 1e, e1]") == [
        0.001,
        2e5,
        -10.0,
        150.0,
        7,
        "1e",
        "e1",
    ]


def test_a_very_large_file_is_refused_unread(tmp_path, monkeypatch):
    path = tmp_path / "large.yaml"
    path.write_text("- a\n" * 2_500_000)
    monkeypatch.setattr(Path, "read_text", lambda *_, **__: pytest.fail("it was read"))
    with pytest.raises(SceneError, match=r"large.yaml: it has 10000000 bytes; at most 1000000"):
        load_scene(path)
    with pytest.raises(ConfigError, match="10000000 bytes"):
        plan_entry("- a\n" * 2_500_000, "", "", [], Assets())


@pytest.mark.parametrize("content", [b"\xff\xfe\x00\x00", b"\x80abc"])
def test_a_file_that_is_no_text_is_refused(tmp_path, content):
    path = tmp_path / "scene.yaml"
    path.write_bytes(content)
    with pytest.raises(SceneError, match=r"scene.yaml: "):
        load_scene(path)


def test_files_that_cannot_be_read_are_named(tmp_path):
    with pytest.raises(SceneError, match="nowhere.yaml: No such file"):
        load_scene(tmp_path / "nowhere.yaml")
    with pytest.raises(SceneError, match="Is a directory"):
        load_scene(tmp_path)


def test_an_entry_alone_may_have_no_relative_address():
    with pytest.raises(ConfigError, match=r"'rock.obj' is relative, but there is no folder"):
        plan_entry("{type: mesh, mesh: rock.obj}", "", "", [], Assets())
    with pytest.raises(ConfigError, match="folder is 'here'; an absolute path is needed"):
        plan_entry("{type: mesh, mesh: rock.obj}", "", "here", [], Assets())


def test_an_entry_alone_gets_a_free_name(folder):
    assets = Assets()
    assert plan_entry(CUSTOM, "", "", [], assets)[0].source.name == "custom_1"
    taken = ["custom_1", "custom_2"]
    assert plan_entry(CUSTOM, "", "", taken, assets)[0].source.name == "custom_3"
    assert plan_entry(CUSTOM, "rock", "", taken, assets)[0].source.name == "rock"


def test_a_mesh_that_has_changed_is_read_anew(folder):
    assets = Assets()
    entry = "{type: mesh, mesh: rock.obj}"
    first = plan_entry(entry, "", str(folder), [], assets)[0].bodies[0].segments[0]
    (folder / "rock.obj").write_text(TETRAHEDRON.replace("v 0 0 1", "v 0 0 5.5"))
    second = plan_entry(entry, "", str(folder), [], assets)[0].bodies[0].segments[0]
    assert second.center[2] > first.center[2] + 0.5


def test_scenes_are_found_by_name_and_by_path(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.yaml").write_text("objects: []\n")
    assert find_scene("floor").name == "floor.yaml"
    assert find_scene("./mine.yaml") == Path("mine.yaml")
    assert find_scene(str(tmp_path / "mine.yaml")) == tmp_path / "mine.yaml"
    with pytest.raises(SceneError, match="there is no scene 'flor'; there are: floor"):
        find_scene("flor")
    with pytest.raises(SceneError, match="no such file"):
        find_scene("yours.yaml")
    monkeypatch.setenv("TELEX_SCENE_PATH", f"/nowhere:{tmp_path}")
    assert find_scene("mine") == tmp_path / "mine.yaml"
    (tmp_path / "floor.yaml").write_text("objects: []\n")
    assert scenes()["floor"] == tmp_path / "floor.yaml"


@pytest.mark.parametrize("name", sorted(set(object_types()) - {"custom", "mesh"}))
def test_every_type_of_the_library_can_be_made_as_it_is(name):
    assemblies = plan_entry(f"{{type: {name}}}", "", "", [], Assets())
    assert assemblies
    for assembly in assemblies:
        assert assembly.source.entry == f"{name}_1"


def test_types_keep_the_rules_of_the_library():
    for name, kind in object_types().items():
        assert name == name.lower()
        assert name.isidentifier()
        assert kind.__doc__
    assert set(RESERVED) == {"type", "name", "position", "yaw", "rpy", "shield", "source"}


def test_the_examples_of_the_documentation_are_right(folder):
    text = (Path(__file__).parents[4] / "docs" / "instructor" / "scenes.md").read_text()
    examples = re.findall(r"```yaml\n(.*?)```", text, re.DOTALL)
    assert len(examples) == 4
    (folder / "part.obj").write_text(TETRAHEDRON)
    for number, example in enumerate(examples):
        scene = planned(folder, example, f"example_{number}.yaml").scene
        assert scene.objects


# What passed once, and ended or ruined the simulation
RUINOUS = (
    "{type: custom, static: true, links: [{name: a, parts: [{box: [1, 1, 1]}]},"
    " {name: b, mass: 1, parts: [{sphere: 1.0e-103}]}],"
    " joints: [{motion: hinge, parent: a, child: b, lower: -1, upper: 1, closer: {preload: 1}}]}",
    "{type: custom, static: true, links: [{name: a, parts: [{box: [1, 1, 1]}]},"
    " {name: b, mass: 1, parts: [{box: [1, 1, 1]}]}],"
    " joints: [{motion: hinge, parent: a, child: b, lower: -1, upper: 1,"
    " closer: {preload: 1.0e+308}}]}",
    "{type: crate, name: [1]}",
    "{type: crate, name: {a: 1}}",
    "{type: crate, mass: 0x" + "f" * 50_000 + "}",
    "{type: crate, mass: " + "1:" + "59:" * 20_000 + "59}",
)


@pytest.mark.parametrize("entry", RUINOUS)
def test_what_would_end_the_simulation_is_refused(tmp_path, entry):
    path = tmp_path / "bad.yaml"
    path.write_text(f"objects: [{entry}]\n")
    with pytest.raises(SceneError) as caught:
        plan_scene(path, Assets(), 0.002)
    assert len(str(caught.value)) < 1000
