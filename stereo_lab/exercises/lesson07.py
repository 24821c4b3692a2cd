"""Questions of lesson 07: the live cell."""

from __future__ import annotations

import math

from stereo_lab.exercises.answers import Choice, Function, Number, Wrong
from stereo_lab.exercises.lesson05 import elbow_deg, shoulder_deg
from stereo_lab.exercises.question import Question, lesson
from stereo_lab.recording import Recording

OLD_MS, SPEED_MM_S = 80.0, 250.0  # how old a picture is, and how fast a ball rolls, in the second question
SIGMAS = 4.0  # farther off than so many standard deviations is another ball
PAPERS_CPU, PAPERS_RATE = 23.37, 10.0  # percent, pairs a second


def questions(recording: Recording) -> tuple[Question, ...]:
    """Eight questions, the first by the arm of the recording; see :mod:`stereo_lab.exercises`."""
    l1, l2 = float(recording.arm.l1_mm), float(recording.arm.l2_mm)
    return lesson("07", _angles(l1, l2), _gone(), _ahead(), _hidden(), _same_ball(), _milliseconds(), _cost(), _hold())


def _angles(l1, l2):
    reach = l1 + l2
    tries = ((0.5 * reach, 0.3 * reach, l1, l2), (-0.4 * reach, 0.6 * reach, l1, l2 + 30), (5.0, 15.0, 12.0, 9.0))
    return dict(
        asks="Join Eq. 5 and Eq. 6 of lesson 05: from a place to both angles.",
        answer=Function(
            angles_for, tries, 0.01, "degrees",
            (
                Wrong(lambda *t: angles_for(*t)[::-1], "the shoulder comes first, then the elbow."),
                Wrong(lambda *t: tuple(math.radians(a) for a in angles_for(*t)), "those are radians. The arm counts in degrees."),
                Wrong(
                    lambda x, y, a, b: (math.degrees(math.atan2(y, x)), elbow_deg(a, b, x, y)),
                    "that shoulder points straight at the place; the bent elbow needs the second part of Eq. 6.",
                ),
                Wrong(
                    lambda x, y, a, b: (-angles_for(x, -y, a, b)[0], -elbow_deg(a, b, x, y)),
                    "that is the other elbow, θ2 below zero. It reaches too, but the paper's Eq. 5 gives θ2 from 0 to 180.",
                ),
                Wrong(lambda x, y, a, b: angles_for(y, x, a, b), "x and y are swapped."),
            ),
            "the elbow by the distance of the place, then the shoulder by its direction.",
            domain="acos got a number outside −1…1, for a place that is in reach. Do the links and the place stand in the right order?",
        ),
        hints=(
            "Eq. 6 needs θ2. So which one comes first?",
            "theta2 = elbow_deg(l1, l2, x, y), and then the shoulder, which takes it.",
            "theta2 = elbow_deg(l1, l2, x, y)\n    return shoulder_deg(l1, l2, x, y, ____), theta2",
        ),
        code=(
            "def angles_for(x, y, l1, l2):\n"
            "    theta2 = elbow_deg(l1, l2, x, y)\n"
            "    return shoulder_deg(l1, l2, x, y, theta2), theta2"
        ),
        reason="Eq. 5 gives the elbow; Eq. 6 takes it and gives the shoulder.",
        reference=angles_for,
    )  # fmt: skip


