"""Objects in physics: where they stand, what they weigh, when they sleep."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pybullet
import pytest

from telex_control.common.geometry.matrices import rotation_matrix
from telex_control.common.geometry.quaternions import compose, invert, rotate, twist
from telex_control.common.params import ConfigError
from telex_sim.scene.meshes import mass_properties
from telex_sim.scene.meshes.convex_hull import MOST_VERTICES, FlatError, convex_hull
from telex_sim.scene.model import (
    MOST_OBJECTS,
    Floor,
    Form,
    Geometry,
    Joint,
    Link,
    Motion,
    ObjectModel,
    Part,
    SceneObject,
    Surface,
)

TURNED = (0.1825742, 0.3651484, 0.5477226, 0.7302967)


def unit(quaternion):
    length = math.sqrt(sum(number * number for number in quaternion))
    return tuple(number / length for number in quaternion)


TURNED = unit(TURNED)


def part(form, size, position=(0.0, 0.0, 0.0), orientation=(0.0, 0.0, 0.0, 1.0), mesh=""):
    return Part(Geometry(form, size, mesh), position, orientation)


def box(size, position=(0.0, 0.0, 0.0), orientation=(0.0, 0.0, 0.0, 1.0)):
    return part(Form.BOX, size, position, orientation)


def thing(name, parts, mass=1.0, position=(0.0, 0.0, 0.0), orientation=None, **link):
    model = ObjectModel((Link("body", mass, tuple(parts), **link),), static=mass == 0.0)
    return SceneObject(name, model, position, orientation or (0.0, 0.0, 0.0, 1.0), name)


def cube(name, position, mass=5.0, edge=0.2, **link):
    return thing(name, [box((edge, edge, edge), (0.0, 0.0, edge / 2.0))], mass, position, **link)


def gate(name, position, start):
    """A bar of 0.8 m on a vertical hinge; at 0 it lies along x."""
    post = Link("post", 0.0, (box((0.05, 0.05, 0.3), (0.0, 0.0, 0.15)),))
    bar = Link("bar", 2.0, (box((0.8, 0.04, 0.04), (0.4, 0.0, 0.0)),))
    hinge = Joint(
        "hinge", Motion.HINGE, "post", "bar", (0, 0, 0.1), lower=-1.6, upper=1.6, start=start
    )
    return SceneObject(name, ObjectModel((post, bar), (hinge,), True), position, entry=name)


def inertia_in_pybullet(stage, uid):
    """Mass, centre and inertia tensor of a body's base, in its frame."""
    info = pybullet.getDynamicsInfo(uid, -1, physicsClientId=stage.client)
    turn = rotation_matrix(info[4])
    return info[0], np.array(info[3]), turn @ np.diag(info[2]) @ turn.T


# --- mass ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("solid", "inertia"),
    [
        (box((0.2, 0.4, 0.6)), (0.52 / 12.0, 0.40 / 12.0, 0.20 / 12.0)),
        (part(Form.SPHERE, (0.3, 0.0, 0.0)), (0.4 * 0.09,) * 3),
        (
            part(Form.CYLINDER, (0.2, 0.0, 0.5)),
            ((3 * 0.04 + 0.25) / 12.0, (3 * 0.04 + 0.25) / 12.0, 0.02),
        ),
    ],
)
def test_primitives_have_the_textbooks_inertia_wherever_they_lie(stage, solid, inertia):
    placed = Part(solid.geometry, (0.1, -0.2, 0.3), TURNED)
    tested = stage(thing("it", [placed], mass=3.0, position=(0.0, 0.0, 5.0)))
    mass, center, tensor = inertia_in_pybullet(tested, tested.uid("it"))
    turn = rotation_matrix(TURNED)
    assert mass == pytest.approx(3.0)
    assert center == pytest.approx((0.1, -0.2, 0.3))
    np.testing.assert_allclose(tensor, turn @ np.diag(inertia) @ turn.T * 3.0, atol=1e-9)


def test_two_boxes_weigh_like_the_dumbbell_that_they_are(stage):
    ends = [box((0.2, 0.2, 0.2), (x, 0.0, 0.1)) for x in (-0.5, 0.5)]
    tested = stage(thing("dumbbell", ends, mass=4.0))
    mass, center, tensor = inertia_in_pybullet(tested, tested.uid("dumbbell"))
    own = 2.0 * 0.08 / 12.0
    assert mass == pytest.approx(4.0)
    assert center == pytest.approx((0.0, 0.0, 0.1), abs=1e-12)
    assert np.diag(tensor) == pytest.approx([2 * own, 2 * (own + 0.5), 2 * (own + 0.5)])


