"""What is reconfigured while a trial runs is noticed."""

from __future__ import annotations

import copy

from waiting import wait_until

from telex_training.ros.configuration import ConfigurationWatch


def test_what_changes_is_told_by_its_name():
    config = {"cameras": {"rate": 10, "front": {"exposure": {"ev": 0}}}, "gains of turret": {}}
    told = []
    watch = ConfigurationWatch(told.append, lambda: copy.deepcopy(config), period=0.01)
    try:
        wait_until(lambda: watch.changed(config) == [])
        config["cameras"]["front"]["exposure"]["ev"] = -1
        wait_until(lambda: told == ["cameras"])
        config["gains of turret"] = {"p": 3.0}
        wait_until(lambda: told == ["cameras", "gains of turret"])
    finally:
        watch.close()


def test_what_cannot_be_read_for_a_while_has_not_changed():
    watch = ConfigurationWatch(lambda _: None, dict, period=10.0)
    watch.close()
    assert watch.changed({"cameras": {"b": 1, "a": 2}, "gains of turret": {"p": 1}}) == []
    assert watch.changed({}) == []
    assert watch.changed({"cameras": {"a": 2, "b": 1}}) == []
    assert watch.changed({"cameras": {"a": 2, "b": 2}}) == ["cameras"]
