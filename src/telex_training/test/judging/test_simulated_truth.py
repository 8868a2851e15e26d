"""The judge on what the simulator itself tells of the shipped robot."""

from __future__ import annotations

import io
import json

import numpy as np
import pytest
from genpy import Time
from std_msgs.msg import String

from telex_sim.offline.simulation import OfflineSimulation, robot_description
from telex_sim.truth.messages import names_message, sample_message
from telex_sim.truth.sampler import TruthSampler
from telex_training.exercises.catalog import find_exercise
from telex_training.exercises.exercise_file import load_exercise
from telex_training.exercises.seeds import scene_text
from telex_training.judging.entries import Entry
from telex_training.judging.judge import Judge
from telex_training.judging.truth import Names, World, read_sample

STEPS = 10


def serialized(message):
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


class Simulated:
    """An exercise's scene in the simulation, whose truth a judge is fed with."""

    def __init__(self, name, folder):
        made = load_exercise(find_exercise(name)).first
        text = scene_text(made, 7)
        path = folder / "scene.yaml"
        path.write_text(text)
        urdf = robot_description()
        self.offline = OfflineSimulation(urdf, world=str(path))
        self.simulation = self.offline.simulation
        self.sampler = TruthSampler(self.simulation, self.simulation.robots[0])
        self.judge = Judge(made, text, urdf)
        self.world = World(None, urdf)
        self.number = self.sequence = 0
        message = names_message(self.sampler.names, 1)
        self.feed("sim/truth_names", "telex_msgs/TruthNames", message)
        self.world.name(Names(message))

    def feed(self, channel, kind, message):
        self.number += 1
        entry = Entry(self.number, self.simulation.time, channel, kind, serialized(message))
        return self.judge.feed(entry)

    def input(self, kind, **fields):
        text = json.dumps({"input": kind, **fields})
        return self.feed("training/inputs", "std_msgs/String", String(data=text))

    def step(self):
        for _ in range(STEPS):
            self.simulation.step()
        made = self.sampler.sample()
        self.sequence += 1
        message = sample_message(made)
        message.sequence, message.steps = self.sequence, self.sequence * STEPS
        message.revision, message.margin = 1, 1.0
        message.wall_time = 1e9 + self.simulation.time
        message.header.stamp = Time.from_sec(self.simulation.time)
        self.world.take(read_sample(serialized(message)))
        return self.feed("sim/truth", "telex_msgs/TruthSample", message)


@pytest.fixture(scope="module")
def simulated(tmp_path_factory):
    made = Simulated("cube_to_bin", tmp_path_factory.mktemp("scene"))
    yield made
    made.simulation.close()


def test_the_tool_is_where_the_simulation_has_it(simulated):
    for _ in range(20):
        simulated.step()
    frames = simulated.simulation.body.link_names()
    poses = np.asarray(simulated.simulation.link_poses()).reshape(-1, 7)
    wanted = poses[frames.index("tool_link"), :3]
    # float32 in the message, and the last step of the joints in the physics.
    assert simulated.world.tool == pytest.approx(wanted, abs=2e-5)


def test_a_trial_at_the_start_of_an_exercise_waits_and_is_valid(simulated):
    simulated.input("open", operator="ann", mode="exam", seed=7)
    simulated.input("start")
    simulated.input("ready")
    for _ in range(20):
        simulated.step()
    state = simulated.judge.state()
    assert state["phase"] == "waiting"
    assert state["valid"], state["invalid_because"]
    simulated.input("again")
    simulated.input("ready")
    simulated.input("abort")
    assert simulated.judge.sheet()["verdict"] == ""
