"""Questions of lesson 04: depth from disparity, and how exact it can be."""

from __future__ import annotations

from functools import lru_cache

from stereo_lab.exercises.answers import Choice, Function, Number, Wrong
from stereo_lab.exercises.question import Question, lesson
from stereo_lab.localization import Localizer
from stereo_lab.recording import Recording, open_recording

A_LENGTH = "the area of its picture does. The disparity is a length: once, not squared."
SMALLER = "((gets |is |becomes )?(smaller|shorter|less)|shrinks?|decreases|falls|drops|goes down)"
LESS = "(as (small|short|little|narrow|thin)|smaller|shorter|less|narrower|thinner)"  # after "twice"
ANOTHER = "(z|(the |its )?(depth|distance( to the ball)?|baseline|focal length|error|time|ball))"  # than the disparity


def questions(recording: Recording) -> tuple[Question, ...]:
    """Six questions; see :mod:`stereo_lab.exercises`."""
    baseline, focal, left_u, right_u, raw_px, measured_mm = _facts(str(recording.path))
    tries = ((baseline, focal, 60.0), (baseline, focal, 30.0), (100.0, 800.0, 80.0))
    far = ((1000.0, focal, baseline), (2000.0, focal, baseline), (600.0, 400.0, 300.0))
    return lesson(
        "04",
        _twice_as_far(),
        _disparity(left_u, right_u, raw_px, baseline, focal, measured_mm),
        _eq3(tries),
        _unknowns(),
        _one_pixel(far),
        _wider(baseline, focal),
    )


def _twice_as_far():
    return dict(
        asks="The ball moves twice as far away. What does its disparity do?",
        answer=Choice(
            "halves",
            (
                Wrong("shrinks by a fixed number", "then it would be below zero sooner or later: behind the cameras."),
                Wrong("quarters", A_LENGTH),
                Wrong("doubles", "far things jump less, not more. Try it with a finger."),
                Wrong("stays", "then no camera could tell near from far."),
            ),
            "disparity times depth stays the same: half of one, twice the other.",
            same=(
                ("^(it )?(shrinks?|is shrinking)$", "smaller"),
                ("(2|two)[ -]?(times|x|fold)", "twice"),
                ("(4|four)[ -]?(times|x|fold)", "four times"),
                ("(it )?(shrinks by|becomes|gets) .*(pixel|px|mm).*", "shrinks by a fixed number"),
                (
                    "(the |its |their )?product( of both)? (stays|is|remains) (the same|constant),? (so|hence|therefore),?",
                    "",
                ),
                (r"[(]?(when|if|while|as)? ?(z|the depth|depth|the distance) (doubles|is doubled)[)]?", ""),
                (
                    f"(it )?halves twice|(gets |is |becomes )?four times {LESS}|{SMALLER} (by )?four times|{SMALLER} (by|to) a factor( of)? (4|four)|(by )?a factor( of)? (4|four) {LESS}|(is )?divided by (4|four)",
                    "quarters",
                ),
                (f"{SMALLER} by (the same|a fixed|a constant|an equal) amount", "shrinks by a fixed number"),
                (
                    f"half as (large|big|much|far|wide)|(is )?inversely proportional|{SMALLER} (by|to) (half|a factor( of)? (2|two))|halve|(gets |is |becomes |goes )?(to |down to )?(halved|halfs|half)( of it)?|(is )?(divide[sd]? by|cut in) (2|two)|(only|just) half|[dδ]? ?[/:÷] ?2|1/2|0.5|50 ?(%|percent)( smaller| less)?",
                    "halves",
                ),
                ("(a |one )?quarter|1/4|0.25", "quarters"),
                (
                    f"(gets |is |becomes )?twice {LESS}|{SMALLER} (by )?twice|(by )?a factor( of)? (2|two) {LESS}",
                    "halves",
                ),
                (
                    "doubled?|twice( as (large|big|much|far|long|wide)| larger| bigger)?|times 2|(is |gets )?(multiplied|multiplies) by (2|two)",
                    "doubles",
                ),
                ("(stays )?(the )?same|constant|nothing|no change|unchanged|(does not|doesn't) change", "stays"),
            ),
            not_meant=(
                ("(it )?halves,? (and )?(then )?(it )?(halves )?again", A_LENGTH),
                (
                    f"((it )?(halves|half|half of) )?{ANOTHER}( halves| is halved)?",
                    "another thing than the one asked for. The depth is doubled: what does the disparity do?",
                ),
                (
                    "(it )?(halves|is halved|half) (every|each|for|per|with) .*(metre|meter|millimetre|mm|cm|pixel|px|step)s?",
                    "from 1 m to 2 m is twice as far, from 2 m to 3 m is not. Leave the steps away: what part of it is left at twice the depth?",
                ),
                (
                    r"((it|the disparity|disparity) )?(.* again|grows|increases|rises|(goes )?up|(gets |becomes |is )?(larger|bigger)|[+]|plus|three halves).*",
                    "far things jump less, not more. What part of it is left at twice the depth?",
                ),
                (
                    ".*squar.*",
                    "areas and squares have no place here: it is a length. Twice as far away, how long is it?",
                ),
                (
                    "(by )?half an? (pixel|px|mm|millimetre).*",
                    "a fixed number taken away would bring it below zero sooner or later: behind the cameras. What part of it is left?",
                ),
                (
                    "(a )?half of (a|one|the) half|(a (little|bit) )?(less|more) than half",
                    "the two triangles have one shape. At twice the depth, what part of it is left?",
                ),
            ),
            beside=(
                (
                    ".*(zero|vanish|disappear|nothing).*",
                    "only at no end of distance it is zero. At twice the depth, what part of it is left?",
                ),
                (
                    ".*(negative|below|minus|sign).*",
                    "below zero it would be behind the cameras. At twice the depth, what part of it is left?",
                ),
                (
                    "(a |one )?third|(a |one )?fifth",
                    "twice as far, and Z = B·f/d: what must become of d, so that Z is doubled?",
                ),
                (
                    "(it )?(gets|becomes|is|goes)? ?(smaller|less|shrinks?|decreases?|falls|drops|down|lower)( a (bit|little|lot))?",
                    "smaller, yes. By how much: to half, to a quarter, or by a fixed number?",
                ),
                (
                    "(it )?(gets|becomes|is|goes)? ?(larger|bigger|more|grows?|increases?|rises|up|higher)",
                    "far things jump less, not more. Try it with a finger.",
                ),
                (
                    "(it )?(squares?|four times( as (large|much))?|quadruples|times 4)",
                    "far things jump less, not more, and a length is not squared. Look at the two triangles.",
                ),
                (
                    "(it )?(is |becomes |gets )?(zero|0|nothing left)",
                    "only infinitely far away. At twice the distance something is left: what part?",
                ),
                (
                    "(minus |- ?|.*by )\\d+.*",
                    "a fixed number taken away would bring it below zero sooner or later: behind the cameras. What part of it is left?",
                ),
            ),
        ),
        hints=(
            "Look at the figure: two triangles of the same shape.",
            "The baseline stays. At twice the depth it is seen under about half the angle.",
            'twice_as_far = "____"   # halves, quarters, doubles, stays or shrinks by a fixed number',
        ),
        code='twice_as_far = "halves"',
        reason="Z = B·f/d: depth and disparity are inverse to each other.",
        reference="halves",
    )


