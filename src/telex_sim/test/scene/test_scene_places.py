"""Where things stand in a scene, and moving them there."""

from __future__ import annotations

import math

import numpy as np
import pybullet
import pytest

from telex_control.common.geometry.quaternions import IDENTITY, about
from telex_control.common.params import ConfigError
from telex_sim.engine.world import World
from telex_sim.scene.assets import Assets
from telex_sim.scene.model import Floor
from telex_sim.scene.objects.bodies import SceneBodies
from telex_sim.scene.objects.outlines import extent, outline
from telex_sim.scene.objects.places import first_hit, standing_height, steady
from telex_sim.scene.planning import plan_entry

STEP = 0.002
DOWN = (0.0, 0.0, -1.0)
TABLE = "{type: table, name: table, position: [2, 0, 0], height: 0.7}"
RAMP = "{type: ramp, name: ramp, position: [-3, 0, 0], length: 2.0, height: 0.6}"


class Yard:
    """A world with a floor and what it is given."""

    def __init__(self, *entries):
        self.world = World(STEP, 50)
        self.client = self.world.client
        self.objects = SceneBodies(self.client, STEP)
        self.objects.load(Floor(), (), lambda done, count: None)
        for entry in entries:
            self.put(entry)

    def plan(self, entry):
        taken = [item.name for item in self.objects.objects()]
        return plan_entry(entry, "", "", taken, Assets(), STEP)

    def put(self, entry):
        for _ in self.objects.add(self.plan(entry), []):
            pass

    def run(self, seconds):
        for _ in range(round(seconds / STEP)):
            self.objects.apply()
            self.world.step()

    def place(self, name):
        item = next(each for each in self.objects.objects() if each.name == name)
        return self.objects.link_pose(name, item.model.links[0].name)

    def height(self, entry, x, y, yaw=0.0):
        """Height at which something stands where a look from above meets something."""
        hit = first_hit(self.client, (x, y, 3.0), DOWN)
        corners = extent(self.plan(entry), IDENTITY)
        return standing_height(self.client, corners, hit.point, about((0, 0, 1), yaw))


@pytest.fixture
def yard():
    made = []

    def make(*entries):
        made.append(Yard(*entries))
        return made[-1]

    yield make
    for each in made:
        each.world.close()


@pytest.mark.parametrize(
    "kind", ["crate", "cube", "pallet", "cone", "barrel", "sphere", "table", "briefcase", "valve"]
)
def test_what_is_put_somewhere_stands_on_what_is_there_and_stays(yard, kind):
    there = yard(TABLE.replace("0.7", "0.7, length: 3.0, width: 3.0"))
    height, _ = there.height(f"{{type: {kind}}}", 2.0, 0.3, yaw=0.6)
    assert height == pytest.approx(0.7, abs=0.01)
    there.put(f"{{type: {kind}, name: it, position: [2.0, 0.3, {height}], yaw: 0.6}}")
    there.run(0.5)
    assert there.place("it")[0] == pytest.approx((2.0, 0.3, 0.7), abs=0.02)


def test_a_slope_carries_by_its_highest_point_and_nothing_stands_in_it(yard):
    there = yard(RAMP)
    height, _ = there.height("{type: crate, size: [0.4, 0.4, 0.2]}", -3.0, 0.0)
    level = first_hit(there.client, (-3.0, 0.0, 3.0), DOWN).point[2]
    assert level + 0.03 < height < level + 0.1
    there.put(f"{{type: crate, size: [0.4, 0.4, 0.2], name: it, position: [-3, 0, {height}]}}")


def test_under_a_table_it_stands_on_the_floor(yard):
    there = yard(TABLE)
    hit = first_hit(there.client, (0.0, 0.0, 0.5), (2.0, 0.0, -0.5))
    corners = extent(there.plan("{type: cube, edge: 0.1}"), IDENTITY)
    height, _ = standing_height(there.client, corners, hit.point, IDENTITY[1])
    assert height == pytest.approx(0.001, abs=1e-6)


def test_a_long_thing_that_is_turned_is_no_square(yard):
    there = yard("{type: platform, name: step, position: [0.9, -0.9, 0], length: 0.4, width: 0.4}")
    wall = "{type: wall, length: 3.0}"
    assert there.height(wall, 0.0, 0.0, math.pi / 4)[0] == pytest.approx(0.001, abs=1e-6)
    assert there.height(wall, 0.0, 0.0, -math.pi / 4)[0] > 0.1


def test_a_thing_does_not_stand_on_itself(yard):
    there = yard("{type: crate, name: box, size: [0.4, 0.4, 0.4]}")
    (assembly,) = there.objects.assemblies()
    own = there.objects.bodies_of("box")
    place = (0.1, 0.0, 0.2)
    height, bodies = standing_height(
        there.client, extent([assembly], IDENTITY), place, IDENTITY[1], own
    )
    assert height == pytest.approx(0.001, abs=1e-6)
    assert not bodies & set(own)


