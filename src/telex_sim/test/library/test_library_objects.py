"""The library's objects in physics: they rest, and they move as their parameters say."""

from __future__ import annotations

import math
from pathlib import Path

import pybullet
import pytest

from telex_control.common.geometry.quaternions import rotate
from telex_sim.scene.files.scene_file import build_entry
from telex_sim.scene.objects.latches import wake


def build(type_name, name="it", **given):
    return build_entry({"type": type_name, **given}, Path("/"), name)


def twist(stage, name, link, torque, seconds):
    """Turn a link about its world axis by a torque (N m)."""

    # What sleeps does not feel it.
    wake(stage.client, stage.uid(name))

    def push():
        pybullet.applyExternalTorque(
            stage.uid(name), link, torque, pybullet.WORLD_FRAME, physicsClientId=stage.client
        )

    stage.run(seconds, push)


def pull(stage, uid, link, force, at, seconds):
    """Pull at a point of the world (N, m)."""

    wake(stage.client, uid)

    def push():
        pybullet.applyExternalForce(
            uid, link, force, at, pybullet.WORLD_FRAME, physicsClientId=stage.client
        )

    stage.run(seconds, push)


FREE = ["crate", "pallet", "bin", "barrel", "briefcase", "cube", "cylinder", "bottle", "cone",
        "source_capsule", "sphere", "plate"]  # fmt: skip


class TestRest:
    @pytest.mark.parametrize("kind", FREE)
    def test_what_stands_on_the_floor_stays_there(self, stage, kind):
        made = stage(*build(kind))
        frame = made.objects.frames()[0]
        made.run(1.0)
        (x, y, z), (qx, qy, _, _) = made.pose(frame)
        assert math.dist((x, y, z), (0.0, 0.0, 0.0)) < 5e-4
        assert math.hypot(qx, qy) < 1e-3

    def test_a_stack_of_pallets_stands_and_is_half_a_metre_high(self, stage):
        made = stage(*build("pallet_stack"))
        made.run(3.0)
        for index in range(4):
            (x, y, z), _ = made.pose(f"it_{index + 1}/pallet")
            assert math.dist((x, y, z), (0.0, 0.0, 0.125 * index)) < 1e-3
        ((_, _, _, top, _),) = pybullet.rayTest((0, 0, 2), (0, 0, 0), physicsClientId=made.client)
        assert top[2] == pytest.approx(0.5, abs=1e-3)

    def test_a_lying_pipe_stays_when_nothing_pushes_it(self, stage):
        made = stage(*build("pipe"))
        made.run(1.0)
        assert math.dist(made.pose("it/pipe")[0], (0.0, 0.0, 0.0)) < 1e-3

    @pytest.mark.parametrize("lid", ["free", "hinged"])
    def test_a_lid_lies_on_its_pot(self, stage, lid):
        made = stage(*build("source_container", lid=lid))
        frame = "it_lid/lid" if lid == "free" else "it/lid"
        before = made.pose(frame)[0]
        made.run(2.0)
        assert math.dist(before, made.pose(frame)[0]) < 1e-3

    def test_a_capsule_goes_into_the_pot(self, stage):
        made = stage(
            *build("source_container", lid="none"),
            *build("source_capsule", "capsule", position=[0.0, 0.0, 0.1]),
        )
        made.run(1.0)
        x, y, z = made.pose("capsule/capsule")[0]
        assert z == pytest.approx(0.2 * 0.28, abs=1e-3)
        assert math.hypot(x, y) < 0.06

    def test_a_bin_holds_what_falls_into_it(self, stage):
        made = stage(*build("bin"), *build("cube", "cube", position=[0.05, 0.05, 0.3]))
        made.run(1.0)
        x, y, z = made.pose("cube/cube")[0]
        assert abs(x) < 0.2
        assert abs(y) < 0.15
        assert z == pytest.approx(0.008, abs=2e-3)

    def test_things_lie_on_a_table_a_shelf_and_in_a_drawer(self, stage):
        made = stage(
            *build("table", "table", position=[0.0, 3.0, 0.0], height=0.6),
            *build("cube", "on_table", position=[0.0, 3.0, 0.6]),
            *build("shelf", "shelf", position=[0.0, -3.0, 0.0], height=1.4),
            *build("cube", "on_shelf", position=[0.0, -3.0, 0.55]),
            *build("drawers", "drawers", opened=[0.0, 0.0, 0.3]),
            *build("cube", "in_drawer", position=[-0.3, 0.0, 0.55]),
        )
        made.run(1.0)
        assert made.pose("on_table/cube")[0][2] == pytest.approx(0.6, abs=1e-3)
        assert made.pose("on_shelf/cube")[0][2] == pytest.approx(0.55, abs=1e-3)
        # Two drawers' pitch of 0.24, the cabinet's bottom, the slide and the drawer's own bottom.
        assert made.pose("in_drawer/cube")[0][2] == pytest.approx(0.507, abs=2e-3)
        assert made.objects.joint_position("drawers", "drawer_3_slide") == pytest.approx(
            0.3, abs=1e-3
        )


