#!/usr/bin/env python3
"""Draws docs/images/kinematics.svg: the arm's frames and Denavit-Hartenberg parameters.

Everything that is drawn comes from the robot's URDF by telex_control.kinematics. All joints stand
at 0. The picture is an oblique projection: x to the right, z upwards, y away from the reader.

    source env.sh
    python docs/draw_kinematics.py          # the SVG
    python docs/draw_kinematics.py --png    # and the PNG, by Chromium
"""

from __future__ import annotations

import argparse
import re
import subprocess
import tempfile
from pathlib import Path
from typing import Any, Dict, List
from xml.sax.saxutils import escape

import numpy as np

from telex_control.kinematics import Chain, DHChain, dh_chain
from telex_control.urdf.joints import parse_urdf

IMAGES = Path(__file__).parent / "images"
MODEL = Path(__file__).parents[1] / "src" / "telex_description" / "urdf" / "telex.urdf.xacro"
MINUS = "\u2212"
SIZE = (1480, 720)  # px
ORIGIN = (120.0, 500.0)  # px, where base_link is drawn
SCALE = 820.0  # px/m
AWAY = (1.05, 0.80)  # what a metre of y is drawn as, in metres to the right and upwards
ROUND = 0.45  # shortens the depth of round signs, which would look slanted otherwise
AXIS = 62.0  # px, of the drawn axes
X_COLOUR, Z_COLOUR, INK, PALE, FILL = "#c0392b", "#1f5fa8", "#1c1c1c", "#5c5c5c", "#e9edf1"
STYLE = f"""
  text {{ font-family: 'Times New Roman', 'Liberation Serif', serif; fill: {INK}; }}
  .symbol {{ font-size: 23px; }}
  .number {{ font-size: 20px; }}
  .joint {{ font-size: 18px; fill: {PALE}; }}
  .sub {{ font-size: 70%; }}
  .variable {{ font-style: italic; }}
"""
Point = Any  # two numbers (px), or an array of them


def project(point: Any) -> np.ndarray:
    """Return where a point of base_link (m) is drawn (px)."""
    x, y, z = point
    return np.array([ORIGIN[0] + SCALE * (x + AWAY[0] * y), ORIGIN[1] - SCALE * (z + AWAY[1] * y)])


def _moved(point: Point, x: float, y: float) -> Point:
    return (point[0] + x, point[1] + y)


def hull(points: np.ndarray) -> np.ndarray:
    """Convex hull of points in the plane, by Andrew's monotone chain."""
    ordered = sorted(map(tuple, points))

    def half(sequence: List[Point]) -> List[Point]:
        kept: List[Point] = []
        for point in sequence:
            while len(kept) > 1 and _turn(kept[-2], kept[-1], point) <= 1e-9:
                kept.pop()
            kept.append(point)
        return kept[:-1]

    return np.array(half(ordered) + half(ordered[::-1]))


def _turn(a: Point, b: Point, c: Point) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


