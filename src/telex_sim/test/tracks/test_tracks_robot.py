"""The shipped robot on its tracks: the figures that the track model has to show, shortened."""

from __future__ import annotations

import math

import pybullet
import pytest
from geometry_msgs.msg import Twist
from std_msgs.msg import Float64

pytestmark = pytest.mark.slow

BELTS = ("front_left", "rear_left", "front_right", "rear_right")
RADIUS = 0.110
STEPS = [0.004, 0.002, 0.001]


class Driver:
    """A robot in `drive` pose, and what is measured on it."""

    def __init__(self, robot, step=0.002, **changes):
        self.offline = robot(
            start__pose="drive",
            timing__step_size=step,
            timing__control_period=max(step, 0.002),
            **changes,
        )
        self.simulation = self.offline.simulation
        self.client = self.simulation.world.client
        self.uid = self.simulation.body.uid
        self.step_size = step
        self.publisher = self.offline.node.advertise("track_controller/cmd_vel", Twist)
        self.offline.run(0.4)

    def slope(self, along=0.0, across=0.0, seconds=0.5):
        """Let gravity lean (degrees), little by little."""
        parts = 25
        for part in range(1, parts + 1):
            x, y = (math.radians(angle) * part / parts for angle in (along, across))
            angle = math.hypot(x, y)
            pull = 9.81 * math.sin(angle) / angle
            pybullet.setGravity(
                -pull * x,
                -pull * y,
                -9.81 * math.cos(angle),
                physicsClientId=self.client,
            )
            self.offline.run(seconds / parts)

    def lower_flippers(self):
        """Lay them flat on the ground."""
        for belt in BELTS:
            topic = f"{belt}_flipper_position_controller/command"
            self.offline.node.advertise(topic, Float64).publish(Float64(0.0))
        self.offline.run(1.5)

    def drive(self, speed, seconds, watch=None):
        message = Twist()
        message.linear.x = speed
        every = round(0.1 / self.step_size)
        for count in range(round(seconds / self.step_size)):
            if count % every == 0:
                self.publisher.publish(message)
            self.simulation.step()
            if watch is not None:
                watch()

    @property
    def place(self):
        return self.simulation.body.base_pose()[0]

    @property
    def motion(self):
        return pybullet.getBaseVelocity(self.uid, physicsClientId=self.client)

    def belt(self, name="front_left"):
        return self.simulation.hw.joint_state(f"{name}_track_joint")


def rms(values):
    return math.sqrt(sum(value * value for value in values) / len(values))


@pytest.mark.parametrize("speed", [1.0, -0.5])
def test_it_runs_at_belt_speed_without_shaking(robot, speed):
    tested = Driver(robot)
    tested.drive(speed, 0.8)
    start, rise, pitch = tested.place, [], []

    def watch():
        linear, angular = tested.motion
        rise.append(linear[2])
        pitch.append(angular[1])

    tested.drive(speed, 0.6, watch)
    assert tested.place[0] - start[0] == pytest.approx(0.6 * speed, rel=0.01)
    assert rms(rise) < 2e-3
    assert rms(pitch) < 1e-3


@pytest.mark.parametrize("step", STEPS)
@pytest.mark.parametrize("slope", [{"along": 30.0}, {"across": 30.0}])
def test_it_holds_on_a_slope(robot, slope, step):
    tested = Driver(robot, step)
    tested.slope(**slope)
    tested.offline.run(0.3)
    start = tested.place
    tested.offline.run(1.0)
    # 1 mm in 30 s is required
    assert math.dist(start, tested.place) < 1e-3 / 30.0


@pytest.mark.parametrize("step", STEPS)
def test_a_ramp_costs_effort_but_no_speed(robot, step):
    tested = Driver(robot, step)
    tested.slope(along=30.0)
    tested.drive(0.5, 0.7)
    start = tested.place
    tested.drive(0.5, 0.4)
    assert tested.place[0] - start[0] == pytest.approx(0.4 * 0.5, rel=0.02)
    force = sum(tested.belt(name).effort for name in BELTS) / RADIUS
    # 75 kg, and the friction of four belts: 1 N m each
    assert force == pytest.approx(75.0 * 9.81 * 0.5 + 4.0 / RADIUS, rel=0.1)