def _gone():
    right = OLD_MS / 1000 * SPEED_MM_S
    return dict(
        asks=f"A picture is {OLD_MS:.0f} ms old when the arm gets its order; the ball rolls at {SPEED_MM_S:.0f} mm/s. How far has it gone?",
        answer=Number(
            right, 0.05, "mm",
            (
                Wrong(OLD_MS * SPEED_MM_S, "that is 20 metres. A millisecond is a thousandth of a second."),
                Wrong(SPEED_MM_S / OLD_MS, "speed times time, not speed divided by time."),
                Wrong(right * 10, "80 ms are 0.080 s, not 0.8."),
                Wrong(right / 1000, "that is in metres."),
                Wrong(OLD_MS / SPEED_MM_S, "speed times time, not time divided by speed."),
                Wrong(SPEED_MM_S, "that is how far it goes in a whole second."),
                Wrong(OLD_MS / 1000, "that is the time, in seconds. How far does it go in it?"),
                Wrong(OLD_MS, "that is the time, in milliseconds. How far does it go in it?"),
                Wrong(SPEED_MM_S + OLD_MS, "a speed and a time are not added. Speed times time."),
                Wrong(right / 10, "80 ms are 0.080 s, not 0.008."),
            ),
            f"{right:.0f} mm, the whole radius of the ball.",
        ),
        hints=(
            "How far does it roll in one second? And in a tenth of one?",
            f"{OLD_MS:.0f} ms are {OLD_MS / 1000:g} s.",
            "gone_mm = 250 * ____",
        ),
        code="gone_mm = 250 * 0.080",
        reason="Speed times time, in millimetres a second and seconds.",
        reference=right,
    )  # fmt: skip


def _ahead():
    tries = ((100.0, 250.0, 0.08), (-40.0, -120.0, 0.05), (0.0, 0.0, 0.3), (10.5, 33.0, 0.07))
    return dict(
        asks="Where will the ball be after some seconds, if it goes on as it does?",
        answer=Function(
            ahead, tries, 0.01, "mm",
            (
                Wrong(lambda p, v, s: p * v * s, "the way is added to the place: plus."),
                Wrong(lambda p, v, s: p + 2 * v * s, "that is twice the way."),
                Wrong(lambda p, v, s: p + v * s / 2, "that is half of the way. (Half belongs to a steady acceleration, not to a steady velocity.)"),
                Wrong(lambda p, v, s: p + v * s**2, "the seconds count once: a steady velocity, no acceleration."),
                Wrong(lambda p, v, s: p - v * s, "that is where it was. Plus takes you ahead."),
                Wrong(lambda p, v, s: p, "that is where it was in the picture. It has gone on since."),
                Wrong(lambda p, v, s: (p + v) * s, "only the velocity belongs to the seconds: no brackets round the sum."),
                Wrong(lambda p, v, s: p + v / s if s else p, "speed times time is a way, not speed divided by time."),
                Wrong(lambda p, v, s: v * s, "that is how far it goes. Start from where it is."),
                Wrong(lambda p, v, s: p + v, "that is a whole second ahead."),
                Wrong(lambda p, v, s: p + v * s / 1000, "the seconds are seconds already, no milliseconds."),
                Wrong(lambda p, v, s: p + v * s * 1000, "the seconds are seconds already, no milliseconds."),
                Wrong(lambda p, v, s: p + abs(v) * s, "a ball with a velocity below zero goes the other way."),
            ),
            "where it was, and what it has gone since.",
        ),
        hints=(
            "Start from where it is, and add how far it goes.",
            "How far it goes is its velocity times the seconds.",
            "return place_mm + ____",
        ),
        code="def ahead(place_mm, velocity_mm_s, seconds):\n    return place_mm + velocity_mm_s * seconds",
        reason="With a steady velocity the way grows with the time.",
        reference=ahead,
    )  # fmt: skip


def _hidden():
    return dict(
        asks="The ball goes behind a book. What should the arm do?",
        answer=Choice(
            "go on for a moment, then stop",
            (
                Wrong("stop at once", "one picture without a ball is no news: a shadow, a smear, a hand in front. The ball is where it was going."),
                Wrong("go on until the ball comes back", "the longer nobody sees it, the less anybody knows where it is. Look at the band."),
                Wrong("go home", "a machine that has lost its target should not begin new moves."),
            ),
            "as long as the prediction is worth something.",
            same=(
                ("(go on )?(for )?(a moment|briefly|a little|a while|a bit)(,| and|, and)? then stop", "go on for a moment, then stop"),
                ("^stop(, then go on.*)?$", "stop at once"), ("^(go on|go on for ever|go on forever)$", "go on until the ball comes back"),
            ),
        ),
        hints=(
            "Look at the width of the band: how sure is the place after one hidden picture, and after ten?",
            "A guess that is 10 mm wide is worth following, one that is as wide as the table is not.",
            'hidden = "go on for a ____, then stop"',
        ),
        code='hidden = "go on for a moment, then stop"',
        reason="A prediction is good for some tenths of a second; after that the ball may be anywhere.",
        reference="go on for a moment, then stop",
    )  # fmt: skip


