"""GLSL sources of the renderer.

Colours are handled linearly, with a gamma of 2 in place of sRGB's curve: close to it, exact for
what only passes through, and one multiplication and one square root, which a CPU does in no time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple


class ShaderSource(NamedTuple):
    """Sources of one program."""

    vertex: str
    fragment: str


# At what height above a point blurred things cover it fully (m); and what they then take of the
# light from above, and of that of a lamp straight above.
_FULL_COVER, _SKY_SHADE, _LAMP_SHADE = 0.25, 0.75, 0.7

# Light of what glows fully: nearly white on the display.
_GLOW = 1.5

EXPOSURE = 2.3
"""Halvings of what a pixel lacks to white, per unit of light."""

_TO_DISPLAY = """
// As on film, highlights run softly into white instead of being cut off.
vec3 to_display(vec3 light) { return sqrt(1.0 - exp2(-EXPOSURE * light)); }
"""

_LIT_VERTEX = """
in vec3 in_position;
in vec3 in_normal;
in vec4 in_color;
uniform mat4 world_from_model;
uniform mat4 clip_from_world;
out vec3 world;
out vec3 normal;
// Linear colour, and in place of alpha what glows by itself; the same all over a visual.
flat out vec4 paint;
#if SUN
uniform mat4 map_from_world;
uniform float normal_offset;
out vec3 in_map;
#endif
#if TEXTURED
in vec2 in_uv;
out vec2 uv;
#endif
void main() {
  vec4 position = world_from_model * vec4(in_position, 1.0);
  world = position.xyz;
  normal = mat3(world_from_model) * in_normal;
  paint = vec4(in_color.rgb * in_color.rgb, in_color.a);
  gl_Position = clip_from_world * position;
#if SUN
  // Looking the shadow up a little above the surface keeps it from shading itself.
  in_map = (map_from_world * (position + vec4(normal * normal_offset, 0.0))).xyz;
#endif
#if TEXTURED
  uv = in_uv;
#endif
}
"""

_LIT_FRAGMENT = """
in vec3 world;
in vec3 normal;
flat in vec4 paint;
uniform float opacity;
uniform vec3 eye;
uniform vec3 to_fill;
uniform vec3 fill;
uniform vec3 sky_ambient;
uniform vec3 ground_ambient;
uniform vec3 haze_light;
uniform float specular;
uniform float haze;
#if SUN
in vec3 in_map;
uniform vec3 to_sun;
uniform vec3 sun;
uniform sampler2DShadow shadow_map;
uniform float shadow_softness;
#endif
#if COVER
// Blurred heights (m), and how the world leads to the map: offset along x and y, scale.
uniform sampler2D cover_map;
uniform vec3 cover_place;
#endif
#if LAMPS
// Position and 1/reach^2; direction and factor of the cone; light and offset of the cone.
uniform vec4 lamp_place[LAMPS];
uniform vec4 lamp_aim[LAMPS];
uniform vec4 lamp_light[LAMPS];
#endif
#if TEXTURED
in vec2 uv;
uniform sampler2D picture;
#endif
out vec4 fragment;

// Blinn's highlight with an exponent of 32, by squaring.
float highlight(vec3 n, vec3 to_light, vec3 to_eye) {
  vec3 between = to_light + to_eye;
  float shine = max(dot(n, between), 0.0) * inversesqrt(dot(between, between));
  shine *= shine; shine *= shine; shine *= shine; shine *= shine; shine *= shine;
  return specular * shine;
}

#if SUN
// Share of the sun that arrives, 0..1: the mean over a ring of look-ups. All are always taken: on a
// CPU both sides of a branch are executed, so stopping where the first few agree saves nothing.
float sunlight() {
  const mat2 turn = mat2(TURN_COS, TURN_SIN, -TURN_SIN, TURN_COS);
  vec2 offset = vec2(0.0, shadow_softness);
  float lit = 0.0;
  for (int number = 0; number < SHADOW_LOOKUPS; ++number) {
    lit += textureLod(shadow_map, vec3(in_map.xy + offset, in_map.z), 0.0);
    offset = turn * offset;
  }
  return lit * (1.0 / float(SHADOW_LOOKUPS));
}
#endif