def write_mesh(path, triangles):
    lines = [f"v {x} {y} {z}" for x, y, z in triangles.reshape(-1, 3)]
    lines += [f"f {n + 1} {n + 2} {n + 3}" for n in range(0, len(lines), 3)]
    path.write_text("\n".join(lines) + "\n")
    return f"file://{path}"


def corners(size):
    grid = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    return (grid - 0.5) * size


def test_a_mesh_weighs_like_the_box_that_it_is(stage, tmp_path):
    address = write_mesh(tmp_path / "box.obj", convex_hull(corners((0.1, 0.2, 0.3)) + 0.05))
    body = part(Form.MESH, (2.0, 2.0, 2.0), mesh=address)
    tested = stage(thing("mesh", [body], mass=2.0, position=(0.0, 0.0, 0.2)))
    mass, center, tensor = inertia_in_pybullet(tested, tested.uid("mesh"))
    assert (mass, tuple(center)) == (pytest.approx(2.0), pytest.approx((0.1, 0.1, 0.1)))
    assert np.diag(tensor) == pytest.approx([0.52 / 6.0, 0.40 / 6.0, 0.20 / 6.0], rel=1e-5)
    tested.run(1.0)
    # its underside, at 0.1 - 0.3 below the frame, has come to rest on the floor
    assert tested.pose("mesh/body")[0][2] == pytest.approx(0.2, abs=2e-3)


def test_the_hull_of_points():
    size = np.array([1.0, 2.0, 3.0])
    inside = np.random.default_rng(1).random((500, 3)) * size - size / 2.0
    hull = convex_hull(np.concatenate([corners(size), inside]))
    assert mass_properties.closed_surface(hull).mass == pytest.approx(6.0)
    ball = np.random.default_rng(2).normal(size=(5000, 3))
    ball /= np.linalg.norm(ball, axis=1)[:, None]
    hull = convex_hull(ball)
    assert len(np.unique(hull.reshape(-1, 3), axis=0)) <= MOST_VERTICES
    solid = mass_properties.closed_surface(hull)
    assert 0.95 * 4.0 / 3.0 * math.pi < solid.mass < 4.0 / 3.0 * math.pi
    assert solid.center == pytest.approx([0.0, 0.0, 0.0], abs=0.01)


def assert_encloses(hull, points):
    """No point lies outside, and the surface is closed: each edge belongs to two triangles."""
    across = np.cross(hull[:, 1] - hull[:, 0], hull[:, 2] - hull[:, 0])
    doubled = np.linalg.norm(across, axis=1)
    size = np.ptp(points, axis=0).max()
    # Corners on one edge of the body make triangles with hardly an area, which have no direction.
    real = doubled > 1e-6 * size * size
    across = across[real] / doubled[real, None]
    heights = points @ across.T - np.einsum("ij,ij->i", hull[real, 0], across)
    assert heights.max() < 2e-6 * size
    _, number = np.unique(hull.reshape(-1, 3), axis=0, return_inverse=True)
    edges = np.concatenate([number.reshape(-1, 3)[:, pair] for pair in ([0, 1], [1, 2], [2, 0])])
    edges = {(int(a), int(b)) for a, b in edges}
    assert edges == {(b, a) for a, b in edges}


@pytest.mark.parametrize("size", [(1.0, 2.0, 3.0), (0.28, 0.001, 0.014)])
def test_no_point_lies_outside_a_hull_of_few_vertices(size):
    points = np.random.default_rng(1).random((1500, 3)) * size
    hull = convex_hull(points)
    assert len(np.unique(hull.reshape(-1, 3), axis=0)) < MOST_VERTICES
    assert_encloses(hull, points)


def test_points_of_a_grid_many_in_each_plane_have_a_whole_hull():
    for seed in range(150):
        numbers = np.random.default_rng(seed)
        grid = numbers.integers(0, 2 + seed % 8, (200, 3)).astype(float)
        turn, _ = np.linalg.qr(numbers.normal(size=(3, 3)))
        points = grid @ turn + 10.0 * numbers.normal(size=3)
        assert_encloses(convex_hull(points), points)


