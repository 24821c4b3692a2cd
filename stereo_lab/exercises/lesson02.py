"""Questions of lesson 02: find the ball."""

from __future__ import annotations

import math

import cv2
import numpy as np

from stereo_lab.exercises.answers import Choice, Function, Number, Wrong
from stereo_lab.exercises.question import Question, lesson
from stereo_lab.exercises.seats import numbers
from stereo_lab.recording import Recording

HUES = np.array([0, 2, 6, 7, 8, 30, 90, 120, 171, 172, 173, 175, 179], np.uint8)
CENTERS = ((10.0, 10.0, 13.0, 14.0), (100.0, 50.0, 100.25, 50.5), (20.0, 30.0, 26.0, 28.5))
EMPTY_INSIDE = (
    r"[,:;]? \(?((but|and|with|there|that|which|is|has|of|an?) )*"
    "(a?round nothing|((nothing|empty|hollow|hole|no (vote|point|dot)s?( (reach(es)?|gets? to|meets? (in|at)))?)( (in|at|inside))?|without)"
    r"( (an?|the|its))? (centre|center|middle))\)?"
)
POINTS = "((many|several|single) )?(points|dots|spots)"
# Rings that votes towards the bright side do not draw; half the ball's own size may be right
OTHER_RINGS = (
    ".*(outside|beyond|(on|at|where) (the|its) (rim|edge)|round the (rim|edge|ball(?!'s c))|everywhere|everything|all over"
    r"|\b(two|three|many|several|lots of)( \w+)? (rings|circles)|rings? in(side)? (a )?rings?|r ?[+] ?r).*"
)
ITS_OWN_RING = (
    r"(?!.*\b(half|smaller)\b).*(\b(same|original) (circle|ring|radius|size|diameter)|\b(again|as before)\b"
    "|(size|radius|diameter|circle) of the (ball|circle|rim)"
    "|(ball|circle)('s)? (own )?(size|radius|diameter|circle|rim)"
    r"|\b(radius|diameter) (of |is )?(2 ?[*·]? ?)?r\b(?! ?([-−–/]|minus|less))).*"
)
LARGE_RING = r"(?=.*\b(ring|circle))(?!.*\b(half|smaller|filled)\b).*\b(big|large|huge|wide|double|twice|enlarged).*"


def questions(recording: Recording) -> tuple[Question, ...]:
    """Seven questions; the pixel and the numbers are the same for every recording, but for those of a seat."""
    pixel = numbers(recording.seat).pixel_bgr
    return lesson("02", _order(pixel), _wrap(), _lightness(pixel), _votes(), _peak(), _rate(), _error())


def _order(pixel):
    return dict(
        asks=f"A pixel of OpenCV is {pixel}. How much red is in it?",
        answer=Number(
            pixel[2], 0, "of 255",
            (
                Wrong(pixel[0], "that is its blue: OpenCV's order is blue, green, red."),
                Wrong(pixel[1], "that is its green, in the middle."),
                Wrong(0, "that is the place of a number in the row; the number that stands there is asked for: pixel[…]."),
                Wrong(1, "that is the place of a number in the row; the number that stands there is asked for: pixel[…]."),
                Wrong(3, "that is how many numbers a pixel has. Which of the three is its red?"),
                Wrong(255, "255 is the most there can be. How much red has this pixel?"),
                Wrong(100 * pixel[2] / 255, "that is its share in percent. Take the number as it stands there."),
                Wrong(pixel[2] / sum(pixel), "that is the share of red in all three. Take the number as it stands there."),
                Wrong(100 * pixel[2] / sum(pixel), "that is the share of red in all three, in percent. Take the number as it stands there."),
                Wrong(sum(pixel) / 3, "that is the mean of all three. Red alone is asked for."),
                Wrong(2, "that is the place of red in the row; the number that stands there is asked for: pixel[…]."),
                Wrong(sum(pixel), "that is all three added. Red alone is asked for."),
                Wrong(pixel[2] / 255, "that is its share of the most there can be. Take the number as it stands there."),
            ),
            "blue, green, red: red comes last.",
            of_several="Take one of them: pixel[0], pixel[1] or pixel[2].",
            known={f"pixel[{k}]": n for k, n in enumerate(pixel)} | {"255": 255},
            ask="Take one of the three as it stands there.",
            beside=(
                ("r|red|(the )?(third|last)( one| number)?", "that is its name. The number that stands there is asked for: pixel[…]."),
                (r"(?!.*red).*\b(blue|green)\b.*", "blue stands first, green in the middle. Which number is the red one?"),
            ),
        ),
        hints=(
            "The three numbers are colours in a certain order.",
            "OpenCV counts B, G, R, the other way round than most.",
            "red = ____   # pixel[0], pixel[1] or pixel[2]",
        ),
        code="red = pixel[2]",
        reason="OpenCV keeps pictures as blue, green, red.",
        reference=pixel[2],
    )  # fmt: skip


