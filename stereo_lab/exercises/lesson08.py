"""Questions of lesson 08: your own cameras."""

from __future__ import annotations

import math

import numpy as np

from stereo_lab.doctor import healthy
from stereo_lab.exercises.answers import Choice, Function, Number, Wrong
from stereo_lab.exercises.question import Question, lesson
from stereo_lab.exercises.reading import ACROSS, DOWN
from stereo_lab.recording import Recording

RULER_MM, PRINTED_MM = 100.0, 98.0  # of the ruler on the sheet: as drawn, and as it left the printer
PART = "(\\w+\\.(csv|json)|pictures?|images?|pairs?|photos?|names?|paths?|half|parts?|pieces?|some|most)"


def questions(recording: Recording) -> tuple[Question, ...]:
    """Eight questions, the third by the board of the recording, three by its patients; see :mod:`stereo_lab.exercises`."""
    well = healthy(recording.seat)
    return lesson(
        "08", _baseline(), _both_see(), _square(recording.board.square_mm), _board(well), _belongs(well), _slip(well),
        _cameras_alone(), _help(),
    )  # fmt: skip


def _baseline():
    tries = (
        (1000.0, 2.0, 600.0, 0.05),
        (2000.0, 2.0, 600.0, 0.05),
        (1500.0, 5.0, 450.0, 0.1),
        (800.0, 1.0, 1000.0, 0.04),
    )
    return dict(
        asks="How far apart must the cameras stand, so that the depth at depth_mm is known to error_mm?",
        answer=Function(
            baseline_for, tries, 0.0, "mm",
            (
                Wrong(lambda z, e, f, s: z**2 / f * s, "the error does not come in: who allows more of it needs less baseline."),
                Wrong(lambda z, e, f, s: z * s / (f * e), "the depth comes in squared: once because a far ball has a small disparity, once because that changes slowly."),
                Wrong(lambda z, e, f, s: 2 * z * s / (f * e), "that is twice Z. Squared is **2."),
                Wrong(lambda z, e, f, s: z**2 * s * e / f, "who allows more error needs less baseline: error_mm stands under the line, in one pair of brackets with focal_px."),
                Wrong(lambda z, e, f, s: f * e / (z**2 * s), "upside down: a ball farther away needs a longer baseline."),
                Wrong(lambda z, e, f, s: z**2 / f * s / f, "focal_px comes in twice, and the error is missing."),
                Wrong(lambda z, e, f, s: z**2 * f * s / e, "a longer lens sees more: focal_px stands under the line."),
                Wrong(lambda z, e, f, s: z**2 / (f * e), "the noise of the disparity is missing: sigma_d_px."),
                Wrong(lambda z, e, f, s: z**2 / (f * e * s), "more noise needs more baseline: sigma_d_px stands above the line."),
            ),
            "twice as far needs four times the baseline.",
            relative=0.01,
        ),
        hints=(
            "Lesson 04: the error is Z²·σ_d/(f·B). Which letter is asked for here?",
            "Multiply both sides by B, and divide both by the error.",
            "return depth_mm**2 * sigma_d_px / ____",
        ),
        code=(
            "def baseline_for(depth_mm, error_mm, focal_px, sigma_d_px):\n"
            "    return depth_mm**2 * sigma_d_px / (focal_px * error_mm)"
        ),
        reason="The error of lesson 04, solved for the baseline: error and baseline change places.",
        reference=baseline_for,
    )  # fmt: skip


