"""Stairs, obstacles, mazes and tunnels have the dimensions that their parameters say.

Most are measured with rays in the physics, since that is what the robot drives on.
"""

from __future__ import annotations

import math
from collections import deque
from pathlib import Path

import pybullet
import pytest

from telex_sim.scene.files.scene_file import build_entry
from telex_sim.scene.library.building.tunnel import Niche, Tunnel
from telex_sim.scene.library.shapes import along_bend
from telex_sim.scene.library.terrain.maze import Maze, perfect_maze
from telex_sim.scene.library.terrain.stairs import Stairs
from telex_sim.scene.library.terrain.stepfield import Stepfield


def build(type_name, **given):
    return build_entry({"type": type_name, **given}, Path("/"), "it")


class Probe:
    """Measures a scene with rays."""

    def __init__(self, stage):
        self.client = stage.client

    def hit(self, start, end):
        """Where a ray hits first, or None."""
        ((uid, _, _, place, _),) = pybullet.rayTest(start, end, physicsClientId=self.client)
        return place if uid >= 0 else None

    def height(self, x, y=0.0):
        """Of what stands at a place (m)."""
        return self.hit((x, y, 10.0), (x, y, -1.0))[2]


@pytest.fixture
def probe(stage):
    return lambda type_name, **given: Probe(stage(*build(type_name, **given)))


class TestStairs:
    @pytest.mark.parametrize(
        ("rise", "run", "steps"),
        [(0.17, 0.28, 8), (0.18, 0.28, 8), (0.20, 0.2325, 5), (0.2, 0.2, 6)],
    )
    def test_every_tread_has_rise_and_run_up_and_down(self, probe, rise, run, steps):
        landing = 1.2
        measure = probe(
            "stairs",
            rise=rise,
            run=run,
            steps=steps,
            landing=landing,
            form="up_and_down",
            railings="none",
        )
        half = (steps - 1) * run + landing / 2.0
        for step in range(1, steps):
            for way in (-1.0, 1.0):
                nosing = way * (half - (step - 1) * run)
                for inside in (0.002, run - 0.002):
                    height = measure.height(nosing - way * inside)
                    assert height == pytest.approx(step * rise, abs=1e-4)
        for x in (-landing / 2.0 + 0.002, 0.0, landing / 2.0 - 0.002):
            assert measure.height(x) == pytest.approx(steps * rise, abs=1e-4)
        for x in (-half - 0.002, half + 0.002):
            assert measure.height(x) == pytest.approx(0.0, abs=1e-4)

    def test_they_are_as_wide_as_they_are_said_to_be(self, probe):
        measure = probe("stairs", width=0.9, railings="none")
        assert measure.height(1.5, 0.449) == pytest.approx(1.36, abs=1e-4)
        assert measure.height(1.5, 0.451) == pytest.approx(0.0, abs=1e-4)

    def test_flights_have_landings_between_them(self):
        stairs = Stairs(rise=0.15, run=0.3, steps=3, flights=2, landing=1.0)
        lengths = [round(end - start, 9) for start, end, _ in stairs.treads()]
        assert lengths == [0.3, 0.3, 1.0, 0.3, 0.3, 1.0]
        assert stairs.height == pytest.approx(0.9)

    def test_a_single_step_with_railings_can_be_built(self):
        assert build("stairs", steps=1, form="up_and_down", landing=0.2)

    def test_railings_leave_the_width_free(self, probe):
        measure = probe("stairs", width=1.2, railings="both")
        for share in (-0.5, 0.5):
            assert measure.height(-0.2, share) < 1.4
        assert measure.hit((-2.0, -0.5, 1.9), (2.0, -0.5, 1.9)) is None


