"""Previews lose detail and full pictures become smaller while previews fall behind."""

import pytest

from telex_sim.cameras.ros.size_by_load import SizeByLoad

FULL, COARSER, SMALLER = (1.0, 1.0), (1.0, 0.75), (0.75, 0.75)
SMALL, SMALLEST = (0.5, 0.75), (0.4, 0.6)


def run(sizes, seconds, previews, asked=50.0, busy=1.0, begin=0.0):
    """Let time pass in which so many previews come in each second; scale and detail in each."""
    seen = []
    for second in range(seconds):
        for _ in range(previews):
            sizes.shown()
        sizes.rested(1.0 - busy)
        sizes.judge(begin + second + 1.0, asked)
        seen.append((sizes.step.scale, sizes.step.preview_detail))
    return seen


@pytest.fixture
def sizes():
    found = SizeByLoad(0.4)
    found.judge(0.0, 50.0)
    return found


def test_previews_lose_detail_first_and_full_pictures_are_not_below_the_smallest(sizes):
    assert sizes.step.shadow_spacing == 1.0
    steps = run(sizes, 9, previews=40)
    assert steps == [FULL, *[COARSER] * 2, *[SMALLER] * 2, *[SMALL] * 2, *[SMALLEST] * 2]
    assert sizes.step.shadow_spacing == 6.0
    assert sizes.step.coarse


def test_who_is_far_behind_loses_two_steps_at_once(sizes):
    steps = run(sizes, 6, previews=25)
    assert steps == [FULL, *[SMALLER] * 2, *[SMALLEST] * 3]


def test_previews_may_give_way_a_little_first(sizes):
    assert set(run(sizes, 10, previews=46)) == {FULL}


def test_who_has_time_is_not_behind_for_want_of_it(sizes):
    assert set(run(sizes, 10, previews=25, busy=0.5)) == {FULL}


def test_waiting_for_poses_between_pictures_is_no_time_left(sizes):
    assert run(sizes, 2, previews=40, busy=0.92) == [FULL, COARSER]


def test_nobody_watches_previews(sizes):
    assert set(run(sizes, 10, previews=0, asked=0.0)) == {FULL}


def test_one_bad_second_changes_nothing(sizes):
    run(sizes, 1, previews=10)
    run(sizes, 1, previews=50, busy=0.85, begin=1.0)
    assert run(sizes, 1, previews=10, begin=2.0) == [FULL]


def test_larger_again_when_there_is_time_and_ever_more_seldom_where_it_was_too_much(sizes):
    run(sizes, 2, previews=40)
    assert sizes.step.coarse_previews
    eased = run(sizes, 6, previews=50, busy=0.6, begin=2.0)
    assert eased == [COARSER] * 4 + [FULL] * 2
    run(sizes, 2, previews=40, begin=8.0)
    assert run(sizes, 12, previews=50, busy=0.6, begin=10.0) == [COARSER] * 9 + [FULL] * 3


def test_the_time_before_a_silence_does_not_count(sizes):
    sizes.judge(100.0, 50.0)
    assert set(run(sizes, 1, previews=10, begin=100.0)) == {FULL}


def test_never_where_that_is_not_wanted():
    sizes = SizeByLoad(1.0)
    sizes.judge(0.0, 50.0)
    assert set(run(sizes, 10, previews=10)) == {FULL}


class TestLarger:
    @pytest.fixture
    def sizes(self):
        found = SizeByLoad(0.5, largest=2.0)
        found.judge(0.0, 0.0)
        return found

    def test_full_pictures_grow_where_there_is_time_for_so_many_more_pixels(self, sizes):
        scales = [scale for scale, _ in run(sizes, 20, previews=0, asked=0.0, busy=0.1)]
        assert scales[0] == 1.0
        assert sorted(set(scales)) == [1.0, 1.5, 2.0]
        assert scales == sorted(scales)

    def test_what_they_would_cost_is_asked_first(self, sizes):
        assert set(run(sizes, 30, previews=50, busy=0.5)) == {FULL}

    def test_the_largest_is_kept(self):
        sizes = SizeByLoad(1.0, largest=1.5)
        sizes.judge(0.0, 0.0)
        assert {scale for scale, _ in run(sizes, 30, previews=0, busy=0.05)} == {1.0, 1.5}

    def test_they_shrink_before_anything_falls_behind(self, sizes):
        run(sizes, 20, previews=0, asked=0.0, busy=0.1)
        steps = run(sizes, 4, previews=50, busy=0.95, begin=20.0)
        assert [scale for scale, _ in steps] == [2.0, 1.5, 1.5, 1.0]
        assert run(sizes, 4, previews=50, busy=0.95, begin=24.0) == [FULL] * 4
