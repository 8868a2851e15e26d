from __future__ import annotations

import sys
import threading

import pytest
from waiting import wait_until

from telex_control.hardware.hardware_interface import (
    EffortJointInterface,
    SwitchState,
    VelocityJointInterface,
)
from telex_control.manager.controller import Controller


class Recorder(Controller):
    """Claims what its parameters say and notes its calls."""

    def init(self, hw, root, node):
        self.calls = []
        kinds = {"effort": EffortJointInterface, "velocity": VelocityJointInterface}
        for kind, joints in node.param("claims", dict, {}).items():
            for joint in joints:
                hw.get(kinds[kind]).get_handle(joint)
        self.fail_in = node.param("fail_in", str, "")
        if self.fail_in == "init":
            raise RuntimeError("broken")
        if self.fail_in == "exit in init":
            sys.exit(3)
        return self.fail_in != "init as in C++"

    def _note(self, call):
        self.calls.append(call)
        if self.fail_in == call:
            raise RuntimeError("broken")
        if self.fail_in == f"exit in {call}":
            sys.exit(3)

    def starting(self, time):
        self._note("starting")

    def update(self, time, period):
        self._note("update")

    def stopping(self, time):
        self._note("stopping")


class BadConstructor(Controller):
    def __init__(self):
        raise RuntimeError("broken")


class EndingConstructor(Controller):
    def __init__(self):
        sys.exit(3)


RECORDER = f"{__name__}.Recorder"


@pytest.fixture
def recorders(bench):
    return bench(
        {
            "a": {"type": RECORDER, "claims": {"effort": ["elbow"]}},
            "b": {"type": RECORDER, "claims": {"effort": ["slide"]}},
            "rival": {"type": RECORDER, "claims": {"velocity": ["elbow"]}},
            "both": {
                "type": RECORDER,
                "claims": {"effort": ["wheel"], "velocity": ["wheel"]},
            },
            "free": {"type": RECORDER},
            "no_joint": {"type": RECORDER, "claims": {"effort": ["nose"]}},
            "bad_init": {"type": RECORDER, "fail_in": "init"},
            "false_init": {"type": RECORDER, "fail_in": "init as in C++"},
            "bad_start": {"type": RECORDER, "fail_in": "starting"},
            "bad_stop": {
                "type": RECORDER,
                "fail_in": "stopping",
                "claims": {"effort": ["elbow"]},
            },
            "bad_update": {
                "type": RECORDER,
                "fail_in": "update",
                "claims": {"effort": ["elbow"]},
            },
            "untyped": {"joint": "elbow"},
            "unknown_type": {"type": "effort_controllers/NoSuchController"},
            "unknown_path": {"type": "telex_control.no_such_module.Controller"},
            "no_controller": {"type": "telex_control.laws.pid.Pid"},
            "bad_constructor": {"type": f"{__name__}.BadConstructor"},
            "two": {
                "type": RECORDER,
                "claims": {"velocity": ["wheel", "elbow"], "effort": ["slide"]},
            },
        }
    )


def wait_for_switch(bench):
    wait_until(lambda: bench.manager._switch is not None, "a switch to reach the loop")


class Call(threading.Thread):
    """A call of the manager in a thread of its own, as a service makes it."""

    def __init__(self, function, *arguments, **options):
        super().__init__(daemon=True)
        self._call = lambda: function(*arguments, **options)
        self.answer = None
        self.start()

    def run(self):
        self.answer = self._call()

    def result(self):
        self.join(5.0)
        assert not self.is_alive(), "the call did not return"
        return self.answer


def test_loaded_controllers_are_initialized_and_listed_in_load_order(recorders):
    assert recorders.manager.load_controller("b")
    assert recorders.manager.load_controller("a")
    assert recorders.states() == {"b": "initialized", "a": "initialized"}
    (info, _), _ = recorders.manager.list_controllers()
    assert info.claimed_resources[0].hardware_interface == (
        "hardware_interface::EffortJointInterface"
    )
    assert info.claimed_resources[0].resources == ("slide",)