class TestObstacles:
    @pytest.mark.parametrize("gap", [0.1, 0.6])
    def test_a_gap_is_as_wide_as_it_is_said_to_be(self, probe, gap):
        measure = probe("gap", gap=gap, height=0.2)
        for side in (-1.0, 1.0):
            assert measure.height(side * (gap / 2.0 + 0.001)) == pytest.approx(0.2, abs=1e-4)
            assert measure.height(side * (gap / 2.0 - 0.001)) == pytest.approx(0.0, abs=1e-4)

    @pytest.mark.parametrize("height", [0.1, 0.3, 0.5])
    @pytest.mark.parametrize("edge", ["square", "pipe"])
    def test_a_hurdle_is_as_high_as_it_is_said_to_be(self, probe, height, edge):
        measure = probe("hurdle", height=height, edge=edge, length=0.6)
        assert measure.height(0.0) == pytest.approx(height, abs=1e-4)
        front = measure.hit((-2.0, 0.0, height - 0.035), (2.0, 0.0, height - 0.035))
        assert front[0] == pytest.approx(-0.3, abs=1e-3)

    def test_the_pipes_of_a_hurdle_roll_freely(self, stage):
        made = stage(*build("hurdle", edge="pipe", height=0.3))
        uid = made.uid("it")
        for _ in range(500):
            # Half a newton at the pipe's radius.
            pybullet.applyExternalTorque(
                uid, 0, (0.0, 0.5 * 0.035, 0.0), pybullet.WORLD_FRAME, physicsClientId=made.client
            )
            made.run(0.002)
        assert abs(made.objects.joint_position("it", "front_axle")) < 1e-6
        for _ in range(500):
            pybullet.applyExternalTorque(
                uid, 0, (0.0, 2.0 * 0.035, 0.0), pybullet.WORLD_FRAME, physicsClientId=made.client
            )
            made.run(0.002)
        assert abs(made.objects.joint_position("it", "front_axle")) > 2.0


class TestSlopes:
    @pytest.mark.parametrize("degrees", [15, 30, 45])
    def test_a_plane_rises_evenly_at_its_angle_from_the_floor(self, probe, degrees):
        angle = math.radians(degrees)
        measure = probe("inclined_plane", angle=angle, length=2.4, platform=1.2)
        run = 2.4 * math.cos(angle)
        foot = -(run + 1.2) / 2.0
        for x in (0.01, 0.3, 0.5 * run, run - 0.01):
            for y in (-1.1, 0.0, 1.1):
                height = measure.height(foot + x, y)
                assert height == pytest.approx(x * math.tan(angle), abs=1e-3)
        assert measure.height(foot + run + 0.6) == pytest.approx(2.4 * math.sin(angle), abs=1e-3)

    def test_nothing_drives_in_beneath(self, probe):
        measure = probe("ramp", length=2.0, height=0.6, width=1.0)
        for x in (0.0, 0.4, 0.8):
            slope = 0.3 * (x + 1.0)
            place = measure.hit((x, -2.0, 0.5 * slope), (x, 2.0, 0.5 * slope))
            assert place is not None
            assert place[1] == pytest.approx(-0.5, abs=1e-3)

    def test_crossing_ramps_meet_without_a_step_along_each_column(self, probe):
        measure = probe("crossing_ramps", pattern="crossing", rows=4, columns=2)
        heights = {}
        for y in (-0.3, 0.3):
            heights[y] = [measure.height(-3.2 + 0.05 * index, y) for index in range(129)]
            steps = [abs(b - a) for a, b in zip(heights[y], heights[y][1:])]
            assert max(steps) < 0.05 * math.tan(math.radians(15.0)) + 2e-3
            assert max(heights[y]) == pytest.approx(1.2 * math.tan(math.radians(15.0)), abs=0.01)
        # Somewhere one column is up where the other is down: the robot rolls.
        assert max(abs(a - b) for a, b in zip(heights[-0.3], heights[0.3])) > 0.3

    def test_continuous_ramps_rise_together(self, probe):
        measure = probe("crossing_ramps", pattern="continuous", rows=4, columns=2)
        for x in (-2.0, -1.2, 0.4, 1.9):
            assert measure.height(x, -0.3) == pytest.approx(measure.height(x, 0.3), abs=1e-6)


