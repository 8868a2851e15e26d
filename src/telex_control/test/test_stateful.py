"""State that parts declare, and what comes back of it."""

from __future__ import annotations

from collections import deque

import numpy as np

from telex_control.common.stateful import Stateful
from telex_control.manager.controller import Controller


class Inner(Stateful):
    __slots__ = ("kept", "left")
    SAVED = ("kept",)

    def __init__(self, value):
        self.kept = value
        self.left = value


class Base(Stateful):
    SAVED = ("values", "array", "window")
    SAVED_TIMES = ("begun", "never")
    SAVED_PARTS = ("inner", "several", "missing")

    def __init__(self):
        self.values = [1.0, 2.0]
        self.array = np.zeros(2)
        self.window = deque([1], maxlen=2)
        self.begun = 3.0
        self.never = None
        self.inner = Inner(1)
        self.several = (Inner(2), Inner(3))
        self.missing = None


class Derived(Base):
    SAVED = ("own",)

    def __init__(self):
        super().__init__()
        self.own = "x"


def spoil(part):
    part.values[0] = 9.0
    part.array += 1.0
    part.window.append(7)
    part.begun, part.never = 8.0, 8.0
    part.inner.kept = part.inner.left = 9
    part.several[1].kept = 9
    part.own = "y"


def test_what_is_declared_comes_back_as_often_as_wanted():
    part = Derived()
    saved = part.save_state()
    for _ in range(2):
        spoil(part)
        part.restore_state(saved, 2.5)
        assert part.values == [1.0, 2.0]
        assert part.array.tolist() == [0.0, 0.0]
        assert part.window == deque([1])
        assert part.window.maxlen == 2
        assert (part.inner.kept, part.several[1].kept, part.own) == (1, 3, "x")


def test_times_come_back_later_and_what_is_not_declared_does_not():
    part = Derived()
    saved = part.save_state()
    spoil(part)
    part.restore_state(saved, 2.5)
    assert (part.begun, part.never) == (5.5, None)
    assert part.inner.left == 9


def test_a_class_says_whether_it_declares_anything():
    class Nothing(Stateful):
        pass

    assert Derived.has_state()
    assert not Nothing.has_state()


JOINT = {"type": "position_controllers/JointPositionController", "joint": "elbow"}
OTHER = {"type": "position_controllers/JointPositionController", "joint": "slide"}


class Undeclared(Controller):
    """A user's, which says nothing of its state."""

    def init(self, hw, root, node):
        self.calls = []

    def starting(self, time):
        self.calls.append("starting")

    def update(self, time, period): ...

    def stopping(self, time):
        self.calls.append("stopping")


def test_the_controllers_of_a_state_run_again_with_what_they_held(bench):
    bench = bench({"first": JOINT, "second": OTHER, "own": {"type": "test_stateful.Undeclared"}})
    first, second, own = bench.load_and_start("first", "second", "own")
    first._commands = (0.7,)
    bench.switch(stop=("second",))
    saved = bench.manager.save_state()
    first._commands = (0.1,)
    bench.switch(start=("second",), stop=("first",))
    own.calls.clear()
    bench.hw.switches.clear()
    bench.manager.restore_running(saved, bench.time)
    assert bench.states() == {"first": "running", "second": "stopped", "own": "running"}
    assert bench.hw.switches == [(["first"], ["second"])]
    bench.manager.restore_state(saved, bench.time, 1.0)
    assert first._commands == (0.7,)
    assert own.calls == ["stopping", "starting"]


def test_a_controller_that_was_unloaded_stays_so(bench):
    bench = bench({"first": JOINT})
    bench.load_and_start("first")
    saved = bench.manager.save_state()
    bench.switch(stop=("first",))
    assert bench.manager.unload_controller("first")
    bench.manager.restore_running(saved, bench.time)
    bench.manager.restore_state(saved, bench.time, 1.0)
    assert bench.states() == {}
