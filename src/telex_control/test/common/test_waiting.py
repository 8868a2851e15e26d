"""The wait that all tests share."""

from __future__ import annotations

import asyncio

import pytest
from waiting import wait_until, wait_until_async


def test_the_first_true_value_is_returned():
    values = iter([0, "", None, [7], [8]])
    assert wait_until(lambda: next(values), "a value", period=0.0) == [7]


def test_what_is_not_there_yet_is_not_yet_so():
    heard = []

    def look():
        heard.append(len(heard) + 1)
        return heard[3]

    assert wait_until(look, period=0.0) == 4


def test_it_fails_with_what_was_awaited_and_what_was_seen_last():
    with pytest.raises(AssertionError, match=r"not within 0.02 s: the lamp; last seen: \[\]"):
        wait_until(list, "the lamp", 0.02)
    with pytest.raises(AssertionError, match=r"the lamp's level; last seen: KeyError"):
        wait_until(lambda: {}["level"], lambda: "the lamp's level", 0.0)


def test_without_words_the_condition_speaks_for_itself():
    brightness = 3
    with pytest.raises(AssertionError, match="lambda: brightness > 5.*; last seen: False"):
        wait_until(lambda: brightness > 5, timeout=0.0)


def test_it_looks_once_more_when_the_time_is_over():
    looks = []
    with pytest.raises(AssertionError):
        wait_until(lambda: looks.append(1), timeout=0.0)
    assert len(looks) == 1


def test_other_errors_end_the_wait():
    with pytest.raises(ZeroDivisionError):
        wait_until(lambda: 1 / 0)


def test_in_an_event_loop_others_go_on():
    async def wait():
        done = []
        asyncio.get_running_loop().call_later(0.01, done.append, 7)
        return await wait_until_async(lambda: done)

    assert asyncio.run(wait()) == [7]