class Schematic:
    """An SVG picture in the making."""

    def __init__(self) -> None:
        self._elements: List[str] = []

    def line(
        self, start: Point, end: Point, colour: str = INK, width: float = 1.5, more: str = ""
    ) -> None:
        """Draw a straight line (px)."""
        self._elements.append(
            f'<line x1="{start[0]:.1f}" y1="{start[1]:.1f}" x2="{end[0]:.1f}" y2="{end[1]:.1f}" '
            f'stroke="{colour}" stroke-width="{width}" {more}/>'
        )

    def polygon(self, points: np.ndarray, fill: str = FILL, width: float = 1.6) -> None:
        """Draw a closed outline (px)."""
        text = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        self._elements.append(
            f'<polygon points="{text}" fill="{fill}" stroke="{INK}" stroke-width="{width}" '
            'stroke-linejoin="round"/>'
        )

    def dot(self, place: Point) -> None:
        """Mark the origin of a frame."""
        self._elements.append(
            f'<circle cx="{place[0]:.1f}" cy="{place[1]:.1f}" r="4.5" fill="{INK}"/>'
        )

    def arrow(self, start: Point, end: Point, colour: str, width: float = 2.4) -> None:
        """Draw an arrow with a filled head."""
        self.line(start, end, colour, width, f'marker-end="url(#head-{colour[1:]})"')

    def text(self, place: Point, text: str, kind: str, anchor: str = "middle") -> None:
        """Write, as `_typeset` has it."""
        self._elements.append(
            f'<text x="{place[0]:.1f}" y="{place[1]:.1f}" class="{kind}" '
            f'text-anchor="{anchor}">{_typeset(text)}</text>'
        )

    def dimension(
        self, start: Point, end: Point, shift: Point, label: str, beside: bool = False
    ) -> None:
        """Draw a measure between two points, moved aside by `shift`.

        Its label stands beyond the line, or, where that is too short for it, `beside` its end.
        """
        a, b = np.add(start, shift), np.add(end, shift)
        away = np.array(shift) / np.linalg.norm(shift)
        for point, moved in ((start, a), (end, b)):
            self.line(point + 7.0 * away, moved + 7.0 * away, PALE, 0.9)
        self.line(a, b, INK, 1.1, 'marker-start="url(#tick)" marker-end="url(#tick)"')
        middle = (a + b) / 2.0
        if beside:
            end = max(a, b, key=lambda point: point[0])
            self.text(_moved(end, 12.0, -13.0 if shift[0] else 7.0), label, "symbol", "start")
        elif away[0]:
            self.text(_moved(middle, -14.0, 7.0), label, "symbol", "end")
        else:
            self.text(_moved(middle, 0.0, 28.0 if away[1] > 0 else -12.0), label, "symbol")

    def cylinder(self, centre: np.ndarray, axis: np.ndarray, radius: float, length: float) -> None:
        """Draw the sign of a revolute joint; figures in m, in base_link."""
        across = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
        across /= np.linalg.norm(across)
        other = np.cross(axis, across)
        angles = np.linspace(0.0, 2.0 * np.pi, 49)[:-1]
        ring = [radius * (np.cos(t) * across + np.sin(t) * other) for t in angles]
        ring = [(x, ROUND * y, z) for x, y, z in ring]
        # Of the two ends one faces the reader, who looks along (-AWAY[0], 1, -AWAY[1]).
        facing = np.sign(np.dot(axis, (AWAY[0], -1.0, AWAY[1])))
        ends = {
            side: np.array([project(centre + side * length / 2.0 * axis + r) for r in ring])
            for side in (-1.0, 1.0)
        }
        self.polygon(hull(np.vstack([ends[-1.0], ends[1.0]])))
        self.polygon(ends[facing], "#f8fafb", 1.2)

    def box(self, centre: np.ndarray, half: np.ndarray) -> None:
        """Draw the sign of a prismatic joint: a box along x, y, z; figures in m, in base_link."""
        low, high = centre - half, centre + half
        corners = {
            (i, j, k): project([(low, high)[i][0], (low, high)[j][1], (low, high)[k][2]])
            for i in (0, 1)
            for j in (0, 1)
            for k in (0, 1)
        }
        for face in (
            [(1, 0, 0), (1, 1, 0), (1, 1, 1), (1, 0, 1)],
            [(0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)],
            [(0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1)],
        ):
            self.polygon(np.array([corners[corner] for corner in face]), width=1.3)

    def svg(self) -> str:
        """Return the picture as a file's text."""
        heads = "".join(
            f'<marker id="head-{colour[1:]}" markerWidth="9" markerHeight="8" refX="6" refY="4" '
            f'orient="auto"><path d="M0,0.6 L8,4 L0,7.4 z" fill="{colour}"/></marker>'
            for colour in (X_COLOUR, Z_COLOUR)
        )
        tick = (
            '<marker id="tick" markerWidth="12" markerHeight="12" refX="6" refY="6" '
            f'orient="auto"><path d="M3,9 L9,3" stroke="{INK}" stroke-width="1.6"/></marker>'
        )
        return "\n".join(
            [
                f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {SIZE[0]} {SIZE[1]}" '
                f'width="{SIZE[0]}" height="{SIZE[1]}">',
                f"<style>{STYLE}</style>",
                f"<defs>{heads}{tick}</defs>",
                '<rect width="100%" height="100%" fill="white"/>',
                *self._elements,
                "</svg>\n",
            ]
        )


def _typeset(text: str) -> str:
    """Turn ``*x*`` into italics, and ``_x`` or ``_{xy}`` into a subscript."""
    made, lowered = [], False
    for part in re.split(r"(_\{[^}]*\}|_.|\*[^*]+\*)", text):
        if not part:
            continue
        subscript = part.startswith("_")
        kinds = "sub" if subscript else "variable" if part.startswith("*") else ""
        # A step down at a subscript, and up again after it.
        step = 6 * (subscript - lowered)
        lowered = subscript
        attributes = (f' class="{kinds}"' if kinds else "") + (f' dy="{step}"' if step else "")
        made.append(f"<tspan{attributes}>{escape(part.strip('_{}*'))}</tspan>")
    return "".join(made)