@pytest.mark.parametrize(
    ("name", "logged"),
    [
        ("", "empty"),
        (
            "untyped",
            "the type was not specified. Did you load the controller configuration on the "
            "parameter server (namespace: '/untyped')?",
        ),
        ("not_there", "'not_there' because the type was not specified"),
        ("unknown_type", "type 'effort_controllers/NoSuchController' does not exist"),
        ("unknown_type", "Use 'rosservice call controller_manager/list_controller_types'"),
        ("unknown_path", "no_such_module"),
        ("no_controller", "no subclass"),
        ("no_joint", "'nose'"),
        ("bad_init", "Exception thrown while initializing controller 'bad_init'"),
        ("bad_init", "Initializing controller 'bad_init' failed"),
        ("false_init", "Initializing controller 'false_init' failed: its init returned False"),
        ("no_joint", "Initializing controller 'no_joint' failed: Could not find resource"),
        ("bad_constructor", "while constructing controller 'bad_constructor'"),
    ],
)
def test_what_cannot_be_loaded_is_refused_and_says_why(recorders, caplog, name, logged):
    assert not recorders.manager.load_controller(name)
    assert logged in caplog.text
    assert recorders.states() == {}


def test_a_name_is_loaded_once(recorders, caplog):
    assert recorders.manager.load_controller("a")
    assert not recorders.manager.load_controller("a")
    assert "already loaded" in caplog.text


def test_life_of_a_controller(recorders):
    (a,) = recorders.load_and_start("a")
    assert recorders.states() == {"a": "running"}
    recorders.cycle(2)
    assert recorders.switch(stop=["a"])
    assert recorders.states() == {"a": "stopped"}
    # whatever number of cycles ran while the callers waited: started once, stopped once, last
    assert a.calls[0] == "starting"
    assert a.calls[-1] == "stopping"
    assert a.calls.count("starting") == a.calls.count("stopping") == 1
    count = len(a.calls)
    recorders.cycle(3)
    assert len(a.calls) == count
    assert recorders.switch(start=["a"])
    assert recorders.states() == {"a": "running"}


def test_running_controllers_are_not_unloaded(recorders, caplog):
    recorders.load_and_start("a")
    assert not recorders.manager.unload_controller("a")
    assert "still running" in caplog.text
    recorders.switch(stop=["a"])
    assert recorders.manager.unload_controller("a")
    assert recorders.states() == {}
    assert not recorders.manager.unload_controller("a")


@pytest.mark.parametrize("strictness", [1, 2])
def test_joints_are_claimed_across_interfaces(recorders, strictness, caplog):
    recorders.load_and_start("a")
    assert recorders.manager.load_controller("rival")
    assert not recorders.switch(start=["rival"], strictness=strictness)
    assert "elbow" in caplog.text
    assert recorders.states() == {"a": "running", "rival": "initialized"}
    assert recorders.switch(start=["rival"], stop=["a"], strictness=strictness)
    assert recorders.states() == {"a": "stopped", "rival": "running"}


def test_a_controller_can_conflict_with_itself(recorders):
    assert recorders.manager.load_controller("both")
    assert not recorders.switch(start=["both"], strictness=1)


@pytest.mark.parametrize(
    ("start", "stop", "strict", "best_effort"),
    [
        (["ghost"], [], False, True),
        ([], ["ghost"], False, True),
        (["a"], [], False, True),  # runs already
        ([], ["b"], False, True),  # does not run
        (["a"], ["a"], False, False),  # both, and running
        (["b"], ["b"], False, True),  # both, not running: started
        ([], [], True, True),
        (["b", "b"], [], True, True),
    ],
)
def test_strictness(recorders, start, stop, strict, best_effort):
    recorders.load_and_start("a")
    recorders.manager.load_controller("b")
    assert recorders.switch(start, stop, strictness=2) is strict
    if not strict:
        assert recorders.states() == {"a": "running", "b": "initialized"}
        assert recorders.switch(start, stop, strictness=1) is best_effort
    assert recorders.states()["a"] == "running"
    assert recorders.states()["b"] == ("running" if "b" in start else "initialized")