def _wrap():
    return dict(
        asks="Write a function that is True where a hue is red: at most 7, or at least 172.",
        answer=Function(
            is_red, ((HUES,), (HUES[3:11],)), 0, "",
            (
                Wrong(lambda h: (h <= 7) & (h >= 172), "no hue is below 7 and above 172 at once: the two ends belong together by or, |."),
                Wrong(lambda h: (h <= 7, h >= 172), "a comma makes two answers. Join the two conditions by or: |."),
                Wrong(lambda h: (h > 7) & (h < 172), "this is everything that is not red. Turn both signs round, and & into |."),
                Wrong(lambda h: (h < 7) | (h >= 172), "at most 7 takes 7 as well: <=."),
                Wrong(lambda h: (h <= 7) | (h > 172), "at least 172 takes 172 as well: >=."),
                Wrong(lambda h: (h < 7) | (h > 172), "at most 7 takes 7 as well, and at least 172 takes 172: <= and >=."),
                Wrong(lambda h: (h >= 7) | (h <= 172), "this is every hue there is. Turn both signs round."),
                Wrong(lambda h: (h == 7) | (h == 172), "== takes one hue alone: use <= and >=."),
                Wrong(lambda h: 255 * is_red(h), "these are 255 and 0. True and False are asked for: the comparison itself gives them."),
                Wrong(lambda h: (h <= 7) | (h <= 172), "these are all hues up to 172. At least 172 is written >=."),
                Wrong(lambda h: (h >= 7) | (h >= 172), "these are all hues from 7 on. At most 7 is written <=."),
                Wrong(lambda h: (h <= 14) | (h >= 344), "OpenCV halves the hues already: 0 to 179. The bounds are 7 and 172."),
                Wrong(lambda h: (h > 0) & (h <= 7) | (h >= 172), "0 is red as well: it is at most 7."),
                Wrong(lambda h: (h <= 7) ^ (h <= 172), "^ is True where just one of the two is, and the second sign is turned. Use | and >=."),
                Wrong(lambda h: ~(h <= 7) | (h >= 172), "~ turns the first condition alone round: without it."),
                Wrong(lambda h: h == 0, "== takes one hue alone: use <= and >=."),
                Wrong(lambda h: bool(is_red(h).any()), "this is one answer for all hues together. Give one for each."),
                Wrong(lambda h: h <= 7, "half of red is missing: the hue wraps round, and 175 is red as well. If you wrote it, put each of the two comparisons in brackets of its own."),
                Wrong(lambda h: h >= 172, "half of red is missing: hues from 0 to 7 are red as well. If you wrote them, put each of the two comparisons in brackets of its own."),
                Wrong(lambda h: (h >= 7) & (h <= 172), "this is everything that is not red. Turn both signs round."),
            ),
            "red sits at both ends of the circle of hues.",
            also=(lambda h: ~((h > 7) & (h < 172)),),
        ),
        hints=(
            "Hue runs in a circle, 0 to 179 in OpenCV. Red lies where the circle closes.",
            "Two conditions, joined by | (or). Each in its own brackets.",
            "return (hue <= 7) | (____)",
        ),
        code="def is_red(hue):\n    return (hue <= 7) | (hue >= 172)",
        reason="OpenCV halves the 360 degrees of hue to fit a byte; red lies round 0, on both sides.",
        reference=is_red,
    )  # fmt: skip


