"""Things that stand in each other are refused, and named."""

from __future__ import annotations

import re

import pytest

from telex_control.common.params import ConfigError
from telex_sim.engine.world import WorldError
from telex_sim.scene.command_line import main as scene_command
from telex_sim.scene.files.scene_file import SceneError
from telex_sim.scene.library import object_types
from telex_sim.scene.objects.assembly import MOST_AT_ONCE

pytestmark = pytest.mark.slow

NEED_MORE = ("custom", "mesh")
CRATE = "{{type: crate, name: {name}, position: [{x}, {y}, {z}]}}"


def crate(name, x=5.0, y=0.0, z=0.0):
    return CRATE.format(name=name, x=x, y=y, z=z)


@pytest.fixture
def scene(tmp_path):
    def write(*entries):
        path = tmp_path / "yard.yaml"
        path.write_text("objects:\n" + "".join(f"  - {entry}\n" for entry in entries))
        return str(path)

    return write


def test_two_hundred_in_one_place_are_refused_and_ten_pairs_are_named(robot, scene, capsys):
    tested = robot()
    world = scene(*[crate(f"c{number}") for number in range(200)])
    before = tested.simulation.link_poses()
    with pytest.raises(SceneError, match="stand in each other: 'c0' and 'c1'") as caught:
        tested.simulation.change_scene(tested.simulation.plan_scene(world))
    assert len(re.findall(r"'c\d+' and 'c\d+' \(400 mm\)", str(caught.value))) == 10
    assert "and more" in str(caught.value)
    assert tested.simulation.link_poses() == before
    # The same is said where it would be the first scene, and by `scene check`.
    with pytest.raises(WorldError, match="stand in each other: 'c0' and 'c1'"):
        robot(world=world)
    for options in ([], ["--no-robot"]):
        assert scene_command(["check", world, *options]) == 1
        assert "stand in each other: 'c0' and 'c1'" in capsys.readouterr().err


def test_five_millimetres_are_allowed(robot, scene):
    for gap, fits in ((-0.004, True), (-0.006, False)):
        world = scene(crate("low"), crate("high", z=0.4 + gap))
        if fits:
            robot(world=world)
        else:
            with pytest.raises(WorldError, match=r"'low' and 'high' \(6 mm\)|'high' and 'low'"):
                robot(world=world)


def test_single_spawns_do_not_add_up(robot):
    simulation = robot().simulation
    simulation.spawn(simulation.plan(crate("first")))
    simulation.spawn(simulation.plan(crate("beside", x=5.7)))
    frames = simulation.objects.frames()
    for entry in (crate("second"), "{type: platform, name: wall, position: [5, 0, 0]}"):
        with pytest.raises(ConfigError, match="stand in each other: '(second|wall)' and 'first'"):
            simulation.spawn(simulation.plan(entry))
    assert simulation.objects.frames() == frames


def test_what_stands_fast_may_stand_in_what_stands_fast(robot):
    simulation = robot().simulation
    simulation.spawn(simulation.plan("{type: platform, name: a, position: [5, 0, 0]}"))
    simulation.spawn(simulation.plan("{type: platform, name: b, position: [5, 0.1, 0]}"))


def test_the_floor_carries_and_holds_nothing(robot):
    simulation = robot().simulation
    with pytest.raises(ConfigError, match="'sunk' and the floor"):
        simulation.spawn(simulation.plan(crate("sunk", z=-0.1)))


def test_every_type_by_its_defaults_has_room(robot):
    simulation = robot().simulation
    for kind in object_types():
        if kind not in NEED_MORE:
            simulation.spawn(simulation.plan(f"{{type: {kind}, name: it, position: [0, 60, 0]}}"))
            simulation.delete("it")


def test_a_large_mesh_comes_body_by_body_between_steps(robot, tmp_path):
    side = 130
    places = [(x, y) for x in range(side) for y in range(side)]
    lines = [f"v {0.02 * x} {0.02 * y} {0.05 * ((x * y) % 2)}" for x, y in places]
    for x in range(side - 1):
        for y in range(side - 1):
            corner = x * side + y + 1
            lines += [f"f {corner} {corner + side} {corner + 1}"]
            lines += [f"f {corner + 1} {corner + side} {corner + side + 1}"]
    (tmp_path / "hill.obj").write_text("\n".join(lines))
    tested = robot()
    simulation = tested.simulation
    text = "{type: mesh, name: hill, mesh: hill.obj, static: true, position: [5, 0, 0]}"
    plans = simulation.plan(text, "", str(tmp_path))
    sizes = [len(body.segments[0].shapes[0].triangles) for body in plans[0].bodies]
    assert sum(sizes) == 2 * (side - 1) ** 2
    assert max(sizes) <= MOST_AT_ONCE
    made = []
    for _ in simulation.spawn_gradually(plans):
        made.append(len(simulation.world.bodies()))
        simulation.step()
    assert len(set(made)) == len(sizes) > 5
    simulation.spawn(simulation.plan(crate("on_it", x=6.0, y=1.0, z=0.1)))
    tested.run(0.5)
    assert 0.03 < simulation.objects.poses()[2] < 0.06
