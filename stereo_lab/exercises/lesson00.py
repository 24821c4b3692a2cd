"""Questions of lesson 00: a first pair, a first place."""

from __future__ import annotations

import math
from functools import lru_cache

from stereo_lab.detection import Detection
from stereo_lab.exercises.answers import Choice, Function, Number, Wrong
from stereo_lab.exercises.question import Question, lesson
from stereo_lab.localization import Localizer
from stereo_lab.recording import Position, Recording, open_recording

TRIES = (
    (Position(0.0, 0.0, 0.0), Position(3.0, 4.0, 0.0)),
    (Position(10.0, -20.0, 1000.0), Position(12.0, -14.0, 1003.0)),
    (Position(5.0, 5.0, -30.0), Position(7.5, 1.0, 41.0)),
)
# Words of the question that an answer may repeat
THE_BALL, PICTURE = (
    "(the ball |it )?(is )?(farther |further |more )?(to the )?left in (the )?",
    "( (hand )?(one|picture|image|camera))?",
)
SIDE_BY_SIDE = (
    "the two cameras stand side by side, so each sees the ball at another place. "
    "In which picture is it nearer to the left edge?"
)
NEAR_YOUR_NOSE = "try it with a finger: near your nose it jumps far, at arm's length only a little."
# Growing beside a ball that goes away; and the ball's coming told as a distance that gets less
WITH_DISTANCE = (
    r"(?!.*(decreas|reduc|invers|shrink|short|small|little|less|near|close|closing|falls|drops|hardly|\bnot\b))"
    r".*(grow|increas|ris(es|ing)|larger|bigger|greater|more|wider|longer|higher|\bup\b)"
    r".*(distance|depth|(?<!jumps )(?<!moves )\b(farther|further|far)\b|away|stretch|\barm\b.*long).*"
)
# Something else than the jump is said to grow
ANOTHER_GROWS = (
    "(?!.*jump)(the |its )?(ball|finger|wall|distance|depth|error|time|size|radius|diameter|picture|speed)( of the ball| to the cameras?)?( itself)?"
    " ((grow|increas|rise|enlarge)[a-z]*|(gets?|becomes?|is) (larger|bigger|greater|longer|more|higher))( .*)?|.*jumps? (farther|further) away"
)
LESS_DISTANCE = (
    "(as|when|if|while|because|since) (the |its )?(distance|depth) (is |gets |becomes )?(decreas(es|ing)|shrinks|shrinking|falls|drops|smaller|shorter|less)"
    "|with (a )?(less|smaller|shorter|decreasing|shrinking) (distance|depth)"
)
# What "farther left" says of the ball, beside the picture that is named
FARTHER_LEFT = "(farther|further|more) (to the )?left|(it|the ball) (moves|jumps|goes|shifts) (to the )?left"
THERE_FIRST = rf"(the ball )?(in )?(the )?{{}}{PICTURE},? (it )?is (farther |further |more )?(to the )?left( there)?"


