"""Drawings of the arm, to scale, from its own numbers: ``python drawings.py [FOLDER]``.

Writes front.svg, layers.svg and template.svg beside itself, or into a folder, and template.html, the last one on sheets
that a browser prints. Lengths, limits, switches and end stops are
those of the kit's arm; belts, pulleys and boards stand below. Who builds another arm changes a number and draws again.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from stereo_lab.arm.virtual import BENCH_ARM, END_STOPS_DEG, SWITCHES_DEG
from stereo_lab.kinematics import TwoLinkArm

SMALL_PULLEY, LARGE_PULLEY, TOOTH_MM = 20, 60, 2.0  # teeth of the pulleys on motor and joint; a GT2 belt
SHOULDER_BELT_MM, ELBOW_BELT_MM = 200.0, 852.0  # closed belts that are sold
MOTOR_MM, MOTOR_LONG_MM = 24.4, 52.0  # the motor's diameter, its length with encoder
PEG_MM = 5.0  # an end stop is two screws of this diameter, shank on shank
LINK_MM = 34.0  # how wide the links are
STEEL_MM = 28.0  # how far before and behind the elbow's motor the steel sits that balances the arm
HAND_MM = 20.0  # the spot that holds the ball
SPACERS_MM = (40.0, 30.0)  # where the four spacers of the back board sit, from the shoulder's axle
SWITCH_MM = (20.0, 10.0)  # a micro switch from its side
# How far it sits before the place where it closes, and beside the way of the peg
SWITCH_ASIDE_MM, SWITCH_OFF_MM = 5.0, 2.0
SWITCH_MOVED_MM = (complex(-2.2, 0), complex(-3, -2.7))  # so that the peg comes across its lever, and not along it
LEVER_MM, LEVER_DEG = 17.0, 10.0  # its lever, and how that stands off its side
SHEET_MM = (180.0, 190.0)  # of the template on one sheet, A4 or Letter; no hole is cut
HEAD = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>{told}</title>
<style>@page {{ margin: 10mm }} body {{ margin: 0; font: 9pt sans-serif }} p {{ margin: 0 0 1mm }}
section {{ break-after: page; break-inside: avoid }} svg {{ display: block }}</style></head><body>"""
PLAY_MM = 4.0  # how far a motor can be pushed along its belt
BLACK, BLUE, ORANGE, GREEN, RED, WOOD, NUT = "#000000", "#0072B2", "#E69F00", "#009E73", "#D55E00", "#F3E3C3", "#E8A07A"
NUT_MM, THIN_NUT_MM = 4.0, 2.7  # how high a nut M5 is, and a thin one

# From where to where a part reaches, mm towards the cameras from the face of the front board.
BACK_BOARD, SPACERS, FRONT_BOARD = (-46.0, -38.0), (-38.0, -8.0), (-8.0, 0.0)
SHOULDER_AXLE, SHOULDER_MOTOR = (-58.0, 66.0), (-4.0 - MOTOR_LONG_MM, -4.0)
SHOULDER_PULLEYS, SHOULDER_BELT = (2.0, 18.0), (10.5, 16.5)
SHOULDER_PEGS = (
    (-11.0, 24.0),
    (19.0, 54.0),
)  # on the board, on link 1: screws of 35 mm, with three washers and with two
SHOULDER_SWITCH = (17.0, 23.4)  # on a block of 16 mm and 1 mm of card
ELBOW_PULLEYS, ELBOW_BELT = (26.0, 42.0), (27.5, 33.5)
LINK_1, LINK_2 = (44.0, 52.0), (64.0, 68.0)
ELBOW_MOTOR = (48.0, 48.0 + MOTOR_LONG_MM)
ELBOW_PEGS = ((44.0, 60.0), (56.0, 72.0))  # on link 1 from behind, countersunk; on link 2 from before: screws of 16 mm
ELBOW_DOUBLER = (68.0, 72.0)  # a second layer of link 2, where its peg is
ELBOW_SWITCH = (53.5, 59.9)  # on 1.5 mm of card
ELBOW_AXLE = (25.0, 80.0)


def pulley_radius_mm(teeth: int) -> float:
    """The radius at which the belt runs."""
    return teeth * TOOTH_MM / (2 * math.pi)


