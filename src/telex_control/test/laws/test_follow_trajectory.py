"""Paths, how fast they are run along, the references for them, and what is made of a recording."""

from __future__ import annotations

import json
import math
import struct
from dataclasses import replace

import numpy as np
import pytest
from telex_msgs.msg import Proximity, ProximityPair, SimStatus

from telex_control.follow_trajectory import FollowTrajectoryError, command_line, report, table
from telex_control.follow_trajectory.analysis import PathRecording, TrackingResult, analyse, overdue
from telex_control.follow_trajectory.command_line import parse, tool_path
from telex_control.follow_trajectory.follower import approach, follow
from telex_control.follow_trajectory.paths import (
    Path,
    Shape,
    circle,
    figure_8,
    from_csv,
    square,
)
from telex_control.follow_trajectory.reference import plan
from telex_control.follow_trajectory.speed_profile import SpeedProfile
from telex_control.follow_trajectory.watch import MotionWatch
from telex_control.kinematics import Chain, IKSolver
from telex_control.step_response.runner import StepError

# ---- paths


def test_a_spiral_is_as_long_and_as_wide_as_geometry_says():
    shape = Shape(radius=0.15, height=0.3, turns=3.0, centre=(0.8, 0.1, 0.5))
    path = circle(shape)
    assert path.length == pytest.approx(math.hypot(2.0 * math.pi * 0.15 * 3.0, 0.3), rel=1e-6)
    assert path.stops == ()
    assert np.hypot(path.points[:, 0] - 0.8, path.points[:, 1] - 0.1) == pytest.approx(0.15)
    assert path.points[[0, -1], 2] == pytest.approx([0.35, 0.65])


def test_equal_lengths_are_equal_ways_on_every_curve():
    for path in (circle(Shape(turns=2.0)), figure_8(Shape()), square(Shape(height=0.2))):
        lengths = np.linspace(0.0, path.length, 2001)
        ways = np.linalg.norm(np.diff(path.position(lengths), axis=0), axis=1)
        smooth = ways[~np.isclose(ways, path.length / 2000, rtol=1e-3)]
        # Only where a step leads round a corner it is shorter.
        assert len(smooth) <= len(path.stops)


def test_a_square_stops_at_its_corners_and_a_rise_keeps_its_shape():
    path = square(Shape(radius=0.1, plane="xz", centre=(0.7, 0.2, 0.4)))
    assert path.length == pytest.approx(0.8)
    assert path.stops == pytest.approx((0.2, 0.4, 0.6))
    assert path.points[:, 1] == pytest.approx(0.2)
    risen = square(Shape(radius=0.1, plane="xz", height=0.1))
    assert (risen.points[0, 1], risen.points[-1, 1]) == pytest.approx((-0.05, 0.05))


def test_a_figure_of_eight_crosses_itself_in_its_centre():
    path = figure_8(Shape(radius=0.2, plane="yz", centre=(0.8, 0.0, 0.5)))
    assert path.position(np.array([0.0, path.length / 2, path.length])) == pytest.approx(
        np.tile((0.8, 0.0, 0.5), (3, 1)), abs=1e-4
    )
    assert np.ptp(path.points, axis=0) == pytest.approx((0.0, 0.4, 0.2), abs=1e-6)


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"radius": 0.0}, "radius is 0.0"),
        ({"radius": math.nan}, "radius is nan"),
        ({"turns": -1.0}, "turns is -1.0"),
        ({"height": math.inf}, "height and centre must be finite"),
        ({"plane": "ab"}, "plane is 'ab'; xy, xz, yz"),
    ],
)
def test_impossible_shapes_are_refused(change, named):
    with pytest.raises(FollowTrajectoryError, match=named):
        Shape(**change)


def test_points_of_a_file_make_a_path_with_its_corners(tmp_path):
    file = tmp_path / "way.csv"
    file.write_text("x,y,z\n# a hook\n0,0,0\n0.1,0,0\n\n0.1,0,0\n0.1, 0.1 ,0\n")
    path = from_csv(file, (1.0, 2.0, 3.0))
    assert path.points == pytest.approx(
        np.array([[1.0, 2.0, 3.0], [1.1, 2.0, 3.0], [1.1, 2.1, 3.0]])
    )
    assert path.stops == pytest.approx((0.1,))