def draw(chain: Chain, parameters: DHChain) -> str:
    """Return the picture of a chain with the robot's seven arm joints."""
    drawing = Schematic()
    zero = [0.0] * len(chain.joints)
    frames = parameters.frames(zero)
    origins = [frame[:3, 3] for frame in frames]
    places = {joint.child: chain.forward(zero, joint.child) for joint in chain.path}
    _links(drawing, places, origins)
    _joints(drawing, places)
    _frames(drawing, frames)
    _dimensions(drawing, parameters, origins)
    _table(drawing, parameters)
    return drawing.svg()


def _links(drawing: Schematic, places: Dict[str, np.ndarray], origins: List[np.ndarray]) -> None:
    """Draw the skeleton: hull, column, arm, forearm, gripper."""
    turret = origins[0]
    ground = project((turret[0], 0.0, 0.0))
    for offset in range(-60, 61, 15):
        drawing.line(
            (ground[0] + offset, ground[1] + 62), (ground[0] + offset - 11, ground[1] + 75)
        )
    drawing.line((ground[0] - 72, ground[1] + 62), (ground[0] + 66, ground[1] + 62), width=2.0)
    drawing.line(_moved(ground, 0.0, 62.0), project(origins[1]), width=5.0)
    path = [origins[1], places["upper_arm_link"][:3, 3] * (1, 0, 1), *origins[2:4], *origins[4:8]]
    for start, end in zip(path, path[1:]):
        drawing.line(project(start), project(end), width=5.0)
    tool = project(origins[7])
    for side in (-1.0, 1.0):
        palm = _moved(tool, -44.0, side * 24.0)
        drawing.line(_moved(tool, -44.0, 0.0), palm, width=4.0)
        drawing.line(palm, _moved(palm, 62.0, 0.0), width=4.0)


def _joints(drawing: Schematic, places: Dict[str, np.ndarray]) -> None:
    """Draw the signs of the joints, and their names."""
    x, y, z = np.eye(3)
    at = {link: pose[:3, 3] for link, pose in places.items()}
    signs = (
        (at["turret_link"], z, (44, 8), "turret", "start"),
        (at["upper_arm_link"], y, (-68, 28), "shoulder", "end"),
        (at["telescope_link"], None, (0, 56), "telescope", "middle"),
        (at["elbow_link"] - 0.044 * y, y, (-18, 66), "elbow", "middle"),
        (at["forearm_link"] + 0.225 * x, x, (0, 50), "forearm roll", "middle"),
        (at["wrist_link"], y, (8, 62), "wrist pitch", "middle"),
        (at["gripper_link"] + 0.05 * x, x, (0, 50), "gripper roll", "middle"),
    )
    for index, (place, axis, shift, name, anchor) in enumerate(signs, start=1):
        if axis is None:
            drawing.box(place, np.array([0.050, 0.018, 0.028]))
        else:
            drawing.cylinder(place, axis, 0.030, 0.064)
        drawing.text(_moved(project(place), *shift), f"*q*_{index} {name}", "joint", anchor)


def _frames(drawing: Schematic, frames: List[np.ndarray]) -> None:
    """Draw x and z of the base link's frame and of frames 0 to 7; 5 and 6 share their place."""
    labels = {
        "B": (np.eye(4), (8, 24), (-20, 8)),
        "0": (frames[0], (22, 8), (22, 6)),
        "1": (frames[1], (20, -8), (-22, 8)),
        "2": (frames[2], (-22, -4), (28, 20)),
        "3": (frames[3], (-22, 8), (16, 26)),
        "4": (frames[4], (-22, 8), (20, 2)),
        "5": (frames[5], (-42, 8), (14, 26)),
        "6": (frames[6], None, (22, 0)),
        "7": (frames[7], (-22, 8), (22, 8)),
    }
    for name, (frame, x_shift, z_shift) in labels.items():
        place = project(frame[:3, 3])
        length = 42.0 if name == "B" else AXIS
        for column, colour, shift in ((0, X_COLOUR, x_shift), (2, Z_COLOUR, z_shift)):
            if shift is None:
                continue
            direction = project(frame[:3, 3] + frame[:3, column]) - place
            end = place + direction / np.linalg.norm(direction) * length
            drawing.arrow(place, end, colour)
            label = (
                "*x*_5, *x*_6" if (name, column) == ("5", 0) else f"*{'xz'[column // 2]}*_{name}"
            )
            drawing.text(_moved(end, *shift), label, "symbol")
        drawing.dot(place)


