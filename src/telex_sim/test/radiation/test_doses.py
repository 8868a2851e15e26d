"""Doses over time, and the lives of cameras."""

import math

import numpy as np
import pytest

from telex_control.common.params import ConfigError, read_struct
from telex_sim.radiation.dosimetry import Doses, DosimetryConfig


class TestDoses:
    def test_are_the_integral_of_rates_that_change_evenly(self):
        doses = Doses([40.0, 0.0])
        for second in range(11):
            doses.receive(np.array([3600.0, 360.0 * second]), 5.0 + second)
        assert doses.doses == pytest.approx([50.0, 5.0])
        assert doses.rates == pytest.approx([3600.0, 3600.0])

    def test_begin_with_the_first_look(self):
        doses = Doses([0.0])
        doses.receive(np.array([100.0]), 1000.0)
        assert doses.doses == [0.0]


class TestDosimetryConfig:
    def test_cameras_live_about_88_gray_each_in_its_way(self):
        lives = [DosimetryConfig(seed=seed).life("arm") for seed in range(400)]
        assert min(lives) >= 88.0 * 0.7
        assert max(lives) <= 88.0 * 1.3
        assert np.mean(lives) == pytest.approx(88.0, rel=0.03)
        config = DosimetryConfig()
        assert config.life("arm") == config.life("arm") != config.life("front")

    @pytest.mark.parametrize(
        ("params", "message"),
        [
            ({"rate": 0.0}, "rate is 0"),
            ({"history": {"arm": math.nan}}, "history/arm is nan; it must be finite"),
            ({"history": {"arm": -1.0}}, "history/arm is -1.0 Gy; 0 to 100000 is possible"),
            ({"camera_life": math.inf}, "camera_life is inf"),
            ({"spread": 1.0}, "spread is 1"),
            (
                {"electronics": {"robot": {"link": "base_link", "joints": []}}},
                "electronics has 'robot', which is the hull's name; another one is needed",
            ),
        ],
    )
    def test_refuses_what_makes_no_sense(self, params, message):
        with pytest.raises(ConfigError, match=message):
            read_struct(DosimetryConfig, params)

    def test_names_links_that_the_robot_lacks(self):
        config = DosimetryConfig(hull="hull", tool="probe")
        assert config.lacking(["hull", "probe"]) == []
        assert config.lacking(["hull"]) == ["probe"]
        assert DosimetryConfig().lacking([]) == []