@pytest.mark.parametrize("shape", [circle, square, figure_8])
@pytest.mark.parametrize("turns", [1e8, 1e308])
def test_a_shape_that_would_take_all_memory_is_refused(shape, turns):
    named = "turns is 1e.*, radius is 0.15 and height is 0: .* points; at most 2000000 are possible"
    with pytest.raises(FollowTrajectoryError, match=named):
        shape(Shape(turns=turns))
    with pytest.raises(FollowTrajectoryError, match=r"height is 1e\+09"):
        circle(Shape(height=1e9))


def test_a_file_may_begin_with_a_byte_order_mark(tmp_path):
    file = tmp_path / "way.csv"
    for text in ("0,0,0\n0.1,0,0\n", "x,y,z\n0,0,0\n0.1,0,0\n"):
        file.write_text(text, encoding="utf-8-sig")
        assert from_csv(file).points == pytest.approx(np.array([[0, 0, 0], [0.1, 0, 0]]))


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("nan,0,0\n1,0,0\n2,0,0\n", "line 1 is 'nan,0,0'"),
        ("O.1,0,0\n1,0,0\n2,0,0\n", "line 1 is 'O.1,0,0'"),
        ("time,x,y,z\n1,0,0\n2,0,0\n", "line 1 is 'time,x,y,z'"),
        ("0,0,0\n", "has 1 points"),
        ("0,0,0\n1,2\n", r"way.csv, line 2 is '1,2'; x, y, z \(m\) are needed"),
        ("0,0,0\n1,nan,2\n", "line 2"),
        ("0,0,0\n0,0,0\n", "0.000 mm long"),
    ],
)
def test_a_wrong_file_is_refused_with_its_line(tmp_path, text, named):
    file = tmp_path / "way.csv"
    file.write_text(text)
    with pytest.raises(FollowTrajectoryError, match=named):
        from_csv(file)
    with pytest.raises(FollowTrajectoryError, match="gone.csv"):
        from_csv(tmp_path / "gone.csv")


# ---- speed


@pytest.mark.parametrize(("length", "stops"), [(1.0, ()), (0.01, ()), (0.5, (0.1, 0.105, 0.4))])
def test_a_path_is_run_along_within_speed_and_acceleration_from_rest_to_rest(length, stops):
    profile = SpeedProfile(length, stops, 0.05, 0.1)
    step = 1e-3
    times = np.arange(-0.1, profile.duration + 0.1, step)
    behind = profile.length(times)
    speed = np.diff(behind) / step
    assert (behind[0], behind[-1]) == pytest.approx((0.0, length), abs=1e-9)
    assert speed.min() > -1e-9
    assert speed.max() <= 0.05 + 1e-9
    assert np.abs(np.diff(speed) / step).max() <= 0.1 + 1e-6
    for stop in stops:
        at = np.searchsorted(behind, stop)
        assert speed[at - 1] < 1e-3, "it rests at a corner"


def test_a_long_way_takes_its_time_at_the_whole_speed():
    profile = SpeedProfile(1.0, (), 0.05, 0.1)
    assert profile.duration == pytest.approx(1.0 / 0.05 + 0.05 / 0.1)
    with pytest.raises(FollowTrajectoryError, match="speed is 0"):
        SpeedProfile(1.0, (), 0.0, 0.1)


@pytest.mark.parametrize(
    ("speed", "acceleration", "stops"),
    [
        (1e-6, 0.1, ()),
        (5e-324, 0.1, ()),
        (0.05, 1e-9, ()),
        (0.05, 5e-324, ()),
        (0.05, 2e-6, [0.01 * each for each in range(1, 100)]),
    ],
)
def test_a_way_that_takes_longer_than_an_hour_is_refused(speed, acceleration, stops):
    named = rf"speed is {speed:g} and acceleration is {acceleration:g}: .* at most 3600 s"
    with pytest.raises(FollowTrajectoryError, match=named):
        SpeedProfile(1.0, stops, speed, acceleration)


# ---- references

