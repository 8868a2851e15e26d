"""Trees, chains and Denavit-Hartenberg parameters; the shipped robot's stand in tests/."""

from __future__ import annotations

import math

import numpy as np
import PyKDL
import pytest

from telex_control.kinematics import (
    Chain,
    KinematicsError,
    UrdfTree,
    dh_chain,
    kdl_tree,
)
from telex_control.urdf.joints import UrdfError
from telex_control.urdf.model import read_robot

LIMIT = '<limit lower="-3" upper="3" velocity="1" effort="1"/>'


def link(name, inertial=""):
    return f'<link name="{name}">{inertial}</link>'


def joint(name, parent, child, kind="revolute", xyz="0 0 0", rpy="0 0 0", axis="0 0 1"):
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/>{LIMIT}</joint>'
    )


def robot(*elements):
    return read_robot(f'<robot name="r">{"".join(elements)}</robot>')


ARM = robot(
    *(link(name) for name in ("base", "yaw", "pitch", "slide", "hand", "camera")),
    joint("yaw_joint", "base", "yaw", xyz="0.1 0 0.2"),
    joint("pitch_joint", "yaw", "pitch", xyz="0 0 0.3", rpy=f"{-math.pi / 2} 0 0"),
    joint("slide_joint", "pitch", "slide", kind="prismatic", xyz="0.5 0 0", axis="2 0 0"),
    joint("hand_joint", "slide", "hand", kind="fixed", xyz="0 0.25 0"),
    joint("camera_joint", "base", "camera", kind="continuous"),
)


# ---- trees


@pytest.mark.parametrize(
    ("elements", "named"),
    [
        ([], "roots none"),
        ([link("a"), link("b")], "roots a, b"),
        ([link("a"), joint("j", "a", "b")], "'j': there is no link 'b', its child"),
        ([link("b"), joint("j", "a", "b")], "'j': there is no link 'a', its parent"),
        (
            [link("a"), link("b"), joint("j", "a", "b"), joint("k", "a", "b")],
            "'b' is carried by two joints, 'j' and 'k'",
        ),
        (
            [link("a"), link("b"), link("c"), joint("j", "b", "c"), joint("k", "c", "b")],
            "only 1 of 3 links hang on 'a'",
        ),
        ([link("a"), link("b"), joint("j", "a", "b", kind="planar")], "'j' is of type 'planar'"),
        ([link("a"), link("b"), joint("j", "a", "b", axis="0 0 0")], "'j': axis is"),
        ([link("a"), link("b"), joint("j", "a", "b", xyz="0 0")], '<origin xyz="0 0">; 3 finite'),
        ([link("a"), link("b"), joint("j", "a", "b", rpy="0 nan 0")], "3 finite numbers"),
        ([link("a"), '<joint name="j" type="fixed"/>'], "'j' has no <parent"),
        ([link("a", "<inertial><mass value='1'/></inertial>")], "'a': its <inertial> needs"),
        (
            [link("a", "<inertial><mass value='x'/><inertia ixx='1'/></inertial>")],
            "a finite number is needed",
        ),
    ],
)
def test_wrong_trees_are_named(elements, named):
    with pytest.raises(UrdfError, match=named):
        UrdfTree(robot(*elements))


def test_a_kdl_tree_has_all_links_and_joints():
    tree = kdl_tree(UrdfTree(ARM))
    assert tree.getNrOfSegments() == 5
    assert tree.getNrOfJoints() == 4


def test_kdl_gets_inertias_about_the_centre_of_mass_in_the_links_axes():
    turned = (
        '<inertial><origin xyz="0.1 0.2 0.3" rpy="0 0 1.5707963267948966"/><mass value="2"/>'
        '<inertia ixx="1" iyy="2" izz="2.5" ixy="0.1" ixz="0" iyz="0"/></inertial>'
    )
    made = robot(link("a"), link("b", turned), joint("j", "a", "b", xyz="1 1 1"))
    chain = Chain(made, "a", "b").kdl
    body = chain.getSegment(0).getInertia()
    assert body.getMass() == 2.0
    assert list(body.getCOG()) == pytest.approx([0.1, 0.2, 0.3])
    # about the link's origin: Steiner's part comes to it
    moments = [body.getRotationalInertia()[index] for index in range(9)]
    assert moments == pytest.approx(
        [
            *(2 + 2 * (0.2**2 + 0.3**2), -0.1 - 2 * 0.1 * 0.2, -2 * 0.1 * 0.3),
            *(-0.1 - 2 * 0.1 * 0.2, 1 + 2 * (0.1**2 + 0.3**2), -2 * 0.2 * 0.3),
            *(-2 * 0.1 * 0.3, -2 * 0.2 * 0.3, 2.5 + 2 * (0.1**2 + 0.2**2)),
        ]
    )