def _dimensions(drawing: Schematic, parameters: DHChain, origins: List[np.ndarray]) -> None:
    """Draw the lengths that are not 0."""
    at = [project(origin) for origin in origins]
    rows = parameters.rows
    # where the axes of turret and shoulder are nearest to each other
    foot = project(origins[1] + parameters.base[:3, 0] * rows[1].a)
    base = project((0.0, 0.0, 0.0))
    top = 96.0
    drawing.dimension(base, at[0], (0, 112), f"{origins[0][0]:.3f}")
    drawing.dimension(at[0], at[1], (-104, 0), f"*d*_1 = {rows[0].d:.3f}")
    drawing.dimension(at[1], foot, (0, 150 - at[1][1]), f"*a*_1 = {rows[1].a:.3f}", beside=True)
    drawing.dimension(at[2], foot, (104, 0), f"*d*_2 = {_signed(rows[1].d, 3)}", beside=True)
    drawing.dimension(at[2], at[3], (0, top - at[2][1]), f"*d*_3 = {rows[2].d:.3f} + *q*_3")
    drawing.dimension(at[3], at[4], (100, 0), f"*d*_4 = {rows[3].d:.3f}", beside=True)
    drawing.dimension(at[4], at[5], (0, top - at[4][1]), f"*d*_5 = {rows[4].d:.3f}")
    drawing.dimension(at[6], at[7], (0, top - at[6][1]), f"*d*_7 = {rows[6].d:.3f}")


def _table(drawing: Schematic, parameters: DHChain) -> None:
    """Write the parameters."""
    columns = (660.0, 770.0, 890.0, 1040.0, 1200.0)
    heads = ("*i*", "*\u03b1*_{i\u22121}", "*a*_{i\u22121}", "*d*_i", "*\u03b8*_i")
    top, step = 424.0, 30.0
    left, right = columns[0] - 34.0, columns[-1] + 70.0
    for height in (top - 28.0, top + 14.0, top + 26.0 + 7 * step):
        drawing.line((left, height), (right, height), INK, 1.3)
    for x, head in zip(columns, heads):
        drawing.text((x, top), head, "symbol")
    for index, row in enumerate(parameters.rows, start=1):
        height = top + 12.0 + index * step
        drawing.text((columns[0], height), str(index), "number")
        angle, variable = np.degrees(row.theta), f"*q*_{index}"
        cells = (
            _signed(np.degrees(row.alpha), 0, "\u00b0"),
            _signed(row.a, 3),
            _signed(row.d, 3) + (f" + {variable}" if row.prismatic else ""),
            _signed(angle, 0, "\u00b0") if row.prismatic else _sum(variable, angle),
        )
        for x, cell in zip(columns[1:], cells):
            drawing.text((x, height), cell, "number")
    note = "lengths in m; all joints at 0; offsets across the arm are drawn 1.3 times as long"
    drawing.text(((left + right) / 2.0, top + 54.0 + 7 * step), note, "joint")


def _signed(value: float, digits: int, unit: str = "") -> str:
    if abs(value) < 1e-9:
        return "0"
    sign = MINUS if value < 0 else ""
    return f"{sign}{abs(value):.{digits}f}{unit}"


def _sum(variable: str, angle: float) -> str:
    if abs(angle) < 1e-9:
        return variable
    return f"{variable} {MINUS if angle < 0 else '+'} {abs(angle):.0f}\u00b0"


def main() -> None:
    """Write the picture."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--png", action="store_true", help="also the PNG, by Chromium")
    options = parser.parse_args()
    urdf = subprocess.run(
        ["xacro", str(MODEL)], check=True, stdout=subprocess.PIPE, text=True
    ).stdout
    chain = Chain(parse_urdf(urdf), "base_link", "tool_link")
    target = IMAGES / "kinematics.svg"
    target.write_text(draw(chain, dh_chain(chain)), encoding="utf-8")
    if options.png:
        with tempfile.TemporaryDirectory() as profile:
            subprocess.run(
                [
                    "chromium",
                    "--headless",
                    "--no-sandbox",
                    "--disable-gpu",
                    f"--user-data-dir={profile}",
                    f"--window-size={SIZE[0]},{SIZE[1]}",
                    f"--screenshot={target.with_suffix('.png')}",
                    target.as_uri(),
                ],
                check=True,
                capture_output=True,
            )


if __name__ == "__main__":
    main()
