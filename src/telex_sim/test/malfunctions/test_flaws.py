"""Flaws of cameras in pictures."""

from __future__ import annotations

import numpy as np
import pytest

from telex_sim.cameras.optics.flaws import FlawedGlass, Flaws

WIDTH, HEIGHT = 320, 240


def shown(flaws, picture=None, seed=7, size=(WIDTH, HEIGHT)):
    if picture is None:
        picture = np.full((size[1], size[0], 4), 200, np.uint8)
    picture = picture.copy()
    FlawedGlass(*size, seed).show(picture, flaws)
    return picture[..., :3]


@pytest.mark.parametrize(("lost", "grey"), [(1.0, 0), (0.75, 100), (0.05, 195)])
def test_a_dark_camera_loses_light_of_which_pictures_show_the_root(lost, grey):
    assert shown(Flaws(dark=lost)).mean() == pytest.approx(grey, abs=1.0)


@pytest.mark.parametrize("share", [0.1, 0.35, 0.8])
def test_dirt_covers_its_share_of_the_window(share):
    dirty = shown(Flaws(dirty=share))
    assert (dirty.mean(axis=2) < 140.0).mean() == pytest.approx(share, abs=0.06)
    assert dirty.max() == 200 or share > 0.5


def test_dirt_is_in_one_place_in_every_size_and_in_another_on_another_camera():
    dirty = shown(Flaws(dirty=0.3)).astype(float)
    small = shown(Flaws(dirty=0.3), size=(160, 120)).astype(float)
    assert abs(dirty[::2, ::2] - small).mean() < 10.0
    assert abs(dirty - shown(Flaws(dirty=0.3), seed=8)).mean() > 30.0


@pytest.mark.parametrize("share", [0.002, 0.01, 0.05])
def test_blur_spreads_an_edge_by_its_share_of_the_width(share):
    edge = np.zeros((HEIGHT, WIDTH, 4), np.uint8)
    edge[:, WIDTH // 2 :] = 255
    row = shown(Flaws(blurred=share), edge)[HEIGHT // 2, :, 0].astype(float)
    # Of a blurred step, 68 % of the rise lies within one standard deviation to both sides.
    across = np.searchsorted(row, 0.84 * 255.0) - np.searchsorted(row, 0.16 * 255.0)
    assert across == pytest.approx(2.0 * share * WIDTH, abs=2.0, rel=0.15)
