"""Pictures that the renderer draws itself."""

import hashlib

import numpy as np
import pytest

from telex_sim.cameras.drawing.light.daylight import Lighting
from telex_sim.cameras.drawing.quality import TIERS
from telex_sim.cameras.optics.pinhole import PinholeCamera
from telex_sim.cameras.preview.still import Still, looking
from telex_sim.scene.textures.optotypes import DIRECTIONS, PER_ROW, ROW_STEP
from telex_sim.scene.textures.procedural import (
    TextureNameError,
    chart_answers,
    check_texture,
    generate_texture,
    texture_names,
)
from telex_sim.scene.visual_scene import Daylight, Visual, VisualScene, VisualShape

pytestmark = pytest.mark.slow

PICTURES = ("sign", "label", "chart", "optotype")
NOT_TILED = (*PICTURES, "crate")
TINTED = sorted(set(texture_names()) - {*PICTURES, "hazard_stripes"})


@pytest.fixture(scope="module")
def drawn():
    return {name: generate_texture(f"generated:{name}") for name in texture_names()}


def test_all_that_scenes_may_ask_for_exist():
    wanted = """concrete asphalt brick plaster wood crate cardboard tread_plate brushed_metal
        painted_metal hazard_stripes checker tiles gravel rubber tunnel_wall sign label chart
        optotype""".split()
    assert set(wanted) <= set(texture_names())


@pytest.mark.parametrize("name", texture_names())
def test_pictures_are_rgb_of_a_fair_size(drawn, name):
    picture = drawn[name]
    assert picture.dtype == np.uint8
    assert picture.shape[2] == 3
    assert 128 <= min(picture.shape[:2]) <= max(picture.shape[:2]) <= 2048
    assert picture.std() > 3.0


@pytest.mark.parametrize("name", texture_names())
def test_the_same_again(drawn, name):
    again = generate_texture(f"generated:{name}")
    assert hashlib.sha1(again).digest() == hashlib.sha1(drawn[name]).digest()


@pytest.mark.parametrize("name", sorted(set(texture_names()) - {"sign", "label", "optotype"}))
def test_another_seed_is_another_picture_of_the_same_kind(drawn, name):
    other = generate_texture(f"generated:{name}?seed=12345")
    assert (other != drawn[name]).any()
    np.testing.assert_allclose(other.mean((0, 1)), drawn[name].mean((0, 1)), atol=14)


@pytest.mark.parametrize("name", TINTED)
def test_materials_take_the_colour_of_the_visual(drawn, name):
    mean = drawn[name].reshape(-1, 3).mean(axis=0)
    assert mean.min() > 140
    assert np.ptp(mean) < 20


@pytest.mark.parametrize("name", sorted(set(texture_names()) - set(NOT_TILED)))
def test_no_seam(drawn, name):
    picture = drawn[name].astype(float).mean(axis=2)
    for axis in (0, 1):
        steps = np.abs(picture - np.roll(picture, 1, axis)).mean(axis=1 - axis)
        # From the last row to the first it is no further than anywhere else.
        assert steps[0] <= steps[1:].max() * 1.05


@pytest.mark.parametrize(
    ("address", "complaint"),
    [
        (
            "generated:marble",
            "texture 'marble' is unknown; there are asphalt, brick, brushed_metal",
        ),
        ("generated:", "texture '' is unknown"),
        ("generated:brick?colour=red", "brick has no 'colour'; it has seed, rows, columns"),
        ("generated:brick?rows=7", "rows is '7'; an even number is needed"),
        ("generated:brick?rows=many", "rows is 'many'; a whole number is needed"),
        ("generated:brick?seed=-1", "seed is '-1'; 0 to 2147483647 is possible"),
        ("generated:brick?seed", "'seed' has no value"),
        ("generated:brick?seed=1&seed=2", "'seed' is given twice"),
        ("generated:sign?shape=star", "shape is 'star'; there are triangle, square, circle"),
        ("generated:label?aspect=nan", "aspect is 'nan'; 0.1 to 10 is possible"),
        ("generated:label?text=%C3%A4", "printable characters of ASCII"),
        (f"generated:sign?text={41 * 'a'}", "at most 40 characters"),
        ("generated:optotype?angle=360", "angle is '360'; 0 to 359 is possible"),
        ("generated:chart?kind=D", "kind is 'D'; there are E, C"),
        ("file:///a.png", "begins with generated:"),
    ],
)
def test_mistakes_are_named(address, complaint):
    for use in (check_texture, generate_texture):
        with pytest.raises(TextureNameError) as caught:
            use(address)
        assert f"'{address}'" in str(caught.value)
        assert complaint in str(caught.value)


