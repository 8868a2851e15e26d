"""The logic of the command lines on a manager in memory; tests/nodes/command_lines runs them."""

from __future__ import annotations

import socket
import threading

import pytest
from controller_manager_msgs.msg import ControllerState, HardwareInterfaceResources

from telex_control.command_lines import (
    controller_group,
    controller_manager,
    last_calls,
    spawner,
    unspawner,
)
from telex_control.common.params import ConfigError
from telex_control.manager.client import STRICT


class FakeManager:
    """Has the methods of ControllerManagerClient; knows the controllers a, b and c."""

    prefix = "controller_manager"

    def __init__(self, **states):
        self.states = dict(states)
        self.calls = []

    def list_controllers(self):
        claims = [HardwareInterfaceResources("i::E", ["j"]), HardwareInterfaceResources("i::V", [])]
        return [
            ControllerState(
                name=name, state=state, type="t", claimed_resources=[*claims, claims[0]]
            )
            for name, state in self.states.items()
        ]

    def list_controller_types(self):
        return ["x/X", "y/Y"]

    def load(self, name):
        self.calls.append(f"load {name}")
        if name not in "abc" or name in self.states:
            return False
        self.states[name] = "initialized"
        return True

    def unload(self, name):
        self.calls.append(f"unload {name}")
        if self.states.get(name, "running") == "running":
            return False
        del self.states[name]
        return True

    def switch(self, start, stop, strictness=STRICT):
        self.calls.append(f"switch +{''.join(start)} -{''.join(stop)} {strictness}")
        if strictness == STRICT:
            known = all(name in self.states for name in [*start, *stop])
            if not known or any(self.states[name] != "running" for name in stop):
                return False
        self.states.update(dict.fromkeys(start, "running"))
        self.states.update(dict.fromkeys(stop, "stopped"))
        return True

    def reload_libraries(self, force_kill):
        if self.states and not force_kill:
            return False
        self.states.clear()
        return True


def run(client, command, *names):
    controller_manager.COMMANDS[command](client, list(names))


@pytest.mark.parametrize(
    ("command", "names", "printed"),
    [
        ("load", ["b", "x"], "Loaded 'b'\nError when loading 'x'\n"),
        ("unload", ["s", "a"], "Unloaded 's' successfully\nError when unloading 'a'\n"),
        ("start", ["s"], "Started ['s'] successfully\n"),
        ("stop", ["a"], "Stopped ['a'] successfully\n"),
        ("stop", ["s"], "Error when starting [] and stopping ['s']\n"),
        ("sp", ["b"], "Loaded 'b'\nStarted ['b'] successfully\n"),
        ("kill", ["a"], "Stopped ['a'] successfully\nUnloaded 'a' successfully\n"),
        ("list", [], "'a' - 'i::E+i::V' ( running )\n's' - 'i::E+i::V' ( stopped )\n"),
        ("list-types", [], "x/X\ny/Y\n"),
        ("reload-libraries", [], "Restore: False\nSuccessfully reloaded libraries\n"),
    ],
)
def test_output_is_upstreams(command, names, printed, capsys):
    run(FakeManager(a="running", s="stopped"), command, *names)
    assert capsys.readouterr().out == printed


def test_an_empty_list_is_told(capsys):
    run(FakeManager(), "lc")
    assert capsys.readouterr().out == "No controllers are loaded in mechanism control\n"


def test_reloading_restores_what_was(capsys):
    client = FakeManager(a="running", b="stopped")
    run(client, "reload-libraries", "--restore")
    assert client.states == {"a": "running", "b": "initialized"}
    assert capsys.readouterr().out == (
        "Restore: True\nSuccessfully reloaded libraries\nControllers restored to original state\n"
    )


def test_reloading_without_force_is_refused_while_controllers_are_loaded(capsys):
    assert not controller_manager.reload_libraries(FakeManager(a="running"), force_kill=False)
    assert "Failed to reload libraries. Do you still have" in capsys.readouterr().out


def test_starting_and_stopping_in_one_switch(capsys):
    client = FakeManager(a="running", b="stopped")
    assert controller_manager.switch(client, start=["b"], stop=["a"])
    assert capsys.readouterr().out == "Started ['b'] successfully\nStopped ['a'] successfully\n"


GROUPS = {"one": ["a", "c"], "two": ["b", "c"]}


def test_groups_are_switched_in_one_switch():
    client = FakeManager(a="running", c="running")
    controller_group.switch_group(client, GROUPS, "two")
    assert client.calls == ["load b", f"switch +b -a {STRICT}"]
    controller_group.switch_group(client, GROUPS, "two")
    assert client.calls[-1] == f"switch + - {STRICT}"


