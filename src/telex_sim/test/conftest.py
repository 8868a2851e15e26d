from __future__ import annotations

import pytest

from telex_sim.engine.world import World
from telex_sim.offline.simulation import OfflineSimulation, robot_description
from telex_sim.scene.assets import Assets
from telex_sim.scene.model import Floor
from telex_sim.scene.objects.assembly import assemble
from telex_sim.scene.objects.bodies import SceneBodies

# The tests of this package import the modules that they share from this directory.


@pytest.fixture(scope="session")
def urdf():
    return robot_description()


@pytest.fixture
def closing():
    """Turns a class into a function that makes one, and closes the worlds of all in the end."""
    made = []

    def maker(kind):
        def make(*args, **kwargs):
            made.append(kind(*args, **kwargs))
            return made[-1]

        return make

    yield maker
    for each in made:
        each.world.close()


@pytest.fixture
def robot(urdf):
    """Makes shipped robots, and closes them."""
    made = []

    def make(**changes):
        offline = OfflineSimulation(urdf, **changes)
        made.append(offline)
        return offline

    yield make
    for offline in made:
        offline.simulation.close()


class Stage:
    """Objects in a world without a robot."""

    def __init__(self, *items, step_size=0.002, floor=None):
        self.step_size = step_size
        self.world = World(step_size, 50)
        self.client = self.world.client
        self.objects = SceneBodies(self.client, step_size)
        self.assets = Assets()
        self.objects.load(floor or Floor(), self.plan(*items), lambda done, count: None)

    def plan(self, *items):
        return [assemble(item, self.assets, self.step_size) for item in items]

    def add(self, *items, robots=()):
        for _ in self.objects.add(self.plan(*items), robots):
            pass

    def run(self, seconds, each_step=None):
        for _ in range(round(seconds / self.step_size)):
            if each_step is not None:
                each_step()
            self.objects.apply()
            self.world.step()

    def uid(self, name, body=0):
        return self.objects.bodies_of(name)[body]

    def pose(self, frame):
        """Position and orientation of a link's frame."""
        index = self.objects.frames().index(frame)
        values = self.objects.poses()[7 * index : 7 * index + 7]
        return tuple(values[:3]), tuple(values[3:])


@pytest.fixture
def stage(closing):
    """Makes worlds without a robot, and closes them."""
    return closing(Stage)
