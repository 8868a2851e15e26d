"""What a crashed node leaves to its successor."""

from __future__ import annotations

import errno
import os
import stat

import pytest

from telex_control.ros.run_memory import RunMemory


@pytest.fixture
def path(tmp_path):
    return str(tmp_path / "run" / "telex.node.memory.json")


def test_a_successor_recalls_what_a_crashed_node_kept_last(path):
    memory = RunMemory(path)
    assert memory.recall() == {}
    memory.keep(steps=123456, e_stop=True)
    memory.keep(steps=7, e_stop=False)
    assert RunMemory(path).recall() == {"steps": 7, "e_stop": False}


def test_a_successor_may_keep_less_than_was_there(path):
    RunMemory(path).keep(text="x" * 1000)
    successor = RunMemory(path)
    successor.recall()
    successor.keep(a=1)
    assert RunMemory(path).recall() == {"a": 1}


def test_an_end_in_order_leaves_nothing(path):
    memory = RunMemory(path)
    memory.keep(token="secret")
    memory.forget()
    assert not os.path.exists(path)
    memory.keep(token="late")
    memory.forget()
    assert RunMemory(path).recall() == {}


def test_only_its_user_can_read_it(path):
    RunMemory(path).keep(token="secret")
    assert stat.S_IMODE(os.stat(path).st_mode) == 0o600


def test_a_file_that_others_can_read_is_not_used(path):
    RunMemory(path).keep(token="theirs")
    os.chmod(path, 0o644)
    memory = RunMemory(path)
    assert memory.recall() == {}
    memory.keep(token="ours")
    with open(path) as file:
        assert "ours" not in file.read()


@pytest.mark.parametrize("left", ["", "{", "[1]", "3", '{"a": 1'])
def test_what_makes_no_sense_is_not_recalled(path, left):
    RunMemory(path).keep()
    with open(path, "w") as file:
        file.write(left)
    assert RunMemory(path).recall() == {}


def test_without_a_place_nothing_is_kept_and_nothing_fails(tmp_path):
    (tmp_path / "file").write_text("")
    memory = RunMemory(str(tmp_path / "file" / "memory.json"))
    memory.keep(a=1)
    assert memory.recall() == {}
    memory.forget()


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EDQUOT, errno.EIO])
@pytest.mark.parametrize("call", ["pwrite", "pread"])
def test_a_file_that_fails_is_given_up_with_one_warning(path, monkeypatch, caplog, call, number):
    RunMemory(path).keep(steps=1)
    memory = RunMemory(path)

    def fail(*_arguments):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(os, call, fail)
    for steps in range(3):
        recalled = memory.recall()
        memory.keep(steps=steps)
    assert recalled == {}
    warnings = [each.getMessage() for each in caplog.records if each.levelname == "WARNING"]
    assert len(warnings) == 1
    assert path in warnings[0]
    assert os.strerror(number) in warnings[0]
    monkeypatch.undo()
    assert RunMemory(path).recall() == {}