def _lightness(pixel):
    hue, lightness, saturation = (int(n) for n in cv2.cvtColor(np.uint8([[pixel]]), cv2.COLOR_BGR2HLS)[0, 0])
    grey = float(np.dot((0.114, 0.587, 0.299), pixel))  # as cv2.COLOR_BGR2GRAY weighs them
    return dict(
        asks="The same pixel in HLS is printed above. What is its lightness?",
        answer=Number(
            lightness, 0, "of 255",
            (
                Wrong(saturation, "that is its saturation. Other programs write HSL; OpenCV's order is H, L, S."),
                Wrong(hue, "that is its hue: the tint, 0 to 179."),
                Wrong(0, "that is a place in the row; the number that stands there is asked for: hls_pixel[…]."),
                Wrong(1, "that is the place in the row; the number that stands there is asked for: hls_pixel[…]."),
                Wrong(3, "that is how many numbers there are. Which of the three is the lightness?"),
                Wrong(255, "255 would be white. How light is this pixel?"),
                Wrong(100 * lightness / 255, "that is its share in percent. Take the number as it stands there."),
                Wrong(grey, "that is its grey value, as an eye weighs the three colours. The numbers of the same pixel in HLS are in hls_pixel.", exact=True),
                Wrong(sum(pixel) / 3, "that is the mean of blue, green and red. The numbers of the same pixel in HLS are in hls_pixel."),
                Wrong((hue + lightness + saturation) / 3, "that is the mean of hue, lightness and saturation. Take one of them."),
                Wrong(hue + lightness + saturation, "that is all three added. Take one of them."),
                Wrong(pixel[0], "that is its blue. The numbers of the same pixel in HLS are in hls_pixel."),
                Wrong(pixel[2], "that is its red. The numbers of the same pixel in HLS are in hls_pixel."),
                Wrong(lightness / 255, "that is its share of the most there can be. Take the number as it stands there."),
                Wrong(pixel[1], "that is its green. The numbers of the same pixel in HLS are in hls_pixel."),
            ),
            "H, L, S: lightness stands in the middle.",
            of_several="Take one of them: hls_pixel[0], hls_pixel[1] or hls_pixel[2].",
            known={"hls_pixel[0]": hue, "hls_pixel[1]": lightness, "hls_pixel[2]": saturation, "255": 255},
            ask="Take one of the three as it stands there.",
            beside=(
                ("l|lightness|(the )?(second|middle)( one| number)?", "that is its name. The number that stands there is asked for: hls_pixel[…]."),
                (r"(?!.*light).*\b(hue|saturation|red|green|blue)\b.*", "which of the three numbers in hls_pixel is the lightness? Write it alone."),
            ),
        ),
        hints=(
            "The letters of HLS are in the order of the numbers.",
            "Hue, lightness, saturation.",
            "lightness = ____   # hls_pixel[0], hls_pixel[1] or hls_pixel[2]",
        ),
        code="lightness = hls_pixel[1]",
        reason="cv2.COLOR_BGR2HLS gives hue, lightness, saturation, in this order.",
        reference=lightness,
    )  # fmt: skip