def _disparity(left_u, right_u, raw_px, baseline, focal, measured_mm):
    right = left_u - right_u
    return dict(
        asks="What is the disparity of the ball in the pair above?",
        answer=Number(
            right, 0.3, "px",
            (
                Wrong(int(right) + 1.0, "that is rounded too much. Keep its decimals."),
                Wrong(baseline * focal / measured_mm, "that is the disparity which the ruler's depth would give; depth is what comes out in the end. How many columns lie between the two?", exact=True),
                Wrong(right + 1, "not one more: u is a place, and a way is one place less the other.", exact=True),
                Wrong(-right, "your disparity is below zero: the ball would be behind the cameras. Take left minus right."),
                Wrong(left_u + right_u, "you added the two columns. Disparity is how far they are apart."),
                Wrong(left_u, "that is the column in the left picture alone."),
                Wrong(raw_px, "those are the raw columns, as the pictures come. Take the rectified ones: u_left and u_right."),
                Wrong(right_u, "that is the column in the right picture alone."),
                Wrong((left_u + right_u) / 2, "that is the middle between the two columns. How far are they apart?"),
                Wrong(baseline * focal / right, "that is a depth already, in mm. The disparity is in px: how many columns lie between the two?"),
                Wrong(left_u**2 - right_u**2, "squares have no place here. How many columns lie between the two?"),
                Wrong(left_u / right_u, "you divided. How many columns lie between the two?"),
            ),
            f"{right:.1f} px, and above zero, as for everything in front of the cameras.",
            known={"u_left": left_u, "u_right": right_u, "the raw columns, left less right,": raw_px, "baseline_mm": baseline, "focal_px": focal},
            ask="How many columns lie between u_left and u_right?",
            small="fewer columns than lie between the two. Are these rows? Take u_left and u_right.",
            large="more columns than lie between the two. Are these millimetres, or a sum? Take u_left and u_right.",
            of_several="How many columns lie between the two?",
        ),
        hints=(
            "u_left and u_right are columns, counted from the left edge.",
            "The order decides the sign: the left camera sees the ball farther right.",
            "d_px = u_left - ____",
        ),
        code="d_px = u_left - u_right",
        reason="d = u_left − u_right is above zero in front of the cameras, and grows when the ball comes nearer.",
        reference=right,
    )  # fmt: skip


