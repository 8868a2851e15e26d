"""Robot descriptions that no body can have are refused, by name."""

from __future__ import annotations

import pytest

from telex_control.urdf.checks import check_bodies
from telex_control.urdf.elements import UrdfError, root_links
from telex_control.urdf.joints import parse_urdf

MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
BOX = '<box size="1 -1 1"/>'


def link(name, mass="1", moments="1 0 0 1 0 1", rest=""):
    inertia = " ".join(f'{key}="{value}"' for key, value in zip(MOMENTS, moments.split()))
    return (
        f'<link name="{name}"><inertial><mass value="{mass}"/><inertia {inertia}/></inertial>'
        f"{rest}</link>"
    )


def joint(parent, child, rest="", kind="fixed"):
    return (
        f'<joint name="{parent}_{child}" type="{kind}"><parent link="{parent}"/>'
        f'<child link="{child}"/>{rest}</joint>'
    )


def robot(*elements):
    return f'<robot name="r">{"".join(elements)}</robot>'


def chain(count):
    names = [f"l{number}" for number in range(count)]
    return robot(*map(link, names), *map(joint, names, names[1:]))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            robot(link("a"), link("b"), joint("a", "b"), joint("b", "a")),
            "circle: (a -> b -> a|b -> a -> b);",
        ),
        (robot(link("a"), joint("a", "a")), "circle: a -> a; one link must hang on no joint"),
        (
            robot(*map(link, "abc"), joint("a", "c"), joint("b", "c")),
            "'c' is the child of the joints 'a_c' and 'b_c'",
        ),
        (chain(3000), r"'l\d+' is the last of a chain of \d+; 200 are possible"),
        (robot(link("a")) + " " * 1_000_001, "at most 1000000 are read"),
        (robot("<a/>" * 60_000), "has 60001 elements; at most 50000 are read"),
    ],
    ids=["circle", "itself", "two joints", "chain", "long", "full"],
)
def test_links_that_are_no_tree_are_refused(text, said):
    with pytest.raises(UrdfError, match=said):
        parse_urdf(text)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (robot(), "robot_description has no <link>"),
        (robot(link("a"), link("b")), "has the roots a, b; one link must hang on no joint"),
        (robot(link("a"), joint("a", "b")), "joint 'a_b': its child is 'b', which is no link"),
        (robot(link("a", "-5")), "link 'a': mass is -5 kg; 0 to 1e.06 is needed"),
        (robot(link("a", "nan")), "link 'a': <mass value=.nan.>; a finite number"),
        (robot(link("a", "1e300")), "mass is 1e.300 kg"),
        (robot(link("a", "much")), "link 'a': <mass value=.much.>; a finite number"),
        (robot(link("a", moments="1 0 0 inf 0 1")), "'a': <inertia iyy=.inf.>; a finite number"),
        (robot(link("a", moments="1 2 0 1 0 1")), "principal moment -1 kg m2 .ixx 1, ixy 2"),
        (
            robot(link("a"), link("b"), joint("a", "b", '<origin xyz="nan 0 0"/>')),
            "joint 'a_b': <origin xyz=.nan 0 0.>; 3 finite numbers are needed",
        ),
        (
            robot(link("a"), link("b"), joint("a", "b", '<axis xyz="inf 0 0"/>')),
            "joint 'a_b': <axis xyz=.inf 0 0.>; 3 finite numbers are needed",
        ),
        (
            robot(link("a"), link("b"), joint("a", "b", '<axis xyz="0 0 0"/>', "continuous")),
            "joint 'a_b': axis is 0 0 0; a direction is needed",
        ),
        (
            robot(link("a"), link("b"), joint("a", "b", '<axis xyz="0 1e-12 0"/>', "prismatic")),
            "joint 'a_b': axis is 0 1e-12 0; a direction is needed",
        ),
        (
            robot(link("a"), link("b"), joint("a", "b", '<origin xyz="0 2e4 0"/>')),
            "joint 'a_b': <origin xyz> has the value 20000; at most 10000 is possible",
        ),
        (
            robot(link("a"), link("b"), joint("a", "b", "<origin xyz='0 0 x'/>", "prismatic")),
            "joint 'a_b': <origin xyz=.0 0 x.>; 3 finite numbers are needed",
        ),
        (
            robot(link("a"), link("b"), joint("a", "b", kind="planar")),
            "joint 'a_b' has the type 'planar'; simulated are fixed, revolute, cont",
        ),
        (robot(link("a"), link("a")), "robot_description has 2 links of the name 'a'"),
        (robot(link("a"), link("")), "robot_description has a <link> without a name"),
        (robot(link("a")).replace(' name="r"', ""), "<robot> has no name"),
        (
            robot(link("a")).replace('"r"', f'"{"r" * 201}"'),
            r"the name of a <robot> is 'r{40}\.\.\.', of 201 bytes; at most 200 are possible",
        ),
        (robot(link("\u00e4" * 101)), "the name of a <link> is '\u00e4{40}.*, of 202 bytes"),
        (
            robot(link("a"), link("b" * 199), joint("a", "b" * 199)),
            "the name of a <joint> is 'a_b{38}.*, of 201 bytes; at most 200",
        ),
        (robot(link("a", moments="1 0 0 1 0 1e200")), "'a': its <inertia> has 1e.200 kg m2"),
        (
            robot('<link name="a"><inertial><mass value="1"/></inertial></link>'),
            "link 'a': its <inertial> has no <inertia>",
        ),
        (
            robot(
                link(
                    "a",
                    rest=f"<collision><origin rpy='0 0'/><geometry>{BOX}</geometry></collision>",
                )
            ),
            "link 'a': collision: <origin rpy=.0 0.>; 3 finite numbers are needed",
        ),
        (
            robot(link("a", rest="<collision><geometry><cone/></geometry></collision>")),
            "link 'a': collision has the shape <cone> in its <geometry>; known are box, sphere",
        ),
        (
            robot(link("a", rest="<visual/>")),
            "link 'a': visual has no shape in its <geometry>; known are box, sphere",
        ),
        (
            robot(link("a", rest=f"<collision><geometry>{BOX}</geometry></collision>")),
            "link 'a': collision: size is -1 m",
        ),
    ],
)
def test_numbers_that_no_body_has_are_refused(text, said):
    with pytest.raises(UrdfError, match=said):
        check_bodies(parse_urdf(text))


def test_what_foreign_robots_have_is_taken():
    check_bodies(
        parse_urdf(
            robot(
                '<link name="frame"/>',
                link("nothing", "0", "0 0 0 0 0 0"),
                link("rod", "1", "0 0 0 1 0 1"),
                joint("frame", "nothing"),
                joint("frame", "rod", '<origin xyz="0 0 x"/><axis xyz="0 0 0"/>'),
            )
        )
    )
    parse_urdf(chain(150))


def test_a_default_namespace_is_read_past():
    text = robot(link("a"), link("b"), joint("a", "b")).replace(
        "<robot", '<robot xmlns="http://www.ros.org" xmlns:sensor="http://sensor"', 1
    )
    found = parse_urdf(text.replace("</robot>", "<sensor:camera/></robot>"))
    assert list(found.link_map) == ["a", "b"]
    assert root_links(found) == ["a"]
    assert found.links[0].inertial.mass == 1.0
