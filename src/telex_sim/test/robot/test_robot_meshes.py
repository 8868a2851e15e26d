"""A robot's files: what is only seen never keeps the first robot from starting."""

from __future__ import annotations

import pytest

from telex_control.common.params import ConfigError
from telex_sim.engine.world import World
from telex_sim.robot import meshes as robot_meshes
from telex_sim.robot.meshes import check_meshes
from telex_sim.scene.addresses import resolve_address

ROBOT = """<robot name="r"><link name="base">{}<visual><geometry><mesh filename="{}"/></geometry>
</visual></link></robot>"""
TOUCHED = '<collision><geometry><mesh filename="{}"/></geometry></collision>'


def resolve(address):
    if address.startswith("model:"):
        raise ValueError(f"'{address}' has no known scheme")
    return address


@pytest.fixture
def plate(tmp_path):
    path = tmp_path / "plate.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 2 3 4\nf 1 3 4\n")
    return str(path)


@pytest.mark.parametrize("seen", ["model://r/base.dae", "/nowhere/base.dae"])
def test_what_is_only_seen_is_told_at_start_and_refused_later(seen, plate):
    urdf = ROBOT.format(TOUCHED.format(plate), seen)
    told = []
    check_meshes(urdf, resolve, told.append)
    assert len(told) == 1
    assert "link 'base'" in told[0]
    assert seen in told[0]
    with pytest.raises(ConfigError, match="link 'base'"):
        check_meshes(urdf, resolve)


def test_the_world_loads_a_robot_whose_visuals_have_no_usable_address(plate, closing):
    world = closing(Holder)().world
    urdf = ROBOT.format(TOUCHED.format(plate), "model://r/base.dae")
    assert world.load_robot(urdf, resolve, (0.0, 0.0, 1.0), 0.0, {}).base_link == "base"


class Holder:
    def __init__(self):
        self.world = World(0.002, 50)


def test_a_file_to_collide_by_that_is_missing_is_refused_at_start_too():
    with pytest.raises(ConfigError, match="link 'base': /nowhere/a.obj: No such file"):
        check_meshes(ROBOT.format(TOUCHED.format("/nowhere/a.obj"), ""), resolve, lambda said: None)


def test_an_address_that_no_file_can_have_is_named(plate):
    def find(address):
        return resolve_address(address, str)

    said = "link 'base': 'file:///a%00.obj': no file's name has %00"
    with pytest.raises(ConfigError, match=said):
        check_meshes(ROBOT.format(TOUCHED.format("file:///a%00.obj"), ""), find, lambda _: None)
    told = []
    urdf = ROBOT.format(TOUCHED.format(f"file://{plate}"), "file:///a%00.obj")
    check_meshes(urdf, find, told.append)
    assert told == [said]


def test_triangles_count_at_each_use_and_a_file_is_read_once(plate, monkeypatch):
    monkeypatch.setattr(robot_meshes, "MOST_COLLISION_TRIANGLES", 11)
    read = []
    real = robot_meshes.load_mesh
    monkeypatch.setattr(robot_meshes, "load_mesh", lambda path: read.append(path) or real(path))
    told = []
    check_meshes(ROBOT.format(TOUCHED.format(plate) * 3, ""), resolve, told.append)
    assert len(read) == 1
    assert "have 12 triangles in all; at most 11" in told[0]
    with pytest.raises(ConfigError, match="at most 11 are possible in a robot"):
        check_meshes(ROBOT.format(TOUCHED.format(plate) * 3, ""), resolve)