def belt_mm(apart_mm: float) -> float:
    """How long a belt round both pulleys is, their axles so far apart."""
    large, small = pulley_radius_mm(LARGE_PULLEY), pulley_radius_mm(SMALL_PULLEY)
    lean = math.asin((large - small) / apart_mm)
    return 2 * apart_mm * math.cos(lean) + math.pi * (large + small) + 2 * lean * (large - small)


def axles_apart_mm(length_mm: float) -> float:
    """How far apart the axles are with a belt of this length, to a thousandth: halves the gap."""
    low, high = pulley_radius_mm(LARGE_PULLEY) + pulley_radius_mm(SMALL_PULLEY), length_mm
    while high - low > 0.001:
        middle = (low + high) / 2
        low, high = (middle, high) if belt_mm(middle) < length_mm else (low, middle)
    return (low + high) / 2


def peg_circle_mm(stops_deg: tuple[float, float]) -> float:
    """The radius at which two pegs meet at both ends of a range."""
    return PEG_MM / 2 / math.sin(math.radians(360 - (stops_deg[1] - stops_deg[0])) / 4)


def fixed_peg_deg(stops_deg: tuple[float, float]) -> float:
    """Where the peg that does not turn sits, in degrees of the joint: half way round, between the two ends."""
    return (stops_deg[1] + stops_deg[0] + 360) / 2


@dataclass
class Svg:
    """A drawing in millimetres, y up; text is read from left to right.

    Attributes
    ----------
    low, high : (x, y) of the lower left and the upper right corner, mm
    parts : list of str
    """

    low: tuple[float, float]
    high: tuple[float, float]
    parts: list[str] = field(default_factory=list)

    def at(self, x: float, y: float) -> tuple[float, float]:
        """A place on the sheet, whose y points down."""
        return round(x - self.low[0], 2), round(self.high[1] - y, 2)

    def line(
        self, places: Sequence[tuple[float, float]], color: str = BLACK, wide: float = 0.6, dash: str = ""
    ) -> None:
        """A line through some places."""
        way = " ".join(f"{x},{y}" for x, y in (self.at(*p) for p in places))
        dash = f' stroke-dasharray="{dash}"' if dash else ""
        self.parts.append(f'<polyline points="{way}" fill="none" stroke="{color}" stroke-width="{wide}"{dash}/>')

    def area(self, places: Sequence[tuple[float, float]], fill: str, color: str = BLACK, wide: float = 0.6) -> None:
        """A filled outline."""
        way = " ".join(f"{x},{y}" for x, y in (self.at(*p) for p in places))
        self.parts.append(f'<polygon points="{way}" fill="{fill}" stroke="{color}" stroke-width="{wide}"/>')

    def box(self, x: float, y: float, wide: float, high: float, fill: str) -> None:
        """A rectangle from its lower left corner."""
        self.area([(x, y), (x + wide, y), (x + wide, y + high), (x, y + high)], fill)

    def circle(self, x: float, y: float, radius: float, fill: str = "none", color: str = BLACK, dash: str = "") -> None:
        """A circle."""
        cx, cy = self.at(x, y)
        dash = f' stroke-dasharray="{dash}"' if dash else ""
        self.parts.append(
            f'<circle cx="{cx}" cy="{cy}" r="{round(radius, 2)}" fill="{fill}" stroke="{color}" stroke-width="0.6"{dash}/>'
        )

    def text(
        self, x: float, y: float, words: str, size: float = 7.0, anchor: str = "start", color: str = BLACK
    ) -> None:
        """A line of text."""
        tx, ty = self.at(x, y)
        self.parts.append(
            f'<text x="{tx}" y="{ty}" font-size="{size}" text-anchor="{anchor}" fill="{color}">{words}</text>'
        )

    @property
    def size(self) -> tuple[float, float]:
        """Width and height, mm."""
        return self.high[0] - self.low[0], self.high[1] - self.low[1]

    def write(self, path: Path, told: str) -> None:
        """As a file; a millimetre is a millimetre when it is printed at 100 percent."""
        wide, high = self.size
        head = (
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{wide:g}mm" height="{high:g}mm" viewBox="0 0 {wide:g} {high:g}" '
            f'font-family="sans-serif" role="img" aria-label="{told}">\n<rect width="{wide:g}" height="{high:g}" fill="#fff"/>\n'
        )
        path.write_text(head + "\n".join(self.parts) + "\n</svg>\n", encoding="utf-8")