void main() {
  vec3 n = normalize(normal);
  vec3 to_eye = eye - world;
  float square = dot(to_eye, to_eye);
  float nearness = inversesqrt(square);
  to_eye *= nearness;
  vec3 albedo = paint.rgb;
#if TEXTURED
  // Half a level sharper than OpenGL would choose for floors, which are mostly seen at a slant.
  vec3 texel = texture(picture, uv, -0.5).rgb;
  albedo *= texel * texel;
#endif
  vec3 above = sky_ambient;
#if COVER
  vec2 in_cover = world.xy * cover_place.z + cover_place.xy;
  float covered = (textureLod(cover_map, in_cover, 0.0).r - world.z) * (1.0 / FULL_COVER);
  covered = clamp(covered, 0.0, 1.0);
  above *= 1.0 - SKY_SHADE * covered;
#endif
  vec3 light = mix(ground_ambient, above, 0.5 + 0.5 * n.z) + fill * max(dot(n, to_fill), 0.0);
  vec3 shine = vec3(0.0);
#if SUN
  float facing = dot(n, to_sun);
  if (facing > 0.0) {
    facing *= sunlight();
    light += sun * facing;
    shine += sun * (facing * highlight(n, to_sun, to_eye));
  }
#endif
#if LAMPS
  for (int number = 0; number < LAMPS; ++number) {
    vec4 place = lamp_place[number];
    vec4 aim = lamp_aim[number];
    vec4 source = lamp_light[number];
    vec3 to_lamp = place.xyz - world;
    float distance2 = dot(to_lamp, to_lamp);
    to_lamp *= inversesqrt(distance2);
    float cone = clamp(source.w - aim.w * dot(to_lamp, aim.xyz), 0.0, 1.0);
    // Falls with the square of the distance, and smoothly to nothing at the reach.
    float far = distance2 * place.w;
    float fade = max(1.0 - far * far, 0.0) * cone;
#if COVER
    // The higher a lamp stands, the more of what hides the sky hides it, too.
    float high = max(to_lamp.z, 0.0);
    fade *= 1.0 - LAMP_SHADE * covered * high * high;
#endif
    float arriving = max(dot(n, to_lamp), 0.0) * fade * fade / (distance2 + NEAREST2);
    light += source.rgb * arriving;
    shine += source.rgb * (arriving * highlight(n, to_lamp, to_eye));
  }
#endif
  light += GLOW * paint.a;
#if FOG
  float clear = exp2(-haze * square * nearness);
#else
  float veil = haze * square;
  float clear = 1.0 / (1.0 + veil * veil);
#endif
  fragment = vec4(to_display(mix(haze_light, albedo * light + shine, clear)), opacity);
}
"""

_DEPTH_VERTEX = """
in vec3 in_position;
uniform mat4 clip_from_model;
void main() { gl_Position = clip_from_model * vec4(in_position, 1.0); }
"""

_DEPTH_FRAGMENT = """
void main() {}
"""

_SKY_VERTEX = """
in vec2 in_corner;
uniform mat3 ray_from_corner;
out vec3 ray;
void main() {
  ray = ray_from_corner * vec3(in_corner, 1.0);
  gl_Position = vec4(in_corner, 1.0, 1.0);
}
"""

_SKY_FRAGMENT = """
in vec3 ray;
uniform vec3 horizon;
uniform vec3 zenith;
#if FOG
uniform vec3 haze_light;
uniform float fog_depth;
#endif
out vec4 fragment;
void main() {
  float height = max(ray.z, 0.0) * inversesqrt(dot(ray, ray));
  vec3 sky = mix(horizon, zenith, height * (2.0 - height));
#if FOG
  sky = mix(haze_light, sky, exp2(-fog_depth / max(height, 0.001)));
#endif
  fragment = vec4(to_display(sky), 1.0);
}
"""


@dataclass(frozen=True)
class LitVariant:
    """What a program for lit surfaces can do; each thing that it cannot do makes it faster.

    Attributes
    ----------
    textured
        Whether surfaces have a texture.
    sun, cover, fog
        Whether the sun shines, whether things take light from above from what is below them
        (`SkyCover`), and whether there is fog.
    lamps
        For how many lamps there is room.
    """

    textured: bool
    sun: bool
    cover: bool
    fog: bool
    lamps: int


def lit_source(variant: LitVariant, shadow_lookups: int, nearest: float) -> ShaderSource:
    """Show surfaces in the light of the sun, the sky and lamps.

    Parameters
    ----------
    variant
        What is needed.
    shadow_lookups
        In the sun's shadow map for each pixel.
    nearest
        Distance below which the light of a lamp grows no more (m).
    """
    turn = 2.0 * math.pi / shadow_lookups
    head = _head(
        TEXTURED=int(variant.textured),
        SUN=int(variant.sun),
        COVER=int(variant.cover),
        FULL_COVER=_FULL_COVER,
        GLOW=_GLOW,
        SKY_SHADE=_SKY_SHADE,
        LAMP_SHADE=_LAMP_SHADE,
        FOG=int(variant.fog),
        LAMPS=variant.lamps,
        NEAREST2=nearest**2,
        SHADOW_LOOKUPS=shadow_lookups,
        TURN_COS=math.cos(turn),
        TURN_SIN=math.sin(turn),
    )
    return ShaderSource(head + _LIT_VERTEX, head + _TO_DISPLAY + _LIT_FRAGMENT)


def depth_source() -> ShaderSource:
    """Write depth alone, for the shadow map."""
    return ShaderSource(_head() + _DEPTH_VERTEX, _head() + _DEPTH_FRAGMENT)


def sky_source(fog: bool) -> ShaderSource:
    """Show the sky behind everything, with or without fog before it."""
    head = _head(FOG=int(fog))
    return ShaderSource(head + _SKY_VERTEX, head + _TO_DISPLAY + _SKY_FRAGMENT)


def _head(**defines: float) -> str:
    lines = [f"#define {name} {value}" for name, value in {**defines, "EXPOSURE": EXPOSURE}.items()]
    return "\n".join(["#version 330", *lines, ""])
