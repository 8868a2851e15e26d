"""Samples of the truth as messages."""

from __future__ import annotations

from telex_msgs.msg import TruthContact, TruthNames, TruthSample

from ..scene.model import WORLD_FRAME
from .sampler import Names, SampledTruth


def names_message(names: Names, revision: int) -> TruthNames:
    """Make the message of what a sample's numbers are of, without its stamp."""
    return TruthNames(
        revision=revision,
        robot=names.robot,
        joints=list(names.joints),
        groups=list(names.groups),
        links=list(names.links),
        group_of=bytes(names.group_of),
        objects=list(names.objects),
        bodies=list(names.bodies),
        mechanisms=list(names.mechanisms),
        latches=list(names.latches),
    )


def sample_message(sample: SampledTruth) -> TruthSample:
    """Make the message of a sample, without stamp, numbers, wall's time and margin."""
    message = TruthSample(
        base=sample.base,
        twist=sample.twist,
        joints=sample.joints,
        mechanisms=sample.mechanisms,
        latched=sample.latched,
        whole=sample.whole,
        moved=sample.moved,
        poses=sample.poses,
        held=sample.held,
        grip=sample.grip,
        contacts=[
            TruthContact(each.group, each.other, each.peak, each.impulse, each.steps, each.point)
            for each in sample.contacts
        ],
    )
    message.header.frame_id = WORLD_FRAME
    return message