def test_a_moved_thing_is_at_rest_where_it_was_put_and_what_lay_on_it_falls(yard):
    there = yard(
        "{type: crate, name: box, position: [0, 0, 0], size: [0.4, 0.4, 0.4]}",
        "{type: cube, name: top, position: [0, 0, 0.4]}",
    )
    there.run(3.0)  # both sleep
    there.objects.move("box", ((1.0, 1.0, 0.001), about((0, 0, 1), 0.5)), [])
    assert there.place("box")[0] == pytest.approx((1.0, 1.0, 0.001), abs=1e-6)
    there.run(1.0)
    position, orientation = there.place("box")
    assert position == pytest.approx((1.0, 1.0, 0.0), abs=5e-3)
    assert 2.0 * math.asin(orientation[2]) == pytest.approx(0.5, abs=0.01)
    assert there.place("top")[0][2] < 0.1


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_what_latches_hold_one_on_another_goes_with_it(yard, order):
    links = ", ".join(
        f"{{name: {name}, mass: 1.0, parts: [{{box: [0.1, 0.1, 0.1]}}]}}" for name in "abc"
    )
    latches = [
        f"{{name: {parent}{child}, motion: latch, parent: {parent}, child: {child}, "
        "position: [0, 0, 0.1], hold: 500.0}"
        for parent, child in ("ab", "bc")
    ]
    joints = ", ".join(latches[number] for number in order)
    there = yard(
        "{type: custom, name: pile, position: [0, 0, 0.05], "
        f"links: [{links}], joints: [{joints}]}}"
    )
    there.objects.move("pile", ((2.0, 0.0, 0.05), IDENTITY[1]), [])
    for height, link in enumerate("abc"):
        position = there.objects.link_pose("pile", link)[0]
        assert position == pytest.approx((2.0, 0.0, 0.05 + 0.1 * height), abs=1e-6)


def test_a_place_that_is_taken_is_refused_and_nothing_has_changed(yard):
    there = yard(
        "{type: crate, name: box, position: [0, 0, 0]}",
        "{type: crate, name: other, position: [1, 0, 0]}",
        TABLE,
    )
    there.run(0.1)
    body = there.objects.bodies_of("box")[0]
    pybullet.resetBaseVelocity(body, (0.1, 0, 0), (0, 0, 0), physicsClientId=there.client)
    before = there.place("box")
    with pytest.raises(ConfigError, match="'box' and 'other'|'other' and 'box'"):
        there.objects.move("box", ((1.1, 0.0, 0.0), IDENTITY[1]), [])
    with pytest.raises(ConfigError, match=r"stand in each other: .*floor"):
        there.objects.move("box", ((3.0, 3.0, -0.1), IDENTITY[1]), [])
    with pytest.raises(ConfigError, match="'box' would stand in the robot"):
        there.objects.move("box", ((1.1, 0.0, 0.1), IDENTITY[1]), there.objects.bodies_of("other"))
    assert np.array(there.place("box")[0]) == pytest.approx(before[0], abs=1e-9)
    speed = pybullet.getBaseVelocity(body, physicsClientId=there.client)[0]
    assert speed == pytest.approx((0.1, 0.0, 0.0), abs=1e-9)
    with pytest.raises(ConfigError, match="name is 'table'; it stands fast"):
        there.objects.move("table", ((4.0, 0.0, 0.0), IDENTITY[1]), [])
    with pytest.raises(ConfigError, match="name is 'nothing'; there is no such object"):
        there.objects.move("nothing", IDENTITY, [])


@pytest.mark.parametrize(
    ("pose", "message"),
    [
        (((math.nan, 0, 0), (0, 0, 0, 1)), "position is .nan"),
        (((0, math.inf, 0), (0, 0, 0, 1)), "position is"),
        (((0, 41, 0), (0, 0, 0, 1)), "at most 40 m"),
        (((0, 0, 0), (0, 0, 0, 0)), "orientation is .0, 0, 0, 0.; a quaternion"),
        (((0, 0, 0), (0, 0, math.nan, 1)), "orientation is"),
    ],
)
def test_a_pose_that_is_none_is_refused(pose, message):
    with pytest.raises(ConfigError, match=message):
        steady(pose, 40.0)


def test_a_ray_that_is_none_is_refused(yard):
    there = yard()
    assert first_hit(there.client, (0, 0, 1), (0, 0, 1)) is None
    for direction in ((0, 0, 0), (math.nan, 0, 1), (math.inf, 0, 0)):
        with pytest.raises(ConfigError, match="a direction that has a length"):
            first_hit(there.client, (0, 0, 1), direction)


def test_an_outline_is_in_the_world_for_what_stands_fast_else_in_its_own_frame(yard):
    there = yard(TABLE, "{type: crate, name: box, position: [5, 5, 0], size: [0.4, 0.2, 0.3]}")
    table, box = map(outline, there.objects.assemblies())
    assert table.frame == "world"
    assert (table.bottom, table.top) == pytest.approx((0.0, 0.7), abs=1e-6)
    corners = np.concatenate(table.polygons)
    assert corners.mean(axis=0) == pytest.approx((2.0, 0.0), abs=0.05)
    assert box.frame.startswith("box/")
    assert np.abs(np.concatenate(box.polygons)).max(axis=0) == pytest.approx((0.2, 0.1), abs=1e-3)
