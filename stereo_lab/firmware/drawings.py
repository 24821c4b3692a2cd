"""Drawings of the arm, to scale, from its own numbers: ``python drawings.py [FOLDER]``.

Writes front.svg, layers.svg and template.svg beside itself, or into a folder. Lengths, limits, switches and end stops are
those of the kit's arm; belts, pulleys and boards stand below. Who builds another arm changes a number and draws again.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from stereo_lab.arm.virtual import BENCH_ARM, END_STOPS_DEG
from stereo_lab.kinematics import TwoLinkArm

SMALL_PULLEY, LARGE_PULLEY, TOOTH_MM = 20, 60, 2.0  # teeth of the pulleys on motor and joint; a GT2 belt
SHOULDER_BELT_MM, ELBOW_BELT_MM = 200.0, 760.0  # closed belts that are sold
MOTOR_MM, MOTOR_LONG_MM = 24.4, 52.0  # the motor's diameter, its length with encoder
PEG_MM = 4.0  # an end stop is two screws of this diameter, shank on shank
LINK_MM, WEB_MM = 34.0, 4.0  # how wide and how thick the links are
HAND_MM = 20.0  # the spot that holds the ball
BLACK, BLUE, ORANGE, GREEN, RED, WOOD = "#000000", "#0072B2", "#E69F00", "#009E73", "#D55E00", "#F3E3C3"


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

    def write(self, path: Path, told: str) -> None:
        """As a file; a millimetre is a millimetre when it is printed at 100 percent."""
        wide, high = self.high[0] - self.low[0], self.high[1] - self.low[1]
        head = (
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{wide:g}mm" height="{high:g}mm" viewBox="0 0 {wide:g} {high:g}" '
            f'font-family="sans-serif" role="img" aria-label="{told}">\n<rect width="{wide:g}" height="{high:g}" fill="#fff"/>\n'
        )
        path.write_text(head + "\n".join(self.parts) + "\n</svg>\n", encoding="utf-8")


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


def front(arm: TwoLinkArm, folder: Path) -> None:
    """As the cameras see it: ranges, end stops, both belts."""
    one, other, far = 35.0, -60.0, sum((arm.l1_mm, arm.l2_mm))
    (low1, high1), (low2, high2) = arm.limits_deg
    tail, behind = axles_apart_mm(ELBOW_BELT_MM) - arm.l1_mm, axles_apart_mm(SHOULDER_BELT_MM)
    elbow, motors = around(arm.l1_mm, one), ((0.0, -behind), around(-tail, one))
    hand = around(arm.l2_mm, one + other, elbow)
    s = Svg((-far - 15, -far - 45), (far + 15, far + 30))
    s.box(-60, -far - 20, 120, far + 75, WOOD)
    s.box(-150, -far - 30, 300, 10, WOOD)
    s.circle(0, 0, far, color="#999999", dash="6 4")
    s.line([(0, 0), (far - 40, 0)], "#999999", 0.4, "4 3")
    s.text(far - 42, -14, "0°", 11, "end", "#555555")
    s.line(arc(far - 25, low1, high1), BLUE, 1.2)
    s.text(0, far - 19, f"shoulder {low1:g}° to {high1:g}°", 11, "middle", BLUE)
    for end in (low1, high1):
        s.line([around(far - 37, end), around(far - 17, end)], BLUE, 1.2)
        s.text(*around(far - 42, end), f"{end:g}°", 11, "start", BLUE)
    s.area(bar((0, 0), one, tail, arm.l1_mm), "#DCEBF5")
    s.area(bar(elbow, one + other, 0, arm.l2_mm), "#DDF2EA")
    s.line(belt_line(motors[0], (0, 0)), BLACK, 1.2)
    s.line(belt_line(motors[1], elbow), BLACK, 1.2)
    for motor in motors:
        s.circle(*motor, MOTOR_MM / 2, "#cccccc")
    for stops, center, link, turns in ((END_STOPS_DEG[0], (0.0, 0.0), 0.0, one), (END_STOPS_DEG[1], elbow, one, other)):
        for angle in (link + fixed_peg_deg(stops), link + turns):
            s.circle(*around(peg_circle_mm(stops), angle, center), PEG_MM / 2, RED, RED)
    s.line(arc(arm.l1_mm * 0.42, one + low2, one + high2, elbow), GREEN, 1.2)
    s.text(elbow[0], elbow[1] + arm.l1_mm * 0.42 + 6, f"elbow {low2:g}° to {high2:g}°", 11, "middle", GREEN)
    s.line([elbow, around(arm.l2_mm * 0.9, one, elbow)], "#999999", 0.4, "4 3")
    for place in ((0.0, 0.0), elbow):
        s.circle(*place, 4, "#ffffff")
    s.circle(*hand, HAND_MM / 2, ORANGE)
    s.text(hand[0] - 4, hand[1] + 22, "hand", 11, "end")
    s.text(-far, -far - 5, f"links {arm.l1_mm:g} and {arm.l2_mm:g} mm from axle to axle", 11)
    s.text(-far, -far - 20, "red: the pegs that end the ranges", 11, color=RED)
    s.text(-far, -far - 35, "black: belts; grey: motors", 11)
    s.write(
        folder / "front.svg", "The arm as the cameras see it, with the ranges of both joints; the page says the same"
    )


def layers(arm: TwoLinkArm, folder: Path) -> None:
    """Seen from above, the arm to the right: what sits before what. Depths are drawn twice as large as lengths."""
    deep, tail, far = 2.0, axles_apart_mm(ELBOW_BELT_MM) - arm.l1_mm, arm.l1_mm + 60
    parts = (  # words, thickness in mm, from and to along the arm, colour
        ("back board, 4 mm, with a hole of 26 mm for the motor", 4, -70, 60, WOOD),
        ("four spacers, 22 mm", 22, 52, 58, "#eeeeee"),
        ("front board, 8 mm: two of 4 mm, glued", 8, -70, 60, WOOD),
        ("belt of the shoulder, pulleys of 20 and 60 teeth: 12 mm", 12, -21, 21, "#dddddd"),
        ("belt of the elbow, pulleys of 20 and 60 teeth: 12 mm", 12, -tail - 8, arm.l1_mm + 21, "#dddddd"),
        ("link 1, 4 mm", WEB_MM, -tail - LINK_MM / 2, arm.l1_mm + LINK_MM / 2, "#DCEBF5"),
        ("washers, 6 mm: room for the pegs of the elbow", 6, arm.l1_mm - 8, arm.l1_mm + 8, "#eeeeee"),
        ("link 2, 4 mm", WEB_MM, arm.l1_mm - LINK_MM / 2, far, "#DDF2EA"),
    )
    s = Svg((-tail - 35, -75), (far + 215, 260))
    tops = [deep * sum(part[1] for part in parts[: k + 1]) for k in range(len(parts))]
    board, link = tops[2], tops[5]
    s.box(-MOTOR_MM / 2, board - 8 * deep - MOTOR_LONG_MM * deep, MOTOR_MM, MOTOR_LONG_MM * deep, "#cccccc")
    s.text(0, -40, "motor", 8, "middle")
    s.text(0, -66, f"{MOTOR_LONG_MM:g} mm", 8, "middle")
    for (words, thick, start, end, fill), top in zip(parts, tops, strict=True):
        s.box(start, top - thick * deep, end - start, thick * deep, fill)
        told = max(top - thick * deep / 2, 0)
        s.line([(end, told), (far + 8, told)], "#777777", 0.3)
        s.text(far + 10, told - 2.2, words, 6.5)
    s.box(-tail - MOTOR_MM / 2, link, MOTOR_MM, MOTOR_LONG_MM * deep, "#cccccc")
    s.text(-tail, link + 60, "motor", 8, "middle")
    s.box(-4, 0, 8, link + 6, "#888888")
    s.box(arm.l1_mm - 4, tops[3], 8, tops[7] - tops[3] + 8, "#888888")
    s.text(-tail - 30, 246, "From above; the cameras are at the top. Depths are drawn twice as large as lengths.", 9)
    s.text(30, -30, "The motor of the shoulder lies below its axle and is drawn through it.", 7)
    s.text(30, -42, "Axles (dark): 8 mm, each in two bearings.", 7)
    s.write(
        folder / "layers.svg",
        "The arm from above: boards, belts and links one before the other; the page says the same",
    )


def template(arm: TwoLinkArm, folder: Path) -> None:
    """Both links and the holes of the front board, as large as they are: print at 100 percent, glue on, drill."""
    tail, behind = axles_apart_mm(ELBOW_BELT_MM) - arm.l1_mm, axles_apart_mm(SHOULDER_BELT_MM)
    s = Svg((-tail - 25, -205), (arm.l1_mm + 45, 35))
    s.area(bar((0, 0), 0, tail, arm.l1_mm), "none")
    s.text(arm.l1_mm / 2, 6, "link 1", 8, "middle")
    _hole(s, 0, 0, 8, "shoulder: 8 mm; the axle is clamped by a hub")
    _hole(s, arm.l1_mm, 0, 16, "elbow: 16 mm; two flanged bearings F688", "end")
    _motor(s, -tail, 0)
    _peg(s, peg_circle_mm(END_STOPS_DEG[0]), 0)
    _peg(s, *around(peg_circle_mm(END_STOPS_DEG[1]), fixed_peg_deg(END_STOPS_DEG[1]), (arm.l1_mm, 0)))
    s.area([(x, y - 65) for x, y in bar((0, 0), 0, 0, arm.l2_mm)], "none")
    s.text(arm.l2_mm / 2, -59, "link 2", 8, "middle")
    _hole(s, 0, -65, 8, "elbow: 8 mm; the axle is clamped by a hub")
    _hole(s, arm.l2_mm, -65, 3, "hand: 3 mm", "end")
    _peg(s, peg_circle_mm(END_STOPS_DEG[1]), -65)
    s.text(0, -108, "front board, turned: down is to the right", 7)
    _hole(s, 60, -140, 22, "shoulder: 22 mm; a bearing 608 in each board", "end")
    _motor(s, 60 + behind, -140)
    s.text(78 + behind, -142, "motor of the shoulder", 5)
    _peg(s, *around(peg_circle_mm(END_STOPS_DEG[0]), fixed_peg_deg(END_STOPS_DEG[0]) + 90, (60, -140)))
    s.line([(0, -190), (100, -190)])
    for x in range(0, 101, 10):
        s.line([(x, -190), (x, -183 if x % 50 == 0 else -187)])
    s.text(104, -191, "100 mm: measure this line after printing", 6)
    s.text(arm.l1_mm + 40, -200, "red: pegs, 4 mm", 6, "end", RED)
    s.write(folder / "template.svg", "Templates of both links and of the holes in the front board, at full size")


def _hole(s, x, y, diameter, words, anchor="start"):
    s.circle(x, y, diameter / 2)
    s.line([(x - 3, y), (x + 3, y)], wide=0.2)
    s.line([(x, y - 3), (x, y + 3)], wide=0.2)
    s.text(x + (-3 if anchor == "start" else 3), y - LINK_MM / 2 - 6, words, 5, anchor)


def _motor(s, x, y):
    """The motor's face: slots, so that it can be moved until the belt is tight."""
    for side, radius in ((0, 3.6), (8.5, 1.6), (-8.5, 1.6)):
        s.area([*arc(radius, -90, 90, (x + 2, y + side)), *arc(radius, 90, 270, (x - 2, y + side))], "none")


def _peg(s, x, y):
    s.circle(x, y, PEG_MM / 2, color=RED)


def main(folder: Path) -> None:
    """Draw all of it."""
    for draw in (front, layers, template):
        draw(BENCH_ARM, folder)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
