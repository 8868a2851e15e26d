"""The threads that work for the web nodes."""

from __future__ import annotations

import threading
import time

from web_harness import wait_until

from telex_teleop.web.workers import NewestWorker


def test_who_takes_long_makes_others_wait_for_one_call_only():
    worker, done, greedy = NewestWorker("test"), [], [f"greedy {n}" for n in range(5)]

    def call(key, duration):
        def run():
            time.sleep(duration)
            done.append(key)

        worker.submit(key, run)

    for turn in range(8):
        for key in greedy:
            call(key, 0.03)
        call("modest", 0.0)
        before = len(done)
        wait_until(lambda turn=turn: done.count("modest") > turn)
        place = [number for number, key in enumerate(done) if key == "modest"][turn]
        # At the beginning nobody knows yet who takes long; later one call may run already.
        assert turn == 0 or place - before <= 1
    wait_until(lambda: worker.backlog == 0)
    counts = [done.count(key) for key in greedy]
    assert max(counts) - min(counts) <= 1  # they share what is left


def test_keys_that_come_and_go_do_not_hold_back_one_that_stays():
    worker, done, crowd, calls = NewestWorker("test"), [], 8, 90

    def visit(number):
        time.sleep(0.002)
        done.append("visitor")
        worker.cancel(number)
        if len(done) < calls:
            worker.submit(number + crowd, lambda: visit(number + crowd))

    def stay():
        time.sleep(0.002)
        done.append("stays")
        if len(done) < calls:
            worker.submit("stays", stay)

    worker.submit("stays", stay)
    for number in range(crowd):
        worker.submit(number, lambda number=number: visit(number))
    wait_until(lambda: len(done) >= calls and worker.backlog == 0)
    assert done[30:].count("stays") >= 3  # of a fair share of six


def test_the_newest_call_of_a_key_runs_unless_it_is_forgotten():
    worker, done, release = NewestWorker("test", niceness=1), [], threading.Event()
    worker.submit("first", release.wait)
    wait_until(lambda: worker.backlog == 0)
    for number in range(3):
        worker.submit("a", lambda number=number: done.append(number))
        worker.submit("b", lambda: done.append("b"))
    worker.cancel("b")
    worker.submit("broken", lambda: 1 / 0)
    release.set()
    wait_until(lambda: worker.backlog == 0)
    worker.submit("c", lambda: done.append("c"))
    wait_until(lambda: "c" in done)
    assert done == [2, "c"]
