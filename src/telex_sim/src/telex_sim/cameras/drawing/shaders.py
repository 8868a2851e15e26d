"""GLSL sources of the renderer.

Colours are handled linearly, with a gamma of 2 in place of sRGB's curve: close to it, exact for
what only passes through, and one multiplication and one square root, which a CPU does in no time.

llvmpipe fetches each number of a uniform anew for every few pixels, which takes as long as some ten
additions. What changes with the scene only is therefore compiled in, and what changes with the
picture comes from the vertices.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Mapping, NamedTuple, Sequence, Tuple

Constants = Mapping[str, Tuple[float, ...]]
"""Values by name, of one to four numbers, that are compiled into a shader."""


class ShaderSource(NamedTuple):
    """Sources of one program."""

    vertex: str
    fragment: str


FULL_COVER = 0.15
"""At what height above a point blurred things cover it fully (m)."""

# What they then take of the light from above, and of that of a lamp straight above; where the sun
# shines, of all light: at the foot of things the bright sky around it is hidden as well.
_SKY_SHADE, _LAMP_SHADE, _SUN_SHADE = 0.75, 0.7, 0.6

# Share of the surroundings that surfaces without a texture mirror: seen straight on, and what is
# added at grazing angles.
_MIRRORED, _GRAZING = 0.03, 0.30

# Light of what glows fully: nearly white on the display.
_GLOW = 1.5

# Share of the sharp shadow map's side, along its edges, in which the wide one is taken already.
_SHARP_BORDER = 0.006

# Share of the horizon's light that distant hills show.
_HILLS = (0.50, 0.60, 0.58)

# Lamps for which vertices work out what changes evenly between them. How much they can hand on is
# limited; with more lamps, pixels do all.
MOST_LAMPS_BY_VERTEX = 4

EXPOSURE = 2.3
"""Halvings of what a pixel lacks to white, per unit of light."""

_TO_DISPLAY = """
// As on film, highlights run softly into white instead of being cut off.
vec3 to_display(vec3 light) { return sqrt(1.0 - exp2(-EXPOSURE * light)); }
"""

_LAMPS = """
#if LAMPS
// Position and 1/reach^2; direction and factor of the cone; light and offset of the cone.
uniform vec4 lamp_place[LAMPS];
uniform vec4 lamp_aim[LAMPS];
uniform vec4 lamp_light[LAMPS];
// Axes of the lamp's tile, as long as its focal length; with them, how far off a surface to look
// per distance, and the factor of depth. Then the middle of the tile, and the offset of depth.
uniform vec4 lamp_right[LAMPS];
uniform vec4 lamp_down[LAMPS];
uniform vec4 lamp_shadow[LAMPS];