ARM = """
<robot name="arm">
  <link name="base"/><link name="a"/><link name="b"/><link name="c"/><link name="d"/>
  <link name="tool"/>
  <joint name="yaw" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" velocity="1" effort="9"/></joint>
  <joint name="reach" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="1 0 0"/>
    <origin xyz="0.3 0 0"/><limit lower="0" upper="0.6" velocity="0.5" effort="9"/></joint>
  <joint name="lift" type="prismatic"><parent link="b"/><child link="c"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="1" velocity="0.5" effort="9"/></joint>
  <joint name="wrist" type="revolute"><parent link="c"/><child link="tool"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" velocity="2" effort="9"/></joint>
  <joint name="rest" type="fixed"><parent link="tool"/><child link="d"/></joint>
</robot>
"""
SEED = [0.0, 0.3, 0.5, 0.0]


@pytest.fixture(scope="module")
def chain():
    return Chain.from_urdf(ARM, "base", "tool")


def planned(chain, path, speed=0.1, acceleration=0.2, period=0.01):
    profile = SpeedProfile(path.length, path.stops, speed, acceleration)
    return plan(IKSolver(chain), path, profile, np.eye(3), SEED, period)


def test_references_lead_the_tool_along_the_path(chain):
    path = circle(Shape(radius=0.1, height=0.2, turns=1.5, centre=(0.6, 0.0, 0.5)))
    motion = planned(chain, path)
    times = motion.period * np.arange(len(motion.references))
    places = np.array([chain.forward(q.tolist())[:3, 3] for q in motion.references])
    assert np.abs(places - motion.tool(times)).max() < 3e-5
    assert places[-1] == pytest.approx(path.points[-1], abs=3e-5)
    steps = np.abs(np.diff(motion.references, axis=0)).max(axis=0) / motion.period
    assert (steps <= chain.velocity_limits + 1e-9).all()
    # Between two references, before the start and after the end.
    assert motion.reference(0.005) == pytest.approx(motion.references[:2].mean(axis=0))
    assert motion.reference(-1.0) == pytest.approx(motion.references[0])
    assert motion.reference(1e3) == pytest.approx(motion.references[-1])


def test_a_path_that_leaves_the_workspace_is_refused_before_anything_moves(chain):
    with pytest.raises(
        FollowTrajectoryError, match=r"start of the path, \(2.100.*cannot be reached"
    ):
        planned(chain, circle(Shape(radius=0.1, centre=(2.0, 0.0, 0.5))))
    with pytest.raises(FollowTrajectoryError, match="cannot be followed at .*reach at its limit"):
        planned(chain, Path([[0.6, 0.0, 0.5], [1.2, 0.0, 0.5]]))
    with pytest.raises(FollowTrajectoryError, match="at its limit.*less speed"):
        planned(chain, Path([[0.6, 0.0, 0.1], [0.6, 0.0, 0.9]]), speed=0.8, acceleration=5.0)


class FakeRig:
    """Joints that follow their references late, by a pure delay."""

    def __init__(self, joints, delay, known):
        self._delay, self._known = delay, known
        self._now = dict(zip(joints, SEED))
        self.joints = joints

    def reference(self, joint):
        return self._now[joint]

    position = reference

    def lag(self):
        return self._known

    def wait(self, seconds):
        pass

    def stream(self, references, end):
        times = np.arange(0.0, end + 0.0101, 0.01)
        positions = []
        for time in times:
            late = references(max(time - self._delay, -self._delay))
            positions.append([late[joint] for joint in self.joints])
        self._now = dict(references(end))
        return PathRecording(times, np.array(positions))


def test_a_known_lag_is_made_good_and_an_unknown_one_is_told(chain):
    motion = planned(chain, circle(Shape(radius=0.1, centre=(0.6, 0.0, 0.5))))
    for known, behind in ((0.04, 0.0), (0.0, 0.04)):
        rig = FakeRig(chain.joint_names, 0.04, known)
        approach(rig, motion, motion.start)
        figures = analyse("circle", motion, follow(rig, motion)).figures
        assert figures.delay == pytest.approx(behind, abs=1e-3)
        times = np.arange(0.0, motion.profile.duration, 0.01)
        speed = np.diff(motion.profile.length(times)) / 0.01
        assert figures.rms == pytest.approx(behind * np.sqrt(np.mean(speed**2)), abs=1e-4)