def test_unknown_strictness_counts_as_best_effort(recorders, caplog):
    assert recorders.switch(start=["ghost"], strictness=0)
    assert "BEST_EFFORT is taken" in caplog.text


@pytest.mark.parametrize("timeout", [float("nan"), float("inf"), -1.0])
def test_timeouts_must_be_usable(recorders, timeout):
    recorders.manager.load_controller("a")
    assert not recorders.switch(start=["a"], timeout=timeout)
    assert recorders.states() == {"a": "initialized"}


def test_a_switch_happens_in_one_cycle_after_the_updates(recorders):
    (a,) = recorders.load_and_start("a")
    recorders.manager.load_controller("rival")
    thread = threading.Thread(
        target=recorders.manager.switch_controller, args=(["rival"], ["a"], 2), daemon=True
    )
    thread.start()
    wait_for_switch(recorders)
    a.calls.clear()
    recorders.cycle()
    thread.join(5.0)
    assert not thread.is_alive()
    rival = recorders.manager.controller("rival")
    assert a.calls == ["update", "stopping"]
    assert rival.calls == ["starting"]
    assert recorders.hw.switches[-1] == (["rival"], ["a"])


def test_hardware_that_takes_its_time(recorders):
    recorders.hw.switch_result = lambda info=None: SwitchState.ONGOING
    recorders.manager.load_controller("a")
    thread = threading.Thread(
        target=recorders.manager.switch_controller, args=(["a"], [], 2), daemon=True
    )
    thread.start()
    wait_for_switch(recorders)
    recorders.cycle(3)
    assert recorders.states() == {"a": "waiting"}
    recorders.hw.switch_result = lambda info=None: SwitchState.DONE
    recorders.cycle()
    thread.join(5.0)
    assert not thread.is_alive()
    assert recorders.states() == {"a": "running"}


def test_hardware_that_fails_or_is_late_aborts_the_start(recorders):
    recorders.hw.switch_result = lambda info=None: SwitchState.ERROR
    recorders.manager.load_controller("a")
    assert not recorders.switch(start=["a"])
    assert recorders.states() == {"a": "aborted"}
    recorders.hw.switch_result = lambda info=None: SwitchState.ONGOING
    recorders.period = 0.2
    assert not recorders.switch(start=["a"], timeout=0.5)
    assert recorders.states() == {"a": "aborted"}


def test_listing_does_not_wait_for_a_switch(recorders):
    recorders.manager.load_controller("a")
    thread = threading.Thread(
        target=recorders.manager.switch_controller, args=(["a"], [], 2), daemon=True
    )
    thread.start()
    wait_for_switch(recorders)
    assert recorders.states() == {"a": "initialized"}
    recorders.manager.close()
    thread.join(5.0)
    assert not thread.is_alive()


def test_a_controller_that_raises_is_stopped_and_the_others_go_on(recorders, caplog):
    bad, good = recorders.load_and_start("bad_update", "b")
    recorders.cycle(3)
    assert recorders.states() == {"bad_update": "stopped", "b": "running"}
    assert bad.calls[-1] == "stopping"
    assert good.calls[-1] == "update"
    assert "bad_update" in caplog.text
    # the hardware hears of it, so that the joint is not left to itself
    assert recorders.hw.switches[-1] == ([], ["bad_update"])


@pytest.mark.parametrize("call", ["starting", "update"])
def test_a_controller_that_ends_the_program_ends_only_itself(bench, call, caplog):
    tested = bench({"c": {"type": RECORDER, "fail_in": f"exit in {call}"}, "b": {"type": RECORDER}})
    assert tested.manager.load_controller("c")
    tested.switch(start=["c"])
    tested.load_and_start("b")
    tested.cycle(2)
    assert tested.states() == {"c": "stopped", "b": "running"}
    assert "controller 'c' raised an exception" in caplog.text


