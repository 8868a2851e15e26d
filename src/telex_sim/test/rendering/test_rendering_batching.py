"""What is drawn in one call, and that nobody sees the difference."""

import math
from collections import Counter

import numpy as np
import pytest

from telex_sim.cameras.drawing.light.daylight import Lighting
from telex_sim.cameras.drawing.meshes import batching, gpu_scene
from telex_sim.cameras.drawing.meshes.batching import (
    CHUNK_SIZE,
    Batch,
    BatchPart,
    batches,
    bounding_radius,
    merge,
)
from telex_sim.cameras.drawing.quality import TIERS
from telex_sim.cameras.optics.pinhole import PinholeCamera
from telex_sim.cameras.preview.still import Still, looking
from telex_sim.scene.meshes.meshes import primitive_mesh
from telex_sim.scene.visual_scene import Daylight, Visual, VisualLamp, VisualScene, VisualShape

CRATE, STRIPES, TILES = "generated:crate", "generated:hazard_stripes", "generated:tiles"


def box(position=(0.0, 0.0, 0.0), **changes):
    return Visual(
        "world", **{"shape": VisualShape.BOX, "size": (0.3, 0.3, 0.3), **changes}, position=position
    )


def radius(visual):
    return bounding_radius(visual, lambda _: 1.0)


class TestGroups:
    def test_one_for_what_is_near_one_another_with_the_same_texture(self):
        visuals = [box((0.1 * x, 0.0, 0.0), color=(0.1 * x, 0.5, 0.5, 1.0)) for x in range(9)]
        (batch,) = batches(visuals, radius)
        assert set(batch.visuals) == set(visuals)

    def test_each_texture_frame_and_kind_of_shadow_has_its_own(self):
        visuals = [
            box(),
            box(texture=CRATE),
            Visual("thing", VisualShape.BOX, (1.0, 1.0, 1.0)),
            box(shape=VisualShape.PLANE),
        ]
        assert len(batches(visuals, radius)) == 4

    def test_what_shines_through_is_drawn_alone(self):
        found = batches([box(color=(1, 1, 1, 0.5)), box(color=(1, 1, 1, 0.5)), box()], radius)
        assert sorted(batch.opacity for batch in found) == [0.5, 0.5, 1.0]

    def test_a_hall_is_drawn_in_pieces(self):
        rng = np.random.default_rng(0)
        visuals = [box((*rng.uniform(-10, 10, 2), 0.2)) for _ in range(500)]
        wall = box((0.0, 10.0, 1.5), size=(20.0, 0.2, 3.0))
        found = batches([*visuals, wall], radius)
        assert Batch((wall,)) in found
        assert len(found) <= 1 + (20 / CHUNK_SIZE + 2) ** 2
        drawn = Counter(visual for batch in found for visual in batch.visuals)
        assert drawn == Counter([*visuals, wall])
        for batch in found:
            if wall not in batch.visuals:
                places = np.array([visual.position for visual in batch.visuals])
                assert np.ptp(places, axis=0).max() <= CHUNK_SIZE

    def test_the_same_things_on_another_frame_have_the_same_content(self):
        one, other = (
            Batch((Visual(frame, VisualShape.SPHERE, (0.1, 0.0, 0.0)),)) for frame in ("a", "b")
        )
        assert one.content == other.content
        assert one.frame != other.frame


class TestMerge:
    def test_places_turns_and_colours(self):
        half = math.sqrt(0.5)
        visuals = [
            box((1.0, 2.0, 3.0), size=(0.2, 0.4, 0.6), color=(1.0, 0.5, 0.0, 1.0), glow=0.2),
            box((0.0, 0.0, 0.0), size=(0.2, 0.4, 0.6), orientation=(0.0, 0.0, half, half)),
        ]
        vertices, triangles = merge(
            [BatchPart(visual, primitive_mesh(visual)) for visual in visuals]
        )
        assert len(vertices) == 48
        assert triangles.max() == 47
        first, second = vertices[:24], vertices[24:]
        np.testing.assert_allclose(first["position"].mean(axis=0), [1.0, 2.0, 3.0], atol=1e-6)
        np.testing.assert_allclose(np.ptp(second["position"], axis=0), [0.4, 0.2, 0.6], atol=1e-6)
        assert first["color"][0].tolist() == [255, 128, 0, 51]
        # Outside stays outside.
        corners = vertices["position"][triangles]
        faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        assert (np.einsum("ti,ti->t", faces, vertices["normal"][triangles[:, 0]]) > 0).all()


