"""Each robot gets back the line that it had before a trial, whoever else cannot."""

from __future__ import annotations

import pytest
from telex_msgs.msg import LinkState

from telex_training.exercises.model import LINK_FIELDS
from telex_training.ros.apparatus import Apparatus, ApparatusError

PERFECT = dict.fromkeys(LINK_FIELDS, 0.0)


@pytest.fixture
def apparatus():
    """Without ROS: `made` are the calls, to bridges of which those in `gone` do not answer."""
    made = Apparatus.__new__(Apparatus)
    made.made, made.gone = [], set()
    made._links_before = {name: LinkState(profile="perfect") for name in ("", "/second", "/third")}

    def configure(robot, profile, fields):
        if robot in made.gone:
            raise ApparatusError(f"link of {robot}")
        made.made.append((robot, profile))
        made.figures = fields

    made._configure = configure
    return made


@pytest.mark.parametrize(
    ("before", "profile", "figures"),
    [
        (LinkState(profile="by_distance"), "by_distance", {}),
        (LinkState(profile="by_distance", signal_known=True, delay=0.15), "by_distance", {}),
        (LinkState(profile="300", delay=0.3), "300", {**PERFECT, "delay": 0.3}),
        (LinkState(profile="fields", loss=0.2), "", {**PERFECT, "loss": 0.2}),
        (LinkState(profile="lossy", perfect=True), "lossy", PERFECT),
    ],
)
def test_a_line_that_follows_the_signal_follows_it_again(apparatus, before, profile, figures):
    apparatus._links_before = {"": before}
    apparatus.restore_line()
    assert apparatus.made == [("", profile)]
    assert apparatus.figures == figures


def test_a_bridge_that_is_gone_keeps_nobody_else_on_a_bad_line(apparatus):
    apparatus.gone = {"/second", "/third"}
    with pytest.raises(ApparatusError, match="link of /second; link of /third"):
        apparatus.restore_line()
    assert apparatus.made == [("", "perfect")]
    apparatus.gone = {"/third"}
    with pytest.raises(ApparatusError, match="^link of /third$"):
        apparatus.restore_line()
    assert apparatus.made == [("", "perfect"), ("/second", "perfect")]
    apparatus.gone = set()
    apparatus.restore_line()
    apparatus.restore_line()
    assert apparatus.made[2:] == [("/third", "perfect")]