def _eq3(tries):
    return dict(
        asks="Two triangles of the same shape: write the depth from baseline, focal length and disparity.",
        answer=Function(
            ideal_depth, tries, 0.05, "mm",
            (
                Wrong(lambda b, f, d: -b * f / d, "your depth is below zero: look at the order of the two cameras in d."),
                Wrong(lambda b, f, d: b * f * d, "your depth grows when the ball comes closer: d belongs under the line."),
                Wrong(lambda b, f, d: b + f / d, "the baseline multiplies, it is not added."),
                Wrong(lambda b, f, d: b / d, "the focal length is missing: B/d alone has no unit of length per pixel."),
                Wrong(lambda b, f, d: b * f / d / 1000, "right, told in metres. This kit counts in millimetres."),
            ),
            "mm times px over px gives mm, as it should.",
            also=(lambda b, f, d: f / (d / b),),
        ),
        hints=(
            "In triangles of the same shape, width to height is the same number.",
            "d / f = B / Z. Solve for Z. Millimetres and pixels must cancel to millimetres.",
            "return baseline_mm * ____ / d_px",
        ),
        code="def depth_mm(baseline_mm, focal_px, d_px):\n    return baseline_mm * focal_px / d_px",
        reason="Similar triangles: d / f = B / Z.",
        reference=ideal_depth,
    )  # fmt: skip


def _unknowns():
    return dict(
        asks="How many samples does Eq. 4 need at least?",
        answer=Number(
            3, 0, "",
            (
                Wrong(1, "one sample gives one equation, and Eq. 4 has three unknown numbers."),
                Wrong(2, "two equations leave one of the three numbers m, n, c open."),
                Wrong(0, "with no sample at all m, n and c could be any numbers. How many of them are unknown?"),
                Wrong(5, "Eq. 4 has five letters; Z and d are measured in each sample. How many are unknown?"),
                Wrong(6, "so many are in the depth set: some to fit, some to check. How many does the fit need at least?"),
                Wrong(4, "four are more than needed: with three unknowns, three equations decide."),
            ),
            "three unknowns, three equations: solved exactly, with nothing left to check it by.",
            beside=(
                (r"(as|one|1|a sample|an equation)( many| sample| equation)? (as|for|per) (there are )?(each |every )?(of )?(unknowns?|parameters?|m, ?n,? ?(and )?c\b)( numbers?)?( there are)?", "yes. How many are they: which letters of Eq. 4 are neither Z nor d?"),
                (r"(3|three)\W+((for )?m, ?n,? ?(and )?c\)?|one (for|per) (each )?unknown)|m, ?n,? ?(and )?c\W+(3|three)", "so many, yes. Write the number alone."),
                (r"(3|three) (\w+ )?(per|each|for (each|every)|times|squared|cubed|(are|is) (too|not)|too few)\b.*", "each sample gives one equation. How many numbers of Eq. 4 are unknown? So many samples in all: write the number alone."),
                (r"(no|not|never) (less|fewer|lower|smaller) than (3|three)( samples)?|(3|three)( samples)? and (more|up)", "so many, yes. Write the number alone."),
                (r"(>|more than|over|above) ?(2|two)( samples)?", "and which is the smallest of such numbers? Write it alone."),
                (r"(at most|up to|no more than|fewer than|less than|not more than|[<≤]|>(?!=)).*", "more are welcome: they make the fit better. How many does Eq. 4 need at least?"),
                (r"(as )?(many|more|all|every)(?!.*three)\D*", "more samples make the fit better. How many does Eq. 4 need at least?"),
            ),
            small="fewer equations than unknowns leave some of m, n and c open.",
            large="that is more than it needs. Each sample gives one equation: how many numbers of Eq. 4 are unknown?",
        ),
        hints=(
            "Count the letters in Eq. 4 that are neither Z nor d.",
            "Each sample, a disparity with its depth, gives one equation.",
            "samples_needed = ____   # as many as there are unknown numbers: m, n and c",
        ),
        code="samples_needed = 3",
        reason="m, n and c are unknown; each sample gives one equation.",
        reference=3,
    )  # fmt: skip