def sheets(drawing: Svg, path: Path, told: str) -> None:
    """A drawing cut into sheets for a printer, each in a frame along which it is cut; the frames lie edge on edge."""
    (wide, high), (across, down) = drawing.size, SHEET_MM
    columns, rows = math.ceil(wide / across), math.ceil(high / down)
    pages = []
    for k in range(columns * rows):
        row, column = divmod(k, columns)
        shared = '<g id="all">' + "\n".join(drawing.parts) + "</g>" if k == 0 else '<use href="#all"/>'
        pages.append(
            f"<section><p>Row {row + 1} of {rows}, column {column + 1} of {columns}. Print at 100 percent: the frame is "
            f"{across:g} mm wide. Cut along it.</p>\n"
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{across:g}mm" height="{down:g}mm" role="img" '
            f'viewBox="{column * across:g} {row * down:g} {across:g} {down:g}" font-family="sans-serif" '
            f'aria-label="{told}, row {row + 1}, column {column + 1}">\n{shared}\n<rect x="{column * across:g}" '
            f'y="{row * down:g}" width="{across:g}" height="{down:g}" fill="none" stroke="#000" stroke-width="0.4"/>\n</svg></section>'
        )
    page = "\n".join([HEAD.format(told=told), *pages, "</body></html>"])
    path.write_text(page + "\n", encoding="utf-8")


def around(radius: float, degrees: float, center: tuple[float, float] = (0.0, 0.0)) -> tuple[float, float]:
    """A place on a circle; 0 degrees points right, plus is counter-clockwise."""
    angle = math.radians(degrees)
    return center[0] + radius * math.cos(angle), center[1] + radius * math.sin(angle)


def arc(radius: float, low: float, high: float, center: tuple[float, float] = (0.0, 0.0)) -> list[tuple[float, float]]:
    """Places along a part of a circle."""
    return [around(radius, low + (high - low) * k / 120, center) for k in range(121)]


def belt_line(motor: tuple[float, float], joint: tuple[float, float]) -> list[tuple[float, float]]:
    """The way of a belt round the pulley of a motor and that of a joint."""
    large, small = pulley_radius_mm(LARGE_PULLEY), pulley_radius_mm(SMALL_PULLEY)
    apart, along = math.dist(motor, joint), math.degrees(math.atan2(joint[1] - motor[1], joint[0] - motor[0]))
    lean = 90 + math.degrees(math.asin((large - small) / apart))
    round_joint = arc(large, along - lean, along + lean, joint)
    round_motor = arc(small, along + lean, along + 360 - lean, motor)
    return [*round_joint, *round_motor, round_joint[0]]


def bar(start: tuple[float, float], degrees: float, tail: float, length: float) -> list[tuple[float, float]]:
    """A link with round ends, from a tail behind its axle to an end before it."""
    back, front = around(-tail, degrees, start), around(length, degrees, start)
    return [*arc(LINK_MM / 2, degrees - 90, degrees + 90, front), *arc(LINK_MM / 2, degrees + 90, degrees + 270, back)]


def tail_mm(arm: TwoLinkArm) -> float:
    """How far behind the shoulder the elbow's motor sits, for its belt to be tight."""
    return axles_apart_mm(ELBOW_BELT_MM) - arm.l1_mm


def switch_box(j: int, turned_deg: float = 0.0) -> tuple[tuple[float, float], float]:
    """The middle of a joint's switch, mm from the axle, and which way its long side lies, degrees.

    Its lever leans into the way of the moving peg; with the peg where the switch closes, it is pressed.
    """
    radius = peg_circle_mm(END_STOPS_DEG[j]) + PEG_MM / 2 + SWITCH_OFF_MM + SWITCH_MM[1] / 2
    middle = SWITCHES_DEG[j] + math.degrees(SWITCH_ASIDE_MM / radius) + turned_deg
    place = complex(*around(radius, middle)) + SWITCH_MOVED_MM[j] * complex(*around(1.0, turned_deg))
    return (place.real, place.imag), middle + 90


def lever(j: int, turned_deg: float = 0.0) -> list[tuple[float, float]]:
    """Both ends of the lever: its hinge where the peg comes from, its tip before the fixed peg."""
    middle, along = switch_box(j, turned_deg)
    hinge = around(SWITCH_MM[1] / 2, along + 90, around(SWITCH_MM[0] / 2 - 1.5, along, middle))
    return [hinge, around(LEVER_MM, along + 180 - LEVER_DEG, hinge)]