class TestStepfield:
    def test_every_post_is_as_high_as_the_plan_says(self, probe):
        measure = probe("stepfield", pattern="diagonal", seed=4)
        (rows,) = Stepfield(pattern="diagonal", seed=4).heights()
        for row, levels in enumerate(rows):
            for column, level in enumerate(levels):
                x, y = (row - 4.5) * 0.1, (column - 4.5) * 0.1
                assert measure.height(x, y) == pytest.approx(level * 0.1, abs=1e-4)

    @pytest.mark.parametrize("pattern", ["flat", "hill", "diagonal"])
    def test_a_seed_gives_one_field_and_another_gives_another(self, pattern):
        first = Stepfield(pattern=pattern, pallets=2, seed=7).heights()
        assert first == Stepfield(pattern=pattern, pallets=2, seed=7).heights()
        assert first != Stepfield(pattern=pattern, pallets=2, seed=8).heights()
        assert first[0] != first[1]

    def test_patterns_have_their_shape(self):
        (flat,) = Stepfield(pattern="flat", seed=2).heights()
        assert {level for row in flat for level in row} == {1, 2}
        (hill,) = Stepfield(pattern="hill", seed=2).heights()
        assert sum(hill[4] + hill[5]) > 2 * sum(hill[0] + hill[9])
        (diagonal,) = Stepfield(pattern="diagonal", seed=2).heights()
        assert sum(diagonal[i][i] for i in range(10)) > 30
        assert diagonal[0][9] + diagonal[9][0] <= 4


class TestMaze:
    @pytest.mark.parametrize("seed", [1, 2, 3])
    @pytest.mark.parametrize("size", [(1, 1), (4, 3), (8, 8)])
    def test_one_way_leads_from_any_cell_to_any_other(self, size, seed):
        columns, rows = size
        passages = perfect_maze(columns, rows, seed)
        assert len(passages) == columns * rows - 1
        seen, waiting = {(0, 0)}, deque([(0, 0)])
        while waiting:
            column, row = waiting.popleft()
            for cell in (
                (column + 1, row),
                (column - 1, row),
                (column, row + 1),
                (column, row - 1),
            ):
                if frozenset(((column, row), cell)) in passages and cell not in seen:
                    seen.add(cell)
                    waiting.append(cell)
        assert len(seen) == columns * rows

    def test_a_seed_gives_one_maze(self):
        assert perfect_maze(6, 6, 5) == perfect_maze(6, 6, 5)
        assert perfect_maze(6, 6, 5) != perfect_maze(6, 6, 6)
        # The same on every machine: whoever trained in it finds it again.
        ways = sorted(tuple(sorted(passage)) for passage in perfect_maze(3, 2, 1))
        assert ways == [
            ((0, 0), (1, 0)), ((0, 1), (1, 1)), ((1, 0), (1, 1)),
            ((1, 1), (2, 1)), ((2, 0), (2, 1)),
        ]  # fmt: skip

    def test_walls_stand_where_there_is_no_passage_and_nowhere_else(self, probe):
        maze = Maze(columns=4, rows=3, seed=7)
        measure = probe("maze", columns=4, rows=3, seed=7)
        passages = perfect_maze(4, 3, 7)

        def middle(column, row):
            return ((column - 1.5) * maze.pitch, (row - 1.0) * maze.pitch, 0.5)

        for column in range(4):
            for row in range(3):
                for other in ((column + 1, row), (column, row + 1)):
                    if other[0] < 4 and other[1] < 3:
                        free = measure.hit(middle(column, row), middle(*other)) is None
                        assert free == (frozenset(((column, row), other)) in passages)
        assert measure.hit(middle(-1, 0), middle(0, 0)) is None
        assert measure.hit(middle(3, 2), middle(4, 2)) is None
        for outside, inside in (((-1, 1), (0, 1)), ((-1, 2), (0, 2)), ((3, 0), (4, 0))):
            assert measure.hit(middle(*outside), middle(*inside)) is not None
        for column in range(4):
            assert measure.hit(middle(column, -1), middle(column, 0)) is not None
            assert measure.hit(middle(column, 2), middle(column, 3)) is not None

    def test_corridors_are_1_2_m_wide(self, probe):
        measure = probe("maze", columns=1, rows=1)
        right = measure.hit((0.0, 0.0, 0.5), (0.0, -3.0, 0.5))
        left = measure.hit((0.0, 0.0, 0.5), (0.0, 3.0, 0.5))
        assert left[1] - right[1] == pytest.approx(1.2, abs=1e-3)