def test_a_climb_slows_the_belts_once_their_power_is_spent(robot):
    tested = Driver(robot, tracks__friction=1.2, tracks__lateral_friction=0.84)
    # On round hubs alone it would tip over backwards.
    tested.lower_flippers()
    tested.slope(along=45.0)
    tested.drive(1.2, 1.5)
    front, rear = tested.belt("front_left"), tested.belt("rear_left")
    assert front.velocity == rear.velocity
    assert 0.5 < front.velocity * RADIUS < 1.0
    assert (front.effort + rear.effort) * front.velocity == pytest.approx(250.0, rel=0.01)
    assert tested.motion[0][0] == pytest.approx(front.velocity * RADIUS, rel=0.05)


def test_blocked_belts_stall(robot):
    """On ground that holds it, against a slope that its motors cannot climb."""
    tested = Driver(
        robot,
        tracks__friction=1.5,
        tracks__drive={
            "force": 150.0,
            "power": 250.0,
            "acceleration": 5.0,
            "inertia": 15.0,
            "brake_force": 900.0,
        },
    )
    # 150 N a side: too much to climb beside the drives' friction of 18 N, too little to slide back
    tested.slope(along=24.0)
    tested.drive(0.5, 0.6)
    efforts = [tested.belt(name).effort for name in BELTS]
    assert [tested.belt(name).velocity for name in BELTS] == [0.0] * 4
    assert efforts[0] + efforts[1] == pytest.approx(150.0 * RADIUS)
    assert efforts[2] + efforts[3] == pytest.approx(150.0 * RADIUS)


def test_the_emergency_stop_holds_on_a_slope(robot):
    tested = Driver(robot)
    tested.slope(along=30.0)
    tested.drive(0.5, 0.6)
    tested.simulation.request_e_stop(True)
    tested.drive(0.5, 0.6)
    start = tested.place
    assert tested.belt().velocity == 0.0
    tested.drive(0.5, 0.5)
    assert math.dist(start, tested.place) < 1e-4


@pytest.mark.parametrize("command", [math.nan, math.inf])
def test_a_command_that_is_no_number_moves_nothing(robot, command):
    tested = Driver(robot)
    handles = [tested.simulation.hw.drive(f"{name}_track_joint").handle for name in BELTS]
    write = tested.simulation.hw.write

    def poison(time, period):
        for handle in handles:
            handle.command = command
        write(time, period)

    tested.simulation.hw.write = poison
    start = tested.place
    tested.offline.run(0.1)
    assert math.dist(start, tested.place) < 1e-4
    assert tested.belt().velocity == 0.0


@pytest.mark.parametrize(
    ("materials", "moves"),
    [({}, True), ({"concrete": {"friction": 0.1, "lateral_friction": 0.1}}, False)],
)
def test_grip_can_be_given_by_material(robot, materials, moves):
    tested = Driver(robot, tracks__materials=materials)
    tested.slope(along=15.0)
    start = tested.place
    tested.drive(0.3, 0.5)
    assert (tested.place[0] > start[0]) is moves


def test_materials_are_what_objects_look_like(robot, tmp_path):
    scene = tmp_path / "looks.yaml"
    scene.write_text(
        "objects:\n"
        "  - {type: crate, name: wooden, position: [3, 0, 0]}\n"
        "  - {type: crate, name: paper, position: [5, 0, 0], material: cardboard}\n"
    )
    objects = robot(world=str(scene)).simulation.objects
    assert objects.material(0, -1) == "concrete"
    assert objects.material(objects.bodies_of("wooden")[0], -1) == "wood"
    assert objects.material(objects.bodies_of("paper")[0], -1) == "cardboard"
    assert objects.material(10**6, -1) == ""