class TestHandles:
    def free_below(self, stage, x, y, low, high):
        """Whether a pad fits between two heights across a bar along x."""
        return all(
            pybullet.rayTest((x, y - 0.3, z), (x, y + 0.3, z), physicsClientId=stage.client)[0][0]
            < 0
            for z in (low, 0.5 * (low + high), high)
        )

    def test_fingers_fit_under_the_handle_of_a_briefcase(self, stage):
        made = stage(*build("briefcase"))
        made.run(0.01)
        for x in (-0.06, 0.0, 0.06):
            assert self.free_below(made, x, 0.0, 0.335, 0.375)
        ((uid, _, _, _, _),) = pybullet.rayTest(
            (0.0, -0.3, 0.39), (0.0, 0.3, 0.39), physicsClientId=made.client
        )
        assert uid >= 0

    def test_a_briefcase_can_be_lifted_by_its_handle(self, stage):
        made = stage(*build("briefcase"))
        pull(made, made.uid("it"), -1, (0.0, 0.0, 5.5 * 9.81), (0.0, 0.0, 0.39), 0.5)
        assert made.pose("it/case")[0][2] > 0.05


class TestValve:
    def test_it_turns_above_its_friction_and_stays_below(self, stage):
        made = stage(*build("valve", friction=8.0))
        # The wheel looks towards -x: its axis is -x.
        twist(made, "it", 0, (-7.6, 0.0, 0.0), 1.0)
        assert made.objects.joint_position("it", "wheel_hinge") == pytest.approx(0.0, abs=1e-3)
        twist(made, "it", 0, (-8.6, 0.0, 0.0), 1.0)
        turned = made.objects.joint_position("it", "wheel_hinge")
        assert turned > 0.5
        made.run(1.0)
        rest = made.objects.joint_position("it", "wheel_hinge")
        made.run(0.5)
        assert made.objects.joint_position("it", "wheel_hinge") == pytest.approx(rest, abs=1e-4)

    def test_a_level_wheel_looks_up(self, stage):
        made = stage(*build("valve", facing="up", height=0.7, friction=2.0))
        twist(made, "it", 0, (0.0, 0.0, 2.5), 1.0)
        assert made.objects.joint_position("it", "wheel_hinge") > 0.3

    def test_a_lever_points_up_and_turns_as_a_wheel_does(self, stage):
        made = stage(*build("valve", handle="lever", radius=0.2, friction=8.0))
        ((uid, link, _, _, _),) = pybullet.rayTest(
            (-0.5, 0.0, 0.98), (0.0, 0.0, 0.98), physicsClientId=made.client
        )
        assert (uid, link) == (made.uid("it"), 0)
        twist(made, "it", 0, (-7.6, 0.0, 0.0), 0.5)
        assert made.objects.joint_position("it", "wheel_hinge") == pytest.approx(0.0, abs=1e-3)
        twist(made, "it", 0, (-8.6, 0.0, 0.0), 0.5)
        assert made.objects.joint_position("it", "wheel_hinge") > 0.5