def _same_ball():
    tries = (
        (12.0, 5.0),
        (4.5, 5.0),
        (4.0, 5.0),
        (3.5, 1.0),
        (25.0, 5.0),
        (-12.0, 5.0),
        (-25.0, 5.0),
        (7.5, 5.0),
        (19.5, 5.0),
        (-20.5, 5.0),
        (300.0, 60.0),
        (300.0, 90.0),
        (0.0, 1.0),
    )
    return dict(
        asks="A ball is found some mm from where it should be, and the prediction has a standard deviation. Is it the same ball?",
        answer=Function(
            same_ball, tries, 0.1, "",
            (
                Wrong(lambda gap, sigma: gap < SIGMAS * sigma, "a gap of −25 mm is as far as one of 25 mm: take abs(gap_mm)."),
                Wrong(lambda gap, sigma: abs(gap) > SIGMAS * sigma, "the other way round: far away is another ball."),
                Wrong(lambda gap, sigma: abs(gap) < sigma, "one ball in three lies farther off than one standard deviation. Allow four."),
                Wrong(lambda gap, sigma: abs(gap) < 2 * sigma, "one ball in twenty lies farther off than two standard deviations. Allow four."),
                Wrong(lambda gap, sigma: abs(gap) < 3 * sigma, "one ball in 370 lies farther off than three standard deviations: at 30 pictures a second, one every 12 s. Allow four."),
                Wrong(lambda gap, sigma: abs(gap) < 5 * sigma, "five lets another ball pass that the question does not. Allow four."),
                Wrong(lambda gap, sigma: gap**2 < SIGMAS * sigma, "squared on one side alone: take abs(gap_mm), or square both sides."),
                Wrong(lambda gap, sigma: abs(gap) < SIGMAS + sigma, "four times, not four more."),
                Wrong(lambda gap, sigma: gap > -SIGMAS * sigma, "far off to the other side is another ball, too: take abs(gap_mm)."),
                Wrong(lambda gap, sigma: True, "your function says yes to every ball."),
                Wrong(lambda gap, sigma: False, "your function says no to every ball."),
                Wrong(lambda gap, sigma: abs(gap) < 20, "20 mm, however unsure the prediction is? Let sigma_mm decide how much is allowed."),
                Wrong(lambda gap, sigma: abs(gap) < SIGMAS, "four what? Where the prediction is unsure, more millimetres are allowed."),
                Wrong(lambda gap, sigma: abs(gap) * SIGMAS < sigma, "four times sigma_mm is allowed, not a quarter of it."),
            ),
            "near enough for how sure the prediction is.",
        ),
        hints=(
            "Compare two lengths: how far off it is, and how far off it may be.",
            "It may be 4 standard deviations off, to either side.",
            "return abs(gap_mm) < ____",
        ),
        code="def same_ball(gap_mm, sigma_mm):\n    return abs(gap_mm) < 4 * sigma_mm",
        reason="A normal error is larger than four standard deviations once in 16,000 times.",
        reference=same_ball,
    )  # fmt: skip