def test_texts_may_hold_anything_printable():
    check_texture("generated:sign?text=100%25+%26+more%3F&shape=square")
    plain, same = (generate_texture(f"generated:label?text={text}") for text in ("A B", "A+B"))
    np.testing.assert_array_equal(plain, same)


def test_a_label_has_the_proportions_that_it_is_asked_for():
    height, width, _ = generate_texture("generated:label?text=VALVE&aspect=4").shape
    assert width / height == pytest.approx(4.0, rel=0.02)
    height, width, _ = generate_texture("generated:label?text=VALVE&aspect=0.5").shape
    assert width / height == pytest.approx(0.5, rel=0.02)


@pytest.mark.parametrize("text", ["A", "A rather long text on a small label with many words", ""])
def test_text_stays_inside_its_frame(text):
    picture = generate_texture(f"generated:label?text={text.replace(' ', '+')}")
    empty = generate_texture("generated:label")
    rows, columns = np.nonzero((picture != empty).any(axis=2))
    height, width, _ = picture.shape
    if text:
        assert rows.min() > 0.08 * height
        assert rows.max() < 0.92 * height
        assert columns.min() > 0.04 * width
        assert columns.max() < 0.96 * width


def opening(picture):
    """Direction in which an optotype opens (degrees): from where its ink lies away."""
    dark = picture.mean(axis=2) < 128
    height, width = dark.shape
    row, column = np.nonzero(dark)
    towards = np.array([0.5 * (width - 1) - column.mean(), row.mean() - 0.5 * (height - 1)])
    return np.degrees(np.arctan2(*towards[::-1])) % 360.0


@pytest.mark.parametrize(
    ("kind", "angle"), [(kind, angle) for kind, angles in DIRECTIONS.items() for angle in angles]
)
def test_optotypes_open_where_they_say(kind, angle):
    found = opening(generate_texture(f"generated:optotype?kind={kind}&angle={angle}"))
    assert (found - angle + 180.0) % 360.0 == pytest.approx(180.0, abs=3.0)


class TestChart:
    @pytest.mark.parametrize("kind", DIRECTIONS)
    def test_its_answers_are_what_it_shows(self, kind):
        address = f"generated:chart?kind={kind}&seed=11&rows=7"
        picture, rows = generate_texture(address), chart_answers(address)
        size = len(picture)
        assert len(rows) == 7
        pitch = 2.0 * rows[0].size
        for row in rows:
            assert len(row.angles) == PER_ROW
            half = 0.5 * row.size * size * 1.1
            for place, angle in enumerate(row.angles):
                x = (0.5 + (place - 2) * pitch) * size
                y = row.middle * size
                cut = picture[round(y - half) : round(y + half), round(x - half) : round(x + half)]
                found = opening(cut)
                assert (found - angle + 180.0) % 360.0 == pytest.approx(180.0, abs=15.0)

    def test_rows_shrink_by_a_tenth_of_a_decade_and_fill_the_sheet(self):
        rows = chart_answers("generated:chart?rows=8")
        for larger, smaller in zip(rows, rows[1:]):
            assert larger.size / smaller.size == pytest.approx(ROW_STEP)
            # Between them is at least the height of the lower one.
            gap = smaller.middle - larger.middle - 0.5 * (larger.size + smaller.size)
            assert gap >= smaller.size * 0.999
        assert rows[0].middle - 0.5 * rows[0].size == pytest.approx(0.05)
        assert rows[-1].middle + 0.5 * rows[-1].size == pytest.approx(0.95)

    def test_other_seeds_ask_other_things(self):
        first, second = (chart_answers(f"generated:chart?seed={seed}") for seed in (1, 2))
        assert [row.angles for row in first] != [row.angles for row in second]

    def test_only_charts_have_answers(self):
        with pytest.raises(TextureNameError, match="is no chart"):
            chart_answers("generated:brick")