def test_a_controller_that_ends_the_program_before_it_runs_is_not_loaded(bench, caplog):
    tested = bench(
        {
            "c": {"type": RECORDER, "fail_in": "exit in init"},
            "d": {"type": f"{__name__}.EndingConstructor"},
        }
    )
    assert not tested.manager.load_controller("c")
    assert not tested.manager.load_controller("d")
    assert "Exception thrown while initializing controller 'c'" in caplog.text
    assert "Exception thrown while constructing controller 'd'" in caplog.text


def test_hardware_that_raises_fails_the_switch_and_the_loop_goes_on(recorders, caplog):
    def do_switch(start, stop):
        raise OSError("the bus is gone")

    (a,) = recorders.load_and_start("a")
    recorders.manager.load_controller("b")
    do_switch_before, recorders.hw.do_switch = recorders.hw.do_switch, do_switch
    assert not recorders.switch(start=["b"], stop=["a"])
    assert recorders.states() == {"a": "running", "b": "initialized"}
    assert "the bus is gone" in caplog.text
    recorders.hw.do_switch = do_switch_before
    assert recorders.switch(start=["b"], stop=["a"])


def test_a_controller_that_raises_on_start_fails_the_switch(recorders):
    recorders.manager.load_controller("bad_start")
    assert not recorders.switch(start=["bad_start"])
    assert recorders.states() == {"bad_start": "stopped"}


def test_reset_controllers_restarts_every_running_one(recorders):
    (a,) = recorders.load_and_start("a")
    recorders.manager.load_controller("b")
    a.calls.clear()
    recorders.cycle(reset_controllers=True)
    assert a.calls == ["stopping", "starting", "update"]
    assert recorders.states() == {"a": "running", "b": "initialized"}


def test_a_failed_controller_does_not_take_the_joint_from_its_successor(recorders):
    recorders.manager.load_controller("bad_stop")
    assert recorders.switch(start=["bad_stop"])
    recorders.manager.load_controller("a")
    assert recorders.switch(start=["a"], stop=["bad_stop"])
    assert recorders.states() == {"bad_stop": "stopped", "a": "running"}
    # what the hardware is told last of "a" is that it starts
    assert [call for call in recorders.hw.switches if "a" in call[0] or "a" in call[1]] == [
        (["a"], ["bad_stop"])
    ]


def test_start_asap_starts_what_is_ready(recorders):
    ready = {"b"}
    recorders.hw.switch_result = lambda info=None: (
        SwitchState.DONE if info is not None and info.name in ready else SwitchState.ONGOING
    )
    recorders.manager.load_controller("a")
    recorders.manager.load_controller("b")
    thread = threading.Thread(
        target=recorders.manager.switch_controller, args=(["a", "b"], [], 2, True), daemon=True
    )
    thread.start()
    wait_for_switch(recorders)
    recorders.cycle(2)
    assert recorders.states() == {"a": "waiting", "b": "running"}
    ready.add("a")
    recorders.cycle()
    thread.join(5.0)
    assert recorders.states() == {"a": "running", "b": "running"}


def test_a_switch_that_was_given_up_is_taken_back(recorders):
    recorders.manager.load_controller("a")
    assert not recorders.manager.switch_controller(["a"], [], 2, timeout=0.01)
    recorders.cycle(3)
    assert recorders.states() == {"a": "initialized"}
    assert recorders.hw.switches == []
    assert recorders.switch(start=["a"])


def test_world_reset_starts_again_what_had_failed(recorders):
    (bad,) = recorders.load_and_start("bad_update")
    recorders.cycle()
    assert recorders.states() == {"bad_update": "stopped"}
    bad.fail_in = ""
    recorders.manager.reset(1.0)
    assert recorders.states() == {"bad_update": "running"}
    assert recorders.hw.switches[-1] == (["bad_update"], [])