@pytest.mark.parametrize(
    "points",
    [
        np.zeros((0, 3)),
        np.zeros((9, 3)),
        np.outer(np.arange(5.0), [1.0, 2.0, 3.0]),
        corners((1.0, 1.0, 0.0)),
    ],
)
def test_points_without_a_volume_have_no_hull(points):
    with pytest.raises(FlatError):
        convex_hull(points)


def test_poses_compose_and_turn_back():
    pose = ((1.0, 2.0, 3.0), TURNED)
    position, orientation = compose(pose, invert(pose))
    assert position == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)
    assert abs(orientation[3]) == pytest.approx(1.0)
    assert rotate((0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5)), (1.0, 0.0, 0.0)) == pytest.approx(
        (0.0, 1.0, 0.0)
    )
    axis = (0.0, 0.0, 1.0)
    assert twist((0.0, 0.0, math.sin(0.3), math.cos(0.3)), axis)[2] == pytest.approx(math.sin(0.3))


# --- place ---------------------------------------------------------------------------------------


def test_objects_stand_where_they_were_put(stage):
    tested = stage(thing("it", [box((0.3, 0.2, 0.1), (0.4, 0.0, 0.1))], 2.0, (1, 2, 3), TURNED))
    position, orientation = tested.pose("it/body")
    assert position == pytest.approx((1.0, 2.0, 3.0), abs=1e-6)
    assert orientation == pytest.approx(TURNED, abs=1e-6)


def test_more_shapes_than_pybullet_takes_at_once_all_collide(stage):
    static = thing("wall", [box((0.1, 0.1, 0.5), (0.2 * n, 0.0, 0.25)) for n in range(40)], 0.0)
    posts = [box((0.02, 0.02, 0.3), (0.2 * n, 3.0, 0.15)) for n in range(40)]
    moving = thing("comb", [*posts, box((8.0, 0.05, 0.02), (3.9, 3.0, 0.31))], 20.0)
    tested = stage(static, moving)
    tested.run(tested.step_size)
    for n in range(40):
        for y, top in ((0.0, 0.5), (3.0, 0.32)):
            start, end = (0.2 * n, y, 2.0), (0.2 * n, y, 0.1)
            hit = pybullet.rayTest(start, end, physicsClientId=tested.client)[0]
            assert hit[3][2] == pytest.approx(top, abs=1e-4)
    shares = [
        pybullet.getDynamicsInfo(tested.uid("comb"), link, physicsClientId=tested.client)[0]
        for link in range(-1, pybullet.getNumJoints(tested.uid("comb"), tested.client))
    ]
    assert sum(shares) == pytest.approx(20.0)
    tested.run(1.0)
    assert tested.pose("comb/body")[0][2] == pytest.approx(0.0, abs=2e-3)


def test_each_body_of_a_large_object_is_of_its_material(stage):
    wood = replace(box((0.1, 0.1, 0.5)), surface=Surface(texture="generated:wood"))
    blocks = [replace(wood, position=(0.2 * n, 0.0, 0.25)) for n in range(40)]
    objects = stage(thing("wall", blocks, 0.0), cube("plain", (0.0, 3.0, 0.0))).objects
    assert [objects.material(uid, -1) for uid in objects.bodies_of("wall")] == ["wood"] * 3
    assert objects.material(objects.bodies_of("plain")[0], -1) == ""


def test_static_meshes_collide_as_they_are_and_moving_ones_as_their_hulls(stage, tmp_path):
    # two towers with a gap between them, as one mesh
    towers = np.concatenate(
        [convex_hull(corners((0.2, 0.2, 0.6)) + np.array((x, 0.0, 0.3))) for x in (-0.4, 0.4)]
    )
    address = write_mesh(tmp_path / "towers.obj", towers)
    shape = part(Form.MESH, (1.0, 1.0, 1.0), mesh=address)
    tested = stage(
        thing("static", [shape], 0.0),
        thing("moving", [shape], 9.0, (0.0, 5.0, 0.0)),
        cube("falls", (0.0, 0.0, 1.0), edge=0.2),
        cube("rests", (0.0, 5.0, 1.0), edge=0.2),
    )
    tested.run(2.0)
    assert tested.pose("falls/body")[0][2] == pytest.approx(0.0, abs=5e-3)
    assert tested.pose("rests/body")[0][2] == pytest.approx(0.6, abs=5e-3)