// Where a point of a surface is for a lamp: right and down in the tile (to be divided by the
// distance ahead), ahead (m), and what to take from the offset of depth (to be divided by it as
// well). Between the corners of a flat surface, all change evenly.
vec4 seen_by_lamp(int number, vec3 point, vec3 n, out vec3 to_lamp) {
  vec4 right = lamp_right[number];
  vec4 down = lamp_down[number];
  vec3 aim = lamp_aim[number].xyz;
  to_lamp = lamp_place[number].xyz - point;
  float ahead = -dot(to_lamp, aim);
  // Looking the shadow up a little above the surface keeps it from shading itself. To first order,
  // that adds to the distance ahead as well.
  vec3 seen = n * (right.w * ahead) - to_lamp;
  float nearer = down.w * (1.0 - right.w * dot(n, aim));
  return vec4(dot(seen, right.xyz), dot(seen, down.xyz), ahead, nearer);
}
#endif
"""

_LIT_VERTEX = """
in vec3 in_position;
in vec3 in_normal;
in vec4 in_color;
uniform mat4 world_from_model;
uniform mat4 clip_from_world;
uniform vec3 eye;
uniform vec3 sky_ambient;
uniform vec3 ground_ambient;
uniform float exposure;
uniform float opacity;
out vec3 towards_eye;
out vec3 normal;
// The same all over a picture or a surface.
flat out vec4 sky_and_exposure;
flat out vec4 ground_and_opacity;
#if WORLD
out vec3 world;
#endif
#if COVER
// How the world leads to the map: offset along x and y, scale.
uniform vec3 cover_place;
// Place in the map, and height (of what covers fully).
out vec3 in_cover;
#endif
#if LAMPS_BY_VERTEX
out vec3 to_lamps[LAMPS];
out vec4 in_lamps[LAMPS];
#endif
// Linear colour, and in place of alpha what glows by itself; the same all over a visual.
flat out vec4 paint;
#if SUN
uniform mat4 map_from_world;
uniform float normal_offset;
// From the sharp map's coordinates to those of the wide one beside it.
uniform vec3 wide_scale;
uniform vec3 wide_shift;
out vec3 in_map;
out vec3 in_wide;
#endif
#if TEXTURED
in vec2 in_uv;
out vec2 uv;
#endif
void main() {
  vec4 position = world_from_model * vec4(in_position, 1.0);
  towards_eye = eye - position.xyz;
  sky_and_exposure = vec4(sky_ambient, exposure);
  ground_and_opacity = vec4(ground_ambient, opacity);
#if WORLD
  world = position.xyz;
#endif
#if COVER
  in_cover = vec3(position.xy * cover_place.z + cover_place.xy, position.z * (1.0 / FULL_COVER));
#endif
  normal = mat3(world_from_model) * in_normal;
  paint = vec4(in_color.rgb * in_color.rgb, in_color.a);
  gl_Position = clip_from_world * position;
#if LAMPS_BY_VERTEX
  for (int number = 0; number < LAMPS; ++number) {
    in_lamps[number] = seen_by_lamp(number, position.xyz, normal, to_lamps[number]);
  }
#endif
#if SUN
  // Looking the shadow up a little above the surface keeps it from shading itself.
  in_map = (map_from_world * (position + vec4(normal * normal_offset, 0.0))).xyz;
  in_wide = in_map * wide_scale + wide_shift;
#endif
#if TEXTURED
  uv = in_uv;
#endif
}
"""

_LIT_FRAGMENT = """
in vec3 towards_eye;
in vec3 normal;
flat in vec4 paint;
flat in vec4 sky_and_exposure;
flat in vec4 ground_and_opacity;
#if WORLD
in vec3 world;
#endif
#if SUN
in vec3 in_map;
in vec3 in_wide;
uniform sampler2DShadow shadow_map;
#endif
#if COVER
// Blurred heights (of what covers fully).
uniform sampler2D cover_map;
in vec3 in_cover;
#endif
#if LAMPS
#if LAMPS_BY_VERTEX
in vec3 to_lamps[LAMPS];
in vec4 in_lamps[LAMPS];
#endif
#if LAMP_LOOKUPS
uniform sampler2DShadow lamp_map;
#endif
#endif
#if TEXTURED
in vec2 uv;
uniform sampler2D picture;
#endif
out vec4 fragment;

// Phong's highlight with an exponent of 8, by squaring: as wide as one of Blinn's with 32, and
// without a square root and a division, which are what takes a CPU's time here.
float highlight(vec3 mirrored, vec3 to_light) {
  float shine = max(dot(mirrored, to_light), 0.0);
  shine *= shine; shine *= shine; shine *= shine;
  return specular * shine;
}

#if SUN
// Share of the sun that arrives, 0..1: the mean over a ring of look-ups. All are always taken: on a
// CPU both sides of a branch are executed, so stopping where the first few agree saves nothing.
float sunlight() {
  const mat2 turn = mat2(TURN_COS, TURN_SIN, -TURN_SIN, TURN_COS);
  vec2 off = abs(in_map.xy - 0.5);
  bool sharp = max(off.x, off.y) < 0.5 - SHARP_BORDER;
  vec3 wide = clamp(in_wide, 0.0, 1.0);
  vec3 place = sharp ? in_map : vec3(wide.x + 1.0, wide.yz);
  // Every other pixel looks to the other side, or along a ring that is turned by half a turn.
  float other = fract(0.5 * (gl_FragCoord.x + gl_FragCoord.y)) < 0.25 ? 1.0 : -1.0;
  vec2 offset = (shadow_softness * other) * vec2(0.6, 0.8);
  float lit = 0.0;
  for (int number = 0; number < SHADOW_LOOKUPS; ++number) {
    vec2 at = place.xy + offset;
    // The maps lie side by side.
    lit += textureLod(shadow_map, vec3(0.5 * at.x, at.y, place.z), 0.0);
    offset = turn * offset;
  }
  return lit * (1.0 / float(SHADOW_LOOKUPS));
}
#endif