def _one_pixel(tries):
    return dict(
        asks="By how many millimetres is the depth larger, if the disparity is one pixel smaller?",
        answer=Function(
            one_pixel_mm, tries, 0.0, "mm",
            (
                Wrong(
                    lambda z, f, b: b * f / (b * f / z - 1),
                    "that is the new depth. The question is by how much it is larger than z_mm: take the old one away.",
                ),
                Wrong(
                    lambda z, f, b: z - b * f / (b * f / z - 1),
                    "below zero: with a pixel less the ball seems farther away. Take the smaller depth from the larger one.",
                ),
                Wrong(lambda z, f, b: b * f / (b * f / z - 0.5) - z, "that is for half a pixel: take a whole one from the disparity."),
                Wrong(lambda z, f, b: b * f / (b * f / z + 1) - z, "that is one pixel more, and so the ball is nearer: below zero. Take a pixel from the disparity."),
                Wrong(lambda z, f, b: b * f / (z * f / b - 1) - z, "the disparity is upside down: in d = B·f/Z it is Z that stands below the line."),
                Wrong(lambda z, f, b: b * f / (z - 1), "depth_mm takes a disparity, and z_mm is a depth. First d = B·f/Z, then depth_mm of d − 1, less z_mm."),
                Wrong(lambda z, f, b: b * f / (z - 1) - z, "the pixel is taken from the disparity, not from the depth: first d = B·f/Z, then d − 1."),
                Wrong(lambda z, f, b: b * f / z - b * f / (z - 1), "depth_mm takes a disparity. First d = B·f/Z, then d − 1."),
                Wrong(lambda z, f, b: b * f / (b * f / z - 1) + z, "old and new depth are added. By how much is the new one larger? Take the old one away."),
                Wrong(lambda z, f, b: b * f - z, "that is how far it is from here to a disparity of one pixel. Take one pixel from the disparity it has: d − 1."),
                Wrong(lambda z, f, b: b * f / z - 1, "that is the new disparity. Which depth has it, and by how much is that more than z_mm?"),
                Wrong(lambda z, f, b: z - 1, "a pixel is no millimetre: take it from the disparity, not from the depth. First d = B·f/Z, then d − 1."),
                Wrong(lambda z, f, b: 0.0 * z, "there and back: the depth at the same disparity is the depth it had. Take one pixel from the disparity first."),
                Wrong(lambda z, f, b: z, "that is the depth it has. Take one pixel from its disparity: which depth is that, and by how much is it more?"),
                Wrong(lambda z, f, b: z**2 / (f + b), "f and B stand below the line as a product: times, not plus."),
                Wrong(lambda z, f, b: z**2 / f * b, "brackets are missing under the line: / (focal_px * baseline_mm)."),
                Wrong(lambda z, f, b: z * 2 / (f * b), "that is twice Z. Squared is **2."),
                Wrong(lambda z, f, b: b * f / (b * f / z - 2) - z, "that is for two pixels."),
                Wrong(lambda z, f, b: b * f / (b * f / z - 1) - b * f / (b * f / z + 1), "that is for two pixels, from one more to one less."),
                Wrong(lambda z, f, b: b * f, "that is the depth at a disparity of one pixel. Which disparity has this ball?"),
                Wrong(lambda z, f, b: z / (f * b), "the depth comes in twice: once it makes the disparity small, once it is what changes."),
                Wrong(lambda z, f, b: b * f / z, "that is the disparity at z_mm. Take a pixel from it, and ask for the depth again."),
                Wrong(lambda z, f, b: z / f, "that is how many mm across a pixel covers there. Here the ball moves away."),
            ),
            "a pixel is worth more, the farther away the ball is.",
            also=(
                lambda z, f, b: z - b * f / (b * f / z + 1),
                lambda z, f, b: z**2 / (f * b),
                lambda z, f, b: b * f / (b * f / z - 0.5) - b * f / (b * f / z + 0.5),
            ),
            relative=0.01,
        ),
        hints=(
            "Which disparity does a ball at z_mm have? Eq. 3 says it, turned round: d = B·f/Z.",
            "Ask your depth_mm for the depth at a disparity that is one pixel smaller. By how much is it larger than z_mm?",
            "d_px = baseline_mm * focal_px / z_mm\n    return depth_mm(baseline_mm, focal_px, ____) - z_mm",
        ),
        code=(
            "def one_pixel_mm(z_mm, focal_px, baseline_mm):\n"
            "    d_px = baseline_mm * focal_px / z_mm\n"
            "    return depth_mm(baseline_mm, focal_px, d_px - 1) - z_mm"
        ),
        reason="Depth at d − 1 less depth at d: nearly Z²/(f·B) millimetres.",
        reference=one_pixel_mm,
    )  # fmt: skip


