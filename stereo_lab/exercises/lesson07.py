"""Questions of lesson 07: the live cell."""

from __future__ import annotations

import math

from stereo_lab.exercises.answers import Choice, Function, Number, Wrong
from stereo_lab.exercises.lesson05 import elbow_deg, shoulder_deg
from stereo_lab.exercises.question import Question, lesson
from stereo_lab.exercises.seats import AS_WRITTEN, numbers
from stereo_lab.recording import Recording

BALL_RADIUS_MM = 20.0
SIGMAS = 4.0  # farther off than so many standard deviations is another ball
ARM = "((it|the arm) )?((should|must|has to|shall|will) )?(first )?"
GOES_ON = "(go(es)? on|keeps?|continues?|carr(y|ies) on|follows?|predicts?|guess(es)?|moves?|proceeds?)( going| moving| following)?"
STOPS = "(stop|brake|halt|freeze|wait|stand|stay|hold|pause)s?"
MOMENT = "(a (short |little )?(moment|while|time|bit)|0[.,]\\d+ ?s(econds?)?( |,|$)|(some|a few) (tenths|pictures|frames)|[1-3]?\\d (pictures|frames)|\\d{2,3} ?ms|((a|one) (third|quarter|tenth)|1/\\d+)( of a)? ?s(econd)?\\b)"
TOO_LONG = "((hours?|minutes?|(day|week|month|year)s?|(?<!\\d )(?<!\\d)seconds)\\b|(?<![.,/\\d])([2-9]|\\d{2,})([.,]\\d+)? ?s(ec(ond)?s?)?\\b|\\b([4-9]\\d|\\d{3,}) (pictures|frames)\\b|\\b\\d{4,} ?ms\\b|a long time)"
SHORT = "\\b(short(er)?|small|tiny|little|lollipop|usb|memory|glue|match(stick)?|toothpick|pen|pencil|chopstick|less than|(no|not) (more|longer) than|at most|under (a|\\d+)|quarter|thirds?)\\b"
LONG = "((more than|over|at least) )?(?<![\\d.,/])((a|the|a few|some|several|[1-9]\\d*([.,]\\d+)?)[ -]?(m|met(re|er)s?)|\\d{3,} ?(cm|centimet(re|er)s?)|\\d{4,} ?(mm|millimet(re|er)s?))( or (more|longer))?"
A_LENGTH = "(?<![a-z'’])(mm|cm|m|(milli|centi)?met(re|er)s?|inch(es)?|foot|feet)\\b"
BESIDE_IT = (
    ".*stick.*\\b((near|next to|beside|by|close to) (the |my )?(ball|arm|robot|gripper|hand|it)|close by|nearby)\\b.*"
)
IT_IS_BACK = "(when|if|once) (the ball|it) (comes|is) (back|out|seen|there|visible)"
IT_IS_NOT_BACK = (
    "((and|but|then) )?((if|when|as long as) (the ball|it) (does|did|is|has)( still)? not( (come|appear|been|be|seen|found|there|visible|out|back|again|then|by))*"
    "|unless (the ball|it) (comes|is) back),?"
)
NO_END = "(until|till|for ?ever|always|never)"


def questions(recording: Recording) -> tuple[Question, ...]:
    """Eight questions, the first by the arm of the recording; see :mod:`stereo_lab.exercises`."""
    l1, l2 = float(recording.arm.l1_mm), float(recording.arm.l2_mm)
    given = numbers(recording.seat)
    return lesson(
        "07", _angles(l1, l2), _gone(given), _ahead(), _hidden(), _same_ball(), _milliseconds(), _cost(given), _hold()
    )