def front(arm: TwoLinkArm, folder: Path) -> None:
    """As the cameras see it: ranges, end stops, both belts, all in one pose."""
    one, other, far = 35.0, -60.0, sum((arm.l1_mm, arm.l2_mm))
    (low1, high1), (low2, high2) = arm.limits_deg
    tail, behind = tail_mm(arm), axles_apart_mm(SHOULDER_BELT_MM)
    elbow, motors = around(arm.l1_mm, one), ((0.0, -behind), around(-tail, one))
    hand = around(arm.l2_mm, one + other, elbow)
    s = Svg((-far - 15, -far - 80), (far + 15, far + 30))
    s.box(-30, -far - 55, 60, far - 25, WOOD)
    s.box(-65, -190, 130, 260, WOOD)
    s.box(-150, -far - 65, 300, 10, WOOD)
    s.circle(0, 0, far, color="#999999", dash="6 4")
    s.line([(0, 0), (far - 40, 0)], "#999999", 0.4, "4 3")
    s.text(far - 42, -14, "0°", 11, "end", "#555555")
    s.line(arc(far - 25, low1, high1), BLUE, 1.2)
    s.text(0, far - 19, f"shoulder {low1:g}° to {high1:g}°", 11, "middle", BLUE)
    for end in (low1, high1):
        s.line([around(far - 37, end), around(far - 17, end)], BLUE, 1.2)
        s.text(*around(far - 42, end), f"{end:g}°", 11, "start", BLUE)
    s.area(bar((0, 0), one, tail + STEEL_MM, arm.l1_mm), "#DCEBF5")
    s.area(bar(elbow, one + other, 0, arm.l2_mm), "#DDF2EA")
    s.line(belt_line(motors[0], (0, 0)), BLACK, 1.2)
    s.line(belt_line(motors[1], elbow), BLACK, 1.2)
    for motor in motors:
        s.circle(*motor, MOTOR_MM / 2, "#cccccc")
    for apart in (-STEEL_MM, STEEL_MM):
        s.circle(*around(-tail + apart, one), 9, "#777777")
    for j, center, link, turns in ((0, (0.0, 0.0), 0.0, one), (1, elbow, one, other)):
        stops = END_STOPS_DEG[j]
        for angle in (link + fixed_peg_deg(stops), link + turns):
            s.circle(*around(peg_circle_mm(stops), angle, center), PEG_MM / 2, RED, RED)
        (x, y), along = switch_box(j, link)
        s.area(rectangle((center[0] + x, center[1] + y), SWITCH_MM, along), "#ffffff", RED, 1.0)
        s.line([(center[0] + x, center[1] + y) for x, y in lever(j, link)], RED, 0.8)
    s.line(arc(arm.l1_mm * 0.42, one + low2, one + high2, elbow), GREEN, 1.2)
    s.text(elbow[0], elbow[1] + arm.l1_mm * 0.42 + 6, f"elbow {low2:g}° to {high2:g}°", 11, "middle", GREEN)
    s.line([elbow, around(arm.l2_mm * 0.9, one, elbow)], "#999999", 0.4, "4 3")
    for place in ((0.0, 0.0), elbow):
        s.circle(*place, 4, "#ffffff")
    s.circle(*hand, HAND_MM / 2, ORANGE)
    s.text(hand[0] - 4, hand[1] + 22, "hand", 11, "end")
    s.text(-far, -far - 20, f"links {arm.l1_mm:g} and {arm.l2_mm:g} mm from axle to axle", 11)
    s.text(-far, -far - 35, "red dots: the pegs that end the ranges; red boxes: switches", 11, color=RED)
    s.text(-far, -far - 50, "black: belts; light grey: motors; dark grey: steel", 11)
    s.text(-far, -far - 74, f"the shoulder's axle is {far + 65:g} mm above the table", 11)
    s.write(
        folder / "front.svg", "The arm as the cameras see it, with the ranges of both joints; the page says the same"
    )