def test_a_mirrored_mesh_keeps_its_outside(stage, tmp_path):
    address = write_mesh(tmp_path / "box.obj", convex_hull(corners((1.0, 1.0, 1.0)) + 0.5))
    tested = stage(thing("it", [part(Form.MESH, (-1.0, 1.0, 1.0), mesh=address)], 0.0))
    hit = pybullet.rayTest((-0.5, 0.5, 3.0), (-0.5, 0.5, 0.5), physicsClientId=tested.client)[0]
    assert hit[3][2] == pytest.approx(1.0, abs=1e-6)
    assert hit[4][2] > 0.9


# --- friction ------------------------------------------------------------------------------------


@pytest.mark.parametrize(("own", "floor", "slides"), [(0.5, 1.0, 0.5), (1.0, 0.3, 0.3)])
def test_friction_is_the_product_of_both_surfaces(stage, own, floor, slides):
    tested = stage(cube("sledge", (0.0, 0.0, 0.0), friction=own), floor=Floor(friction=floor))
    tested.run(0.2)
    uid = tested.uid("sledge")
    pybullet.resetBaseVelocity(uid, (2.0, 0.0, 0.0), (0, 0, 0), physicsClientId=tested.client)
    tested.run(2.0)
    way = tested.pose("sledge/body")[0][0]
    assert way == pytest.approx(2.0**2 / (2.0 * 9.81 * slides), rel=0.02)


def test_rolling_friction_stops_a_ball(stage):
    def ball(name, y, rolling):
        sphere = part(Form.SPHERE, (0.1, 0.0, 0.0), (0.0, 0.0, 0.1))
        return thing(name, [sphere], 1.0, (0.0, y, 0.0), rolling_friction=rolling)

    tested = stage(ball("free", 0.0, 0.0), ball("braked", 1.0, 0.005))
    for name in ("free", "braked"):
        pybullet.resetBaseVelocity(
            tested.uid(name), (0.5, 0.0, 0.0), (0.0, 5.0, 0.0), physicsClientId=tested.client
        )
    tested.run(4.0)
    assert tested.pose("free/body")[0][0] > 1.5
    assert tested.pose("braked/body")[0][0] < 0.8


# --- sleep ---------------------------------------------------------------------------------------


def speed(stage, name):
    velocity = pybullet.getBaseVelocity(stage.uid(name), physicsClientId=stage.client)
    return max(map(abs, velocity[0] + velocity[1]))


def asleep(stage, name):
    """Whether gravity no longer acts: a body that is turned in the air does not fall."""
    pushed = stage.pose(f"{name}/body")[0]
    uid = stage.uid(name)
    for _ in range(20):
        pybullet.applyExternalForce(
            uid, -1, (500.0, 0, 0), pushed, pybullet.WORLD_FRAME, physicsClientId=stage.client
        )
        stage.run(stage.step_size)
    return stage.pose(f"{name}/body")[0] == pushed


def test_a_tower_falls_asleep_and_stays(stage):
    tested = stage(*(cube(f"c{n}", (0.0, 0.0, 0.2 * n)) for n in range(5)))
    tested.run(5.0)
    assert asleep(tested, "c4")
    assert tested.pose("c4/body")[0][2] == pytest.approx(0.8, abs=5e-3)


def test_what_creeps_does_not_fall_asleep(stage):
    tested = stage(cube("sledge", (0.0, 0.0, 0.0), friction=0.0))
    tested.run(0.5)
    uid = tested.uid("sledge")
    pybullet.resetBaseVelocity(uid, (0.01, 0.0, 0.0), (0, 0, 0), physicsClientId=tested.client)
    tested.run(6.0)
    assert tested.pose("sledge/body")[0][0] == pytest.approx(0.06, rel=0.02)


def test_a_tower_whose_support_is_removed_falls(stage):
    tested = stage(*(cube(f"c{n}", (0.0, 0.0, 0.2 * n)) for n in range(4)))
    tested.run(5.0)
    assert tested.objects.remove("c0") == ["c0"]
    tested.run(1.0)
    assert tested.pose("c1/body")[0][2] == pytest.approx(0.0, abs=5e-3)
    assert tested.pose("c3/body")[0][2] == pytest.approx(0.4, abs=1e-2)