@pytest.fixture(scope="module")
def still():
    made = Still(TIERS["software"], Lighting(), str)
    yield made
    made.release()


def yard(count):
    """Boxes strewn about, some with textures, one of glass, and a lamp."""
    rng = np.random.default_rng(5)
    visuals = [Visual("world", VisualShape.PLANE, (60.0, 60.0, 0.0), texture="generated:checker")]
    for number in range(count):
        size = tuple(rng.uniform(0.1, 0.5, 3))
        yaw = rng.uniform(0, math.pi)
        visuals.append(
            box(
                (*rng.uniform(-7, 7, 2), 0.5 * size[2]),
                size=size,
                color=(*rng.uniform(0.3, 1.0, 3), 1.0),
                orientation=(0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)),
                texture=("", CRATE, STRIPES)[number % 3],
                texture_scale=0.5 * (number % 2),
            )
        )
    visuals.append(box((-2.0, 0.3, 0.5), color=(0.2, 0.9, 0.2, 0.4)))
    lamp = VisualLamp("world", (0.0, 0.0, 3.0), intensity=5.0, reach=6.0)
    return VisualScene(1, ("world",), tuple(visuals), (lamp,), Daylight())


def test_batches_give_the_same_picture_as_single_visuals(still, monkeypatch):
    camera = PinholeCamera(320, 240, 1.3, 0.05, 60.0)
    view = looking((-6.0, -1.0, 1.5), (0.0, 0.0, 0.3))

    def picture():
        assert still.load(yard(60)) == []
        return still.picture(camera, view, np.eye(4)[None], (0.0, 0.0, 0.0)).astype(int)

    together = picture()
    calls = []

    def single(visuals, radius_of):
        found = [Batch((visual,)) for visual in visuals]
        calls.append(len(found))
        return found

    monkeypatch.setattr(gpu_scene, "batches", single)
    apart = picture()
    assert calls == [62]
    difference = np.abs(together - apart).max(axis=2)
    # Where surfaces meet exactly, the order of drawing may decide single pixels.
    assert (difference > 2).mean() < 0.001


def test_what_stays_is_kept_when_the_scene_changes(still, monkeypatch):
    merged, generated = [], []
    merge = batching.merge
    monkeypatch.setattr(batching, "merge", lambda parts: merged.append(len(parts)) or merge(parts))
    original = gpu_scene.generate_texture
    monkeypatch.setattr(
        gpu_scene, "generate_texture", lambda name: generated.append(name) or original(name)
    )
    robot = tuple(
        Visual("arm", VisualShape.CYLINDER, (0.1, 0.0, 0.1 * (n + 1)), texture=TILES)
        for n in range(5)
    )
    crates = tuple(box((x, 0.0, 0.0)) for x in (10.0, 20.0, 30.0))
    frames = ("world", "arm")
    still.load(VisualScene(1, frames, (*robot, *crates)))
    assert sorted(merged) == [1, 1, 1, 5]
    assert generated == [TILES]
    # Only the cell in which something has changed is made anew.
    still.load(VisualScene(2, frames, (*robot, *crates, box((30.1, 0.0, 0.0)))))
    assert merged[4:] == [2]
    # On a frame of its own it is the same crate again.
    crate = Visual("arm", VisualShape.BOX, (0.3, 0.3, 0.3), (10.0, 0.0, 0.0))
    still.load(VisualScene(3, frames, (*robot, *crates, crate)))
    assert generated == [TILES]


def test_a_thousand_boxes_are_few_calls():
    rng = np.random.default_rng(1)
    visuals = [box((*rng.uniform(-8, 8, 2), 0.1)) for _ in range(1000)]
    assert len(batches(visuals, radius)) <= 36