def test_a_group_that_cannot_be_loaded_changes_nothing(capsys):
    client = FakeManager(a="running")
    controller_group.switch_group(client, {**GROUPS, "bad": ["x"]}, "bad")
    assert client.states == {"a": "running"}
    assert capsys.readouterr().out == "Error when loading 'x'\nCancel group switching\n"


def test_what_a_variant_lacks_is_left_out_of_its_groups(capsys):
    client = FakeManager(a="running", c="running")
    groups = {"one": ["a", "x"], "two": ["b", "y"], "three": ["x"]}
    controller_group.switch_group(client, groups, "two", gone=["y"])
    controller_group.switch_group(client, groups, "one", gone=["x"])
    assert client.calls == ["load b", f"switch +b -a {STRICT}", f"switch +a -b {STRICT}"]
    assert "Left out: 'y', for this robot has none of its joints\n" in capsys.readouterr().out
    controller_group.switch_group(client, groups, "three", gone=["x"])
    assert client.states == {"a": "running", "b": "stopped", "c": "running"}
    assert capsys.readouterr().out.endswith("Cancel group switching\n")


def test_a_controller_is_absent_when_the_robot_has_none_of_its_joints(monkeypatch):
    description = (
        '<robot name="r"><joint name="elbow" type="continuous"/><transmission name="t">'
        '<type>transmission_interface/SimpleTransmission</type><joint name="elbow">'
        "<hardwareInterface>hardware_interface/EffortJointInterface</hardwareInterface></joint>"
        '<actuator name="m"><mechanicalReduction>1</mechanicalReduction></actuator>'
        "</transmission></robot>"
    )
    params = {
        "robot_description": description,
        "arm": {"joints": ["elbow", "slide"]},
        "gripper": {"left_joints": ["finger"], "right_joints": ["thumb"]},
        "states": {"type": "x/X"},
    }
    monkeypatch.setattr(controller_group.rospy, "get_param", params.get)
    assert controller_group.absent(["arm", "gripper", "states", "ghost"]) == ["gripper"]
    del params["robot_description"]
    assert controller_group.absent(["gripper"]) == []


def test_groups_are_listed_in_alphabetical_order(capsys):
    controller_group.list_groups({"z": ["b"], "a": []})
    assert capsys.readouterr().out == "Number of groups: 2\n  a\n  z\n      b\n"


@pytest.mark.parametrize(
    ("value", "named"),
    [
        (["a"], "/controller_groups is"),
        ({"one": "a"}, "/controller_groups/one is 'a'"),
        ({"one": [1]}, "/controller_groups/one is"),
    ],
)
def test_wrong_groups_are_named(value, named):
    with pytest.raises(ConfigError, match=named):
        controller_group.groups_of(value, "/controller_groups")


@pytest.mark.parametrize(
    ("arguments", "timeout"),
    [
        (["a"], 30.0),
        (["--timeout", "5", "a"], 5.0),
        (["--timeout", "0", "a"], None),
        (["--timeout=-1", "a"], None),
        (["--no-timeout", "a"], None),
    ],
)
def test_the_spawners_timeout(arguments, timeout):
    assert spawner.parse(arguments).timeout == timeout


def test_the_spawners_arguments_are_upstreams():
    options = spawner.parse(
        ["--stopped", "--wait-for", "go", "--namespace", "/r", "--shutdown-timeout", "3", "a", "b"]
    )
    assert (options.stopped, options.wait_for, options.namespace) == (True, "go", "/r")
    assert options.controllers == ["a", "b"]
    for wrong in ([], ["--unknown", "a"], ["--timeout", "soon", "a"]):
        with pytest.raises(SystemExit) as caught:
            spawner.parse(wrong)
        assert caught.value.code == 2


def test_a_file_names_its_controllers(tmp_path):
    file = tmp_path / "controllers.yaml"
    file.write_text("a: {type: x/X}\ngains: {p: 1}\n7: {type: x/X}\n")
    params = spawner.read_file(str(file))
    assert list(params) == ["a", "gains", "7"]
    assert spawner.controllers_of(params) == ["a", "7"]


@pytest.mark.parametrize(
    ("text", "named"),
    [
        (None, "No such file"),
        ("a: [", "while parsing"),
        ("just words", "a mapping of controller names"),
        ("gains: {p: 1}", "a mapping of controller names"),
        ("!!python/object/apply:os.getcwd []", "could not determine a constructor"),
    ],
)
def test_wrong_files_are_named(tmp_path, text, named):
    file = tmp_path / "controllers.yaml"
    if text is not None:
        file.write_text(text)
    with pytest.raises(spawner.SpawnerError, match=named) as caught:
        spawner.read_file(str(file))
    assert str(file) in str(caught.value)


@pytest.fixture(autouse=True)
def patient(monkeypatch):
    monkeypatch.setattr(last_calls, "STALL", 30.0)