def test_world_reset_during_a_switch_gives_no_joint_to_two(recorders):
    (bad,) = recorders.load_and_start("bad_update")
    recorders.cycle()
    bad.fail_in = ""
    recorders.manager.load_controller("a")
    switch = Call(recorders.manager.switch_controller, ["a"], [])
    wait_for_switch(recorders)
    recorders.manager.reset(1.0)
    recorders.cycle()
    assert switch.result()
    assert recorders.states() == {"bad_update": "stopped", "a": "running"}


def test_a_switch_that_a_reset_has_overtaken_is_refused(recorders, caplog):
    (bad,) = recorders.load_and_start("bad_update")
    recorders.cycle()
    bad.fail_in = ""
    recorders.manager.load_controller("a")
    # The reset comes when the switch has been judged, and is not yet the loop's.
    recorders.hw.prepare_switch = lambda start, stop: recorders.manager.reset(1.0)
    assert not recorders.switch(start=["a"])
    assert recorders.states() == {"bad_update": "running", "a": "initialized"}
    assert "Resource conflict on [elbow]" in caplog.text


def test_world_reset_leaves_alone_what_somebody_has_stopped(recorders):
    recorders.load_and_start("bad_stop")
    recorders.switch(stop=["bad_stop"])
    recorders.manager.reset(1.0)
    assert recorders.states() == {"bad_stop": "stopped"}


def test_every_interface_that_a_controller_uses_is_listed(bench):
    tested = bench(
        {"j": {"type": "joint_state_controller/JointStateController", "publish_rate": 5}}
    )
    tested.manager.load_controller("j")
    ((info, _),) = tested.manager.list_controllers()
    (used,) = info.claimed_resources
    assert used.hardware_interface == "hardware_interface::JointStateInterface"
    assert used.resources == ()


def test_world_reset_restarts_every_running_one(recorders):
    (a,) = recorders.load_and_start("a")
    a.calls.clear()
    recorders.manager.reset(1.0)
    assert a.calls == ["stopping", "starting"]


def test_libraries_are_reloaded_only_when_nothing_is_loaded_or_forced(bench):
    tested = bench(
        {"j": {"type": "joint_state_controller/JointStateController", "publish_rate": 5}}
    )
    (controller,) = tested.load_and_start("j")
    assert not tested.manager.reload_controller_libraries(force_kill=False)
    answer = []
    thread = threading.Thread(
        target=lambda: answer.append(tested.manager.reload_controller_libraries(force_kill=True))
    )
    thread.start()
    while thread.is_alive():
        tested.cycle()
        thread.join(0.001)
    assert answer == [True]
    assert tested.states() == {}
    (again,) = tested.load_and_start("j")
    assert type(again) is not type(controller)


def test_types_are_listed(recorders):
    types = dict(recorders.manager.list_controller_types())
    assert "effort_controllers/JointPositionController" in types
    assert set(types.values()) == {"controller_interface::ControllerBase"}


def test_users_types_are_listed_once_they_are_known(recorders):
    recorders.manager.load_controller("a")
    recorders.manager.load_controller("b")
    recorders.manager.load_controller("unknown_path")
    types = [name for name, _ in recorders.manager.list_controller_types()]
    assert types.count(RECORDER) == 1
    assert types == sorted(types)
    assert "telex_control.no_such_module.Controller" not in types


def test_a_changed_module_is_imported_anew(bench, tmp_path, monkeypatch):
    source = (
        "from telex_control.manager.controller import Controller\n"
        "class MyController(Controller):\n"
        "    version = {}\n"
        "    def init(self, hw, root, node): pass\n"
    )
    module = tmp_path / "changing_controllers.py"
    module.write_text(source.format(1))
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    tested = bench({"x": {"type": "changing_controllers.MyController"}})
    (first,) = tested.load_and_start("x")
    module.write_text(source.format(2))
    reload = Call(tested.manager.reload_controller_libraries, True)
    while reload.is_alive():
        tested.cycle()
        reload.join(0.001)
    assert reload.answer
    (second,) = tested.load_and_start("x")
    assert (first.version, second.version) == (1, 2)