def _votes():
    tries = ((100.0, 80.0, 1.0, 0.0, 20.0), (50.5, 60.0, 0.6, -0.8, 12.0), (40.0, 30.5, -0.8, 0.6, 15.0))
    return dict(
        asks="An edge pixel at (u, v) with the bright side in direction (du, dv): where does it vote for a centre at radius r?",
        answer=Function(
            votes_for, tries, 0.01, "px",
            (
                Wrong(lambda u, v, du, dv, r: (u - r * du, v - r * dv), "your vote goes away from the ball: the bright side is the inside."),
                Wrong(lambda u, v, du, dv, r: (r * du, r * dv), "that is the way alone. Start it at the edge pixel: (u, v)."),
                Wrong(lambda u, v, du, dv, r: (u + r, v + r), "that goes down to the right, whatever the direction is: r times (du, dv)."),
                Wrong(lambda u, v, du, dv, r: (u + r * dv, v + r * du), "du and dv have changed places."),
                Wrong(lambda u, v, du, dv, r: (u + r * abs(du), v + r * abs(dv)), "abs takes the signs away, and here they count: the bright side may lie to the left, or above."),
                Wrong(lambda u, v, du, dv, r: (u + r * du, v - r * dv), "one sign is turned: both steps are added."),
                Wrong(lambda u, v, du, dv, r: (u + r * math.cos(du), v + r * math.sin(dv)), "du and dv are steps of a direction already, no angles: no cos and sin."),
                Wrong(lambda u, v, du, dv, r: (u + du * dv * r, v + du * dv * r), "du belongs to u alone, and dv to v."),
                Wrong(lambda u, v, du, dv, r: (u * r + du, v * r + dv), "r belongs to the step, not to the edge pixel: r times (du, dv)."),
                Wrong(lambda u, v, du, dv, r: (u * du + r, v * dv + r), "the direction belongs to r, not to the edge pixel: r times (du, dv)."),
                Wrong(lambda u, v, du, dv, r: u + r * du, "that is u alone. Two numbers, with a comma between them."),
                Wrong(lambda u, v, du, dv, r: (u - r * du, v + r * dv), "one sign is turned: both steps are added."),
                Wrong(lambda u, v, du, dv, r: (u + r * du, u + r * dv), "the second number starts at v: you copied the first."),
                Wrong(lambda u, v, du, dv, r: (u + r * du, v + r * du), "the second step goes along dv: you copied the first."),
                Wrong(lambda u, v, du, dv, r: (u + r * du, v + dv), "r is missing in the second step."),
                Wrong(lambda u, v, du, dv, r: (u + du, v + r * dv), "r is missing in the first step."),
                Wrong(lambda u, v, du, dv, r: ((u + du) * r, (v + dv) * r), "only the direction is taken r times: no brackets round the sum."),
                Wrong(lambda u, v, du, dv, r: (u + du / r, v + dv / r), "the farther the centre, the longer the step: times r."),
                Wrong(lambda u, v, du, dv, r: (u + 2 * r * du, v + 2 * r * dv), "that is a whole diameter: the other side of the ball. One radius."),
                Wrong(lambda u, v, du, dv, r: (u, v), "that is the edge pixel itself. The centre lies one radius farther in."),
                Wrong(lambda u, v, du, dv, r: v + r * dv, "that is v alone. Two numbers, with a comma between them."),
                Wrong(lambda u, v, du, dv, r: (u + du, v + dv), "one pixel is not enough: go one radius."),
                Wrong(lambda u, v, du, dv, r: (v + r * dv, u + r * du), "u and v have changed places."),
            ),
            "one radius inwards from the edge lies the centre.",
        ),
        hints=(
            "The centre lies inside, one radius from the edge.",
            "Start at (u, v) and go r times the direction.",
            "return u + r * du, ____",
        ),
        code="def votes_for(u, v, du, dv, r):\n    return u + r * du, v + r * dv",
        reason="The radius of a circle stands at right angles on its edge, and so does the slope of the brightness.",
        reference=votes_for,
    )  # fmt: skip