def _angles(l1, l2):
    reach = l1 + l2
    tries = ((0.5 * reach, 0.3 * reach, l1, l2), (-0.4 * reach, 0.6 * reach, l1, l2 + 30), (5.0, 15.0, 12.0, 9.0))
    return dict(
        asks="Join Eq. 5 and Eq. 6 of lesson 05: from a place to both angles.",
        answer=Function(
            angles_for, tries, 0.01, "degrees",
            (
                Wrong(lambda x, y, l1, l2: (shoulder_deg(l1, l2, x, y, 90.0), 90.0), "the elbow is not always at 90 degrees: elbow_deg tells it from the place."),
                Wrong(lambda *t: angles_for(*t)[::-1], "the shoulder comes first, then the elbow."),
                Wrong(lambda *t: tuple(math.radians(a) for a in angles_for(*t)), "those are radians. The arm counts in degrees."),
                Wrong(lambda *t: (math.radians(angles_for(*t)[0]), angles_for(*t)[1]), "θ1 is in radians then. The arm counts in degrees, and shoulder_deg gives them."),
                Wrong(lambda *t: (angles_for(*t)[0], math.radians(angles_for(*t)[1])), "θ2 is in radians then. The arm counts in degrees, and elbow_deg gives them."),
                Wrong(
                    lambda x, y, a, b: (math.degrees(math.atan2(y, x)), elbow_deg(a, b, x, y)),
                    "that shoulder points straight at the place; the bent elbow needs the second part of Eq. 6.",
                ),
                Wrong(
                    lambda x, y, a, b: (-angles_for(x, -y, a, b)[0], -elbow_deg(a, b, x, y)),
                    "that is the other elbow, θ2 below zero. It reaches too, but the paper's Eq. 5 gives θ2 from 0 to 180.",
                ),
                Wrong(lambda x, y, a, b: (angles_for(x, y, a, b)[1],) * 2, "both of yours are the elbow. The shoulder comes first, by shoulder_deg."),
                Wrong(lambda x, y, a, b: (elbow_deg(a, b, x, y), math.degrees(math.atan2(y, x))), "the shoulder comes first, then the elbow; and it needs θ2 as well."),
                Wrong(lambda x, y, a, b: (shoulder_deg(a, b, x, y, math.radians(elbow_deg(a, b, x, y))), elbow_deg(a, b, x, y)), "shoulder_deg takes θ2 in degrees, as elbow_deg gives it: no radians()."),
                Wrong(lambda x, y, a, b: _by_another_elbow(x, y, a, b, math.radians), "elbow_deg gives degrees already, and shoulder_deg takes them: no radians()."),
                Wrong(lambda x, y, a, b: _by_another_elbow(x, y, a, b, math.degrees), "elbow_deg gives degrees already: no degrees()."),
                Wrong(lambda x, y, a, b: _by_another_elbow(x, y, a, b, lambda t: 180 - t), "180° − θ2 is the triangle's own angle. Give θ2 on as elbow_deg tells it."),
                Wrong(lambda x, y, a, b: (shoulder_deg(a, b, x, y, -elbow_deg(a, b, x, y)), elbow_deg(a, b, x, y)), "the shoulder of the one elbow and the other elbow: give both the same θ2."),
                Wrong(lambda x, y, a, b: (sum(angles_for(x, y, a, b)), elbow_deg(a, b, x, y)), "you add θ2 to the shoulder: that is where the forearm points. shoulder_deg gives θ1 as it is."),
                Wrong(lambda x, y, a, b: (angles_for(x, y, a, b)[0] - elbow_deg(a, b, x, y), elbow_deg(a, b, x, y)), "shoulder_deg gives θ1 already: nothing is to be taken from it."),
                Wrong(lambda x, y, a, b: (shoulder_deg(a, b, x, y, 90), elbow_deg(a, b, x, y)), "that is the shoulder for an elbow of 90 degrees. Call elbow_deg first, and give its answer on."),
                Wrong(lambda x, y, a, b: angles_for(x, y, b, a), "l1 and l2 have changed places: elbow_deg(l1, l2, x, y)."),
                Wrong(lambda x, y, a, b: _given_as(x, y, a, b), "elbow_deg and shoulder_deg take the links first, then the place: (l1, l2, x, y)."),
                Wrong(lambda x, y, a, b: _given_as(x, y, a, b)[::-1], "elbow_deg and shoulder_deg take the links first, then the place; and the shoulder comes first in the answer."),
                Wrong(lambda x, y, a, b: (shoulder_deg(elbow_deg(a, b, x, y), a, b, x, y), elbow_deg(a, b, x, y)), "shoulder_deg takes θ2 last: (l1, l2, x, y, theta2)."),
                Wrong(lambda x, y, a, b: (angles_for(x, y, a, b)[0], sum(angles_for(x, y, a, b))), "the second angle is θ2 itself, as elbow_deg gives it: nothing is to be added to it."),
                Wrong(lambda x, y, a, b: _all_in_radians(x, y, a, b), "elbow_deg and shoulder_deg give degrees and take them, and the arm counts in degrees: no radians()."),
                Wrong(lambda x, y, a, b: sum(angles_for(x, y, a, b)), "a plus makes one number of two. Two angles, with a comma between them."),
                Wrong(lambda x, y, a, b: angles_for(y, x, a, b), "x and y are swapped."),
            ),
            "the elbow by the distance of the place, then the shoulder by its direction.",
            domain="acos got a number outside −1…1, for a place that is in reach. Are the links and the place given on as they are, and in the right order?",
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


def _gone(given):
    old_ms, speed = given.old_ms, given.speed_mm_s
    right = old_ms / 1000 * speed
    return dict(
        asks=f"A picture is {old_ms:.0f} ms old when the arm gets its order; the ball rolls at {speed:.0f} mm/s. How far has it gone?",
        answer=Number(
            right, 0.05, "mm",
            (
                Wrong(old_ms * speed, f"that is {right:g} metres. A millisecond is a thousandth of a second."),
                Wrong(speed / old_ms, "speed times time, not speed divided by time."),
                Wrong(right * 10, f"{old_ms:g} ms are {old_ms / 1000:.3f} s, not {old_ms / 100:g}."),
                Wrong(right / 1000, "that is in metres."),
                Wrong(old_ms / speed, "speed times time, not time divided by speed."),
                Wrong(speed, "that is how far it goes in a whole second."),
                Wrong(old_ms / 1000, "that is the time, in seconds. How far does it go in it?"),
                Wrong(old_ms, "that is the time, in milliseconds. How far does it go in it?"),
                Wrong(speed - old_ms, "a speed and a time are not subtracted. Speed times time."),
                Wrong(speed / (old_ms / 1000), "speed times time, not speed divided by time."),
                Wrong(speed * old_ms / 60, "a millisecond is a thousandth of a second, not a sixtieth."),
                Wrong(speed * old_ms / 3600, "a millisecond is a thousandth of a second. 3600 are the seconds of an hour."),
                Wrong(1000 / old_ms, f"that is how many times {old_ms:g} ms fit into a second. How far does it roll in one of them?"),
                Wrong(1000 / speed, f"that is how many ms it takes for a millimetre. How far does it roll in {old_ms:g}?"),
                Wrong(speed / 1000, f"that is how far it rolls in one millisecond. It has rolled for {old_ms:g}."),
                Wrong(speed / 10, f"that is for a tenth of a second, 100 ms. The picture is {old_ms:g} ms old."),
                Wrong(speed + old_ms, "a speed and a time are not added. Speed times time."),
                Wrong(right / 10, f"{old_ms:g} ms are {old_ms / 1000:.3f} s, not {old_ms / 10_000:g}."),
            ),
            f"{right:.0f} mm, the whole radius of a ball that is {2 * right:.0f} mm wide." if right == BALL_RADIUS_MM else f"{right:g} mm, and the radius of a ball that is 40 mm wide is {BALL_RADIUS_MM:.0f}.",
            known={f"{speed:g}": speed, f"{old_ms:g}": old_ms},
            ask="Speed times time, in millimetres a second and in seconds.",
            small=f"so far it rolls in less than {old_ms:g} ms. Speed times time, in millimetres a second and in seconds.",
            large=f"so far it rolls in more than {old_ms:g} ms. Speed times time, in millimetres a second and in seconds.",
        ),
        hints=(
            "How far does it roll in one second? And in a tenth of one?",
            f"{old_ms:.0f} ms are {old_ms / 1000:g} s.",
            f"gone_mm = {speed:g} * ____",
        ),
        code=f"gone_mm = {speed:g} * {old_ms / 1000:.3f}",
        reason="Speed times time, in millimetres a second and seconds.",
        reference=right,
    )  # fmt: skip


def _ahead():
    tries = ((100.0, 250.0, 0.08), (-40.0, -120.0, 0.05), (0.0, 0.0, 0.3), (10.5, -33.0, 0.07))
    return dict(
        asks="Where will the ball be after some seconds, if it goes on as it does?",
        answer=Function(
            ahead, tries, 0.01, "mm",
            (
                Wrong(lambda p, v, t: max(p, p + v * t), "a ball with a velocity below zero goes the other way: no max."),
                Wrong(lambda p, v, s: p + v * (s + 0.06), "a real camera's own delay is added where you follow, not in here."),
                Wrong(lambda p, v, s: p * v * s, "the way is added to the place: plus."),
                Wrong(lambda p, v, s: p + 2 * v * s, "that is twice the way."),
                Wrong(lambda p, v, s: p + v * s / 2, "that is half of the way. (Half belongs to a steady acceleration, not to a steady velocity.)"),
                Wrong(lambda p, v, s: p + v * s**2, "the seconds count once: a steady velocity, no acceleration."),
                Wrong(lambda p, v, s: p - v * s, "that is where it was. Plus takes you ahead."),
                Wrong(lambda p, v, s: p, "that is where it was in the picture. It has gone on since."),
                Wrong(lambda p, v, s: (p + v) * s, "only the velocity belongs to the seconds: no brackets round the sum."),
                Wrong(lambda p, v, s: p + v / s if s else p, "speed times time is a way, not speed divided by time."),
                Wrong(lambda p, v, s: v * s, "that is how far it goes. Start from where it is."),
                Wrong(lambda p, v, s: p + v * s * s / 2, "half of the squared time belongs to a steady acceleration. A steady velocity: the seconds count once."),
                Wrong(lambda p, v, s: p + v * s * 60, "the seconds are seconds already, no minutes."),
                Wrong(lambda p, v, s: p + v - s, "velocity times seconds is a way: times, not minus."),
                Wrong(lambda p, v, s: p + v + s, "velocity and seconds are not added: velocity times seconds is a way."),
                Wrong(lambda p, v, s: p / s + v if s else p, "the velocity belongs to the seconds, times; the place stays as it is."),
                Wrong(lambda p, v, s: p * s + v, "the velocity belongs to the seconds, times; the place stays as it is."),
                Wrong(lambda p, v, s: p + v * (s + 1), "that is a whole second too far ahead."),
                Wrong(lambda p, v, s: p + v * (1 - s), "not what is left of a second: the seconds themselves."),
                Wrong(lambda p, v, s: abs(p) + v * s, "a place below zero is on the left; abs would take it to the right."),
                Wrong(lambda p, v, s: abs(p + v * s), "a place below zero is on the left; abs would take it to the right."),
                Wrong(lambda p, v, s: p - v / s if s else p, "speed times time is a way, not speed divided by time; and plus takes you ahead."),
                Wrong(lambda p, v, s: p + v // s if s else p, "speed times time is a way, not speed divided by time."),
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
                (IT_IS_NOT_BACK, ","),
                ("(?<=then )(stop and )?(wait|stay)( there)? until (the ball|it) (comes|is) back( again)?", "stop"),
                ("( and)? (wait|stay)( there)? until (the ball|it) (comes|is) back( again)?", ""),
                (f"^{ARM}{GOES_ON}(?!.*({TOO_LONG}|{IT_IS_BACK}))((?!{NO_END}).)*(then|than|and|but).*{STOPS}.*$", "go on for a moment, then stop"),
                (f"^{ARM}{GOES_ON}.* until .*(sigma|σ|uncertain|unsure|doubt|useless|worthless|no longer (sure|known|worth)|(band|guess|prediction|error)( (is|gets|becomes|grows))? (as |too |very )?(wide|wider|large|larger|big|bigger|unsure|bad)\\b|too (wide|unsure)).*$", "go on for a moment, then stop"),
                (f"^{ARM}{GOES_ON}(,? but)?( only| just)? for {MOMENT}([ ,.;]*{STOPS})?((?! or )[^,])*,?$", "go on for a moment, then stop"),
                (f"^{ARM}{STOPS},? ((but )?(only )?after {MOMENT}|but not at once).*$", "go on for a moment, then stop"),
                (f"^((it |the arm )?(should |must |has to )?{STOPS}.*|(do )?nothing|(do not|don't|not) move)$", "stop at once"),
                (f"^{ARM}{GOES_ON}( it| the prediction)?( {NO_END}.*|.*({TOO_LONG}|{IT_IS_BACK}).*)?$", "go on until the ball comes back"),
                ("^((go |move |return |drive )?(back )?(to )?(its )?home|(go|move) back|return)$", "go home"),
            ),
            beside=(
                (".*(off|shut|power|kill).*", "switched off, an arm is not held: lesson 06. It was going somewhere: how long is that worth following, and what then?"),
                (".*(beep|warn|alarm|call|tell|say|ask).*", "that may be done as well. And the arm: how long does it go on, and what then?"),
                (".*(search|look for|find).*", "searching is a new move, without knowing where to. It was going somewhere: how long is that worth following?"),
                (".*((seen|known) last|last (seen|place|position|known)).*", "there the ball is no more: it rolls on. Where it will be is predicted: how long is that worth following?"),
                (".*(track|predict|filter).*", "the tracker goes on, yes. And the arm: how long does it follow what nobody sees, and what then?"),
                (".*slow.*", "slower to where? It was going somewhere: how long is that worth following, and what then?"),
                (".*(behind|through|book).*", "the arm would hit the book. It was going somewhere: how long is that worth following?"),
            ),
            not_meant=((".*(through|into) the book.*", "the arm would hit the book. It was going somewhere: how long is that worth following?"),),
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
                Wrong(lambda gap, sigma: abs(gap) < SIGMAS**2 * sigma, "the square of 4 belongs to the squares of the two. Here it is 4."),
                Wrong(lambda gap, sigma: abs(gap - sigma) < SIGMAS, "a difference of the two tells nothing: how many times sigma_mm is the gap?"),
                Wrong(lambda gap, sigma: round(gap / sigma) == 0, "rounded to 0, half of sigma_mm is allowed. Allow four times."),
                Wrong(lambda gap, sigma: abs(gap) < SIGMAS * sigma**2, "sigma_mm is squared on one side alone: four times sigma_mm itself."),
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
                Wrong("finding the ball", "a few milliseconds at most, for both pictures. Look at the bars: which is the longest?"),
                Wrong("the angles", "two lines of trigonometry: too little to be drawn."),
                Wrong("the order to the arm", "some 30 letters at 115,200 bits a second: 3 milliseconds."),
            ),
            "exposing, reading out, compressing, sending: no program makes that shorter, a better camera does.",
            also=("cameras", "the camera", "taking the pictures", "the pictures"),
            same=(
                ("(the |a )?usb (web)?cam(era)?s?", "the cameras"),
                (".*calibrat.*", "calibration"),
                ("(takes?|needs?|is|are) ((much|far) )?(longer|slower|more( time)?) than [^,;]+", ""),
                ("(?<=[,;] )(and )?(finding|detecting)[^,;]* [1-3]([.,]\\d+)? ?ms", ""),
                (".*(shortest|fastest|quickest|\\bleast|\\bquick\\b|\\bfast\\b|\\bless).*", "the fastest"),
                (".*(detect|find|locat|search|hough|looking for|process|analy).*|(the )?ball", "finding the ball"),
                (".*(order|command|cable|wire|serial|usb).*", "the order to the arm"),
                (".*(camera|webcam|expos(e|ing|ure)|shutter|reading out|taking (the |a )?(picture|photo)).*", "the cameras"),
                ("(the )?(picture|image|photo)s?", "the cameras"),
                (".*(angle|kinematics|trigonometry|formula|equation|calculat|comput(ing|ation)).*", "the angles"),
            ),
            beside=(
                (".*(shortest|fastest|quickest|faster|least|quick|fast|less).*", "the longest is asked for. Which bar is it?"),
                (".*(calibrat).*", "that was done once, before the run. Look at the bars."),
                (".*(position|place|rectif|triangulat|depth).*", "a handful of multiplications: too little to be drawn. Look at the bars."),
                (".*(watchdog|profile|motor).*", "that belongs to the move, and the move is not counted here. Look at the bars."),
                (".*(kalman|filter|predict|track).*", "a few small sums: too little to be drawn. Look at the bars."),
                (".*(same|equal|all|none).*", "look at the bars: one of them is far longer than the others. Which?"),
                (".*(computer|program|python|cpu|code|software).*", "which part of what the program does? Look at the bars: is the longest of them the program's at all?"),
                (".*(arm|motor|move|moving).*", "from the light to the moment when the arm begins to move: the move itself is not counted. Look at the bars."),
            ),
            not_meant=((".*cameras? (take|need)s? ((only|just|about) )?\\d([.,]\\d+)? ?ms.*", "the longest is asked for. Which bar is it?"),),
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


def _cost(given):
    cpu, rate = given.cpu_percent, given.pairs_a_second
    right, pairs = cpu / 100 / rate * 1000, "ten" if rate == 10 else f"{rate:g}"
    whose = "The paper's program" if given == AS_WRITTEN else "A program"
    return dict(
        asks=f"{whose} took {cpu:g} % of the CPU at {rate:g} pairs a second. How many milliseconds of it is that for one pair?",
        answer=Number(
            right, 0.4, "ms",
            (
                Wrong(cpu / 653, "the 653 are the pairs of the whole run. For one second: how many ms of work, and how many pairs?"),
                Wrong(cpu * 653, "the 653 are the pairs of the whole run. For one second: how many ms of work, and how many pairs?"),
                Wrong(cpu / rate, "that is percent, for each pair a second. A second has 1000 ms: what part of it?"),
                Wrong(cpu * rate, f"that is what it takes in one second, all {pairs} pairs together." if rate == 10 else "more pairs leave less time for each: divide by them."),
                Wrong(cpu * 10, f"that is what it takes in one second, all {pairs} pairs together."),
                Wrong(1000 / cpu, "upside down: the part of the second that it worked, over the pairs."),
                Wrong(rate / cpu, "upside down: the part of the second that it worked, over the pairs."),
                Wrong(1000 / rate, "that is the time between two pairs. The CPU rests for most of it."),
                Wrong(100 - cpu, "that is how much of the time it rests, in percent. How much does it work?"),
                Wrong(1000 * rate / cpu, "upside down: the part of the second that it worked, over the pairs."),
                Wrong(100 / cpu, "upside down: the part of the second that it worked, over the pairs."),
                Wrong(1000.0, "that is a whole second. Which part of it does the program work, and for how many pairs?"),
                Wrong(rate, "that is how many pairs there are in a second. Which part of the second does the program work?"),
                Wrong(cpu / 100 * 60 / rate, "a second has 1000 ms, not 60."),
                Wrong(57.0, "that is the most it took at any time, in percent. The mean is asked for, in ms."),
                Wrong(155.71, "that is its memory, in MB. Which part of a second does it work, and for how many pairs?"),
                Wrong(653.0, "that is how many samples the paper took. Which part of a second does it work, and for how many pairs?"),
                Wrong(right / 1000, "that is in seconds."),
                Wrong(right * 100, f"{cpu:g} % is {cpu / 100:.4g}."),
            ),
            f"{right:.1f} ms: {10 * cpu:.0f} ms a second, shared by {pairs} pairs."
            + " (The number of the percentage only because of the ten.)" * (rate == 10),
            known={f"{cpu:g}": cpu, f"{rate:g}": rate, "100": 100},
            ask="For how many ms of each second does it work, and how many pairs share them?",
        ),
        hints=(
            "For how many milliseconds of each second did the CPU work?",
            f"{cpu:g} % of 1000 ms are {10 * cpu:g} ms. They are for {pairs} pairs.",
            f"ms_a_pair = {cpu / 100:.4g} * 1000 / ____",
        ),
        code=f"ms_a_pair = {cpu / 100:.4g} * 1000 / {rate:g}",
        reason="The part of a second that it worked, over the pairs of that second.",
        reference=right,
    )  # fmt: skip


def _hold():
    return dict(
        asks="Real arm, real ball: how do you hold the ball while the arm follows it?",
        answer=Choice(
            "on a stick",
            (
                Wrong("in my fingers", "the hand of the arm comes as near as 10 mm to the ball, at up to two metres a second. Your fingers are there."),
                Wrong("on a table in its plane", "the forearm sweeps through the table to get there."),
                Wrong("thrown to it", "a ball in free fall is too fast for these motors, and the arm would swing after it."),
            ),
            "a metre long or more, and somebody else's hand at the switch of the supply.",
            also=("a stick", "on a long stick"),
            same=(
                (f".*{SHORT}.*", "short"), (BESIDE_IT, "beside"), (LONG, "long"), (f".*{A_LENGTH}.*", "short"),
                (".*(danger|forbid|unsafe).*", "danger"),
                ("(at |on )?(the end of )?(a |the )?(long |thin )?(pole|rod|ruler|wire|broom|broomstick|branch|bar|tube|pipe|skewer|grabber|litter picker|selfie stick|stick)", "on a stick"),
                ("((in|with|by|between|on) )?((my|the|both|two|one|bare|your|a) )*(hands?|fingers?|palm|gloves?|(?<=my )arm)( with gloves?)?", "in my fingers"),
                ("(roll(ed|ing)? )?(it )?(on|over|along|across)? ?(the |a )?(table|floor|bench|desk|book|box|ground)", "on a table in its plane"),
                ("(throw|toss|drop|let)( it| fall)*", "thrown to it"),
            ),
            beside=(
                (".*stick.*(danger|forbid|unsafe).*", "what is longer than the arm reaches keeps you out of its way. What would be safer?"),
                (BESIDE_IT, "what is near the ball is near the arm. What holds the ball, and keeps all of you out of reach?"),
                (f".*{SHORT}.*|(?!.*{LONG}\\b).*{A_LENGTH}.*", "then your hand is within the metre round the shoulder that stays free. What keeps it out of that?"),
                (".*(switch|supply|power).*", "there one person stands. What holds the ball, and keeps all of you out of reach?"),
                (".*(card|paper|board|cushion).*", "what carries that? Whatever is near the ball is near the arm: what is longer than it reaches?"),
                ("(far|away|nowhere|anywhere|somewhere|behind).*", "it must be where the arm can reach it, and you must not. What holds it there?"),
                ("(on |at )?(the )?arm.*", "the arm is to reach for it. What holds the ball, and keeps all of you out of reach?"),
                (".*(grip|claw|tray|shelf|cup|plate|holder).*", "it stands where the arm reaches, and somebody must put the ball there. What holds it, and keeps all of you out of reach?"),
                (".*(tape|glue|head|foot|friend|pocket|mouth).*", "what is near the ball is near the arm. What holds the ball, and keeps all of you out of reach?"),
                (".*(finger|thumb|glove|hand|palm).*", "the hand of the arm comes as near as 10 mm to the ball, at up to two metres a second: yours is there."),
                (".*(tongs|pliers|tweezers).*", "they keep your hand a few centimetres away. What is longer than the arm reaches?"),
                (".*(string|thread|rope|cord).*", "on a string it swings, and the arm swings after it. What holds the ball still, and your hand far away?"),
                (".*(not at all|nobody|don't|do not|careful|slowly).*", "the ball must be somewhere, and you must be out of reach. What is longer than the arm?"),
            ),
            not_meant=((".*stick.* (not|never) ((very|so|that|too) )?(long|far).*", "what is longer than the arm reaches keeps you out of its way. What would be safer?"),),
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


def _all_in_radians(x, y, l1, l2):
    theta2 = math.radians(elbow_deg(l1, l2, x, y))
    return math.radians(shoulder_deg(l1, l2, x, y, theta2)), theta2


def _by_another_elbow(x, y, l1, l2, change):
    theta2_deg = change(elbow_deg(l1, l2, x, y))
    return shoulder_deg(l1, l2, x, y, theta2_deg), theta2_deg


def _given_as(x, y, l1, l2):
    """Both angles, with the place given where the links belong."""
    theta2_deg = elbow_deg(x, y, l1, l2)
    return shoulder_deg(x, y, l1, l2, theta2_deg), theta2_deg


def ahead(place_mm: float, velocity_mm_s: float, seconds: float) -> float:
    """Where something is after some seconds, mm."""
    return place_mm + velocity_mm_s * seconds


def same_ball(gap_mm: float, sigma_mm: float) -> bool:
    """Whether a place is near enough to a prediction."""
    return abs(gap_mm) < SIGMAS * sigma_mm