def layers(arm: TwoLinkArm, folder: Path) -> None:
    """Seen from above, the arm to the right: what sits before what. Depths are drawn three times as large as lengths."""
    deep, tail, far = 3.0, tail_mm(arm), arm.l1_mm + 60
    large, small = pulley_radius_mm(LARGE_PULLEY) + 2, pulley_radius_mm(SMALL_PULLEY) + 2
    boards, l1 = (-SPACERS_MM[0] - 10, SPACERS_MM[0] + 10), arm.l1_mm
    shoulder, elbow = peg_circle_mm(END_STOPS_DEG[0]), peg_circle_mm(END_STOPS_DEG[1])
    parts = (  # words, depths, from and to along the arm, colour
        ("back board, 8 mm: two layers of plywood", BACK_BOARD, *boards, WOOD),
        ("four spacers, 30 mm", SPACERS, SPACERS_MM[0] - 4, SPACERS_MM[0] + 4, "#eeeeee"),
        ("front board, 8 mm: two layers of plywood", FRONT_BOARD, -65, 65, WOOD),
        ("shoulder: 60 teeth on the axle, 20 on the motor", SHOULDER_PULLEYS, -large, large, "#bbbbbb"),
        ("", SPACERS, -SPACERS_MM[0] - 4, -SPACERS_MM[0] + 4, "#eeeeee"),
        ("elbow: 60 teeth on the axle, 20 on the motor", ELBOW_PULLEYS, l1 - large, l1 + large, "#bbbbbb"),
        ("", ELBOW_PULLEYS, -tail - small, -tail + small, "#bbbbbb"),
        ("its belt, 852 mm", ELBOW_BELT, -tail, l1, "#444444"),
        ("link 1, 8 mm: two layers of plywood", LINK_1, -tail - STEEL_MM - 17, l1 + 17, "#DCEBF5"),
        ("tube 10 x 1 mm round the axle, 11 mm long", (LINK_1[1] + 1, LINK_2[0]), l1 - 5, l1 + 5, "#eeeeee"),
        ("link 2, 4 mm: one layer", LINK_2, l1 - 17, far, "#DDF2EA"),
        ("hub of link 2", (LINK_2[1], ELBOW_AXLE[1]), l1 - 11, l1 + 11, "#bbbbbb"),
        ("", (LINK_1[1], LINK_1[1] + 12), -11, 11, "#bbbbbb"),
        ("", ELBOW_MOTOR, -tail - MOTOR_MM / 2, -tail + MOTOR_MM / 2, "#cccccc"),
        ("", SHOULDER_MOTOR, -MOTOR_MM / 2, MOTOR_MM / 2, "#cccccc"),
        ("", SHOULDER_AXLE, -4, 4, "#888888"),
        ("", ELBOW_AXLE, l1 - 4, l1 + 4, "#888888"),
        ("", SHOULDER_PEGS[0], -shoulder - PEG_MM / 2, -shoulder + PEG_MM / 2, RED),
        (
            "red: pegs; this one between both strands",
            SHOULDER_PEGS[1],
            shoulder - PEG_MM / 2,
            shoulder + PEG_MM / 2,
            RED,
        ),
        ("", ELBOW_PEGS[0], l1 - elbow - PEG_MM / 2, l1 - elbow + PEG_MM / 2, RED),
        ("", ELBOW_DOUBLER, l1 + 12, l1 + 27, "#DDF2EA"),
        ("", ELBOW_PEGS[1], l1 + elbow - PEG_MM / 2, l1 + elbow + PEG_MM / 2, RED),
        ("", (LINK_1[1], LINK_1[1] + THIN_NUT_MM), l1 - elbow - 4, l1 - elbow + 4, NUT),
        ("", (LINK_2[0] - THIN_NUT_MM, LINK_2[0]), l1 + elbow - 4, l1 + elbow + 4, NUT),
        ("", (FRONT_BOARD[1], FRONT_BOARD[1] + NUT_MM), -shoulder - 4, -shoulder + 4, NUT),
        ("", (LINK_1[0] - NUT_MM, LINK_1[0]), shoulder - 4, shoulder + 4, NUT),
        ("switch of the shoulder, on its block", SHOULDER_SWITCH, -shoulder - 15, -shoulder - 5, "#ffffff"),
        ("", (FRONT_BOARD[1], SHOULDER_SWITCH[0]), -shoulder - 15, -shoulder - 5, WOOD),
        ("switch of the elbow, on link 1", ELBOW_SWITCH, l1 - elbow - 15, l1 - elbow - 5, "#ffffff"),
    )
    s = Svg((-tail - 85, -deep * 58 - 45), (far + 255, deep * 100 + 32))
    for _, (low, high), start, end, fill in parts:
        s.box(start, deep * low, end - start, deep * (high - low), fill)
    for apart in (-STEEL_MM, STEEL_MM):
        s.box(-tail + apart - 5, deep * 37.6, 10, deep * 36.4, "#777777")
    told = sorted((part for part in parts if part[0]), key=lambda part: sum(part[1]))
    for k, (words, (low, high), _, end, _) in enumerate(told):
        height, level = deep * (low + high) / 2, deep * -40 + 30 * k
        s.line([(end, height), (far + 20, height), (far + 55, level)], "#777777", 0.3)
        s.text(far + 58, level - 2.5, words, 8)
    for depth in (-46, -8, 0, 44, 52, 64, 68, 100):
        s.line([(-tail - 62, deep * depth), (-tail - 56, deep * depth)], wide=0.4)
        s.text(-tail - 65, deep * depth - 3, f"{depth}", 8, "end")
    s.text(-tail + MOTOR_MM / 2 + 6, deep * 85, "motor of the elbow", 8)
    s.text(-tail + STEEL_MM + 8, deep * 60, "steel", 8)
    s.text(18, deep * -52, "motor of the shoulder, below its axle", 8)
    s.text(14, deep * 60, "axle: a tube, the wires go through it; hub of link 1", 8)
    s.text(
        -tail - 80,
        deep * 100 + 18,
        "From above; the cameras are at the top. Depths are drawn three times as large as lengths.",
        10,
    )
    s.text(-tail - 80, deep * -58 - 35, "Left: mm from the face of the front board.", 9)
    s.write(
        folder / "layers.svg",
        "The arm from above: boards, belts and links one before the other; the page says the same",
    )