def _peak():
    return dict(
        asks="You vote with a radius that is too small. What do the votes draw?",
        answer=Choice(
            "a ring",
            (
                Wrong("a point", "that happens for the right radius alone: all votes meet in the centre."),
                Wrong("nothing", "every edge pixel votes, whatever the radius. Where do the votes fall?"),
                Wrong("a disc", "every vote ends at the same distance from the centre. Where is it empty?"),
                Wrong("a line", "the votes come from all round the circle. They end equally far from its centre."),
            ),
            "all votes stop short of the centre, equally far from it.",
            also=(
                "a circle",
                "circle",
                "a small circle",
                "rings",
                "a small ring",
                "a smaller ring",
                "a smaller circle",
            ),
            same=(
                (
                    "((of|with) )?half (of )?(the |its |as )?(radius|size|diameter|large|big)( as)?( (of )?the (ball|rim|circle))?",
                    "",
                ),
                (
                    r"(circle|ring),? \(?(((that|which) is )?smaller( than the (ball|rim|outline|circle))?|but smaller)\)?",
                    "ring",
                ),
                (f"(circle|ring){EMPTY_INSIDE}", "ring"),
                ("((of|with) )?(an? )?smaller (radius|size|diameter)( than the (ball|rim|circle))?", ""),
                (
                    f"(circle|ring) of {POINTS}|{POINTS} (on|in|along|round|forming|that form) an? ((small|smaller) )?(circle|ring)",
                    "ring",
                ),
                ("(hollow|empty) dis[ck]|dis[ck] with a hole|circular line", "ring"),
                (
                    "(filled|full|solid) (circle|ring)|((big|bigger|large|larger|small|smaller|full|filled|solid|whole) )*dis[ck]|blob|patch|round area",
                    "disc",
                ),
                (
                    "((hollow|empty|small|smaller|thin|round|tiny|little|one) )*(circles?|rings?|donut|doughnut|hoop|loop|annulus|round line)"
                    "( with a hole| with nothing inside)?( ((a)?round|about) (the( ball's)?|its) (centre|center|middle))?",
                    "ring",
                ),
                ("((one|a|big|small|smaller|tiny|single) )*(dot|spot|points?|dots|peak)", "point"),
                ("(straight )?(lines?|stroke)", "line"),
            ),
            not_meant=(
                (
                    f"{OTHER_RINGS}|{ITS_OWN_RING}|{LARGE_RING}",
                    "which ring? Every vote goes inwards, by a radius r that is too small: how far from the centre does it end?",
                ),
                (
                    ".*(square|oval|broken) (ring|circle)",
                    "the votes come from all round a circle, and every one goes equally far. What do points equally far from one point draw?",
                ),
            ),
            beside=(
                (
                    ".*(ellips|oval|egg|moon|crescent|half|arc).*",
                    "the ball is nearly round here, and every vote goes equally far. What do points equally far from one point draw?",
                ),
                (
                    ".*(cross|star|string|square|triangle|cloud|chaos|noise|mess|random|everywhere|anything|scatter).*",
                    "each vote ends one radius inwards from its edge pixel, and all edge pixels lie on a circle. Draw four of them: where do they end?",
                ),
                (
                    ".*(centre|center|middle).*",
                    "there the votes of the right radius meet. These go less far: what do they draw round it?",
                ),
                (
                    ".*ball.*",
                    "the votes are no picture of the ball: each edge pixel marks one place. Draw four of them: where do they end?",
                ),
            ),
        ),
        hints=(
            "Each vote goes inwards by one radius.",
            "If the radius is too small, it does not reach the centre. By how much does it miss, and where?",
            'too_small = "a ____"',
        ),
        code='too_small = "a ring"',
        reason="The votes of a circle of radius R end at R − r from its centre: a ring, that shrinks to a point at r = R.",
        reference="a ring",
    )