def test_what_is_hit_wakes(stage):
    tested = stage(cube("sleeper", (0.0, 0.0, 0.0)))
    tested.run(5.0)
    tested.add(cube("hitting", (-0.5, 0.0, 0.0), mass=20.0))
    uid = tested.uid("hitting")
    pybullet.resetBaseVelocity(uid, (3.0, 0.0, 0.0), (0, 0, 0), physicsClientId=tested.client)
    tested.run(1.0)
    assert tested.pose("sleeper/body")[0][0] > 0.1


# --- coming and going ----------------------------------------------------------------------------


def test_objects_come_and_go_without_a_trace(stage):
    tested = stage(cube("first", (0.0, 0.0, 0.0)))
    bodies = pybullet.getNumBodies(physicsClientId=tested.client)
    for _ in range(3):
        tested.add(cube("second", (1.0, 0.0, 0.0)), cube("third", (2.0, 0.0, 0.0)))
        assert tested.objects.frames() == ["first/body", "second/body", "third/body"]
        tested.run(0.05)
        tested.objects.remove("second")
        tested.objects.remove("third")
    assert tested.objects.frames() == ["first/body"]
    assert pybullet.getNumBodies(physicsClientId=tested.client) == bodies
    assert tested.objects.remove("second") == []


def test_equal_shapes_are_made_once(stage, tmp_path, monkeypatch):
    address = write_mesh(tmp_path / "box.obj", convex_hull(corners((1.0, 1.0, 1.0))))
    tested = stage()
    made = []
    for name in ("createCollisionShape", "createCollisionShapeArray"):
        real = getattr(pybullet, name)
        monkeypatch.setattr(
            pybullet, name, lambda *a, real=real, **k: made.append(real(*a, **k)) or made[-1]
        )
    shape = part(Form.MESH, (1.0, 1.0, 1.0), mesh=address)
    for _ in range(5):
        tested.add(thing("exact", [shape], 0.0, (5, 0, 0)), thing("hull", [shape], 2.0, (0, 0, 2)))
        tested.add(cube("a", (9, 0, 0)), cube("b", (8, 0, 0), mass=1.0))
        tested.run(0.01)
        for name in ("exact", "hull", "a", "b"):
            tested.objects.remove(name)
    assert len(made) == 3


def test_a_name_that_is_taken_is_refused_and_nothing_comes(stage):
    tested = stage(cube("first", (0.0, 0.0, 0.0)))
    with pytest.raises(ConfigError, match="name is 'first'; an object of this name exists"):
        tested.add(cube("new", (1.0, 0.0, 0.0)), cube("first", (2.0, 0.0, 0.0)))
    assert tested.objects.frames() == ["first/body"]


def test_an_object_in_a_robot_is_refused_and_nothing_comes(stage):
    tested = stage(cube("robot", (0.0, 0.0, 0.0)))
    robot = tested.uid("robot")
    before = pybullet.getNumBodies(physicsClientId=tested.client)
    with pytest.raises(ConfigError, match="'inside' would stand in the robot"):
        tested.add(cube("far", (3, 0, 0)), cube("inside", (0.1, 0, 0)), robots=(robot,))
    assert pybullet.getNumBodies(physicsClientId=tested.client) == before
    with pytest.raises(ConfigError, match="'opens' would stand in the robot"):
        tested.add(gate("opens", (0.0, 0.8, 0.0), start=-1.5), robots=(robot,))
    tested.add(gate("shut", (0.0, 0.8, 0.0), start=0.0), robots=(robot,))
    tested.objects.remove("shut")
    tested.add(cube("beside", (0.2, 0.0, 0.0)), robots=(robot,))
    assert tested.objects.frames() == ["robot/body", "beside/body"]