def test_claims_are_listed_by_interface(recorders):
    assert recorders.manager.load_controller("two")
    ((info, _),) = recorders.manager.list_controllers()
    assert [(claim.hardware_interface, claim.resources) for claim in info.claimed_resources] == [
        ("hardware_interface::VelocityJointInterface", ("elbow", "wheel")),
        ("hardware_interface::EffortJointInterface", ("slide",)),
    ]


def test_claims_of_a_failed_init_are_not_those_of_the_next(recorders):
    recorders.manager.load_controller("no_joint")
    assert recorders.manager.load_controller("free")
    ((info, _),) = recorders.manager.list_controllers()
    assert info.claimed_resources == ()


def test_controllers_are_updated_in_load_order(recorders, monkeypatch):
    order = []
    monkeypatch.setattr(Recorder, "update", lambda self, time, period: order.append(self))
    b, a = recorders.load_and_start("b", "a")
    order.clear()
    recorders.cycle()
    assert order == [b, a]


def test_a_switch_to_rivals_at_once_is_refused(recorders, caplog):
    recorders.manager.load_controller("a")
    recorders.manager.load_controller("rival")
    for strictness in (1, 2):
        assert not recorders.switch(start=["a", "rival"], strictness=strictness)
    assert "Could not switch controllers, due to resource conflict" in caplog.text
    assert set(recorders.states().values()) == {"initialized"}


def test_best_effort_does_what_it_can(recorders):
    recorders.load_and_start("a")
    recorders.manager.load_controller("rival")
    assert recorders.switch(["rival", "ghost"], ["ghost", "b", "a"], strictness=1)
    assert recorders.states() == {"a": "stopped", "rival": "running"}


def test_strict_does_all_or_nothing(recorders, caplog):
    recorders.load_and_start("a")
    recorders.manager.load_controller("rival")
    assert not recorders.switch(["rival", "ghost"], ["a"])
    assert not recorders.switch(["rival"], ["a", "ghost"])
    assert recorders.states() == {"a": "running", "rival": "initialized"}
    for verb in ("start", "stop"):
        assert f"Could not {verb} controller with name 'ghost' because no" in caplog.text


def test_the_robot_may_refuse_a_combination(recorders, caplog):
    asked = []

    def prepare(start, stop):
        asked.append(([c.name for c in start], [c.name for c in stop]))
        return "one drive is off"

    recorders.hw.prepare_switch = prepare
    recorders.manager.load_controller("a")
    assert not recorders.switch(start=["a"], strictness=1)
    assert asked == [(["a"], [])]
    assert "for the requested controllers is unfeasible: one drive is off" in caplog.text
    assert recorders.states() == {"a": "initialized"}
    assert recorders.hw.switches == []


def test_asap_aborts_only_what_its_hardware_fails(recorders):
    recorders.hw.switch_result = lambda info=None: (
        SwitchState.ERROR if info is not None and info.name == "a" else SwitchState.DONE
    )
    recorders.manager.load_controller("a")
    recorders.manager.load_controller("b")
    assert not recorders.switch(start=["a", "b"], start_asap=True)
    assert recorders.states() == {"a": "aborted", "b": "running"}


def test_an_aborted_controller_can_be_started_or_unloaded(recorders):
    recorders.hw.switch_result = lambda info=None: SwitchState.ERROR
    for name in ("a", "b"):
        recorders.manager.load_controller(name)
    assert not recorders.switch(start=["a", "b"])
    del recorders.hw.switch_result
    assert recorders.switch(start=["a"])
    assert recorders.manager.unload_controller("b")
    assert recorders.states() == {"a": "running"}