def template(arm: TwoLinkArm, folder: Path) -> None:
    """Both links and the holes of the boards, as large as they are; each hole's place in mm stands beside it."""
    tail, behind, l1 = tail_mm(arm), axles_apart_mm(SHOULDER_BELT_MM), arm.l1_mm
    s = Svg((-tail - STEEL_MM - 25, -330), (l1 + 45, 50))
    s.area(bar((0, 0), 0, tail + STEEL_MM, l1), "none")
    s.text(
        l1 / 2,
        22,
        "link 1, twice: glue both layers. Below each hole: mm from the shoulder's axle, and its diameter",
        6,
        "middle",
    )
    _hole(s, 0, 0, 8, "0: axle 8")
    _hole(s, l1, 0, 16)
    s.text(l1 + 34, -37, f"{l1:g}: 16, bearings", 5, "end")
    _motor(s, -tail, 0, f"−{tail:.1f}: motor; opening in the front layer")
    for apart in (-STEEL_MM, STEEL_MM):
        _hole(s, -tail + apart, 0, 10, f"−{tail - apart:.0f}: 10")
    radius1, radius2 = (peg_circle_mm(stops) for stops in END_STOPS_DEG)
    _peg(s, radius1, 0, f"{radius1:.1f}: peg")
    fixed = around(radius2, fixed_peg_deg(END_STOPS_DEG[1]))
    _peg(s, l1 + fixed[0], fixed[1])
    s.text(l1 - 42, -31, f"peg {l1 + fixed[0]:.1f}, and {fixed[1]:.1f} up", 5, "end", RED)
    s.area([(l1 - 38, -17), (l1 - 38, -31), (l1 - 6, -31), (l1 - 6, -15)], "none")
    s.text(l1 - 42, -25, "an ear for the switch, on both layers", 5, "end")
    _switch(s, 1, (l1, 0))
    s.area([(x, y - 70) for x, y in bar((0, 0), 0, 0, arm.l2_mm)], "none")
    s.text(arm.l2_mm / 2, -48, "link 2, once: mm from the elbow's axle", 6, "middle")
    _hole(s, 0, -70, 8, "0: axle 8", "end")
    _hole(s, arm.l2_mm, -70, 3.2, f"{arm.l2_mm:g}: hand 3.2", "end")
    _peg(s, radius2, -70, f"{radius2:.1f}: peg")
    s.area([(12, -80), (27, -80), (27, -60), (12, -60)], "none")
    s.text(31, -68, "piece on the front, 20 x 15", 5)
    x, y = -tail + 110, -185  # the front board lies on its side: up is to the left
    s.box(x - 70, y - 65, 260, 130, "none")
    s.text(x - 66, y + 69, "front board, twice: glue both layers; up is to the left", 6)
    s.text(x + 186, y + 56, "the post is screwed behind this end: 4 x 25", 6, "end")
    for screw in ((95, -20), (95, 20), (175, -20), (175, 20)):
        _hole(s, x + screw[0], y + screw[1], 4)
    _hole(s, x, y, 22, "0: 22, bearing 608")
    _motor(s, x + behind, y, f"−{behind:.1f}: motor; opening in the back layer")
    fixed = around(radius1, fixed_peg_deg(END_STOPS_DEG[0]))
    _peg(s, x - fixed[1], y + fixed[0])
    s.text(x - 8, y - 52, f"peg {-fixed[0]:.1f} to the left, {fixed[1]:.1f} up", 5, "end", RED)
    _switch(s, 0, (x, y), 90)
    for across in (-SPACERS_MM[0], SPACERS_MM[0]):
        for along in (-SPACERS_MM[1], SPACERS_MM[1]):
            _hole(s, x + along, y + across, 4)
    s.box(x + 215, y - 50, 76, 100, "none")
    s.text(x + 253, y + 54, "back board, twice", 6, "middle")
    _hole(s, x + 253, y, 22, "bearing 608")
    for across in (-SPACERS_MM[0], SPACERS_MM[0]):
        for along in (-SPACERS_MM[1], SPACERS_MM[1]):
            _hole(s, x + 253 + along, y + across, 4)
    s.text(x + 253, y - 62, "four holes 4 in each board:", 6, "middle")
    s.text(x + 253, y - 70, f"{SPACERS_MM[0]:g} sideways, {SPACERS_MM[1]:g} up and down", 6, "middle")
    s.line([(-100, -310), (0, -310)])
    for at in range(0, 101, 10):
        s.line([(at - 100, -310), (at - 100, -303 if at % 50 == 0 else -307)])
    s.text(6, -311, "100 mm: measure this line after printing", 6)
    s.text(l1 + 40, -320, f"red: pegs, {PEG_MM:g} mm, and switches (set them with the pegs in place)", 6, "end", RED)
    told = "Templates of the links and of the holes in both boards, at full size"
    s.write(folder / "template.svg", told)
    sheets(s, folder / "template.html", told)


