"""Questions of lesson 01: cameras, boards, rectification."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from stereo_lab.calibration import calibrate_recording
from stereo_lab.exercises.answers import Choice, Function, Number, Wrong
from stereo_lab.exercises.question import Question, lesson
from stereo_lab.exercises.reading import ACROSS, DOWN
from stereo_lab.recording import Recording, open_recording

CURVED = "\\b(bent|bend(s|ing)?|curv(e|es|ed|y|ing)|bow(s|ed|ing)?|arc(s|hed)?|crooked|warp\\w*|distort\\w*|deform\\w*|bulg\\w*|rounds|rounded)\\b"
MOVES = "(it )?(moves|shifts|displaces)( (it|the line))?"
MAKES_ROUND = "\\b(makes?|is|gets?|becomes?|looks?)( (it|the|a|straight|lines?|more|quite)){0,3} round"
PICTURES = "(pairs|ones|pictures|boards|images|data|set)"
NEW = "(unused|different|other|another|new|fresh|unknown|independent|(cross[- ]?)?validation|held[- ]?(out|back)|left[- ]?out|kept[- ]?back|others)"
OF_THE_FIT = "(the |its )?(fit|calibration|training)( set)?"

TRIES = (
    ((100.0, 50.0, 1000.0), 700.0, (320.0, 240.0)),
    ((-30.0, 20.0, 500.0), 650.0, (310.0, 250.0)),
    ((37.0, 21.0, 930.0), 611.5, (318.2, 243.7)),
)


def questions(recording: Recording) -> tuple[Question, ...]:
    """Six questions; see :mod:`stereo_lab.exercises`."""
    board = recording.board
    translation, baseline, focal = _facts(str(recording.path))
    return lesson(
        "01",
        _projection(),
        _corners(board),
        _lines(),
        _unseen(),
        _baseline(translation, baseline, focal),
        _worth(baseline, focal),
    )


def _projection():
    return dict(
        asks="Write where a point (X, Y, Z) in the camera's frame appears: (u, v).",
        answer=Function(
            project, TRIES, 0.01, "px",
            (
                Wrong(
                    lambda p, f, c: (f * p[0] / p[2], f * p[1] / p[2]),
                    "your straight ahead is pixel (0, 0), the upper left corner. Add the centre c.",
                ),
                Wrong(
                    lambda p, f, c: (p[0] / p[2] + c[0], p[1] / p[2] + c[1]),
                    "the focal length is missing: f turns X/Z into pixels.",
                ),
                Wrong(
                    lambda p, f, c: (f * p[0] / math.hypot(*p) + c[0], f * p[1] / math.hypot(*p) + c[1]),
                    "that is divided by how far away the point is. Z counts, how far straight ahead: the picture is flat.",
                ),
                Wrong(lambda p, f, c: (f * (p[0] + c[0]) / p[2], f * (p[1] + c[1]) / p[2]), "the centre is in pixels already: add it last, after the division by Z."),
                Wrong(lambda p, f, c: (f * (p[0] / p[2] + c[0]), f * (p[1] / p[2] + c[1])), "the centre is in pixels already: add it last."),
                Wrong(lambda p, f, c: (f * p[0] / p[2] + c[1], f * p[1] / p[2] + c[0]), "u takes the first number of the centre, v the second."),
                Wrong(lambda p, f, c: (f * p[0] / p[2] + c[0], c[1] - f * p[1] / p[2]), "Y goes down, as v does: plus."),
                Wrong(lambda p, f, c: (f * p[1] / p[2] + c[1], f * p[0] / p[2] + c[0]), "u comes first, then v."),
                Wrong(lambda p, f, c: (f * p[0] / p[2] + c[0], f * p[0] / p[2] + c[1]), "v goes with Y: you copied the line with X."),
                Wrong(lambda p, f, c: (f * p[0] / p[2] + c[0], f * p[0] / p[2] + c[0]), "v goes with Y and the second number of the centre: you copied the line of u."),
                Wrong(lambda p, f, c: (f * p[0] / p[2] + c[0], f * p[1] / p[2] + c[0]), "v takes the second number of the centre: center_px[1]."),
                Wrong(lambda p, f, c: ((f * p[0] + c[0]) / p[2], (f * p[1] + c[1]) / p[2]), "only f·X is divided by Z; the centre is in pixels already."),
                Wrong(lambda p, f, c: (f * p[2] / p[0] + c[0], f * p[2] / p[1] + c[1]), "Z belongs below the line: far things are small."),
                Wrong(lambda p, f, c: (f * p[0] / p[2] - c[0], f * p[1] / p[2] - c[1]), "the centre is added: a point straight ahead appears there."),
                Wrong(lambda p, f, c: (c[0] - f * p[0] / p[2], c[1] - f * p[1] / p[2]), "your picture is turned round: what is on the right appears on the right. Plus, both times."),
                Wrong(lambda p, f, c: (f * p[0] / (p[2] + c[0]), f * p[1] / (p[2] + c[1])), "the brackets take the centre below the line. Only Z stands there; the centre is added last."),
                Wrong(lambda p, f, c: (p[2] * p[0] / f + c[0], p[2] * p[1] / f + c[1]), "f and Z have changed places: Z belongs below the line, for far things are small."),
                Wrong(lambda p, f, c: (f * p[0] // p[2] + c[0], f * p[1] // p[2] + c[1]), "// throws the decimals away. Divide by a single /."),
                Wrong(lambda p, f, c: f * p[1] / p[2] + c[1], "that is v alone. Two numbers, with a comma between them."),
                Wrong(lambda p, f, c: f * p[0] / p[2] + c[0], "that is u alone. Two numbers, with a comma between them."),
                Wrong(
                    lambda p, f, c: (f * p[0] + c[0], f * p[1] + c[1]),
                    "your picture does not get smaller with distance: divide by Z.",
                ),
                Wrong(
                    lambda p, f, c: (f * p[1] / p[2] + c[0], f * p[0] / p[2] + c[1]),
                    "u and v have changed places: u goes with X (right), v with Y (down).",
                ),
            ),
            "far things are small: that is the division by Z.",
            also=(lambda p, f, c: [c[0] + p[0] / p[2] * f, c[1] + p[1] / p[2] * f],),
            parts={"point_mm": ("X", "Y", "Z")},
        ),
        hints=(
            "Two formulas stand above the cell, one for u and one for v.",
            "u = f·X/Z + c_u, and the same with Y for v.",
            "return focal_px * X / Z + center_px[0], ____",
        ),
        code=(
            "def project(point_mm, focal_px, center_px):\n    X, Y, Z = point_mm\n"
            "    return focal_px * X / Z + center_px[0], focal_px * Y / Z + center_px[1]"
        ),
        reason="Similar triangles once for the columns and once for the rows.",
        reference=project,
    )  # fmt: skip


def _corners(board):
    columns, rows = board.grid  # of a ChArUco board its squares are told
    return dict(
        asks="How many inner corners has the board: across and down, as (columns, rows)?",
        answer=Number(
            (columns, rows), 0, "",
            (
                Wrong((columns + 1, rows + 1), "you counted squares. Inner corners, where four squares meet, are one fewer each way."),
                Wrong((columns + 1, rows), "across you counted squares. Four of them must meet."),
                Wrong((columns, rows + 1), "down you counted squares. Four of them must meet."),
                Wrong((rows, columns), "columns first, then rows: across before down."),
                Wrong(columns * rows, "that is how many there are in all. Two numbers are asked for: across and down."),
                Wrong((rows + 1, columns + 1), "you counted squares, and down before across. Inner corners are one fewer each way."),
                Wrong((columns - 1, rows - 1), "one too few each way: the dots at the ends of a row count as well."),
                Wrong((columns - 1, rows), "across one is missing: count the first dot as one."),
                Wrong((columns, rows - 1), "down one is missing: count the first row as one."),
                Wrong((rows - 1, columns - 1), "down before across, and one too few each way: the dots at the ends of a row count as well."),
                Wrong((rows + 1, columns), "down before across, and in one of them you counted squares."),
                Wrong((rows, columns + 1), "down before across, and in one of them you counted squares."),
                Wrong((2 * columns, 2 * rows), "that is twice as many each way. Count the dots in one row, and the rows."),
                Wrong((columns * rows, columns * rows), "that is how many there are in all, twice. Count the dots in one row, and the rows."),
                Wrong((columns + 1, rows + 2), "too many both ways: only where four squares meet counts, not at the rim."),
                Wrong((columns + 2, rows + 2), "you counted the outer rim as well. Only where four squares meet counts."),
            ),
            "where four squares meet; the rim does not count.",
            also=([columns, rows],),
            labels=(ACROSS, DOWN),
            beside=((r".*\d ?(mm|cm|px)\b.*", "corners are counted, not measured: two bare numbers."),),
        ),
        hints=(
            "The coloured dots of the figure sit on the corners that count.",
            "An inner corner is where two black and two white squares meet. Count along one row of dots.",
            "inner_corners = (____, ____)   # how many dots in a row, how many rows of dots",
        ),
        code=f"inner_corners = ({columns}, {rows})",
        reason="A row of n squares has n − 1 places between them.",
        reference=(columns, rows),
    )  # fmt: skip


def _lines():
    return dict(
        asks="What does a lens do to the shape of a straight line near the rim of the picture?",
        answer=Choice(
            "bends it",
            (
                Wrong(
                    "moves it",
                    "its points do move. But a line that is moved alone stays straight: lay a ruler along the solid line at the rim.",
                ),
                Wrong("nothing", "compare the two grids at the rim: by how many pixels do they part?"),
                Wrong("blurs it", "that is focus. The lens is sharp, and still in the wrong place."),
            ),
            "and that is why no straight formula fits raw pixels.",
            also=(
                "bent",
                "bend",
                "it gets bent",
                "it is bent",
                "curves it",
                "curved",
                "it gets curved",
                "distorts it",
                "it distorts it",
            ),
            same=(
                (
                    f"{MOVES},? and (it )?({CURVED})( it)?|({CURVED})( (it|the line))?,? and (it )?(also )?{MOVES}",
                    "bends it",
                ),
                (
                    "(and |but )?the middle( lines?)? (stays?|is|remains?|keeps?) (nearly |almost |quite )?(straight|as it is)",
                    "",
                ),
                (
                    f"^(?!.*\\b(and|or|not|no|never|only|without|straight(?! line))\\b).*({CURVED}|{MAKES_ROUND}).*$|^(a )?round$|.*(not|no longer|no more|hardly|never|stops?) ((stay|keep|remain|leave|look|run|be|being|it|the line|a line|quite|really|exactly|all) ){{0,3}}straight.*",
                    "bends it",
                ),
                ("(shifts?|displaces?|move|pushes|pulls|moved|shifted)( (it|the line))?", "moves it"),
                ("(makes )?(it )?(blurry|blurred|unsharp|out of focus|fuzzy|smeared|smears)( it)?", "blurs it"),
                ("(does )?nothing( at all)?|no change|(it )?stays( the same| straight)?", "nothing"),
            ),
            not_meant=(
                (
                    f".*{CURVED}( (only|more|most))? the (line in the )?(middle|cent(er|re))\\b(?! of the line).*|.*the middle lines? ((is|are|gets?) )?{CURVED}.*"
                    "|.*(only|more|most) (in|at|near) the (middle|cent(er|re))\\b.*|.*not (at |near )?the rim.*",
                    "lines through the middle stay nearly straight. Look at the rim, where the two grids part most.",
                ),
                (
                    f".*(straightens|unbend|{CURVED} (it|the line|lines)( back| in)?( to)? straight|(less|hardly|barely) {CURVED}|(prevent|stop|keep)s? .*from {CURVED}).*",
                    "a pinhole keeps it straight. Follow the solid line near the rim: does the lens?",
                ),
                (
                    "((the|a) )?lens (itself )?(is|has) .*",
                    "that is the lens itself. Follow the solid line near the rim: which shape has it?",
                ),
            ),
            beside=(
                (
                    ".*colou?r.*",
                    "some lenses do that a little, too. Follow the solid line near the rim: which shape has it?",
                ),
                (".*straight.*", "a pinhole keeps it straight. Follow the solid line near the rim: does the lens?"),
                (
                    ".*(magnif|enlarg|zoom|turn|rotat|tilt|stretch|scal|shrink|long|short|thick|thin|wide|bigger|smaller|larger|flip|mirror).*",
                    "turned or stretched, a straight line stays straight. Follow one at the rim with a finger: is it straight?",
                ),
                (
                    ".*(break|cut|split|double|vanish|disappear).*",
                    "it is still one line. Follow it at the rim with a finger: is it straight?",
                ),
            ),
        ),
        hints=(
            "Look at the corners of the grid, not at its middle.",
            "Follow one line of the solid grid with a finger. Is it straight?",
            'a_lens = "____"   # bends it, moves it, blurs it or nothing',
        ),
        code='a_lens = "bends it"',
        reason="The farther from the middle, the more the lens pulls a point in or out.",
        reference="bends it",
    )


def _unseen():
    return dict(
        asks="The error on pairs that were used is small. What shows that the calibration is good?",
        answer=Choice(
            "unseen pairs",
            (
                Wrong(
                    "the same pairs",
                    "a fit always looks good on what it was fitted on. So does a pupil who is asked what stood in the book.",
                ),
                Wrong("more decimals", "decimals are printed, not earned."),
            ),
            "what the fit has not seen cannot flatter it.",
            also=("unseen ones", "unseen pair", "new pairs", "other pairs", "others"),
            same=(
                ("((taken|shot|made) )?(of|from|with|by) the same (board|chessboard|rig|bench|camera)s?", ""),
                (
                    f"((the |some )?(ones|pairs|pictures|boards|images|data|those) )?(which |that )?((it|the fit|the calibration) )?((were|was|are|have|has|had|is|did|does|do|could) )?(not|never) (been )?(use|used|see|saw|seen|know|knew|known|met|fitted|(part of|in|from) {OF_THE_FIT}|(calibrated|train|trained|fitted) (on|with))( before| yet)?( pairs)?|((the |some )?(ones|pairs|pictures|boards|images|data|those) )?((which|that) (are|were) )?(from )?outside (of )?{OF_THE_FIT}|(pairs|pictures|boards|images|ones|data) (that )?(nobody|no one) (has )?(used|seen|saw|knew)",
                    "unseen pairs",
                ),
                (
                    f"(more )?(un|un-|non-|non |not )seen {PICTURES}|({NEW}|test) (set of )?{PICTURES}( than [^,;]+)?|^((the|by|on) )*{NEW}$|(pairs|pictures|boards|images|ones|data) (that (are|were) )?(kept|held|put|left) (back|out|aside|apart)",
                    "unseen pairs",
                ),
                (
                    "((the )?(ones|pairs|pictures|boards|images|data|those) )(which |that )?(it|the fit|the calibration) (already )?(has |had )?(knows|knew|saw|seen|used|uses|known)|(used|seen|known|old|fitted|these|own|all)( (pairs|ones|pictures))?|(the )?pairs (of|from) the fit|(the )?pairs that were used",
                    "the same pairs",
                ),
                (
                    "(more|many|unseen|new|other|different) (digits|places|figures|decimals)|accuracy|precision",
                    "more decimals",
                ),
            ),
            beside=(
                (
                    f"(the )?(left|right).*|(the )?(worst|best|last|first) .*|((the|a|an) )?({NEW} )?(board|chessboard|camera|lens|ruler|corner|number|calibration|test|median|focal length|baseline|distortion).*",
                    "on which pairs is the error to be looked at: on those of the fit, or on others?",
                ),
                (
                    ".*(more|many|most|enough|fewer|less|number of|one|two|three|four|five|ten|twenty|\\d) ?(pairs|pictures|boards|images)?.*",
                    "more pairs make a better fit. But on which pairs does one see that it is better?",
                ),
                (
                    ".*(error|rms|median|mean|residual|px|pixel|small|low).*",
                    "a small error, yes. But an error on which pairs: those that it was fitted on, or others?",
                ),
                (
                    "(the )?(other )?(pair|picture|image)s?( of (the|a) pair)?",
                    "which pairs: those that it was fitted on, or others?",
                ),
            ),
        ),
        hints=(
            "How would you find out whether somebody has learned a poem or read it off?",
            "Keep some pairs back. Fit without them, then measure on them.",
            'judge_by = "____ pairs"',
        ),
        code='judge_by = "unseen pairs"',
        reason="Errors on the pairs of the fit shrink with every free number; errors on others do not.",
        reference="unseen pairs",
    )


def _baseline(translation, baseline, focal):
    return dict(
        asks="How far apart are the two cameras, in mm?",
        answer=Number(
            baseline, 0.06, "mm",
            (
                Wrong(float(translation[0]), "T[0] is the step to the side alone, with its sign. A distance is above zero and counts all three."),
                Wrong(
                    abs(float(translation[0])),
                    "T[0] is the step to the side alone. On this rig it is nearly all, on another it is not: take all three.",
                    exact=True,
                ),
                Wrong(float(np.hypot(*translation[:2])), "those are two of the three steps. Take all three.", exact=True),
                Wrong(float(np.hypot(*translation[::2])), "those are two of the three steps. Take all three.", exact=True),
                Wrong(float(np.abs(translation).sum()), "you added the three steps. The straight distance is Pythagoras in space."),
                Wrong(baseline / 1000, "that is in metres. This kit counts in millimetres."),
                Wrong(float(baseline**2), "the square root is missing."),
                Wrong(float(baseline**2) / 2, "**1/2 is first **1 and then half of it. A root is **0.5 or **(1/2)."),
                Wrong(float(translation.sum()), "the sum of the three steps, signs and all, is no length. Pythagoras in space: squares, sum, root."),
                Wrong(float(translation.mean()), "the mean of the three steps is no length. Pythagoras in space: squares, sum, root."),
                Wrong(float(baseline / np.sqrt(3)), "that is the root of the mean of the squares. A length is the root of their sum."),
                Wrong(baseline / 2, "that is half of the way."),
                Wrong(float(np.abs(translation).mean()), "that is the mean of the three steps. The straight distance is Pythagoras in space."),
                Wrong(float(np.std(translation)), "np.std tells how the three numbers spread. A length is the root of the sum of their squares."),
                Wrong(float(np.sqrt(np.abs(translation).sum())), "a root, but of the steps as they are. Square each of them first."),
                Wrong(float(np.prod(translation)), "you multiplied the three steps. Pythagoras in space: squares, sum, root."),
                Wrong(focal, "that is the focal length, in px. T holds the way from lens to lens."),
                Wrong(float(translation[1]), "that is the step down alone. Take all three."),
                Wrong(float(translation[2]), "that is the step ahead alone. Take all three."),
            ),
            f"{baseline:.1f} mm from lens to lens, measured with a sheet of paper.",
            of_several="T has three steps, right, down and ahead. How long is the way as a whole?",
            known={f"T[{k}]": float(step) for k, step in enumerate(translation)},
            small="shorter than the step to the side alone. Are these the angles, or another step?",
            ask="A length is the root of the sum of the squares.",
        ),
        hints=(
            "T is the way from one camera to the other: three numbers in mm.",
            "The length of a vector: root of the sum of the squares, np.linalg.norm.",
            "baseline = np.linalg.norm(____)",
        ),
        code="baseline = np.linalg.norm(T)",
        reason="The baseline is the length of T.",
        reference=baseline,
    )  # fmt: skip


def _worth(baseline, focal):
    tries = ((1000.0, focal, baseline, 0.5), (2000.0, focal, baseline, 0.5), (700.0, 900.0, 60.0, 0.2))
    return dict(
        asks="Write what an error of some px in the columns means in mm of depth.",
        answer=Function(
            depth_error, tries, 0.01, "mm",
            (
                Wrong(lambda z, f, b, e: z**2 / f * b * e, "brackets are missing under the line: / (focal_px * baseline_mm)."),
                Wrong(lambda z, f, b, e: z * 2 / (f * b) * e, "that is twice Z. Squared is **2."),
                Wrong(lambda z, f, b, e: z**2 / f / b * e**2, "the error counts once, not squared."),
                Wrong(lambda z, f, b, e: f * b / z**2 * e, "upside down: Z² belongs above the line, f·B below it."),
                Wrong(lambda z, f, b, e: z**2 * f * b * e, "f and B belong below the line: a long lens and a wide baseline make the error small."),
                Wrong(lambda z, f, b, e: z**2 // (f * b) * e, "// throws the decimals away. Divide by a single /."),
                Wrong(lambda z, f, b, e: z**2 / (f * b * e), "the error belongs above the line: a larger one costs more."),
                Wrong(lambda z, f, b, e: z / f * e, "that is the error to the side. In depth a pixel is worth Z²/(f·B)."),
                Wrong(lambda z, f, b, e: z / (f * b) * e, "Z counts twice: once for how small things look, once for how flat the angle is."),
                Wrong(lambda z, f, b, e: z**2 / (f * b), "that is for one whole pixel. Multiply by the error."),
            ),
            "at twice the distance it is four times as much.",
        ),
        hints=(
            "The formula stands above the cell.",
            "Z squared, over f times B, times the error in px.",
            "return z_mm**2 / (____) * error_px",
        ),
        code="def depth_error(z_mm, focal_px, baseline_mm, error_px):\n    return z_mm**2 / (focal_px * baseline_mm) * error_px",
        reason="Lesson 04 derives it: the slope of Z = B·f/d.",
        reference=depth_error,
    )  # fmt: skip


def project(
    point_mm: tuple[float, float, float], focal_px: float, center_px: tuple[float, float]
) -> tuple[float, float]:
    """A point in the camera's frame to (u, v), px."""
    x, y, z = point_mm
    return focal_px * x / z + center_px[0], focal_px * y / z + center_px[1]


def depth_error(z_mm: float, focal_px: float, baseline_mm: float, error_px: float) -> float:
    """Millimetres of depth for an error in px."""
    return z_mm**2 / (focal_px * baseline_mm) * error_px


@lru_cache(maxsize=4)
def _facts(path):
    calibration = calibrate_recording(open_recording(path))
    return calibration.translation_mm, calibration.baseline_mm, calibration.focal_px