def _both_see():
    tries = (
        (1000.0, 120.0, 600.0, 640.0),
        (500.0, 240.0, 600.0, 640.0),
        (2000.0, 60.0, 1000.0, 1280.0),
        (200.0, 240.0, 600.0, 640.0),
    )
    return dict(
        asks="How wide is the strip at depth_mm that both cameras see, if both look straight ahead?",
        answer=Function(
            both_see_mm, tries, 0.5, "mm",
            (
                Wrong(lambda z, b, f, w: (z - b) * w / f, "the baseline is taken from the width that one camera sees, not from the depth: multiply and divide first."),
                Wrong(lambda z, b, f, w: abs(z * w / f - b), "where the views do not meet yet, yours is above zero. Leave the sign: it tells that there is no strip."),
                Wrong(lambda z, b, f, w: z * w / f, "that is what one camera sees. The other one stands baseline_mm farther right: what do they share?"),
                Wrong(lambda z, b, f, w: z * w - b / f, "only the baseline is divided. focal_px belongs under depth_mm * width_px."),
                Wrong(lambda z, b, f, w: z * w / f + b, "that is what at least one of them sees. Both see less than one."),
                Wrong(lambda z, b, f, w: z * w / f - 2 * b, "the baseline is lost once: at the left rim of one, or at the right rim of the other."),
                Wrong(lambda z, b, f, w: z * w / f - b / 2, "the whole baseline is lost, not half of it: the right picture begins a whole baseline farther right."),
                Wrong(lambda z, b, f, w: z * f / w - b, "upside down: the picture's width in px stands above, the focal length below."),
                Wrong(lambda z, b, f, w: f * w / z - b, "farther away a camera sees more, not less: depth_mm stands above the line."),
                Wrong(lambda z, b, f, w: b - z * w / f, "the other way round: the width that one sees, less the baseline."),
                Wrong(lambda z, b, f, w: w - b, "millimetres from pixels: first turn the picture's width into mm at that depth."),
                Wrong(lambda z, b, f, w: z * w / f * b, "the baseline is a length that is taken away."),
                Wrong(lambda z, b, f, w: z * (w - b) / f, "the baseline is in mm, and the picture's width in px: first turn the width into mm."),
                Wrong(lambda z, b, f, w: w - f * b / z, "that is right in pixels. How many mm is it at that depth?"),
                Wrong(lambda z, b, f, w: z * w / (2 * f) - b, "that is half of what one camera sees, less the baseline."),
                Wrong(lambda z, b, f, w: z * w / f / b, "the baseline is taken away, nothing is divided by it."),
                Wrong(lambda z, b, f, w: w * f / b, "that is the other question: how near a thing may come. Ask for the strip at depth_mm."),
            ),
            "what one camera sees, less the baseline.",
            also=(lambda z, b, f, w: max(0.0, z * w / f - b),),
        ),
        hints=(
            "How wide is what one camera sees at that depth? A thing as far away as it is wide fills focal_px pixels.",
            "One camera sees depth_mm · width_px / focal_px. The right one begins baseline_mm farther right, and ends farther right.",
            "return depth_mm * width_px / focal_px - ____",
        ),
        code=(
            "def both_see_mm(depth_mm, baseline_mm, focal_px, width_px):\n"
            "    return depth_mm * width_px / focal_px - baseline_mm"
        ),
        reason="Two strips of one width, the baseline apart: they share the width less the baseline.",
        reference=both_see_mm,
    )  # fmt: skip


def _square(drawn):
    right = drawn * PRINTED_MM / RULER_MM
    return dict(
        asks=f"The sheet's ruler should be {RULER_MM:.0f} mm long, and yours says {PRINTED_MM:.0f}. Squares were drawn {drawn:g} mm wide. How wide are they?",
        answer=Number(
            right, 0.0005 * drawn, "mm",
            (
                Wrong(drawn * RULER_MM / PRINTED_MM, "that is larger than drawn. The ruler came out too short, so the squares did, too."),
                Wrong(drawn - (RULER_MM - PRINTED_MM), "the ruler lost 2 mm on 100. A square is shorter than that and loses less: a part, not a length."),
                Wrong(RULER_MM - PRINTED_MM, "that is by how much the ruler is too short. How wide is a square?"),
                Wrong(drawn, "that is what was drawn. The printer made everything smaller."),
                Wrong(PRINTED_MM, "that is the ruler. How wide is a square?"),
                Wrong(RULER_MM / PRINTED_MM, "that is how many times too long a drawn length is. How wide is a square, printed?"),
                Wrong(PRINTED_MM / RULER_MM, "that is the part of its size that is left. Which part of a square's side is that, in mm?"),
                Wrong(drawn * PRINTED_MM, "98 of 100 are 0.98."),
                Wrong(drawn + (RULER_MM - PRINTED_MM), "the ruler came out too short, so the squares did, too; and 2 mm were lost on 100, not on a square."),
                Wrong(RULER_MM, "that is the ruler as drawn. How wide is a square?"), Wrong(drawn / RULER_MM, "that is a square's part of the ruler. How wide is it, printed?"),
                Wrong(drawn * (RULER_MM - PRINTED_MM) / RULER_MM, "that is by how much a square is too small. How wide is it then?"),
            ),
            f"{right:g} mm: two parts in a hundred are missing everywhere.",
        ),
        hints=(
            "The printer made the whole sheet smaller by the same part.",
            "98 of 100 mm are left. So 98 of 100 parts of each side are left.",
            f"square_mm = {drawn:g} * ____ / 100",
        ),
        code=f"square_mm = {drawn:g} * {PRINTED_MM:.0f} / {RULER_MM:.0f}",
        reason="A printer that scales, scales all of the page.",
        reference=right,
    )  # fmt: skip