#if LAMPS
#if LAMP_LOOKUPS
// Share of a lamp's light that nothing stops, 0..1; in_lamp is what seen_by_lamp gives, and inverse
// the reciprocal of the distance ahead.
float lamplight(int number, vec4 in_lamp, float inverse) {
  vec4 tile = lamp_shadow[number];
  vec2 off = in_lamp.xy * inverse;
  vec3 place = vec3(off + tile.xy, tile.z - in_lamp.w * inverse);
#if LAMP_LOOKUPS == 1
  float lit = textureLod(lamp_map, place, 0.0);
#else
  const mat2 turn = mat2(LAMP_COS, LAMP_SIN, -LAMP_SIN, LAMP_COS);
  vec2 offset = vec2(0.0, 1.0);
  float lit = 0.0;
  for (int look = 0; look < LAMP_LOOKUPS; ++look) {
    lit += textureLod(lamp_map, vec3(place.xy + offset * lamp_tile.zw, place.z), 0.0);
    offset = turn * offset;
  }
  lit *= 1.0 / float(LAMP_LOOKUPS);
#endif
  vec2 inside = lamp_tile.xy - abs(off);
  // Beside its tile a lamp shines all around, and one without a tile everywhere.
  return min(min(inside.x, inside.y), in_lamp.z) < 0.0 ? 1.0 : lit;
}
#endif
#endif