def test_kdl_weighs_a_pendulum_right():
    body = (
        '<inertial><origin xyz="0.5 0 0"/><mass value="3"/>'
        '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    )
    made = robot(link("a"), link("b", body), joint("j", "a", "b", axis="0 -1 0"))
    chain = Chain(made, "a", "b").kdl
    torque, angle = PyKDL.JntArray(1), PyKDL.JntArray(1)
    angle[0] = math.pi / 3
    PyKDL.ChainDynParam(chain, PyKDL.Vector(0, 0, -9.81)).JntToGravity(angle, torque)
    assert torque[0] == pytest.approx(3 * 9.81 * 0.5 * math.cos(math.pi / 3))


# ---- chains


def test_a_chain_knows_its_joints_and_their_limits():
    chain = Chain(ARM, "base", "hand")
    assert chain.joint_names == ("yaw_joint", "pitch_joint", "slide_joint")
    assert [joint.upper for joint in chain.joints] == [3.0, 3.0, 3.0]
    assert chain.kdl.getNrOfJoints() == 3
    assert Chain(ARM, "yaw", "slide").joint_names == ("pitch_joint", "slide_joint")


def test_forward_kinematics():
    chain = Chain(ARM, "base", "hand")
    # pitch turns about -90 degrees of roll: its z axis is y of the yaw link, its y axis is -z
    pose = chain.forward([math.pi / 2, math.pi / 2, 0.1])
    assert pose[:3, 3] == pytest.approx([0.1 + 0.25 * 0.0, -0.25 + 0.0, 0.5 - 0.6], abs=1e-12)
    assert pose[:3, :3] @ pose[:3, :3].T == pytest.approx(np.eye(3))
    assert chain.forward([0.3, 0.2, 0.1], "yaw")[:3, 3] == pytest.approx([0.1, 0, 0.2])
    assert chain.forward([0.3, 0.2, 0.1], "base") == pytest.approx(np.eye(4))


@pytest.mark.parametrize(
    ("base", "tip", "named"),
    [
        ("base", "nose", "no link 'nose'"),
        ("hull", "hand", "no link 'hull'"),
        ("camera", "hand", "'hand' does not hang on link 'camera'"),
        ("hand", "base", "'base' does not hang on link 'hand'"),
    ],
)
def test_chains_that_are_not_there_are_named(base, tip, named):
    with pytest.raises(KinematicsError, match=named):
        Chain(ARM, base, tip)


def test_wrong_calls_are_named():
    chain = Chain(ARM, "base", "hand")
    for call in (chain.forward, chain.jacobian):
        for wrong in (math.nan, math.inf):
            with pytest.raises(KinematicsError, match=rf"position of \w+ is {wrong}; a finite one"):
                call([0.0, wrong, 0.0])
    with pytest.raises(KinematicsError, match="2 positions for the 3 joints from base to hand"):
        chain.forward([0.0, 0.0])
    with pytest.raises(KinematicsError, match="'camera' is not between base and hand"):
        chain.forward([0.0, 0.0, 0.0], "camera")
    with pytest.raises(KinematicsError, match="2 positions for 3 joints"):
        dh_chain(chain).forward([0.0, 0.0])
    with pytest.raises(KinematicsError, match="no joint between slide and hand can move"):
        dh_chain(Chain(ARM, "slide", "hand"))


# ---- chains for inverse kinematics


def single(kind, limit, extra=""):
    return (
        '<robot name="r"><link name="a"/><link name="b"/><link name="c"/>'
        f'<joint name="j" type="{kind}"><parent link="a"/><child link="b"/>{limit}{extra}</joint>'
        '<joint name="k" type="fixed"><parent link="b"/><child link="c"/></joint></robot>'
    )


def test_a_chain_of_a_text_has_its_limits():
    chain = Chain.from_urdf(
        single("prismatic", '<limit lower="0.1" upper="0.4" velocity="2" effort="1"/>'), "a", "c"
    )
    assert chain.joint_names == ("j",)
    limits = (chain.lower, chain.upper, chain.velocity_limits)
    assert [limit.tolist() for limit in limits] == [[0.1], [0.4], [2.0]]
    assert chain.jacobian([0.2]).tolist() == [[1.0], [0.0], [0.0], [0.0], [0.0], [0.0]]
    with pytest.raises(KinematicsError, match="2 positions for the 1 joints"):
        chain.jacobian([0.0, 0.0])


def test_a_continuous_joint_has_no_limits():
    chain = Chain.from_urdf(single("continuous", '<limit velocity="2" effort="1"/>'), "a", "b")
    assert chain.lower[0] == -math.inf
    assert chain.upper[0] == math.inf


@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_joints_without_a_range_are_refused(kind):
    with pytest.raises(KinematicsError, match="neither lower nor upper"):
        Chain.from_urdf(single(kind, '<limit velocity="2" effort="1"/>'), "a", "b")
    with pytest.raises(UrdfError, match="has no <limit>"):
        Chain.from_urdf(single(kind, ""), "a", "b")


def test_joints_that_mimic_others_are_refused_in_a_chain():
    other = '<joint name="other" type="continuous"><parent link="c"/><child link="d"/></joint>'
    text = single("revolute", LIMIT, '<mimic joint="other"/>')
    text = text.replace("</robot>", f'<link name="d"/>{other}</robot>')
    with pytest.raises(KinematicsError, match="joint 'j' mimics 'other'"):
        Chain.from_urdf(text, "a", "c")
    assert Chain.from_urdf(text, "b", "c").joint_names == ()


# ---- Denavit-Hartenberg parameters


def random_chain(generator, count):
    """Joints of all kinds, with axes that are skew, meet, are parallel, or lie on one line."""
    elements = [link("l0")]
    for index in range(count):
        special = generator.random() < 0.6
        xyz = generator.choice([0.0, 0.0, 0.4], 3) if special else generator.normal(0, 0.3, 3)
        rpy = (
            generator.choice([0.0, 0.0, math.pi / 2, -math.pi / 2, math.pi], 3)
            if special
            else generator.uniform(-3, 3, 3)
        )
        axis = np.eye(3)[generator.integers(3)] if special else generator.normal(0, 1, 3)
        kind = ["revolute", "prismatic", "continuous", "fixed"][
            generator.choice(4, p=[0.5, 0.2, 0.15, 0.15])
        ]
        if index == 0:
            kind = "revolute"
        elements.append(link(f"l{index + 1}"))
        elements.append(
            joint(
                f"j{index}",
                f"l{index}",
                f"l{index + 1}",
                kind=kind,
                xyz=" ".join(map(repr, map(float, xyz))),
                rpy=" ".join(map(repr, map(float, rpy))),
                axis=" ".join(map(repr, map(float, axis))),
            )
        )
    return Chain(robot(*elements), "l0", f"l{count}")


@pytest.mark.parametrize("seed", range(40))
def test_the_product_of_the_parameters_is_the_forward_kinematics(seed):
    generator = np.random.default_rng(seed)
    chain = random_chain(generator, int(generator.integers(1, 9)))
    parameters = dh_chain(chain)
    assert [row.joint for row in parameters.rows] == list(chain.joint_names)
    for _ in range(20):
        positions = generator.uniform(-3, 3, len(chain.joints))
        difference = parameters.forward(positions) - chain.forward(positions)
        assert abs(difference).max() < 1e-9


def test_parameters_of_a_textbook_arm():
    # two parallel axes, a wrist on the second link
    planar = robot(
        *(link(f"l{index}") for index in range(4)),
        joint("first", "l0", "l1"),
        joint("second", "l1", "l2", xyz="0.7 0 0"),
        joint("third", "l2", "l3", xyz="0.5 0 0", axis="0 1 0"),
    )
    rows = dh_chain(Chain(planar, "l0", "l3")).rows
    figures = [(row.alpha, row.a, row.theta, row.d) for row in rows]
    assert figures == [
        pytest.approx(row) for row in ((0, 0, 0, 0), (0, 0.7, 0, 0), (-math.pi / 2, 0.5, 0, 0))
    ]