class TestWedge:
    def test_it_weighs_and_balances_as_the_wood_that_is_seen(self, stage):
        made = stage(*build("wedge", length=0.12, width=0.06, height=0.06))
        mass, _, moments, center, *_ = pybullet.getDynamicsInfo(
            made.uid("it"), -1, physicsClientId=made.client
        )
        assert mass == pytest.approx(700.0 * 0.5 * 0.12 * 0.06 * 0.06)
        middle, _ = pybullet.getBasePositionAndOrientation(
            made.uid("it"), physicsClientId=made.client
        )
        assert middle == pytest.approx((0.02, 0.0, 0.02), abs=1e-3)
        # Of a triangle with legs a and b about its own middle: (a^2 + b^2) / 18.
        about_y = mass * (0.12**2 + 0.06**2) / 18.0
        assert min(abs(moment / about_y - 1.0) for moment in moments) < 0.02

    def test_its_slope_can_be_touched_where_it_is_seen(self, stage):
        made = stage(*build("wedge"))
        ((uid, _, _, point, _),) = pybullet.rayTest(
            (0.03, 0.0, 0.2), (0.03, 0.0, 0.0), physicsClientId=made.client
        )
        assert uid == made.uid("it")
        # PyBullet lets convex meshes be felt 1 mm before their faces.
        assert point[2] == pytest.approx(0.045 + 1e-3 * math.sqrt(1.25), abs=1e-4)

    def test_it_stays_where_it_stands(self, stage):
        made = stage(*build("wedge"))
        made.run(1.0)
        (x, y, z), _ = made.pose("it/wedge")
        assert math.hypot(x, y) < 5e-4
        assert z == pytest.approx(1e-3, abs=1e-4)


class TestLever:
    def test_it_rests_in_its_notches_and_leaves_them_only_when_pushed(self, stage):
        made = stage(*build("lever"))
        made.run(1.0)
        assert made.objects.joint_position("it", "lever_hinge") == pytest.approx(-0.7, abs=0.02)
        twist(made, "it", 0, (0.0, 2.0, 0.0), 0.5)
        made.run(0.5)
        assert made.objects.joint_position("it", "lever_hinge") == pytest.approx(-0.7, abs=0.02)
        twist(made, "it", 0, (0.0, 6.0, 0.0), 0.5)
        made.run(1.0)
        assert made.objects.joint_position("it", "lever_hinge") == pytest.approx(0.7, abs=0.02)
        knob = rotate(made.pose("it/lever")[1], (-0.16, 0.0, 0.0))
        assert knob[2] == pytest.approx(0.16 * math.sin(0.7), abs=3e-3)


class TestConnector:
    def plug(self, made):
        return made.pose("it/plug")[0]

    def test_the_latch_holds_the_plug_until_it_is_pulled_harder(self, stage):
        made = stage(*build("connector", hold=60.0))
        made.run(0.5)
        start = self.plug(made)
        pull(made, made.uid("it", -1), -1, (-50.0, 0.0, 0.0), start, 0.5)
        assert math.dist(start, self.plug(made)) < 2e-3
        pull(made, made.uid("it", -1), -1, (-75.0, 0.0, 0.0), start, 0.3)
        made.run(1.0)
        assert self.plug(made)[0] < start[0] - 0.03

    @pytest.mark.parametrize("kind", ["rotate_panel", "extract_panel"])
    @pytest.mark.parametrize("height", [0.1, 1.5])
    def test_caps_stay_as_they_are(self, stage, kind, height):
        made = stage(*build(kind, height=height))
        before = [made.pose(frame)[0] for frame in made.objects.frames()]
        made.run(1.0)
        for frame, place in zip(made.objects.frames(), before):
            assert math.dist(place, made.pose(frame)[0]) < 1e-3

    def test_a_cap_turns_by_half_a_turn(self, stage):
        made = stage(*build("rotate_panel", friction=0.5))
        twist(made, "it", 0, (-0.4, 0.0, 0.0), 0.5)
        assert made.objects.joint_position("it", "cap_1_hinge") == pytest.approx(0.0, abs=1e-3)
        twist(made, "it", 0, (-0.7, 0.0, 0.0), 2.0)
        assert made.objects.joint_position("it", "cap_1_hinge") == pytest.approx(math.pi, abs=0.02)

    def test_an_extracted_cap_goes_into_a_hole_of_the_tray(self, stage):
        made = stage(
            *build("place_panel", height=0.8, count=1),
            *build("cylinder", "peg", radius=0.025, length=0.12, position=[0.002, 0.0, 0.78]),
        )
        made.run(1.0)
        assert made.pose("peg/cylinder")[0][2] == pytest.approx(0.74, abs=2e-3)


class TestTouchPanel:
    def test_a_block_gives_way_on_its_spring_and_comes_back(self, stage):
        made = stage(*build("touch_panel", count=1, travel=0.02, spring=1000.0))
        uid, place = made.uid("it"), (-0.12, 0.0, 0.8)
        for force, way in ((3.0, 0.0), (14.0, 0.01), (100.0, 0.02), (0.0, 0.0)):
            pull(made, uid, 0, (force, 0.0, 0.0), place, 1.0)
            position = made.objects.joint_position("it", "block_1_slide")
            assert position == pytest.approx(way, abs=1e-3)

    def test_it_stands_fast_without_travel(self):
        (item,) = build("touch_panel")
        assert item.model.joints == ()