void main() {
  vec3 n = normalize(normal);
  float square = dot(towards_eye, towards_eye);
  float nearness = inversesqrt(square);
  vec3 to_eye = towards_eye * nearness;
  float frontal = dot(n, to_eye);
  vec3 mirrored = 2.0 * frontal * n - to_eye;
  vec3 albedo = paint.rgb;
#if TEXTURED
  // Half a level sharper than OpenGL would choose for floors, which are mostly seen at a slant.
  vec3 texel = texture(picture, uv, -0.5).rgb;
  albedo *= texel * texel;
#endif
  vec3 above = sky_and_exposure.rgb;
  vec3 below = ground_and_opacity.rgb;
#if COVER
  float covered = clamp(textureLod(cover_map, in_cover.xy, 0.0).r - in_cover.z, 0.0, 1.0);
#if !SUN
  above *= 1.0 - SKY_SHADE * covered;
#endif
#endif
  vec3 light = mix(below, above, 0.5 + 0.5 * n.z) + fill * max(dot(n, to_fill), 0.0);
  vec3 shine = vec3(0.0);
#if SUN
  float facing = dot(n, to_sun);
  if (facing > 0.0) {
    facing *= sunlight();
    light += sun * facing;
#if !TEXTURED
    // What has a texture is mostly matt: concrete, wood, plaster.
    shine += sun * (facing * highlight(mirrored, to_sun));
#endif
  }
#if COVER
  // What stands upright is higher than its own foot all along.
  light *= 1.0 - SUN_SHADE * covered * max(n.z, 0.0);
#endif
#endif
#if LAMPS
  for (int number = 0; number < LAMPS; ++number) {
#if LAMPS_BY_VERTEX
    vec3 to_lamp = to_lamps[number];
    vec4 in_lamp = in_lamps[number];
#else
    vec3 to_lamp;
    vec4 in_lamp = seen_by_lamp(number, world, n, to_lamp);
#endif
    float ahead = in_lamp.z;
    vec4 source = lamp_light[number];
    float distance2 = dot(to_lamp, to_lamp);
    float distance = sqrt(distance2);
    // One division for all three.
    float denominator = distance2 + lamp_nearest2;
    float forward = max(ahead, 1e-3);
    float all = 1.0 / (distance * denominator * forward);
    float inverse = all * denominator * forward;
    to_lamp *= inverse;
    float cone = clamp(source.w + lamp_aim[number].w * ahead * inverse, 0.0, 1.0);
    // Falls with the square of the distance, and smoothly to nothing at the reach.
    float far = distance2 * lamp_place[number].w;
    float fade = max(1.0 - far * far, 0.0) * cone;
#if COVER
    // The higher a lamp stands, the more of what hides the sky hides it, too.
    float high = max(to_lamp.z, 0.0);
    fade *= 1.0 - LAMP_SHADE * covered * high * high;
#endif
    float falloff = all * distance * forward;
    float arriving = max(dot(n, to_lamp), 0.0) * fade * fade * falloff;
#if LAMP_LOOKUPS
    arriving *= lamplight(number, in_lamp, all * distance * denominator);
#endif
    light += source.rgb * arriving;
    shine += source.rgb * (arriving * highlight(mirrored, to_lamp));
  }
#endif
#if !TEXTURED
  // Paint, metal and rubber mirror what is around them, the more the flatter one looks at them
  // (C. Schlick, "An inexpensive BRDF model for physically-based rendering", 1994; fourth power).
  float away = clamp(1.0 - frontal, 0.0, 1.0);
  away *= away; away *= away;
  shine += mix(below, above, 0.5 + 0.5 * mirrored.z) * (MIRRORED + GRAZING * away);
#endif
  light += GLOW * paint.a;
#if FOG
  float clear = exp2(-haze * square * nearness);
#else
  float veil = haze * square;
  float clear = 1.0 / (1.0 + veil * veil);
#endif
  vec3 seen = mix(haze_light, albedo * light + shine, clear);
  fragment = vec4(to_display(sky_and_exposure.a * seen), ground_and_opacity.a);
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
uniform float exposure;
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
#else
  // Wooded hills far away end what is seen of the ground.
  sky = ray.z * abs(ray.z) < 0.0008 * dot(ray.xy, ray.xy) ? horizon * HILLS : sky;
#endif
  fragment = vec4(to_display(exposure * sky), 1.0);
}
"""

_SPOTS_VERTEX = """
in vec3 in_position;
in vec2 in_place;
in vec3 in_light;
uniform mat4 clip_from_world;
out vec2 place;
flat out vec3 light;
void main() {
  place = in_place;
  light = in_light;
  gl_Position = clip_from_world * vec4(in_position, 1.0);
}
"""

_SPOTS_FRAGMENT = """
in vec2 place;
flat in vec3 light;
out vec4 fragment;
void main() {
  float within = max(1.0 - dot(place, place), 0.0);
  within *= within; within *= within;
  fragment = vec4(to_display(light * within), 0.0);
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


def lit_source(
    variant: LitVariant, shadow_lookups: int, lamp_lookups: int, constants: Constants
) -> ShaderSource:
    """Show surfaces in the light of the sun, the sky and lamps.

    Parameters
    ----------
    shadow_lookups
        In the sun's shadow maps for each pixel.
    lamp_lookups
        In the shadow map of each lamp for each pixel; 0: lamps throw no shadows.
    constants
        The scene's light, and what never changes.
    """
    turn = 2.0 * math.pi / shadow_lookups
    by_vertex = 0 < variant.lamps <= MOST_LAMPS_BY_VERTEX
    lamp_turn = 2.0 * math.pi / max(lamp_lookups, 1)
    head = _head(
        TEXTURED=int(variant.textured),
        SUN=int(variant.sun),
        COVER=int(variant.cover),
        FULL_COVER=FULL_COVER,
        GLOW=_GLOW,
        MIRRORED=_MIRRORED,
        GRAZING=_GRAZING,
        SKY_SHADE=_SKY_SHADE,
        LAMP_SHADE=_LAMP_SHADE,
        SUN_SHADE=_SUN_SHADE,
        FOG=int(variant.fog),
        LAMPS=variant.lamps,
        LAMPS_BY_VERTEX=int(by_vertex),
        WORLD=int(variant.lamps > 0 and not by_vertex),
        SHADOW_LOOKUPS=shadow_lookups,
        TURN_COS=math.cos(turn),
        TURN_SIN=math.sin(turn),
        SHARP_BORDER=_SHARP_BORDER,
        LAMP_LOOKUPS=lamp_lookups,
        LAMP_COS=math.cos(lamp_turn),
        LAMP_SIN=math.sin(lamp_turn),
    )
    head += "".join(f"const {_glsl_type(v)} {n} = {_glsl(v)};\n" for n, v in constants.items())
    head += _LAMPS
    return ShaderSource(head + _LIT_VERTEX, head + _TO_DISPLAY + _LIT_FRAGMENT)


def _glsl_type(value: Sequence[float]) -> str:
    return f"vec{len(value)}" if len(value) > 1 else "float"


def _glsl(value: Sequence[float]) -> str:
    return f"{_glsl_type(value)}({', '.join(repr(float(number)) for number in value)})"


def depth_source() -> ShaderSource:
    """Write depth alone, for the shadow map."""
    return ShaderSource(_head() + _DEPTH_VERTEX, _head() + _DEPTH_FRAGMENT)


def spots_source() -> ShaderSource:
    """Add round spots of light to what is there."""
    return ShaderSource(_head() + _SPOTS_VERTEX, _head() + _TO_DISPLAY + _SPOTS_FRAGMENT)


def sky_source(fog: bool) -> ShaderSource:
    """Show the sky behind everything, with or without fog before it."""
    head = _head(FOG=int(fog)) + f"const vec3 HILLS = {_glsl(_HILLS)};\n"
    return ShaderSource(head + _SKY_VERTEX, head + _TO_DISPLAY + _SKY_FRAGMENT)


def _head(**defines: float) -> str:
    lines = [f"#define {name} {value}" for name, value in {**defines, "EXPOSURE": EXPOSURE}.items()]
    return "\n".join(["#version 330", *lines, ""])