def _wider(baseline, focal):
    return dict(
        asks="Which baseline halves the error of this rig?",
        answer=Number(
            2 * baseline, 0.02 * baseline, "mm",
            (
                Wrong(baseline / 2, "half the baseline doubles the error: B stands under the line."),
                Wrong(4 * baseline, "four times the baseline makes a quarter of the error: B is not squared, Z is."),
                Wrong(baseline, "that is the baseline this rig has."),
                Wrong(3 * baseline, "three times the baseline makes a third of the error."),
                Wrong(1.5 * baseline, "one and a half times the baseline makes two thirds of the error. Half is asked for."),
                Wrong(baseline / 4, "a narrower baseline makes the error larger: B stands under the line."),
                Wrong(10 * baseline, "ten times the baseline makes a tenth of the error. Half is asked for."),
                Wrong(focal, "that is the focal length, in px. Which baseline halves the error?"),
                Wrong(2 * focal, "twice the focal length halves it as well; but the baseline is asked for, in mm."),
                Wrong(baseline + 2, "not two more: two times as much."),
                Wrong(baseline + 100, "not 100 mm more: what part of the error is left then?"),
                Wrong(0.0, "without a baseline both cameras see the same, and there is no depth at all."),
                Wrong(2, "that is how many times as wide. The baseline itself is asked for, in mm."),
                Wrong(0.5, "half the error, yes. Which baseline gives it, in mm?"),
                Wrong(baseline**2, "a square has no place here: B stands under the line, once."),
                Wrong(baseline * 2**0.5, "B stands under the line once, not squared: no root."),
            ),
            "twice the baseline. What it costs: near things fall out of one of the two pictures.",
            known={"calibration.baseline_mm": baseline, "calibration.focal_px": focal, "2": 2},
            beside=(
                ("(an?|the)? ?(much )?(wider|longer|larger|bigger)( (one|baseline))?|(a |the )?(one|baseline)", "how wide? Work out what becomes of B where half of the error is to be left, and write it in mm."),
                (r"(the |a )?(one|baseline) \D*(twice|two times|double)\D*|twice (this|that) one", "work it out, and write one number in mm."),
                ("(a (little|bit) )?(more than|over|above|>).*", "wider still leaves less than half of the error. Which baseline leaves just half of it?"),
                (r"\d\d[\d.]* times", "so many times as wide? The baseline itself is asked for: write it in mm."),
                ("(2|two) ?([x×*]|times) .*|.*([x×*]|times) ?(2|two)", "work it out, and write one number in mm."),
            ),
            ask="The error has B under the line: how must B change, if half of the error is to be left?",
            small="that leaves more than half of the error. B stands under the line: what must become of it?",
            large="that leaves less than half of the error. B stands under the line: what must become of it?",
        ),
        hints=(
            "Where does B stand in the formula of the limit?",
            "The error is proportional to 1/B.",
            "wider_mm = ____ * calibration.baseline_mm",
        ),
        code="wider_mm = 2 * calibration.baseline_mm",
        reason="σ_Z = Z²/(f·B)·σ_d: twice B, half the error.",
        reference=2 * baseline,
    )  # fmt: skip


def ideal_depth(baseline_mm: float, focal_px: float, d_px: float) -> float:
    """Eq. 3, mm."""
    return baseline_mm * focal_px / d_px


def one_pixel_mm(z_mm: float, focal_px: float, baseline_mm: float) -> float:
    """By how much a ball is farther away whose disparity is one pixel smaller, mm."""
    return baseline_mm * focal_px / (baseline_mm * focal_px / z_mm - 1) - z_mm


@lru_cache(maxsize=4)
def _facts(path):
    """Baseline, focal length, and the columns of the ball in the first depth sample where it is seen: two rectified ones, the raw ones' difference, and its measured depth, mm."""
    recording = open_recording(path)
    localizer = Localizer.fit(recording, leave_out=recording.judges())
    calibration = localizer.calibration
    looks = ((s, localizer.detect(s.pair.left, s.pair.right)) for s in recording.samples("depth"))
    sample, balls = next((s, pair) for s, pair in looks if pair is not None)
    (u_left, _), (u_right, _) = calibration.rectify_centers(*balls)
    columns = float(u_left), float(u_right), balls[0].u - balls[1].u
    return calibration.baseline_mm, calibration.focal_px, *columns, sample.measured.depth_mm