class TestTunnel:
    NICHE = {"at": 2.0, "side": "right", "width": 1.2, "height": 2.1, "depth": 1.5}

    @pytest.mark.parametrize("radius", [0.0, 25.0, -25.0])
    def test_walls_stand_beside_the_centre_line(self, probe, radius):
        measure = probe("tunnel", length=20.0, radius=radius, width=3.6, niches=[self.NICHE])
        # Between two cuts a flat panel lies at most this far inside the bend.
        sagitta = 2.0**2 / (8.0 * 23.0) if radius else 0.0
        for along in (-9.5, -6.3, -2.0, 0.1, 5.0, 9.0):
            x, y, heading = along_bend(along, 0.0, radius)
            for side in (-1.0, 1.0):
                aside = (-side * math.sin(heading), side * math.cos(heading))
                end = (x + 5.0 * aside[0], y + 5.0 * aside[1], 1.0)
                wall = measure.hit((x, y, 1.0), end)
                distance = math.hypot(wall[0] - x, wall[1] - y)
                assert 1.8 - sagitta - 0.01 < distance < 1.8 + sagitta + 0.01
            top = measure.hit((x, y, 1.0), (x, y, 6.0))
            assert top[2] == pytest.approx(3.4, abs=0.02)

    @pytest.mark.parametrize("radius", [0.0, 25.0, -25.0])
    def test_a_niche_is_open_and_as_deep_and_wide_as_it_is_said_to_be(self, probe, radius):
        measure = probe("tunnel", length=20.0, radius=radius, width=3.6, niches=[self.NICHE])
        x, y, heading = along_bend(2.0, 0.0, radius)
        along = (math.cos(heading), math.sin(heading))
        aside = (math.sin(heading), -math.cos(heading))

        def place(forward, right):
            return (
                x + forward * along[0] + right * aside[0],
                y + forward * along[1] + right * aside[1],
                1.0,
            )

        back = measure.hit(place(0.0, 0.0), place(0.0, 6.0))
        depth = math.hypot(back[0] - x, back[1] - y)
        assert depth == pytest.approx(1.8 + 1.5, abs=0.02)
        ends = [measure.hit(place(0.0, 2.6), place(way * 3.0, 2.6)) for way in (-1.0, 1.0)]
        assert math.dist(*ends) == pytest.approx(1.2, abs=0.03)

    def test_closed_ends_are_closed(self, probe):
        measure = probe("tunnel", length=10.0, closed="end")
        assert measure.hit((0.0, 0.5, 1.0), (8.0, 0.5, 1.0))[0] == pytest.approx(5.0, abs=0.01)
        assert measure.hit((0.0, 0.5, 1.0), (-8.0, 0.5, 1.0)) is None

    def test_places_follow_the_bend(self):
        tunnel = Tunnel(length=30.0, radius=40.0, niches=(Niche(0.0),))
        x, y, heading = tunnel.place(10.0, 1.0)
        # 1 m nearer to the centre of the bend, which lies 40 m to the left.
        assert math.hypot(x, y - 40.0) == pytest.approx(39.0)
        assert heading == pytest.approx(0.25)


def test_a_beam_line_follows_the_bend_of_its_tunnel():
    elements = ["pipe", "dipole", "pump", "quadrupole", "pipe"]
    items = build("beam_line", elements=elements, radius=20.0, position=[0.0, 1.0, 0.0])
    assert [item.name for item in items] == [
        "it_pipe_1", "it_dipole_1", "it_pump_1", "it_quadrupole_1", "it_pipe_2",
    ]  # fmt: skip
    for item in items:
        x, y, _ = item.position
        assert math.hypot(x, y - 21.0) == pytest.approx(20.0, abs=1e-6)
        yaw = 2.0 * math.atan2(item.orientation[2], item.orientation[3])
        assert yaw == pytest.approx(math.atan2(x, 21.0 - y), abs=1e-6)