def test_loading_and_unloading_do_not_wait_for_a_switch(recorders, caplog):
    recorders.hw.switch_result = lambda info=None: SwitchState.ONGOING
    recorders.manager.load_controller("a")
    recorders.manager.load_controller("free")
    switch = Call(recorders.manager.switch_controller, ["a"], [], 2)
    wait_for_switch(recorders)
    recorders.cycle()
    assert Call(recorders.manager.load_controller, "b").result()
    assert Call(recorders.manager.unload_controller, "free").result()
    assert recorders.states() == {"a": "waiting", "b": "initialized"}
    # what is being switched stays
    assert Call(recorders.manager.unload_controller, "a").result() is False
    assert "because it is being switched" in caplog.text
    del recorders.hw.switch_result
    recorders.cycle()
    assert switch.result()


def test_a_second_switch_waits_for_the_first(recorders):
    recorders.manager.load_controller("a")
    recorders.manager.load_controller("b")
    switches = [Call(recorders.manager.switch_controller, [name], [], 2) for name in ("a", "b")]
    wait_for_switch(recorders)
    recorders.cycle()
    wait_for_switch(recorders)
    assert sorted(recorders.states().values()) == ["initialized", "running"]
    recorders.cycle()
    assert all(switch.result() for switch in switches)


def test_closing_releases_everybody_who_waits(recorders):
    recorders.manager.load_controller("a")
    recorders.manager.load_controller("b")
    switches = [Call(recorders.manager.switch_controller, [name], [], 2) for name in ("a", "b")]
    wait_for_switch(recorders)
    recorders.manager.close()
    assert [switch.result() for switch in switches] == [False, False]


def test_a_switch_that_waits_too_long_is_given_up_and_aborted(recorders):
    recorders.hw.switch_result = lambda info=None: SwitchState.ONGOING
    recorders.manager.load_controller("a")
    switch = Call(recorders.manager.switch_controller, ["a"], [], 2, False, 0.01)
    wait_for_switch(recorders)
    # the clock stands, as while paused: only the wall's time passes
    while switch.is_alive():
        recorders.manager.apply_switch(recorders.time)
        switch.join(0.01)
    # it may have been given up just after the last one
    recorders.manager.apply_switch(recorders.time)
    assert switch.answer is False
    assert recorders.states() == {"a": "aborted"}
    assert recorders.hw.switches[-1] == ([], ["a"])


def test_a_controller_that_raises_in_every_way_harms_nobody(recorders):
    (good,) = recorders.load_and_start("b")
    for name in ("bad_update", "bad_stop"):
        assert recorders.manager.load_controller(name)
        assert recorders.switch(start=[name])
        recorders.cycle(2)
        recorders.switch(stop=[name], strictness=1)
        assert recorders.states()[name] == "stopped"
    good.calls.clear()
    recorders.cycle(5)
    assert good.calls == ["update"] * 5


def test_four_clients_at_once(recorders):
    """Load, switch, unload and list from four threads while the loop runs: nobody gets stuck."""
    names = ["a", "b", "rival", "free"]
    ended = threading.Event()
    counts = dict.fromkeys(names, 0)

    def client(name):
        manager = recorders.manager
        while not ended.is_set():
            if manager.load_controller(name):
                started = manager.switch_controller([name], [], 1)
                manager.list_controllers()
                if started:
                    assert manager.switch_controller([], [name], 2)
                assert manager.unload_controller(name)
                counts[name] += 1

    def cycle_until(condition, what):
        def ends():
            recorders.cycle()
            return condition()

        wait_until(ends, what, 60.0, period=0.0)

    clients = [Call(client, name) for name in names]
    cycle_until(lambda: min(counts.values()) >= 10, lambda: f"ten rounds of each: {counts}")
    ended.set()
    cycle_until(lambda: not any(each.is_alive() for each in clients), "all clients to end")
    assert recorders.states() == {}