DOORS = [("left", "push"), ("left", "pull"), ("right", "push"), ("right", "pull")]


class TestDoor:
    def width(self, made, x, z=0.3):
        """Clear width at a place along x, as the robot would find it (m)."""
        right = pybullet.rayTest((x, 0.0, z), (x, -3.0, z), physicsClientId=made.client)[0]
        left = pybullet.rayTest((x, 0.0, z), (x, 3.0, z), physicsClientId=made.client)[0]
        return left[3][1] - right[3][1]

    @pytest.mark.parametrize(("hinges", "opening"), DOORS)
    def test_it_stays_shut_and_closes_from_wherever_it_is(self, stage, hinges, opening):
        shut = stage(*build("door", hinges=hinges, opening=opening))
        shut.run(1.0)
        assert shut.objects.joint_position("it", "leaf_hinge") == pytest.approx(0.0, abs=2e-3)
        wide = stage(*build("door", hinges=hinges, opening=opening, start=1.2))
        wide.run(8.0)
        assert wide.objects.joint_position("it", "leaf_hinge") == pytest.approx(0.0, abs=0.01)

    @pytest.mark.parametrize(("hinges", "opening"), DOORS)
    def test_it_opens_to_the_side_that_is_said_and_lets_the_robot_through(
        self, stage, hinges, opening
    ):
        made = stage(
            *build("door", hinges=hinges, opening=opening, start=1.75, closer_torque=0.0,
                   closer_stiffness=0.0)
        )  # fmt: skip
        made.run(0.1)
        assert self.width(made, 0.0) >= 0.9
        away = 1.0 if opening == "push" else -1.0
        side = 1.0 if hinges == "left" else -1.0
        # The leaf stands on the side to which it opens, next to its hinges.
        for x, found in ((0.5 * away, True), (-0.5 * away, False)):
            ray = pybullet.rayTest(
                (x, 0.0, 1.0), (x, 2.0 * side, 1.0), physicsClientId=made.client
            )[0]
            assert (ray[0] >= 0) == found

    def test_a_push_opens_it_and_a_light_one_does_not(self, stage):
        made = stage(*build("door"))
        uid = made.uid("it")
        edge = (0.0, -0.4, 1.0)
        pull(made, uid, 0, (8.0, 0.0, 0.0), edge, 1.0)
        assert made.objects.joint_position("it", "leaf_hinge") < 0.03
        pull(made, uid, 0, (60.0, 0.0, 0.0), edge, 1.5)
        assert made.objects.joint_position("it", "leaf_hinge") > 0.3

    @pytest.mark.parametrize("hinges", ["left", "right"])
    def test_the_handle_goes_down_and_springs_back(self, stage, hinges):
        made = stage(*build("door", hinges=hinges))
        made.run(0.3)
        assert made.objects.joint_position("it", "handle_hinge") == pytest.approx(0.0, abs=0.02)
        side = 1.0 if hinges == "left" else -1.0
        # Downwards at the end of the lever, which points to the hinges.
        twist(made, "it", 1, (-2.5 * side, 0.0, 0.0), 0.5)
        assert made.objects.joint_position("it", "handle_hinge") > 0.6
        made.run(1.0)
        assert made.objects.joint_position("it", "handle_hinge") == pytest.approx(0.0, abs=0.02)


class TestDrawers:
    def test_a_drawer_comes_out_when_it_is_pulled_and_stops_at_its_end(self, stage):
        made = stage(*build("drawers", friction=6.0))
        uid = made.uid("it")
        pull(made, uid, 1, (-5.0, 0.0, 0.0), (-0.3, 0.0, 0.5), 0.5)
        assert made.objects.joint_position("it", "drawer_2_slide") == pytest.approx(0.0, abs=1e-3)
        pull(made, uid, 1, (-12.0, 0.0, 0.0), (-0.3, 0.0, 0.5), 2.0)
        assert made.objects.joint_position("it", "drawer_2_slide") == pytest.approx(0.4, abs=0.01)
        assert made.pose("it/drawer_2")[0][0] == pytest.approx(-0.4, abs=0.01)
        assert made.objects.joint_position("it", "drawer_1_slide") == pytest.approx(0.0, abs=1e-3)