def _rate():
    tries = ((248, 250), (99, 100), (5, 8))
    return dict(
        asks="Write the success rate in percent from hits and frames.",
        answer=Function(
            success_percent, tries, 0.05, "%",
            (
                Wrong(lambda hits, frames: hits / frames, "that is a share between 0 and 1. In percent it is a hundred times as much."),
                Wrong(lambda hits, frames: 100 * (hits // frames), "// throws the decimals away, and hits // frames is 0. Divide by a single /."),
                Wrong(lambda hits, frames: hits * frames / 100, "divide by frames; the hundred multiplies."),
                Wrong(lambda hits, frames: frames - hits, "that is the number of misses. How many of a hundred are hits?"),
                Wrong(lambda hits, frames: 100 - (frames - hits), "that is right for 100 frames alone. How many of a hundred are hits, whatever the number of frames?"),
                Wrong(lambda hits, frames: hits - frames, "that is the misses, with a minus. How many of a hundred are hits?"),
                Wrong(lambda hits, frames: hits / frames / 100, "a share becomes percent times a hundred, not over a hundred."),
                Wrong(lambda hits, frames: hits / frames + 100, "the hundred multiplies: percent is a hundred times the share."),
                Wrong(lambda hits, frames: 100 - hits / frames, "the hundred multiplies: percent is a hundred times the share."),
                Wrong(lambda hits, frames: 100 * hits / (hits + frames), "the hits are among the frames already: divide by frames alone."),
                Wrong(lambda hits, frames: 100 * hits / (frames - hits), "that is hits for each miss. Divide by all frames."),
                Wrong(lambda hits, frames: hits / (frames - hits), "that is hits for each miss. Divide by all frames."),
                Wrong(lambda hits, frames: frames / hits, "upside down: hits belong above the line. And times a hundred."),
                Wrong(lambda hits, frames: (frames - hits) / frames, "that is the share of misses."),
                Wrong(lambda hits, frames: 100 * frames / hits, "this is above 100: hits belong above the line."),
                Wrong(lambda hits, frames: 100 * (frames - hits) / frames, "that is the rate of misses."),
            ),
            "hits over frames, times a hundred.",
        ),
        hints=("Hits belong above the line.", "A share becomes percent times a hundred.", "return 100 * ____ / frames"),
        code="def success_percent(hits, frames):\n    return 100 * hits / frames",
        reason="Percent is of a hundred.",
        reference=success_percent,
    )  # fmt: skip


def _error():
    return dict(
        asks="Write the distance between a found centre (u, v) and the true one (a, b).",
        answer=Function(
            center_error, CENTERS, 0.01, "px",
            (
                Wrong(lambda u, v, a, b: abs(u - a) + abs(v - b), "you added the two steps. The straight way is shorter: Pythagoras."),
                Wrong(lambda u, v, a, b: (u - a) ** 2 + (v - b) ** 2, "the square root is missing."),
                Wrong(lambda u, v, a, b: ((u - a) ** 2 + (v - b) ** 2) / 2, "**1/2 is first **1 and then half of it. A root is **0.5 or **(1/2)."),
                Wrong(lambda u, v, a, b: max(abs(u - a), abs(v - b)), "that is the longer of the two steps; the other one counts as well."),
                Wrong(lambda u, v, a, b: (abs(u - a) + abs(v - b)) / 2, "that is the mean of the two steps. The straight way: Pythagoras."),
                Wrong(lambda u, v, a, b: math.sqrt(abs(u - a) + abs(v - b)), "a root, but of the steps as they are. Square each step first."),
                Wrong(lambda u, v, a, b: math.sqrt(abs(u * u - a * a + v * v - b * b)), "you square each number and then subtract. First subtract, then square: (u - a)**2."),
                Wrong(lambda u, v, a, b: np.hypot((u - a) ** 2, (v - b) ** 2), "np.hypot squares the steps itself: give it the steps as they are."),
                Wrong(lambda u, v, a, b: (u - a) ** 2 - (v - b) ** 2, "the squares are added, not subtracted; and the root comes last."),
                Wrong(lambda u, v, a, b: abs(u - a) + (v - b) ** 2, "the root belongs to the sum of both squares: one more pair of brackets."),
                Wrong(lambda u, v, a, b: (u - a) ** 2 + abs(v - b), "the root belongs to the sum of both squares: one more pair of brackets."),
                Wrong(lambda u, v, a, b: (u - a) * (v - b), "you multiply the two steps. Pythagoras adds their squares, and takes the root."),
                Wrong(lambda u, v, a, b: (u - a) / (v - b), "you divide the two steps: that is a slope. How long is the way?"),
                Wrong(lambda u, v, a, b: (v - b) / (u - a), "you divide the two steps: that is a slope. How long is the way?"),
                Wrong(lambda u, v, a, b: np.arctan2(v - b, u - a), "that is the direction of the way, an angle. How long is it?"),
                Wrong(lambda u, v, a, b: ((u - a) ** 2 + (v - b) ** 2) ** 2, "squared once too often: each step squared, added, and then the root, **0.5."),
                Wrong(lambda u, v, a, b: (u - a + v - b) ** 2, "you square the sum. Square each step alone, then add, then take the root."),
                Wrong(lambda u, v, a, b: abs(u - a + v - b), "you add the steps before you square them, and those below zero eat up the others. Square each step alone."),
                Wrong(lambda u, v, a, b: (u - a + v - b) / 2, "that is the mean of the two steps, signs and all. The straight way: Pythagoras."),
                Wrong(lambda u, v, a, b: min(abs(u - a), abs(v - b)), "that is the shorter of the two steps; the other one counts as well."),
                Wrong(lambda u, v, a, b: abs(u - v) - abs(a - b), "the steps go from u to a and from v to b."),
                Wrong(lambda u, v, a, b: np.hypot(u * a, v * b), "a step is what one coordinate has less than the other: minus, not times."),
                Wrong(lambda u, v, a, b: u * a + v * b, "that is a sum of products. Take the two steps, u less a and v less b: how long is the way?"),
                Wrong(lambda u, v, a, b: np.hypot(u, a) - np.hypot(v, b), "hypot gets two numbers that are no steps. Give it u less a, and v less b."),
                Wrong(lambda u, v, a, b: np.hypot(u, a) + np.hypot(v, b), "hypot gets two numbers that are no steps. Give it u less a, and v less b."),
                Wrong(lambda u, v, a, b: u - a + v - b, "you added the two steps, signs and all. The straight way: Pythagoras."),
                Wrong(lambda u, v, a, b: np.hypot(u, v) - np.hypot(a, b), "those are the distances of both from the picture's corner. Take the two steps first."),
                Wrong(lambda u, v, a, b: np.hypot(u, v) + np.hypot(a, b), "those are the distances of both from the picture's corner, added. Take the two steps first."),
                Wrong(lambda u, v, a, b: (u - a) ** 2 * (v - b) ** 2, "the squares are added, not multiplied; and the root comes last."),
                Wrong(lambda u, v, a, b: abs(u - a), "that is the step along u alone."),
                Wrong(lambda u, v, a, b: abs(v - b), "that is the step along v alone."),
                Wrong(lambda u, v, a, b: np.hypot(u - v, a - b), "the steps go from u to a and from v to b."),
                Wrong(lambda u, v, a, b: np.hypot(u - b, v - a), "a belongs to u, and b to v."),
                Wrong(lambda u, v, a, b: np.hypot(u + a, v + b), "a step is what one coordinate has less than the other: minus."),
            ),
            "Pythagoras, in pixels.",
            also=(lambda u, v, a, b: ((u - a) ** 2 + (v - b) ** 2) ** 0.5,),
        ),
        hints=("Two steps: along u and along v.", "np.hypot, or the root of the summed squares.", "return np.hypot(u - a, ____)"),
        code="def center_error(u, v, a, b):\n    return np.hypot(u - a, v - b)",
        reason="The distance of two points is the root of the summed squares of the steps.",
        reference=center_error,
    )  # fmt: skip


def is_red(hue: np.ndarray) -> np.ndarray:
    """True where OpenCV's hue is red."""
    return (hue <= 7) | (hue >= 172)


def votes_for(u: float, v: float, du: float, dv: float, r: float) -> tuple[float, float]:
    """The centre for which an edge pixel votes."""
    return u + r * du, v + r * dv


def success_percent(hits: int, frames: int) -> float:
    """Hits of frames in percent."""
    return 100 * hits / frames


def center_error(u: float, v: float, a: float, b: float) -> float:
    """Distance of two points, px."""
    return np.hypot(u - a, v - b)