def _milliseconds():
    return dict(
        asks="From the light to the moving arm: which part takes longest on this cell?",
        answer=Choice(
            "the cameras",
            (
                Wrong("finding the ball", "it was, in the paper's days. Look at the bars: some milliseconds for both pictures."),
                Wrong("the angles", "two lines of trigonometry: too little to be drawn."),
                Wrong("the order to the arm", "some 30 letters at 115,200 bits a second: 3 milliseconds."),
            ),
            "exposing, reading out, compressing, sending: no program makes that shorter, a better camera does.",
            also=("cameras", "the camera", "taking the pictures", "the pictures"),
        ),
        hints=(
            "Which bar is the longest?",
            "It is over before the first line of your program sees the picture.",
            'longest = "the ____"',
        ),
        code='longest = "the cameras"',
        reason="A webcam hands its pictures over one to three pictures late.",
        reference="the cameras",
    )  # fmt: skip


def _cost():
    right = PAPERS_CPU / 100 / PAPERS_RATE * 1000
    return dict(
        asks="The paper's program took 23.37 % of the CPU at 10 pairs a second. How many milliseconds of it is that for one pair?",
        answer=Number(
            right, 0.06, "ms",
            (
                Wrong(PAPERS_CPU / PAPERS_RATE, "that is percent, for each pair a second. A second has 1000 ms: what part of it?"),
                Wrong(PAPERS_CPU * PAPERS_RATE, "that is what it takes in one second, all ten pairs together."),
                Wrong(PAPERS_CPU * 10, "that is what it takes in one second, all ten pairs together."),
                Wrong(1000 / PAPERS_CPU, "upside down: the part of the second that it worked, over the pairs."),
                Wrong(PAPERS_RATE / PAPERS_CPU, "upside down: the part of the second that it worked, over the pairs."),
                Wrong(100.0, "that is the time between two pairs. The CPU rests for most of it."),
                Wrong(right / 1000, "that is in seconds."),
                Wrong(right * 100, "23.37 % is 0.2337."),
            ),
            f"{right:.1f} ms: 234 ms a second, shared by ten pairs.",
        ),
        hints=(
            "For how many milliseconds of each second did the CPU work?",
            "23.37 % of 1000 ms are 233.7 ms. They are for ten pairs.",
            "ms_a_pair = 0.2337 * 1000 / ____",
        ),
        code="ms_a_pair = 0.2337 * 1000 / 10",
        reason="The part of a second that it worked, over the pairs of that second.",
        reference=right,
    )  # fmt: skip


def _hold():
    return dict(
        asks="Real arm, real ball: how do you hold the ball while the arm follows it?",
        answer=Choice(
            "on a stick",
            (
                Wrong("in my fingers", "the hand of the arm comes as near as 10 mm to the ball, at half a metre a second. Your fingers are there."),
                Wrong("on a table in its plane", "the forearm sweeps through the table to get there."),
                Wrong("thrown to it", "a ball in free fall is too fast for these motors, and the arm would swing after it."),
            ),
            "longer than the arm reaches, and one hand at the switch of the supply.",
            also=("a stick", "on a long stick"),
            same=(("(in )?(my )?hands?|with (both )?hands|fingers?", "in my fingers"), ("throw( it)?", "thrown to it")),
        ),
        hints=(
            "What is near the ball is near the arm.",
            "Nothing of you should be where the arm can reach.",
            'hold = "on a ____"',
        ),
        code='hold = "on a stick"',
        reason="The only safe place is out of reach.",
        reference="on a stick",
    )  # fmt: skip


def angles_for(x: float, y: float, l1: float, l2: float) -> tuple[float, float]:
    """Eq. 5 and 6: both angles for a place, degrees."""
    theta2_deg = elbow_deg(l1, l2, x, y)
    return shoulder_deg(l1, l2, x, y, theta2_deg), theta2_deg


def ahead(place_mm: float, velocity_mm_s: float, seconds: float) -> float:
    """Where something is after some seconds, mm."""
    return place_mm + velocity_mm_s * seconds


def same_ball(gap_mm: float, sigma_mm: float) -> bool:
    """Whether a place is near enough to a prediction."""
    return abs(gap_mm) < SIGMAS * sigma_mm