@pytest.fixture
def spawned(monkeypatch):
    def make(client):
        monkeypatch.setattr(spawner, "ControllerManagerClient", lambda namespace: client)
        return spawner.Spawner("")

    return make


def test_the_spawner_starts_all_in_one_switch_and_ends_in_reverse(spawned):
    client = FakeManager()
    tested = spawned(client)
    assert tested.load(["a", "x", "b"]) == ["a", "b"]
    tested.start()
    assert client.calls == ["load a", "load x", "load b", f"switch +ab - {STRICT}"]
    client.calls.clear()
    tested.stop()
    assert client.calls == [f"switch + -ba {STRICT}", "unload b", "unload a"]
    assert client.states == {}


def test_the_spawner_unloads_also_what_others_have_stopped(spawned):
    client = FakeManager()
    tested = spawned(client)
    tested.load(["a", "b"])
    tested.start()
    client.states["b"] = "stopped"
    tested.stop()
    assert client.states == {}


def test_a_spawner_that_comes_anew_takes_over_what_the_former_one_has_left(spawned):
    # Killed before it had loaded c and started b; a has been stopped by somebody since.
    client = FakeManager(a="stopped", b="initialized")
    tested = spawned(client)
    settled = tested.adopt(["a", "b", "c"])
    assert settled == ["a"]
    assert tested.load(["a", "b", "c"]) == ["a", "b", "c"]
    tested.start(settled)
    assert client.calls == ["load c", f"switch +bc - {STRICT}"]
    tested.stop()
    assert client.states == {}


def test_a_spawner_that_comes_anew_disturbs_nothing_that_runs(spawned):
    client = FakeManager(a="running", b="running")
    tested = spawned(client)
    settled = tested.adopt(["a", "b"])
    tested.load(["a", "b"])
    tested.start(settled)
    assert client.calls == []


class SlowManager(FakeManager):
    """Answers only when it is told to."""

    def __init__(self, **states):
        super().__init__(**states)
        self.told = threading.Event()

    def switch(self, *arguments):
        self.told.wait(30.0)
        return super().switch(*arguments)


@pytest.fixture
def ending(spawned, monkeypatch):
    """Make a manager that has stopped answering, and what a spawner and an unspawner do at last."""
    monkeypatch.setattr(last_calls, "STALL", 0.05)
    managers = []

    def make():
        client = SlowManager()
        other = SlowManager(a="running")
        for each in (client, other):
            each.told.set()
        tested, unspawned = spawned(client), unspawner.Unspawner(other, ["a"])
        tested.load(["a"])
        tested.start()
        unspawned.stop_running()
        for each in (client, other):
            each.told.clear()
        managers.extend([client, other])
        return [(client, {}, tested.stop), (other, {"a": "running"}, unspawned.restart)]

    yield make
    for each in managers:
        each.told.set()


@pytest.fixture
def listener(monkeypatch):
    """Who takes connections at the address of the manager."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        server.settimeout(30.0)
        address = f"rosrpc://127.0.0.1:{server.getsockname()[1]}"
        monkeypatch.setattr(last_calls, "manager_address", lambda prefix: address)
        yield server


def test_nobody_waits_for_a_manager_that_is_gone(ending, listener):
    listener.close()
    for client, wanted, end in ending():
        end()
        assert not client.told.is_set()
        assert client.states != wanted


def test_nobody_waits_for_a_manager_that_nobody_knows(ending, monkeypatch):
    monkeypatch.setattr(last_calls, "manager_address", lambda prefix: None)
    for client, wanted, end in ending():
        end()
        assert client.states != wanted


def test_a_manager_that_takes_connections_is_waited_for(ending, listener):
    for client, wanted, end in ending():
        ends = threading.Thread(target=end, daemon=True)
        ends.start()
        for _ in range(3):
            listener.accept()[0].close()
        assert ends.is_alive()
        client.told.set()
        ends.join(10.0)
        assert client.states == wanted


def test_one_that_takes_connections_and_never_answers_is_given_up(ending, listener, monkeypatch):
    monkeypatch.setattr(last_calls, "LONGEST_STALL", 0.3)
    for client, wanted, end in ending():
        end()
        assert client.states != wanted


def test_the_unspawner_stops_what_runs_and_starts_it_again():
    client = FakeManager(a="running", b="stopped", c="running")
    tested = unspawner.Unspawner(client, ["b", "a"])
    tested.stop_running()
    assert client.states == {"a": "stopped", "b": "stopped", "c": "running"}
    client.states["b"] = "running"
    tested.stop_running()
    tested.restart()
    assert client.states == {"a": "running", "b": "running", "c": "running"}
    client.calls.clear()
    tested.stop_running()
    assert client.calls == []


def test_the_unspawner_takes_names():
    assert unspawner.parse(["a", "b", "a"]) == ["a", "b"]
    with pytest.raises(SystemExit):
        unspawner.parse([])
