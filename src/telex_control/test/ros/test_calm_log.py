"""A node's log while others send nonsense."""

from __future__ import annotations

import logging

from telex_control.common.calm_log import BURST, LONGEST, CalmLog


def record(text, *arguments, level=logging.WARNING, line=7):
    return logging.LogRecord("rosout", level, "node.py", line, text, arguments, None)


def test_long_lines_are_cut():
    log, long = CalmLog(), record("there is no object %r", "x" * 100000, level=logging.ERROR)
    assert log.filter(long)
    assert long.getMessage().startswith("there is no object 'xxx")
    assert len(long.getMessage()) < LONGEST + 50
    short = record("there is no object %r", "x")
    assert log.filter(short)
    assert short.getMessage() == "there is no object 'x'"


def test_floods_of_warnings_are_thinned_out_each_by_itself():
    now = [5.0]
    log = CalmLog(lambda: now[0])
    assert sum(log.filter(record("bad")) for _ in range(1000)) == BURST
    assert log.filter(record("bad", line=8))
    assert log.filter(record("fatal", level=logging.ERROR))
    now[0] += 3.0
    assert sum(log.filter(record("bad")) for _ in range(1000)) == 3


def test_a_line_with_wrong_arguments_does_not_stop_whoever_logs_it():
    assert CalmLog().filter(record("%d objects", "many"))
    assert CalmLog().filter(record("%s and %s", 1))