def questions(recording: Recording, balls: tuple[Detection, Detection] | None = None) -> tuple[Question, ...]:
    """Five questions; see :mod:`stereo_lab.exercises`. ``balls`` are those of the learner's two pictures, where not of the recording."""
    width, height = recording.image_size
    left, right = balls or _first_ball(str(recording.path))
    jump = left.u - right.u
    return lesson(
        "00",
        dict(
            asks="In which picture is the ball farther to the left?",
            answer=Choice(
                "right",
                (Wrong("left", "hold a finger up and close one eye, then the other: the right eye sees it farther left."),),
                "the right camera stands farther right, so the ball moves to the left in its picture.",
                same=(
                    (rf"{THE_BALL}right{PICTURE}", "right"), (rf"{THE_BALL}left{PICTURE}", "left"),
                    (THERE_FIRST.format("right"), "right"), (THERE_FIRST.format("left"), "left"),
                    (FARTHER_LEFT, ""), ("second|r|right-?hand", "right"), ("first|l|left-?hand", "left"),
                ),
                not_meant=(
                    ("(it is |the ball is )?right in the (middle|centre|center)", SIDE_BY_SIDE),
                    ("(the ball is|(the ball|it) (is|stands|lies) (farther |further |more )?(on|to) the) right( side)?", "that is where the ball is. In which of the two pictures is it farther to the left?"),
                ),
                beside=((".*(both|same|equal|neither|none|no difference|middle).*", SIDE_BY_SIDE),),
            ),
            hints=(
                "Compare the ball with the edge of each picture.",
                "The right camera stands to the right of the left one. What does that do to everything it sees?",
                'One of the two words, in quotes:\n    farther_left_in = "____"',
            ),
            code='farther_left_in = "right"',
            reason="Move to the right, and everything in front of you moves to the left.",
            reference="right",
        ),
        dict(
            asks="How many pixels wide is the picture?",
            answer=Number(
                width, 0, "px",
                (
                    Wrong(height, f"{height} is the number of rows, so the height. shape tells rows first, then columns."),
                    Wrong(height / width, "you divided: that is the shape of the picture. Take one of the numbers of left.shape."),
                    Wrong(width * height, "that is the number of all pixels. Only those side by side in one row are asked for."),
                    Wrong(3 * width * height, "that is how many numbers the picture has in all. left.shape has three: take one of them."),
                    Wrong(width - 1, "that is the number of the last column; they are counted from 0. How many are there?"),
                    Wrong(1, "that is the place of a number; the number that stands there is asked for: left.shape[…]."),
                    Wrong(0, "that is the place of a number; the number that stands there is asked for: left.shape[…]."),
                    Wrong(2, "that is the place of a number; the number that stands there is asked for: left.shape[…]."),
                    Wrong(width + 1, "one too many: the columns are numbered from 0, and the last number is one less than there are."),
                    Wrong(height / 2, "that is half the number of rows. Take one of the three numbers of left.shape, as it stands."),
                    Wrong(width - 3, "the colours are not taken off. Take one of the three numbers of left.shape, as it stands."),
                    Wrong(width + height, "you added rows and columns. Only the columns are asked for."),
                    Wrong(3 * width, "that is how many numbers a row has: three colours for each pixel. How many pixels are in it?"),
                    Wrong(3 * height, "rows times colours. Only the columns are asked for: one of the three numbers of left.shape."),
                    Wrong(3, "3 is the number of colour values of a pixel: blue, green and red. The width comes before it."),
                ),
                f"{width} columns of pixels, numbered 0 to {width - 1}.",
                of_several="Take one of them: left.shape[0], left.shape[1] or left.shape[2].",
                small="it is none of the numbers of left.shape. Take one of them, as left.shape[…].",
                large="it is none of the numbers of left.shape. Take one of them, as left.shape[…].",
                beside=((r"(?!.*\b(wide|width|columns?)\b).*\b(rows?|high|height|tall)\b.*", "rows count how high the picture is. The width is the number of its columns."),),
            ),
            hints=(
                "Look at the three numbers that left.shape gives.",
                "They are rows, columns, colours. The width is the number of columns.",
                "width = ____   # left.shape[0], left.shape[1] or left.shape[2]",
            ),
            code="width = left.shape[1]",
            reason="An image is an array of rows; a row is as long as the picture is wide.",
            reference=width,
        ),
        dict(
            asks="By how many pixels does the ball jump, from the left picture to the right one?",
            answer=Number(
                jump, 0.12, "px",  # u is printed to a tenth of a pixel
                (
                    Wrong(-jump, "your jump is below zero: you took the right picture first. Write left minus right."),
                    Wrong(left.v - right.v, "that is the jump in v, up and down. The cameras stand side by side: take u."),
                    Wrong(left.u, "that is u in the left picture alone. Take the other one away from it."),
                    Wrong(right.u, "that is u in the right picture alone. Take it away from the other one."),
                    Wrong(left.u + right.u, "you added the two. How far apart are they?"),
                    Wrong((left.u + right.u) / 2, "that is the middle between the two. How far apart are they?"),
                    Wrong(left.u / right.u, "you divided. How many pixels lie between the two?"),
                    Wrong(
                        math.hypot(jump, left.v - right.v),
                        "that is the way with its part up and down. The jump is to the side alone: take u.",
                        exact=True,
                    ),
                    Wrong(left.radius_px, "that is the ball's radius in the picture. The jump is how far its centre moves."),
                    Wrong(left.radius_px - right.radius_px, "those are the radii. The jump is how far the centre moves: take u."),
                ),
                f"{jump:.0f} px: this jump is what mainly tells the cameras how far away the ball is.",
                of_several="One number: how far apart are the two?",
                known={
                    **{f"ball_left.{name}": getattr(left, name) for name in ("u", "v", "radius_px")},
                    **{f"ball_right.{name}": getattr(right, name) for name in ("u", "v", "radius_px")},
                },
                ask="The jump is one u less the other u.",
                large="that is more than the two are apart. Is it a sum, or millimetres? The jump is one u less the other u.",
            ),
            hints=(
                "Each detection has u, the distance from the left edge in pixels.",
                "The jump is one u less the other u. It should be above zero.",
                "jump_px = ball_left.u - ____",
            ),
            code="jump_px = ball_left.u - ball_right.u",
            reason="Left minus right is above zero for everything in front of the cameras.",
            reference=jump,
        ),
        dict(
            asks="The ball comes nearer to the cameras. What does its jump do?",
            answer=Choice(
                "grows",
                (
                    Wrong("shrinks", NEAR_YOUR_NOSE),
                    Wrong("stays", "then two cameras could not measure depth at all. Try it with a finger."),
                ),
                "near things jump far. Lesson 04 turns that into millimetres.",
                same=(
                    (LESS_DISTANCE, ""), ("stops? growing|no longer grows?", "stays"),
                    ("(gets|becomes|is|it's)? ?(larger|bigger|more|greater|wider|longer|higher)( jump| jumps)?", "grows"),
                    ("increas(es|ing|e)|enlarges?|ris(es|e|ing)|(goes |moves )?up|jumps farther|expands", "grows"),
                    ("(gets|becomes|grows|is|it's)? ?(smaller|less|lower|shorter|narrower)( jump| jumps)?", "shrinks"),
                    ("decreas(es|ing|e)|falls|fall|drops|(goes |moves )?down|sinks", "shrinks"),
                    ("(stays |is )?(the )?same|constant|(does not|doesn't|no) change|unchanged|nothing|equal", "stays"),
                ),
                not_meant=(
                    (WITH_DISTANCE, NEAR_YOUR_NOSE),
                    (ANOTHER_GROWS, "that is not the jump. The ball comes nearer: does the number of pixels that it jumps by grow, shrink or stay?"),
                ),
                beside=(
                    (".*(zero|vanish|disappear|nothing).*", "only what is very far away stands still. Hold the finger near: does it jump more, or less?"),
                    ("(it |the ball )?(jumps?|moves?|chang(es|e|ing)).*", "it does. Does the jump grow, shrink or stay, when the ball comes nearer?"),
                    (".*(turn|revers|opposite|other way).*", "the direction stays: in the right picture it is always farther left. Does the jump grow or shrink?"),
                    (".*(near|close|far)[a-z]*", "that is what the ball does. What does its jump do: grow, shrink or stay?"),
                    (
                        ".*(doubl|twice|halv|half|quarter|square).*",
                        "by how much depends on how much nearer it comes. Only the direction is asked for: grows, shrinks or stays?",
                    ),
                    (".*(finger|ball|wall|eye|hand|camera).*", "what it is that jumps is known. Does its jump grow, shrink or stay?"),
                    (".*(left|right).*", "where to is another question. Does the jump, the number of pixels, grow, shrink or stay?"),
                ),
            ),
            hints=(
                "You carry two cameras with you: your eyes.",
                "Close one eye, then the other, with a finger near your nose and at arm's length.",
                'nearer_means = "____"   # grows, shrinks or stays',
            ),
            code='nearer_means = "grows"',
            reason="Seen from the ball, the two cameras stand under a wide angle when it is near, and under a narrow one when it is far.",
            reference="grows",
        ),
        dict(
            asks="Write the distance between two places in millimetres.",
            answer=Function(
                distance_mm, TRIES, 0.01, "mm",
                (
                    Wrong(lambda a, b: sum(s * s for s in _steps(a, b)) / 2, "**1/2 is first **1 and then half of it. A root is **0.5 or **(1/2)."),
                    Wrong(lambda a, b: math.hypot(a.x_mm + b.x_mm, a.y_mm + b.y_mm, a.depth_mm + b.depth_mm), "a step is what one has less than the other: minus, not plus."),
                    Wrong(lambda a, b: a.x_mm - b.x_mm + a.y_mm - b.y_mm + a.depth_mm - b.depth_mm, "you add the three steps, and those below zero eat up the others. The straight way: Pythagoras."),
                    Wrong(lambda a, b: _length(a) - _length(b), "those are the distances of the two places from (0, 0, 0). Take the three steps first, then the root."),
                    Wrong(lambda a, b: abs(_length(a) - _length(b)), "those are the distances of the two places from (0, 0, 0). Take the three steps first, then the root."),
                    Wrong(lambda a, b: math.hypot(a.x_mm - b.x_mm, a.y_mm - b.y_mm, a.depth_mm), "the third step is a depth less the other depth."),
                    Wrong(lambda a, b: sum(_steps(a, b)) / 3, "that is the mean of the three steps. The straight way: Pythagoras."),
                    Wrong(lambda a, b: _length(a) + _length(b), "those are the distances of the two places from (0, 0, 0), added. Take the three steps first, then the root."),
                    Wrong(lambda a, b: max(_steps(a, b)), "that is the longest of the three steps; the others count as well."),
                    Wrong(lambda a, b: math.sqrt(sum(_steps(a, b))), "a root, but of the steps as they are. Square each step first."),
                    Wrong(lambda a, b: sum(_signed(a, b)) ** 2, "you square the sum. Square each step alone, then add, then take the root."),
                    Wrong(lambda a, b: abs(sum(_signed(a, b))), "you add the steps before you square them, and those below zero eat up the others. Square each step alone."),
                    Wrong(lambda a, b: sum(_signed(a, b)) / 3, "that is the mean of the three steps, signs and all. The straight way: Pythagoras."),
                    Wrong(lambda a, b: math.prod(_signed(a, b)), "you multiply the three steps. Pythagoras adds their squares, and takes the root."),
                    Wrong(lambda a, b: math.hypot(*_steps(a, b)[:2]) + abs(_signed(a, b)[2]), "hypot takes x and y alone here, and the depth is added after it. All three steps belong into its brackets."),
                    Wrong(lambda a, b: math.hypot(*_steps(a, b)[:2]) + _signed(a, b)[2], "hypot takes x and y alone here, and the depth is added after it. All three steps belong into its brackets."),
                    Wrong(lambda a, b: math.hypot(*_all_six(a, b)), "a comma stands where a minus should: hypot takes three steps, each one number less another."),
                    Wrong(lambda a, b: math.sqrt(abs(_length(a) ** 2 - _length(b) ** 2)), "you square each number and then subtract. First subtract, then square: (a.x_mm - b.x_mm)**2."),
                    Wrong(lambda a, b: math.hypot(a.x_mm - b.y_mm, a.y_mm - b.x_mm, a.depth_mm - b.depth_mm), "x and y are crossed: each step goes from one x to the other x, from one y to the other y."),
                    Wrong(lambda a, b: sum(s * s for s in _steps(a, b)) ** (1 / 3), "there are three steps, and still it is a square root: Pythagoras in space."),
                    Wrong(lambda a, b: math.hypot(a.x_mm, b.x_mm) + math.hypot(a.y_mm, b.y_mm) + math.hypot(a.depth_mm, b.depth_mm), "hypot gets two numbers that are no steps. Give it the three steps, each one number less another."),
                    Wrong(lambda a, b: math.hypot(*(s * s for s in _steps(a, b))), "hypot squares the steps itself: give it the steps as they are."),
                    Wrong(lambda a, b: max(_signed(a, b)), "that is the largest of the three steps, signs and all; the others count as well."),
                    Wrong(lambda a, b: a.x_mm * b.x_mm + a.y_mm * b.y_mm + a.depth_mm * b.depth_mm, "those are products. A step is what one number has less than another: minus."),
                    Wrong(lambda a, b: math.hypot(*_steps(a, b)) / 1000, "that is in metres."),
                    Wrong(lambda a, b: sum(_steps(a, b)), "you add the three steps. The straight way is shorter: Pythagoras."),
                    Wrong(
                        lambda a, b: sum(s * s for s in _steps(a, b)),
                        "the square root is missing: your result is in square millimetres.",
                    ),
                    Wrong(
                        lambda a, b: math.hypot(*_steps(a, b)[:2]),
                        "right in the plane, but depth is left out: add the third step.",
                    ),
                ),
                "this is how far the answer is off, in all three directions together.",
                also=(lambda a, b: math.dist((a.x_mm, a.y_mm, a.depth_mm), (b.x_mm, b.y_mm, b.depth_mm)),),
            ),
            hints=(
                "There are three steps: along x, along y, along depth.",
                "Pythagoras works in space too: the root of the sum of the three squares. math.hypot does that.",
                "return math.hypot(a.x_mm - b.x_mm, ____, ____)",
            ),
            code=(
                "import math\n\n\ndef distance_mm(a, b):\n"
                "    return math.hypot(a.x_mm - b.x_mm, a.y_mm - b.y_mm, a.depth_mm - b.depth_mm)"
            ),
            reason="The straight line between two points is the root of the sum of the squared steps.",
            reference=distance_mm,
        ),
    )  # fmt: skip


def distance_mm(a: Position, b: Position) -> float:
    """Distance between two Positions, mm."""
    return math.hypot(a.x_mm - b.x_mm, a.y_mm - b.y_mm, a.depth_mm - b.depth_mm)


def _length(a):
    return math.hypot(a.x_mm, a.y_mm, a.depth_mm)


def _signed(a, b):
    return a.x_mm - b.x_mm, a.y_mm - b.y_mm, a.depth_mm - b.depth_mm


def _all_six(a, b):
    return a.x_mm, a.y_mm, a.depth_mm, b.x_mm, b.y_mm, b.depth_mm


def _steps(a, b):
    return abs(a.x_mm - b.x_mm), abs(a.y_mm - b.y_mm), abs(a.depth_mm - b.depth_mm)


@lru_cache(maxsize=4)
def _first_ball(path):
    """The two detections of the ball in the first pair in which both cameras see it."""
    recording = open_recording(path)
    judges = recording.judges()
    localizer = Localizer.fit(recording, leave_out=judges)
    return next(found for s in judges if (found := localizer.detect(s.pair.left, s.pair.right)) is not None)