def rectangle(middle: tuple[float, float], size: tuple[float, float], along_deg: float) -> list[tuple[float, float]]:
    """The corners of a rectangle whose long side lies at an angle."""
    turn, corners = complex(*around(1.0, along_deg)), []
    for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
        corner = complex(x * size[0] / 2, y * size[1] / 2) * turn
        corners.append((middle[0] + corner.real, middle[1] + corner.imag))
    return corners


def _hole(s, x, y, diameter, words="", anchor="start"):
    s.circle(x, y, diameter / 2)
    s.line([(x - 3, y), (x + 3, y)], wide=0.2)
    s.line([(x, y - 3), (x, y + 3)], wide=0.2)
    s.text(x + (-3 if anchor == "start" else 3), y - LINK_MM / 2 - 6, words, 5, anchor)


def _motor(s, x, y, words):
    """The motor's face: slots, so that it can be moved until the belt is tight; dashed the opening for its body."""
    for side, radius in ((0, 3.6), (8.5, 1.6), (-8.5, 1.6)):
        _slot(s, x, y + side, radius)
    _slot(s, x, y, MOTOR_MM / 2 + 0.8, "2 2")
    s.text(x - 3, y - LINK_MM / 2 - 12, words, 5)
    s.text(x - 3, y - LINK_MM / 2 - 18, f"of 26 x {26 + PLAY_MM:g}; slots of 7.2, and of", 5)
    s.text(x - 3, y - LINK_MM / 2 - 24, f"3.2, 8.5 aside; all {PLAY_MM:g} longer", 5)


def _slot(s, x, y, radius, dash=""):
    half = PLAY_MM / 2
    places = [*arc(radius, -90, 90, (x + half, y)), *arc(radius, 90, 270, (x - half, y))]
    s.line([*places, places[0]], dash=dash)


def _peg(s, x, y, words=""):
    s.circle(x, y, PEG_MM / 2, color=RED)
    s.text(x, y - LINK_MM / 2 - 6, words, 5, color=RED)


def _switch(s, j, axle, turned_deg=0.0):
    (x, y), along = switch_box(j, turned_deg)
    s.area(rectangle((axle[0] + x, axle[1] + y), SWITCH_MM, along), "none", RED)
    s.line([(axle[0] + x, axle[1] + y) for x, y in lever(j, turned_deg)], RED)


def main(folder: Path) -> None:
    """Draw all of it."""
    for draw in (front, layers, template):
        draw(BENCH_ARM, folder)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