@pytest.fixture(scope="module")
def still():
    made = Still(TIERS["software"], Lighting(), str)
    yield made
    made.release()


@pytest.mark.parametrize(
    ("eye", "up"),
    [
        ((3.0, 0.0, 0.0), "z"),
        ((-3.0, 0.0, 0.0), "z"),
        ((0.0, 3.0, 0.0), "z"),
        ((0.0, -3.0, 0.0), "z"),
        ((0.0, 0.0, 3.0), "y"),
        ((0.0, 0.0, -3.0), "y"),
    ],
)
def test_signs_are_readable_on_every_side_of_a_box(still, eye, up):
    # Opens to the upper left as nobody could mistake: in no other way it looks the same.
    sign = Visual(
        "world",
        VisualShape.BOX,
        (1.0, 1.0, 1.0),
        color=(1.0, 1.0, 1.0, 1.0),
        texture="generated:optotype?kind=C&angle=135",
        texture_scale=0.0,
        glow=1.0,
    )
    night = Daylight(sun=(0.0, 0.0, 0.0), ambient=0.0)
    assert still.load(VisualScene(1, ("world",), (sign,), (), night)) == []
    pose = looking(eye, (0.0, 0.0, 0.0))
    if up == "y":
        # The picture's upper edge towards +y.
        forward = -np.sign(eye[2]) * np.array([0.0, 0.0, 1.0])
        down = np.array([0.0, -1.0, 0.0])
        pose[:3, :3] = np.column_stack([np.cross(down, forward), down, forward])
    camera = PinholeCamera(200, 200, 0.4, 0.1, 10.0)
    picture = still.picture(camera, pose, np.eye(4)[None], (0.0, 0.0, 0.0))
    focal = camera.focal_length / 2.5
    edge = round(100 - 0.5 * focal) + 2, round(100 + 0.5 * focal) - 2
    face = picture[edge[0] : edge[1], edge[0] : edge[1]]
    assert face.max() > 200
    assert (opening(face) - 135.0 + 180.0) % 360.0 == pytest.approx(180.0, abs=4.0)


@pytest.mark.parametrize(
    ("texture", "complaint"),
    [
        (f"file:///tmp/{'a' * 300}.png", "File name too long"),
        ("file:///tmp/a%00.png", "has %00"),
        ("generated:chart?sealed=0123456789abcdef", "sealed: its key cannot be read or made"),
    ],
)
def test_a_texture_that_cannot_be_read_leaves_the_rest(still, monkeypatch, texture, complaint):
    # No folder can be made there.
    monkeypatch.setenv("ROS_HOME", "/dev/null/ros")
    thing = Visual("world", VisualShape.BOX, (1.0, 1.0, 1.0), texture=texture)
    (problem,) = still.load(VisualScene(1, ("world",), (thing,)))
    assert "box of frame 'world' has no texture" in problem
    assert complaint in problem


def test_a_mesh_with_an_impossible_name_is_left_out(still):
    thing = Visual("world", VisualShape.MESH, (1.0, 1.0, 1.0), mesh="file:///tmp/a%00.obj")
    (problem,) = still.load(VisualScene(1, ("world",), (thing,)))
    assert "no file's name has %00" in problem


def test_an_unknown_texture_leaves_the_colour_and_a_line(still):
    thing = Visual("world", VisualShape.BOX, (1.0, 1.0, 1.0), color=(0.9, 0.0, 0.0, 1.0), glow=1.0)
    wrong = Visual(**{**vars(thing), "texture": "generated:marble"})
    (problem,) = still.load(VisualScene(1, ("world",), (wrong,)))
    assert "box of frame 'world' has no texture" in problem
    assert "there are asphalt" in problem
    camera = PinholeCamera(64, 64, 0.8, 0.1, 10.0)
    view = looking((3.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    picture = still.picture(camera, view, np.eye(4)[None], (0.0, 0.0, 0.0))
    red, green, _ = picture[32, 32].astype(int)
    assert red > 3 * green
