"""GLSL sources of the renderer.

Colours are handled linearly, with a gamma of 2 in place of sRGB's curve: close to it, exact for
what only passes through, and one multiplication and one square root, which a CPU does in no time.
"""

from __future__ import annotations

import math
from typing import NamedTuple


class ShaderSource(NamedTuple):
    """Sources of one program."""

    vertex: str
    fragment: str


_TO_DISPLAY = """
// Highlights run softly into white instead of being cut off.
vec3 to_display(vec3 light) { return sqrt(clamp(light * 1.25 / (1.0 + 0.25 * light), 0.0, 1.0)); }
"""

_LIT_VERTEX = """
in vec3 in_position;
in vec3 in_normal;
uniform mat4 world_from_model;
uniform mat4 clip_from_world;
uniform mat4 map_from_world;
uniform float normal_offset;
out vec3 world;
out vec3 normal;
out vec3 in_map;
#if TEXTURED
in vec2 in_uv;
uniform float uv_scale;
out vec2 uv;
#endif
void main() {
  vec4 position = world_from_model * vec4(in_position, 1.0);
  world = position.xyz;
  normal = mat3(world_from_model) * in_normal;
  // Looking the shadow up a little above the surface keeps it from shading itself.
  in_map = (map_from_world * (position + vec4(normal * normal_offset, 0.0))).xyz;
  gl_Position = clip_from_world * position;
#if TEXTURED
  uv = in_uv * uv_scale;
#endif
}
"""

_LIT_FRAGMENT = """
in vec3 world;
in vec3 normal;
in vec3 in_map;
uniform vec4 color;
uniform vec3 eye;
uniform vec3 to_sun;
uniform vec3 to_fill;
uniform vec3 sun;
uniform vec3 fill;
uniform vec3 sky_ambient;
uniform vec3 ground_ambient;
uniform vec3 horizon;
uniform float specular;
uniform float haze;
uniform sampler2DShadow shadow_map;
uniform float shadow_softness;
#if TEXTURED
in vec2 uv;
uniform sampler2D picture;
#endif
out vec4 fragment;

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

void main() {
  vec3 n = normalize(normal);
  vec3 to_eye = eye - world;
  float square = dot(to_eye, to_eye);
  vec3 albedo = color.rgb;
#if TEXTURED
  // Half a level sharper than OpenGL would choose for floors, which are mostly seen at a slant.
  vec3 texel = texture(picture, uv, -0.5).rgb;
  albedo *= texel * texel;
#endif
  vec3 light = mix(ground_ambient, sky_ambient, 0.5 + 0.5 * n.z) + fill * max(dot(n, to_fill), 0.0);
  float facing = dot(n, to_sun);
  float highlight = 0.0;
  if (facing > 0.0) {
    facing *= sunlight();
    light += sun * facing;
    // Blinn's highlight with an exponent of 32, by squaring.
    float shine = max(dot(n, normalize(to_sun + to_eye * inversesqrt(square))), 0.0);
    shine *= shine; shine *= shine; shine *= shine; shine *= shine; shine *= shine;
    highlight = specular * facing * shine;
  }
  float clear = 1.0 / (1.0 + haze * square);
  fragment = vec4(to_display(mix(horizon, albedo * light + highlight * sun, clear)), color.a);
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
out vec4 fragment;
void main() {
  float height = max(ray.z, 0.0) * inversesqrt(dot(ray, ray));
  fragment = vec4(to_display(mix(horizon, zenith, height * (2.0 - height))), 1.0);
}
"""


def lit_source(textured: bool, shadow_lookups: int) -> ShaderSource:
    """Show surfaces in the light of the sun and the sky, with so many look-ups of its shadow."""
    turn = 2.0 * math.pi / shadow_lookups
    head = _head(
        TEXTURED=int(textured),
        SHADOW_LOOKUPS=shadow_lookups,
        TURN_COS=math.cos(turn),
        TURN_SIN=math.sin(turn),
    )
    return ShaderSource(head + _LIT_VERTEX, head + _TO_DISPLAY + _LIT_FRAGMENT)


def depth_source() -> ShaderSource:
    """Write depth alone, for the shadow map."""
    return ShaderSource(_head() + _DEPTH_VERTEX, _head() + _DEPTH_FRAGMENT)


def sky_source() -> ShaderSource:
    """Show the sky behind everything."""
    return ShaderSource(_head() + _SKY_VERTEX, _head() + _TO_DISPLAY + _SKY_FRAGMENT)


def _head(**defines: float) -> str:
    lines = [f"#define {name} {value}" for name, value in defines.items()]
    return "\n".join(["#version 330", *lines, ""])
