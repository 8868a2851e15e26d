"""What renderers hear of a scene."""

from __future__ import annotations

import math

import pytest
from genpy import Time
from telex_msgs.msg import SceneVisual

from telex_sim.ros.scene_messages import SceneMessages
from telex_sim.scene.model import (
    Floor,
    Fog,
    Form,
    Geometry,
    Joint,
    Lamp,
    Lights,
    Link,
    Motion,
    ObjectModel,
    Part,
    Scene,
    SceneObject,
    Start,
    Sun,
    Surface,
)

HALF = math.sqrt(0.5)
URDF = '<robot name="r"><link name="base_link"/></robot>'
GREEN = Surface((0.0, 1.0, 0.0, 1.0), "generated:wood", 0.5, 0.25)


def box(position=(0.0, 0.0, 0.0), surface=GREEN):
    return Part(Geometry(Form.BOX, (0.1, 0.2, 0.3)), position, surface=surface)


def post(name="post", position=(1.0, 2.0, 0.0)):
    """A static post, turned by 90 degrees, with an arm that moves."""
    links = (
        Link("pole", 0.0, (box((1.0, 0.0, 0.0)), box((0.0, 0.0, 9.0), None))),
        Link("arm", 1.0, (box((0.5, 0.0, 0.0)),)),
    )
    joint = Joint("hinge", Motion.HINGE, "pole", "arm", upper=1.0)
    return SceneObject(
        name, ObjectModel(links, (joint,), True), position, (0.0, 0.0, HALF, HALF), name
    )


def crate(name="crate"):
    return SceneObject(name, ObjectModel((Link("body", 1.0, (box((0.0, 0.0, 0.1)),)),)), entry=name)


def messages(*objects, **scene):
    made = SceneMessages("telex", ["base_link"], URDF, Scene("test", **scene))
    made.show(objects)
    return made


def test_static_parts_stand_in_the_world_and_moving_ones_in_their_links():
    said = messages(post(), crate()).description(Time(3))
    assert said.frames == ["world", "telex/base_link", "post/arm", "crate/body"]
    floor, pole, arm, body = said.visuals
    assert (floor.frame, pole.frame, arm.frame, body.frame) == (0, 0, 2, 3)
    assert floor.shape == SceneVisual.PLANE
    assert (pole.pose.position.x, pole.pose.position.y) == pytest.approx((1.0, 3.0))
    assert (pole.pose.orientation.z, pole.pose.orientation.w) == pytest.approx((HALF, HALF))
    assert arm.pose.position.x == 0.5
    assert (pole.shape, pole.size.y, pole.color.g) == (SceneVisual.BOX, 0.2, 1.0)
    assert (pole.texture, pole.texture_scale, pole.glow) == ("generated:wood", 0.5, 0.25)


def test_every_form_has_its_shape():
    parts = tuple(
        Part(Geometry(form, (0.1, 0.2, 0.3), "file:///a.obj" if form is Form.MESH else ""))
        for form in (Form.BOX, Form.SPHERE, Form.CYLINDER, Form.MESH)
    )
    item = SceneObject("all", ObjectModel((Link("body", 1.0, parts),)), entry="all")
    shapes = [visual.shape for visual in messages(item).description(Time()).visuals[1:]]
    assert shapes == [
        SceneVisual.BOX,
        SceneVisual.SPHERE,
        SceneVisual.CYLINDER,
        SceneVisual.MESH,
    ]


def test_light_and_floor_are_told():
    said = messages(
        floor=Floor(GREEN, size=12.0),
        lights=Lights(
            Sun(azimuth=math.pi / 2.0, elevation=math.pi / 6.0, intensity=0.5, color=(1, 0.8, 0.6)),
            ambient=0.1,
            lamps=(Lamp((1.0, 2.0, 3.0), (0.0, 1.0, 0.0), 0.7, 2.0, 5.0, (1.0, 0.9, 0.8)),),
            fog=Fog(25.0, (0.1, 0.2, 0.3)),
        ),
        start=Start(),
    ).description(Time())
    floor, lamp = said.visuals[0], said.lamps[0]
    assert (floor.size.x, floor.size.y, floor.texture) == (12.0, 12.0, "generated:wood")
    sun = (said.to_sun.x, said.to_sun.y, said.to_sun.z)
    assert sun == pytest.approx((0.0, math.sqrt(0.75), 0.5), abs=1e-9)
    assert (said.sun.r, said.sun.g, said.sun.b) == pytest.approx((0.5, 0.4, 0.3))
    assert (said.ambient, said.visibility, said.fog.b) == pytest.approx((0.1, 25.0, 0.3))
    assert (lamp.frame, lamp.position.y, lamp.direction.y) == (0, 2.0, 1.0)
    assert (lamp.angle, lamp.intensity, lamp.reach) == pytest.approx((0.7, 2.0, 5.0))
    assert (lamp.color.r, lamp.color.g, lamp.color.b) == pytest.approx((1.0, 0.9, 0.8))


def test_the_revision_rises_only_with_a_change():
    made = messages(crate())
    first = made.revision
    assert not made.show([crate()])
    assert made.revision == first
    assert made.show([crate(), post()])
    assert made.revision == first + 1
    assert made.show([crate()])
    assert made.revision == first + 2
    assert made.description(Time()).frames == ["world", "telex/base_link", "crate/body"]


def test_poses_carry_what_moves_and_the_revision():
    made = messages(crate())
    numbers = [float(n) for n in range(14)]
    said = made.poses(Time(2), numbers)
    assert said.revision == made.revision
    assert said.poses == [0.0] * 6 + [1.0, *numbers]
