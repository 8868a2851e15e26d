"""An answer of the master that was overtaken hides no publisher."""

from __future__ import annotations

import threading

import pytest
from rospy.impl.registration import RegManager

from telex_control.ros.publisher_updates import miss_no_publisher


@pytest.mark.parametrize("older_answer", [[], ["http://first:1"], ["http://gone:1"]])
def test_an_overtaken_answer_hides_no_publisher(monkeypatch, older_answer):
    monkeypatch.setattr(RegManager, "publisher_update", RegManager.publisher_update)
    miss_no_publisher()
    manager = RegManager.__new__(RegManager)  # its initialiser would outlive the test
    manager.cond, manager.updates = threading.Condition(), []
    manager.publisher_update("/topic", ["http://first:1", "http://second:2"])
    manager.publisher_update("/other", ["http://third:3"])
    manager.publisher_update("/topic", older_answer)
    # rospy takes the last one of a topic, and drops its others.
    (last,) = (set(uris) for topic, uris in manager.updates if topic == "/topic")
    assert last == {"http://first:1", "http://second:2", *older_answer}
    assert ("/other", ["http://third:3"]) in manager.updates