def test_an_arm_that_is_held_does_not_start(chain):
    motion = planned(chain, circle(Shape(radius=0.1, centre=(0.6, 0.0, 0.5))))
    rig = FakeRig(chain.joint_names, 0.0, 0.0)
    rig.position = lambda joint: 0.0
    with pytest.raises(FollowTrajectoryError, match="reach is .* from .*something holds it"):
        approach(rig, motion, motion.start)


# ---- what ends a motion early


def near(distance, closing, contact=ProximityPair.GUARDED):
    pair = ProximityPair(contact=contact, link="gripper_link", other="floor")
    pair.distance, pair.closing_speed = distance, closing
    return Proximity(pairs=[pair])


def test_the_arm_stops_before_what_it_would_run_into():
    watch = MotionWatch(clearance=0.005)
    for harmless in (
        near(0.001, -0.1),  # away from it
        near(0.001, 0.0),
        near(0.030, 0.1),  # there is time
        near(0.001, 0.1, ProximityPair.TOUCHABLE),
    ):
        watch.on_proximity(harmless)
        assert watch.reason is None
    watch.on_proximity(near(0.024, 0.1))
    assert "gripper_link is 24 mm from floor and nears it by 100 mm/s" in watch.reason
    watch.on_proximity(near(0.001, 0.2))
    assert "24 mm" in watch.reason, "the first reason is what counts"


def test_unguarded_it_goes_on_and_a_reset_ends_it_all_the_same():
    watch = MotionWatch(clearance=None)
    watch.on_proximity(near(0.0, 1.0))
    watch.on_status(SimStatus(resets=3))
    watch.on_status(SimStatus(resets=3))
    assert watch.reason is None
    watch.on_status(SimStatus(resets=4))
    assert "was reset on the way" in watch.reason


# ---- figures and files


def result():
    times = np.linspace(0.0, 10.0, 501)
    desired = np.stack([0.05 * times, 0.0 * times, 0.3 + 0.0 * times], axis=-1)
    measured = desired + np.array([-0.001, 0.0, 0.002])
    measured[100] += (0.0, 0.004, 0.0)
    return TrackingResult("straight on", times, desired, measured)


def test_figures_are_those_of_the_distance_at_each_time():
    figures = result().figures
    assert figures.rms_by_axis[0] == pytest.approx(0.001)
    assert figures.largest_by_axis == pytest.approx((0.001, 0.004, 0.002))
    assert figures.largest == pytest.approx(math.sqrt(1 + 16 + 4) * 1e-3)
    assert figures.rms == pytest.approx(math.sqrt(5e-6 + 16e-6 / 501), rel=1e-6)
    assert figures.delay == pytest.approx(0.02)
    assert (figures.length, figures.duration) == pytest.approx((0.5, 10.0))


def test_a_reference_is_overdue_from_when_it_was_due_until_it_is_held():
    due = [0.00, 0.01, 0.02, 0.03, 0.04, 0.05]
    sent = [0.1, 0.2, 0.3, 0.4, 0.4, 0.4]
    looks = [
        (-0.01, 0.0),  # before the start
        (0.002, 0.0),
        (0.006, 0.1),  # nothing before it, so nothing is known of motion
        (0.020, 0.2),  # the next is due in this very cycle
        (0.028, 0.2),
        (0.038, 0.2),  # since 0.02
        (0.040, 0.4),
        (0.060, 0.4),  # it rests
    ]
    assert overdue(due, sent, looks) == pytest.approx([0.0, 0.008, 0.018, 0.0])
    assert overdue([], [], looks) == []


def test_how_late_references_were_is_told_where_it_is_known():
    assert result().figures.overdue is None
    late = replace(result(), overdue=np.array([0.0] * 98 + [0.02, 0.06]))
    assert late.figures.overdue == pytest.approx((0.0, 0.0204, 0.06))
    assert json.loads(table.as_json([late]))[0]["overdue"][2] == pytest.approx(0.06)