def _board(well):
    columns, rows = well.board.columns, well.board.rows
    return dict(
        asks="Patient A: how many inner corners does the board really have, as (columns, rows)?",
        answer=Number(
            (columns, rows), 0, "",
            (
                Wrong((columns + 1, rows + 1), "that is what the patient came with, and no picture fits it. Squares were counted; where do four of them meet?"),
                Wrong((columns + 1, rows), "across these are squares. Count the places where four squares meet."),
                Wrong((columns, rows + 1), "down these are squares. Count the places where four squares meet."),
                Wrong((columns - 1, rows - 1), "one too few each way: the first and the last inner corner count as well."),
                Wrong((columns - 1, rows), "across one is missing."), Wrong((columns, rows - 1), "down one is missing."),
                Wrong((columns + 2, rows + 2), "one more each way than there are squares? Only places where four squares meet count."),
                Wrong((columns - 2, rows), "white squares at the corners run into the rim. Count along the lowest row, which begins and ends with a black one."),
                Wrong((columns - 2, rows + 1), "white squares at the corners run into the rim; and where do four squares meet?"),
                Wrong((columns // 2, rows), "black and white squares both count: where four of them meet is a corner."),
                Wrong(columns * rows, "that is how many there are in all. Two numbers are asked for: across and down."),
                Wrong((columns + 1) * (rows + 1), "those are all squares. Two numbers are asked for: inner corners across and down."),
                Wrong((columns + 1, rows - 1), "across these are squares, and down one is missing."), Wrong((columns - 1, rows + 1), "across one is missing, and down these are squares."),
                Wrong(columns + rows, "one number for both? Tell them apart: (across, down)."),
                Wrong((rows, columns), "columns first, then rows: across before down."),
                Wrong((rows + 1, columns + 1), "these are squares, and down before across."),
            ),
            "one fewer than squares, each way.",
            also=([columns, rows],),
            labels=(ACROSS, DOWN),
        ),
        hints=(
            "Count in the enlarged picture, along the longer side, then along the shorter one.",
            "Somebody counted squares. Inner corners are one fewer than squares, each way.",
            f"board_a = ({columns + 1} - 1, {rows + 1} - ____)",
        ),
        code=f"board_a = ({columns}, {rows})",
        reason="A row of n squares has n − 1 places between them.",
        reference=(columns, rows),
    )  # fmt: skip


def _belongs(well):
    first, count = well.since, well.pairs
    tries = tuple((number,) for number in range(count))  # every pair, for one alone may be missed
    return dict(
        asks="Patient B: does the pair of this number belong to the cameras as they stood when the balls were taken?",
        answer=Function(
            lambda number: number >= first, tries, 0.1, "",
            (
                Wrong(lambda number: number < first, "those are the pairs before the step. The balls were taken last: which cameras saw them?"),
                Wrong(lambda number: number <= first, "those are the pairs before the step, and the first one after it."),
                Wrong(lambda number: number > first, "one is missing: read off the first pair after the step, and take it in (>=)."),
                Wrong(lambda number: number >= first - 1, "one too many: the last pair before the step is in it."),
                Wrong(lambda number: number >= count - first, "that is how many pairs are kept, not the number of the first one."),
                Wrong(lambda number: number < count - first, "that is how many pairs are kept, but from the beginning. The balls were taken last."),
                Wrong(lambda number: number >= first - 2, "two too many: read off the first dot of the upper step."),
                Wrong(lambda number: first <= number < count - 1, "the last pair is missing: a range ends before its second number."),
                Wrong(
                    lambda number: number > 0.5,
                    "that keeps all pairs but the first. Was it 0.5? That is an angle, on the upright axis; `number` is the pair, on the level one. "
                    "Was it a text? Texts are compared letter by letter: compare the numbers themselves.",
                ),
                Wrong(lambda number: number > count - first, "that is how many pairs are kept, not the number of the first one."),
                Wrong(lambda number: str(number) >= str(first), "texts are compared letter by letter, so '7' comes after '12'. Compare the numbers themselves."),
                Wrong(lambda number: number % first == 0, "% is the rest of a division: that says yes to 0 and to every multiple. Compare with >=."),
                Wrong(lambda number: number in (first, count - 1), "those are two pairs, the first and the last of them. All between belong as well: compare with >=."),
                Wrong(lambda number: number == first, "only one pair? All after the step belong together."),
                Wrong(lambda number: True, "your function keeps every pair. Which ones were taken with other cameras, so to say?"),
                Wrong(lambda number: False, "your function keeps no pair at all."),
                Wrong(lambda number: first, "a number is no answer to keep or not: compare it with `number`."),
            ),
            "the balls were taken after the boards, so the last state of the cameras counts.",
            of_all=lambda given: _of_kept(given, first),
        ),
        hints=(
            "Find the step in the figure. On which side of it were the balls taken?",
            "The balls come after all boards. Keep what comes after the step, its first pair included.",
            "return number >= ____",
        ),
        code=f"def belongs(number):\n    return number >= {first}",
        reason="A calibration holds for the cameras as they stood; the balls were seen by those that stand now.",
        reference=_after(first),
    )  # fmt: skip


def _slip(well):
    right, typed = well.depth_mm, well.typed_mm
    digits = f"{right:.0f}"
    return dict(
        asks=f"Patient C: what did the ruler say at {well.slipped}, where {typed:.0f} was typed?",
        answer=Number(
            right, 0.5, "mm",
            (
                Wrong(typed, "that is what was typed. Which place would the ball have then? Look at the bar."),
                *(
                    Wrong(float(other), f"near, but how does {typed:.0f} come of it? Leave one digit out of {other}, and see.")
                    for other in sorted({int(right) - 1, int(right) + 1, int(right) - 2, int(right) + 2, round(right, -1)} - {int(right)})
                ),
                *(
                    Wrong(float(other), f"{typed:.0f} comes of it, but the cameras say something else. Which other digit may be missing?")
                    for other in _with_a_digit(f"{typed:.0f}") if abs(other - right) > 2.5 and other != typed
                ),
                Wrong(float(well.slipped.rpartition("/")[2]), "that is the sample's name. Which depth did the ruler say there?"),
                Wrong(right / 10, "that is in centimetres. The table is in millimetres."),
                Wrong(right - typed, "that is by how much it is off. What did the ruler say?"),
            ),
            f"{digits}: a digit was left out.",
            small=f"not near what the cameras tell there. Look for the pair of bars that differ: {typed:.0f} has all digits but one.",
            large=f"not near what the cameras tell there. Look for the pair of bars that differ: {typed:.0f} has all digits but one.",
        ),
        hints=(
            "What do the cameras say there? The ruler cannot have said something much different.",
            f"One digit was left out. Put one into {typed:.0f} so that it is what the cameras say.",
            f"depth_c = ____   # {len(digits)} digits: those of {typed:.0f}, and the one that is missing",
        ),
        code=f"depth_c = {digits}",
        reason="Two things that agree: what was typed has all digits but one, and the cameras say which.",
        reference=right,
    )  # fmt: skip


def _cameras_alone():
    tries = ((1.3, 0.5), (5.0, 3.0), (1.0, 0.6), (0.9, 0.2))
    return dict(
        asks="The differences between cameras and ruler spread by difference_mm, the ruler's own errors by ruler_mm. How much is the cameras'?",
        answer=Function(
            cameras_alone, tries, 0.001, "mm",
            (
                Wrong(lambda d, r: d * (1 - r), "the ruler has no share in percent: both are in mm. Squares, their difference, and the root."),
                Wrong(lambda d, r: d - r, "spreads do not add up like lengths: an error of one may cancel an error of the other. Squares add up."),
                Wrong(lambda d, r: d**2 - r**2, "that is the square of it. Take the root."),
                Wrong(lambda d, r: math.sqrt(d**2 + r**2), "that is more than was seen. The cameras' part is less: minus."),
                Wrong(lambda d, r: d + r, "that is more than was seen. The cameras' part is less."),
                Wrong(lambda d, r: d, "the ruler has errors of its own, and they are in it."),
                Wrong(lambda d, r: r, "that is the ruler's part."),
                Wrong(lambda d, r: math.sqrt(d) - math.sqrt(r), "first square both, take the one from the other, then the root of what is left."),
                Wrong(lambda d, r: math.sqrt(d - r), "squares are missing under the root: both are squared first."),
                Wrong(lambda d, r: (d**2 - r**2) / 2, "that is half the square of it. Take the root."),
                Wrong(lambda d, r: math.sqrt(2 * d - 2 * r), "times two is not squared: squared is **2."),
                Wrong(lambda d, r: math.sqrt(d**2 - r), "both are squared, the ruler's as well."),
                Wrong(lambda d, r: (d - r) ** 2, "first square each, then take the one from the other: d² − r² is not (d − r)²."),
                Wrong(lambda d, r: (d - r) / 2, "spreads do not add up like lengths, and nothing is halved. Squares add up."),
                Wrong(lambda d, r: d**2 - r**2**0.5, "** 0.5 takes hold of what stands right before it: put brackets round the difference."),
                Wrong(lambda d, r: d - r**2, "only the ruler's is squared. Does a root take hold of difference_mm**2 alone? Then it undoes that square: both squares belong in its brackets."),
                Wrong(lambda d, r: d / r, "how many times the ruler's is not asked for."),
            ),
            "the squares of what is independent add up, as the sides at a right angle do.",
            domain="a root of a number below zero: take the ruler's square from the other one.",
        ),
        hints=(
            "A right triangle: two short sides, which have nothing to do with each other, and the long one.",
            "difference² = cameras² + ruler². Which one do you look for?",
            "return (difference_mm**2 - ____) ** 0.5",
        ),
        code="def cameras_alone(difference_mm, ruler_mm):\n    return (difference_mm**2 - ruler_mm**2) ** 0.5",
        reason="Errors that know nothing of each other add up in their squares.",
        reference=cameras_alone,
    )  # fmt: skip


def _help():
    return dict(
        asks="It does not work, and you write to somebody who may help. What do you send?",
        answer=Choice(
            "the recording and what the doctor says",
            (
                Wrong("the doctor's words alone", "a verdict without the pictures: nobody can try whether it is right, or what mends it."),
                Wrong("the recording alone", "and what the doctor says of it: whoever helps need not wait for it, and sees what you saw. Send both."),
                Wrong("a screenshot of the message", "it shows that something is wrong, and not what. Nobody can try anything with a screenshot."),
                Wrong("the numbers that come out wrong", "what went in is missing. The same wrong depth comes from a dozen mistakes."),
                Wrong("your best pair of pictures", "the mistake is in the others, or between them. Whoever helps must see what the kit saw."),
            ),
            "whoever has both can see it go wrong, and try.",
            same=(
                ("(the )?screenshots?", "a screenshot of the message"), ("(the )?(wrong )?numbers", "the numbers that come out wrong"),
                ("(my |your )?best pair|one pair", "your best pair of pictures"), ("^((what )?the doctor(( says)|'s (words|report|findings|output))?|(the )?report|check(\\.html)?)$", "the doctor's words alone"),
                ("^(the )?(whole )?(folder|recording)( alone)?$", "the recording alone"),
                ("(without|no) (any |the )?faces", ""),
                (
                    "^(?!.*\\b(not|no|or|nor|never|neither|without|alone|only|just|but|screenshots?)\\b)"
                    "(?!.*(doctor|report|check|verdict|words|says)('s)?( \\w+)? (of|on|about|for|from) (the |my |your |this )?(whole )?(recording|folder|data))"
                    "(?=.*\\b(recordings?|folder|data/\\w+))(?=.*\\b(doctor|report|check|verdict)).*$",
                    "the recording and what the doctor says",
                ),
                ("^.*(doctor|report|check|verdict|words|says)('s)?( \\w+)? (of|on|about|for|from) (the |my |your |this )?(whole )?(recording|folder|data/\\w+)$", "the doctor's words alone"),
            ),
            beside=(
                ("both( of (them|these|it))?", "both of what? Name the two: what the kit saw, and what was said of it."),
                (".*(recording|folder|doctor|report)\\b.* or .*", "the one or the other? Say what you send: what the kit saw, what was said of it, or both."),
                (".*screenshots?.*", "nobody can try anything with a screenshot. What holds all that the kit saw, and what it thinks of it?"),
                ("(all|everything|anything|as much).*", "whoever gets everything must search it. Which two things hold all that the kit saw, and what it thinks of it?"),
                (".*(calibration|ball|board|picture|image|pair|sample|csv|table|ruler).*", "that is a part of it, and the mistake may lie in another. What holds all that the kit saw, and what it thinks of it?"),
                (".*(mail|phone|chat|message|text|question).*", "yes, but with what in it? What holds all that the kit saw, and what it thinks of it?"),
                ("(nothing|none|no).*", "without what the kit saw nobody can try anything. What holds it all?"),
                (".*(code|notebook|program|version|computer|camera|log).*", "that may matter later. First: what holds all that the kit saw, and what it thinks of it?"),
            ),
            not_meant=(
                (
                    f".*(\\b({PART})s? .*(of|in|from) (the |my |your |this )?(whole )?(recording|folder)\\b|\\brecording\\.json|\\brecording ({PART})s?\\b).*",
                    "that is a part of it, and the mistake may lie in another. What holds all that the kit saw, and what it thinks of it?",
                ),
            ),
        ),
        hints=(
            "What would you need, to find out what is wrong with somebody else's cameras?",
            "Everything that the kit saw, and what it said of it.",
            'send = "the recording and what the ____ says"',
        ),
        code='send = "the recording and what the doctor says"',
        reason="A mistake that others can see again is half mended.",
        reference="the recording and what the doctor says",
    )  # fmt: skip


def _after(first):
    def belongs(number: int) -> bool:
        """Whether a pair was taken after the camera was moved."""
        return number >= first

    return belongs


def _of_kept(given, first):
    """What is wrong with the pairs that are kept, where each was answered by yes or no; "" where not."""
    if not all(np.size(yes) == 1 and np.ravel(yes)[0] in (0, 1) for yes in given):
        return ""
    kept = [number for number, yes in enumerate(given) if yes]
    missing = sorted({*range(first, len(given))} - {*kept})
    if kept and max(kept) < first:
        return "those are pairs before the step. The balls were taken last: which cameras saw them?"
    if not missing:
        return "too many are kept: read off the first dot of the upper step."
    if kept and min(kept) < first:
        return (
            "pairs from before the step are kept, and some of those after it are not. Which of the two saw the balls?"
        )
    if first in missing:
        return "too few are kept: read off the first dot of the upper step."
    return (
        f"pair {missing[0]} is missing, and it comes after the step as well. Did you compare the angle? Half a degree is about "
        "the step's height, and some pairs lie a little lower. Draw the line in the middle of the step, or compare the number."
    )


def _with_a_digit(digits):
    """All whole numbers that become this one when a digit is left out."""
    return sorted({int(digits[:k] + d + digits[k:]) for k in range(len(digits) + 1) for d in "0123456789"})


def baseline_for(depth_mm: float, error_mm: float, focal_px: float, sigma_d_px: float) -> float:
    """The baseline, mm, with which the depth at ``depth_mm`` is known to ``error_mm`` (lesson 04, solved for B)."""
    return depth_mm**2 * sigma_d_px / (focal_px * error_mm)


def both_see_mm(depth_mm: float, baseline_mm: float, focal_px: float, width_px: float) -> float:
    """The width, mm, of what two cameras that look straight ahead both see at ``depth_mm``."""
    return depth_mm * width_px / focal_px - baseline_mm


def cameras_alone(difference_mm: float, ruler_mm: float) -> float:
    """The cameras' part of a spread that the ruler has a part in, mm."""
    return math.sqrt(difference_mm**2 - ruler_mm**2)