def test_a_refused_object_never_pushes_the_robot(stage):
    tested = stage(cube("robot", (0.0, 0.0, 0.0)))
    tested.run(0.5)
    robot, before = tested.uid("robot"), tested.pose("robot/body")
    posts = [box((0.05, 0.05, 0.5), (0.2 * n, 0.0, 0.25)) for n in range(40)]
    fence = thing("fence", posts, 0.0, (-4.0, 0.0, 0.0))

    def add(items):
        for _ in tested.objects.add(tested.plan(*items), (robot,)):
            tested.run(tested.step_size)

    for items in (
        (cube("inside", (0.1, 0.0, 0.0)),),
        (cube("far", (3.0, 0.0, 0.0)), gate("opens", (0.0, 0.8, 0.0), start=-1.5)),
        (cube("over", (0.0, 0.0, 0.2)), fence),
        (fence, cube("in_it", (-4.0, 0.0, 0.0))),
    ):
        with pytest.raises(ConfigError, match="would stand in the robot|stand in each other"):
            add(items)
        tested.run(0.1)
        assert tested.objects.frames() == ["robot/body"]
        assert np.subtract(tested.pose("robot/body")[0], before[0]) == pytest.approx(0.0, abs=1e-5)


def test_what_moves_is_whole_before_it_is_stepped(stage):
    tested = stage()
    wall = thing("wall", [box((0.1, 0.1, 0.5), (0.2 * n, 3.0, 0.25)) for n in range(40)], 0.0)
    bodies = []
    for _ in tested.objects.add(
        tested.plan(gate("gate", (0.0, 0.0, 0.0), 0.5), cube("on_top", (9.0, 0.0, 0.2)), wall), ()
    ):
        bodies.append(pybullet.getNumBodies(physicsClientId=tested.client))
        tested.run(tested.step_size)
        assert tested.objects.frames() == []
    assert bodies == [2, 3, 4]
    assert tested.objects.joint_position("gate", "hinge") == pytest.approx(0.5, abs=1e-9)
    assert tested.pose("on_top/body")[0][2] == pytest.approx(0.2, abs=1e-6)


def test_an_object_that_pybullet_refuses_leaves_nothing_behind(stage, monkeypatch):
    tested = stage(cube("first", (0.0, 0.0, 0.0)))
    before = pybullet.getNumBodies(physicsClientId=tested.client)
    made = []
    create = pybullet.createMultiBody

    def refuse_the_third(*values, **named):
        made.append(None)
        if len(made) == 3:
            raise pybullet.error("no more")
        return create(*values, **named)

    monkeypatch.setattr(pybullet, "createMultiBody", refuse_the_third)
    wall = thing("wall", [box((0.1, 0.1, 0.5), (0.2 * n, 3.0, 0.25)) for n in range(40)], 0.0)
    with pytest.raises(ConfigError, match="object 'wall': PyBullet cannot make it: no more"):
        tested.add(cube("second", (1.0, 0.0, 0.0)), wall)
    assert pybullet.getNumBodies(physicsClientId=tested.client) == before
    assert tested.objects.frames() == ["first/body"]


def test_no_more_objects_than_the_limit(stage, monkeypatch):
    assert MOST_OBJECTS == 1000
    monkeypatch.setattr("telex_sim.scene.objects.bodies.MOST_OBJECTS", 3)
    tested = stage(cube("a", (0, 0, 0)), cube("b", (1, 0, 0)))
    with pytest.raises(ConfigError, match="there are 2 objects; at most 3 are possible"):
        tested.add(cube("c", (2, 0, 0)), cube("d", (3, 0, 0)))
    tested.add(cube("c", (2, 0, 0)))


def test_a_large_scene_behaves_like_its_parts(stage):
    blocks = [
        thing(f"block{n}", [box((0.3, 0.3, 0.3), (0, 0, 0.15))], 0.0, (n % 10, n // 10, 0.0))
        for n in range(100)
    ]
    cubes = [cube(f"cube{n}", (n % 10, n // 10, 0.35)) for n in range(30)]
    tested = stage(*blocks, *cubes)
    tested.run(3.5)
    for n in range(30):
        x, y, z = tested.pose(f"cube{n}/body")[0]
        assert (x, y, z) == pytest.approx((n % 10, n // 10, 0.3), abs=5e-3)
    assert all(asleep(tested, f"cube{n}") for n in (0, 29))


def test_equal_worlds_stay_bit_identical_through_spawn_and_delete(stage):
    def run():
        tested = stage(*(cube(f"c{n}", (0.02 * n, 0.0, 0.25 * n)) for n in range(5)))
        tested.run(0.7)
        tested.add(cube("late", (0.05, 0.03, 1.5)))
        tested.run(0.7)
        tested.objects.remove("c0")
        tested.run(1.0)
        return tested.objects.poses()

    assert run() == run()