def test_too_little_recorded_is_refused(chain):
    motion = planned(chain, circle(Shape(radius=0.1, centre=(0.6, 0.0, 0.5))))
    times = np.linspace(0.0, 0.5 * motion.profile.duration, 50)
    with pytest.raises(FollowTrajectoryError, match="50 joint states"):
        analyse("circle", motion, PathRecording(times, np.tile(motion.start, (50, 1))))


def test_a_report_holds_the_figure_twice_the_ways_and_the_figures(tmp_path):
    files = report.write(tmp_path / "new", result())
    assert [file.name for file in files] == [
        f"straight_on{suffix}" for suffix in (".png", ".svg", ".csv", ".json", ".md")
    ]
    head = files[0].read_bytes()[:24]
    width, height = struct.unpack(">II", head[16:])
    assert head[:8] == b"\x89PNG\r\n\x1a\n"
    assert (width, height) > (600, 800)
    assert "error in z (mm)" in files[1].read_text() or "<svg" in files[1].read_text()
    rows = files[2].read_text().splitlines()
    assert rows[0] == "time,desired_x,desired_y,desired_z,x,y,z"
    assert len(rows) == 502
    assert json.loads(files[3].read_text())[0]["largest"] == pytest.approx(0.004583, abs=1e-6)
    assert files[4].read_text() == table.text([result()]) + "\n"
    assert "| straight on | 0.50 | 10.0 | rms | 1.000 |" in files[4].read_text()


# ---- command line


def test_shapes_have_their_defaults_and_are_put_where_asked():
    tool = np.array([0.7, 0.1, 0.4])
    spiral = tool_path(parse(["--spiral"]), tool)
    assert np.ptp(spiral.points, axis=0) == pytest.approx((0.3, 0.3, 0.3), abs=1e-6)
    flat = tool_path(parse(["--figure-8", "--plane", "yz", "--centre", "1", "0", "0.5"]), tool)
    assert flat.points[:, 0] == pytest.approx(1.0)
    here = tool_path(parse(["--square", "--radius", "0.05", "--here"]), tool)
    assert here.points[0] == pytest.approx(tool)


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["--spiral", "--circle"],
        ["--circle", "--radius", "-1"],
        ["--circle", "--speed", "nan"],
        ["--circle", "--centre", "0", "inf", "0"],
        ["--circle", "--here", "--centre", "0", "0", "0"],
        ["--circle", "--plane", "zz"],
    ],
)
def test_a_wrong_command_line_ends_the_program(arguments, capsys):
    with pytest.raises(SystemExit):
        parse(arguments)
    assert "follow_trajectory: error" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("error", "status", "said"),
    [
        (None, 0, ""),
        (FollowTrajectoryError("too far"), 1, "follow_trajectory: too far\n"),
        (StepError("it is paused"), 1, "follow_trajectory: it is paused\n"),
        (OSError("no folder"), 1, "follow_trajectory: no folder\n"),
        (KeyboardInterrupt(), 130, ""),
    ],
)
def test_the_program_ends_with_a_status_and_a_reason(monkeypatch, capsys, error, status, said):
    def measure(options):
        if error is not None:
            raise error

    monkeypatch.setattr(command_line, "measure", measure)
    monkeypatch.setattr(command_line.program, "arguments", lambda: ["--circle"])
    monkeypatch.setattr(command_line.program.rosgraph, "is_master_online", lambda: True)
    for name in ("init_node", "signal_shutdown"):
        monkeypatch.setattr(command_line.program.rospy, name, lambda *_, **__: None)
    with pytest.raises(SystemExit) as ended:
        command_line.main()
    assert ended.value.code == status
    assert capsys.readouterr().err == said


def test_without_a_master_the_program_says_what_to_start(monkeypatch, capsys):
    monkeypatch.setattr(command_line.program, "arguments", lambda: ["--circle"])
    monkeypatch.setattr(command_line.program.rosgraph, "is_master_online", lambda: False)
    monkeypatch.setattr(command_line.program.rospy, "signal_shutdown", lambda _: None)
    with pytest.raises(SystemExit) as ended:
        command_line.main()
    assert ended.value.code == 1
    assert "start the simulator first" in capsys.readouterr().err
