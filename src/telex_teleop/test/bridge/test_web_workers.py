"""The threads that work for the web nodes."""

from __future__ import annotations

import threading
import time
from types import SimpleNamespace
from unittest import mock

import pytest
from aiohttp.test_utils import make_mocked_request
from waiting import wait_until

from telex_teleop.web import workers
from telex_teleop.web.video.viewers import client_of
from telex_teleop.web.workers import NewestWorker


@pytest.fixture
def spend(monkeypatch):
    """Take some time, which is what a worker measures, however busy the machine is."""
    now = [0.0]
    monkeypatch.setattr(workers, "time", SimpleNamespace(monotonic=lambda: now[0]))

    def spend(duration):
        time.sleep(duration)
        now[0] += duration

    return spend


def test_who_takes_long_makes_others_wait_for_one_call_only(spend):
    worker, done, greedy = NewestWorker("test"), [], [f"greedy {n}" for n in range(5)]

    def call(key, duration):
        def run():
            spend(duration)
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


def test_keys_that_come_and_go_do_not_hold_back_one_that_stays(spend):
    worker, done, crowd, calls = NewestWorker("test"), [], 8, 90

    def visit(number):
        spend(0.002)
        done.append("visitor")
        worker.cancel(number)
        if len(done) < calls:
            worker.submit(number + crowd, lambda: visit(number + crowd))

    def stay():
        spend(0.002)
        done.append("stays")
        if len(done) < calls:
            worker.submit("stays", stay)

    worker.submit("stays", stay)
    for number in range(crowd):
        worker.submit(number, lambda number=number: visit(number))
    wait_until(lambda: len(done) >= calls and worker.backlog == 0)
    assert done[30:].count("stays") >= 3  # of a fair share of six


def test_time_is_shared_by_clients_whatever_each_asks_for(spend):
    worker, done, calls = NewestWorker("test"), [], 120

    def go_on(key, clients):
        def run():
            spend(0.002)
            done.append(key)
            if len(done) < calls:
                worker.submit(key, run, clients)

        worker.submit(key, run, clients)

    for number in range(6):
        go_on(f"many {number}", ["many"])
    go_on("one", ["one"])
    go_on("both", ["many", "one"])
    wait_until(lambda: len(done) >= calls and worker.backlog == 0)
    late = done[30:]
    # Half of the time is for the client with one key of its own and one that both pay for.
    mine = late.count("one") + 0.5 * late.count("both")
    assert 0.4 < mine / len(late) < 0.6
    counts = [late.count(f"many {number}") for number in range(6)]
    assert max(counts) - min(counts) <= 3


def test_a_client_that_wants_something_no_longer_does_not_pay_for_it(spend):
    worker, done, release = NewestWorker("test"), [], threading.Event()

    def want(key, *clients):
        def run():
            spend(0.01)
            done.append(key)

        worker.submit(key, run, clients)

    worker.submit("busy", release.wait)
    want("both", "first", "second")
    want("both", "second")
    want("of the second", "second")
    want("of the first", "first")
    release.set()
    wait_until(lambda: len(done) == 3)
    assert done == ["both", "of the first", "of the second"]
    for key in ("busy", *done):
        worker.cancel(key)
    wait_until(lambda: not (worker._payers or worker._keys or len(worker._clients)))


@pytest.mark.parametrize(
    ("address", "other", "shared"),
    [
        ("192.0.2.5", "192.0.2.5", True),
        ("192.0.2.5", "192.0.2.6", False),
        ("127.0.0.1", "127.0.0.1", False),
    ],
)
def test_connections_of_an_address_are_one_client_except_on_this_machine(address, other, shared):
    def client(remote, connection=None):
        transport = mock.Mock(get_extra_info=lambda *_: (remote, 1234))
        return client_of(make_mocked_request("GET", "/video", transport=transport), connection)

    assert (client(address, "a") == client(other, "b")) is shared
    assert client(address) == client(address)


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
