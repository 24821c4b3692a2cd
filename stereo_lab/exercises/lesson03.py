"""Questions of lesson 03: from pixels to x and y on the bench."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from stereo_lab.exercises.answers import Choice, Function, Number, Wrong
from stereo_lab.exercises.question import Question, lesson
from stereo_lab.localization import Localizer
from stereo_lab.recording import Recording, open_recording

POINTS = (np.array([100.0, 200.0, 300.0, 450.0]), np.array([40.0, -10.0, -55.0, -130.0]))
MORE = (np.array([10.0, 20.0, 40.0]), np.array([1.0, 4.0, 9.0]))

RAYS_SPREAD = "the other way round: the rays spread. Far away, one pixel covers more millimetres."


def questions(recording: Recording) -> tuple[Question, ...]:
    """Six questions; see :mod:`stereo_lab.exercises`."""
    (v0, y0), (v1, y1), lines, focal, center = _facts(str(recording.path))
    slope, offset, slope_of_y = lines
    tries = (
        (center + 100.0, 1000.0, focal, center),
        (center - 50.0, 2000.0, focal, center),
        (437.0, 850.0, 500.0, 310.0),  # another camera, for an answer with this one's numbers in it
    )
    return lesson(
        "03",
        _sign(),
        _slope(v0, y0, v1, y1),
        _least_squares(),
        _finer_pixels(slope, offset, slope_of_y),
        _twice_as_far(),
        _perspective(tries),
    )


def _sign():
    return dict(
        asks="Is the slope m of Eq. 1 above or below zero?",
        answer=Choice(
            "below",
            (
                Wrong("above", "then the ball would rise in the picture's rows when it rises on the bench. v counts from the top."),
                Wrong("zero", "then y would be the same wherever the ball stands in the picture."),
            ),
            "v grows downwards in a picture, y grows upwards on the bench.",
            same=(
                ("row (0|zero)", ""),  # a reason, and no slope
                ("(less|smaller|lower) than (zero|0)|(under|below|beneath) (zero|0)|sub[ -]?zero|^(under|beneath)$|negative|minus|(m ?)?<=? ?(0|zero)|(0|zero) ?>=? ?m", "below"),
                ("(more|larger|bigger|greater|higher) than (zero|0)|(over|above) (zero|0)|^over$|positive|plus|(m ?)?>=? ?(0|zero)|(0|zero) ?<=? ?m", "above"),
                ("(0|zero) ?=+ ?m|0|(m ?)?=+ ?(0|zero)|flat|level|neither", "zero"),
            ),
            not_meant=(
                (r".*\bnon-? ?(negative|positive|zero).*|minus minus", "say it straight: is m above zero, below zero, or zero itself?"),
                (r"((it|m|the slope) is )?(below|under|above|over) ((minus )?(one|two|[1-9][\d.]*)|the (?!zero|0).*|average|ground|[xyuv])", "compare it with zero: is m a number above zero, or below?"),
            ),
            beside=(
                ("(it |that )?(depends|varies|changes).*", "a straight line has one slope, everywhere. Look at the table: v grows, and y?"),
                ("(very )?(steep|flat|long|short|big|large|small)|gentle", "how steep it is, is not asked for. Is it above or below zero?"),
                ("larger|smaller|bigger|greater|lower|higher|less|more", "than zero? That is above, or below: write the word."),
                ("one|two|three", "its size is not asked for. Is it above or below zero?"),
                ("[+]", "the sign of a number above zero. Think again which way y goes when v grows, and write the word."),
                ("-.*", "a number with a minus is on one side of zero: above, or below? Write the word."),
                (".*\\d.*", "on which side of zero is that number: above, or below? Write the word."),
                ("(.* )?(down(wards)?|up(wards)?|falls|falling|rises|rising)", "that is which way the line goes. Is its slope a number above zero, or below?"),
                ("m|the slope|slope", "that is its name. Is it above or below zero?"),
            ),
        ),
        hints=(
            "Where is row 0 of a picture?",
            "The ball goes up: what does v do, and what does y do?",
            'slope_is = "____"   # above, below or zero',
        ),
        code='slope_is = "below"',
        reason="v counts rows from the top, y counts millimetres from the bench upwards: they run against each other.",
        reference="below",
    )  # fmt: skip


def _slope(v0, y0, v1, y1):
    right = (y1 - y0) / (v1 - v0)
    return dict(
        asks="What is the slope through the highest and the lowest sample, in mm per px?",
        answer=Number(
            right, 0.01 * abs(right), "mm per px",
            (
                Wrong(y0 - right * v0, "that is the offset c, the y of row 0. The slope is one step over the other."),
                Wrong(y1 - y0 / v1 - v0, "brackets are missing: Python divides before it takes away. (… - …) / (… - …)"),
                Wrong((y1 - y0) / v1 - v0, "brackets are missing below the line: / (v1 - v0)."),
                Wrong(y0 - y1 / v0 - v1, "brackets are missing: Python divides before it takes away. (… - …) / (… - …)"),
                Wrong((y0 - y1) / v0 - v1, "brackets are missing below the line: / (v0 - v1)."),
                Wrong(y0 - y1 / (v0 - v1), "brackets are missing above the line: (y0 - y1) / …"),
                Wrong(y0 / v0 - y1 / v1, "first the two steps, then one divided by the other: (y1 - y0) / …"),
                Wrong(y1 / v1 - y0 / v0, "first the two steps, then one divided by the other: (y1 - y0) / …"),
                Wrong(y1 - y0 / (v1 - v0), "brackets are missing above the line: (y1 - y0) / …"),
                Wrong(-right, "the sign is turned: one row down is less y, so the slope is below zero. Take the same order above and below the line, and no abs."),
                Wrong(1 / right, "that is px per mm. Millimetres belong above the line, pixels below."),
                Wrong(math.hypot(v1 - v0, y1 - y0), "Pythagoras has no place here: mm and px do not add up. The slope is the one step over the other."),
                Wrong((-y1 - y0) / (v1 - v0), "the sign of y1 is turned: where it is below zero, the way from y0 to it is the longer one."),
                Wrong(y1 - y0, "that is the step in y alone. Divide it by the step in v."),
                Wrong(v1 - v0, "that is the step in v alone. It belongs below the line, the step in y above it."),
                Wrong(y1 / v1, "that is one sample alone, as a line through (0, 0). Take the steps from one to the other."),
                Wrong(y0 / v0, "that is one sample alone, as a line through (0, 0). Take the steps from one to the other."),
                Wrong((y0 / v0 + y1 / v1) / 2, "those are two lines through (0, 0). Take the steps from one sample to the other."),
                Wrong((y1 + y0) / (v1 + v0), "you added. A step is what one has less than the other: minus."),
                Wrong((y1 - v1) / (y0 - v0), "y with y, v with v: the step in y above the line, the step in v below it."),
                Wrong((y1 - y0) // (v1 - v0), "// throws the decimals away. Divide by a single /."),
                Wrong(math.atan2(y1 - y0, v1 - v0), "that is an angle. The slope is the one step over the other."),
                Wrong(math.atan((y1 - y0) / (v1 - v0)), "that is an angle. The slope is the one step over the other."),
                Wrong(math.degrees(math.atan((y1 - y0) / (v1 - v0))), "that is an angle. The slope is the one step over the other."),
            ),
            f"one row down is {-right:.1f} mm down on the bench.",
            known={"y0": y0, "y1": y1, "v0": v0, "v1": v1},
            ask="The step in y belongs above the line, the step in v below it, both from the same sample to the other.",
        ),
        hints=(
            "Two samples: (v0, y0) and (v1, y1).",
            "The slope is the step in y over the step in v.",
            "slope = (y1 - y0) / (____)",
        ),
        code="slope = (y1 - y0) / (v1 - v0)",
        reason="Slope is rise over run; here millimetres over pixels.",
        reference=right,
    )  # fmt: skip


def _least_squares():
    return dict(
        asks="Write the slope of the least-squares line through many samples.",
        answer=Function(
            line_slope, (POINTS, MORE), 1e-4, "mm per px",
            (
                Wrong(
                    lambda p, q: (q[-1] - q[0]) / (p[-1] - p[0]),
                    "this is the line through the first and the last sample; those between do not count at all.",
                ),
                Wrong(
                    lambda p, q: (p * q).sum() / (p * p).sum(),
                    "this line is forced through the point (0, 0). Take the means away first.",
                ),
                Wrong(_products, "add them up: the fraction has a sum above the line and one below."),
                Wrong(lambda p, q: _products(p, q) / ((p - p.mean()) ** 2).sum(), "above the line a .sum() is missing."),
                Wrong(lambda p, q: _products(p, q) / (p - p.mean()) ** 2, "two times .sum() is missing, above the line and below."),
                Wrong(lambda p, q: _products(p, q).sum(), "that is what stands above the line. Divide it by the sum of the squared pixel steps."),
                Wrong(lambda p, q: ((p - p.mean()) ** 2).sum() / _products(p, q).sum(), "upside down: the pixels alone, squared, belong below the line."),
                Wrong(lambda p, q: _products(p, q).mean() / ((p - p.mean()) ** 2).sum(), "a mean above the line and a sum below it: take the same both times."),
                Wrong(lambda p, q: np.polyfit(p, q, 1), "those are two numbers, slope and offset. The slope is the first one: [0]."),
                Wrong(lambda p, q: (q[1] - q[0]) / (p[1] - p[0]), "that is the line through the first two samples; the others do not count at all."),
                Wrong(lambda p, q: (p - p.mean()).sum() * (q - q.mean()).sum() / ((p - p.mean()) ** 2).sum(), "first multiply, sample by sample, then sum: steps from a mean add up to zero."),
                Wrong(lambda p, q: _products(p, q).sum() / ((p - p.mean()) ** 2).sum() ** 0.5, "no root below the line: there stands the sum of the squared pixel steps itself."),
                Wrong(lambda p, q: _products(p, q).sum() / np.abs(p - p.mean()).sum(), "below the line the pixel steps are squared, not made positive."),
                Wrong(lambda p, q: np.polyfit(p, q, 2)[0], "a 2 fits a parabola, and [0] is its bend. A straight line has 1."),
                Wrong(lambda p, q: np.polyfit(p, q, 1)[1], "that is the offset, where the line meets pixel 0. The slope is [0]."),
                Wrong(lambda p, q: np.cov(p, q)[0, 1] / p.var(), "np.cov divides by one less than there are, .var() by all. Take sums both times."),
                Wrong(lambda p, q: _slopes(p, q).sum(), "a sum of fractions is not the fraction of the sums: .sum() above the line, and once more below it."),
                Wrong(lambda p, q: _slopes(p, q).mean(), "a mean of fractions is not the fraction of the sums: .sum() above the line, and once more below it."),
                Wrong(lambda p, q: q.mean() / p.mean(), "that is the line through (0, 0) and the middle of the samples. Take the steps from the means."),
                Wrong(lambda p, q: _products(p, q).sum() / (p * p).sum(), "below the line, too, the mean is taken away first: (pixels - pixels.mean())**2."),
                Wrong(lambda p, q: ((q - q.mean()) ** 2).sum() / _products(p, q).sum(), "the pixels stand once, the millimetres three times. The products belong above the line, the squared pixel steps below it."),
                Wrong(lambda p, q: (p * q).sum() / ((p - p.mean()) ** 2).sum(), "above the line, too, the means are taken away first."),
                Wrong(lambda p, q: _products(p, -q).sum() / ((p - p.mean()) ** 2).sum(), "the sign is turned."),
                Wrong(lambda p, q: ((p + p.mean()) * (q + q.mean())).sum() / ((p + p.mean()) ** 2).sum(), "the means are taken away: minus, not plus."),
                Wrong(lambda p, q: ((p - q.mean()) * (q - p.mean())).sum() / ((p - p.mean()) ** 2).sum(), "the means are crossed: from the pixels their own mean, from the millimetres theirs."),
                Wrong(lambda p, q: (np.diff(q) / np.diff(p)).mean(), "that is the mean of the slopes from each sample to the next. Take the steps from the means."),
                Wrong(lambda p, q: np.ptp(q) / np.ptp(p), "highest less lowest tells nothing of the sign, nor of the samples between. Take the steps from the means."),
                Wrong(lambda p, q: np.corrcoef(p, q)[0, 1], "that is how well they lie on a line, from -1 to 1. How steep is the line?"),
                Wrong(lambda p, q: q.std() / p.std(), "that is how far the millimetres spread for each pixel of spread. What belongs together, sample by sample, is lost in it."),
                Wrong(lambda p, q: (q - p).mean(), "mm and px are subtracted here. A slope is mm for each px: a fraction."),
                Wrong(lambda p, q: ((q - q.mean()) ** 2).sum() / ((p - p.mean()) ** 2).sum(), "above the line the millimetres stand twice. It is a pixel step times a millimetre step."),
                Wrong(lambda p, q: _products(p, q).mean(), "that is what stands above the line, over the number of samples. Below the line stands the sum of the squared pixel steps."),
                Wrong(lambda p, q: (q / p).mean(), "that is a mean of lines through (0, 0). Take the means away first."),
                Wrong(
                    lambda p, q: ((p - p.mean()) * (q - q.mean())).sum() / ((q - q.mean()) ** 2).sum(),
                    "the pixels belong below the line, squared: you divided by the millimetres.",
                ),
            ),
            "the line with the smallest sum of squared misses.",
            also=(lambda p, q: np.polyfit(p, q, 1)[0],),
            endless="something below a line is zero, or nearly. Steps from a mean add up to zero: square each of them first.",
        ),
        hints=(
            "Take the mean away from the pixels, and from the millimetres.",
            "Sum of (pixel step times millimetre step), over the sum of squared pixel steps.",
            "dp, dq = pixels - pixels.mean(), lengths_mm - lengths_mm.mean()\n    return (dp * dq).sum() / (____).sum()",
        ),
        code=(
            "def line_slope(pixels, lengths_mm):\n"
            "    dp = pixels - pixels.mean()\n"
            "    dq = lengths_mm - lengths_mm.mean()\n"
            "    return (dp * dq).sum() / (dp * dp).sum()"
        ),
        reason="Any other slope makes the sum of the squared misses larger. Try it: a little more, a little less.",
        reference=line_slope,
    )  # fmt: skip


def _twice_as_far():
    return dict(
        asks="The ball stands twice as far away as the plane of the arm, at the same pixel. Its true x is how many times what Eq. 2 says?",
        answer=Number(
            2.0, 0.05, "times",
            (
                Wrong(0.5, RAYS_SPREAD),
                Wrong(1.0, "Eq. 2 says so, because it knows nothing of depth. Look along one ray: where is it at twice the depth?"),
                Wrong(3.0, "twice as far away, not three times. Follow one ray: it goes straight on."),
                Wrong(8.0, "that is how a volume grows. A length grows with the distance itself."),
                Wrong(2**0.5, "no root: a ray goes straight on. At twice the depth, how far to the side is it?"),
                Wrong(1.5, "a ray goes straight on. At one and a half times the depth it would be that; here it is twice the depth."),
                Wrong(0.0, "only a ball right in the middle has x = 0, at any depth. Follow a ray that goes to the side."),
                Wrong(-1.0, "the other side of the middle? A ray goes straight on. At twice the depth, how far to the side is it?"),
                Wrong(0.25, "the other way round, and not squared: a length grows with the distance itself."),
                Wrong(4.0, "areas grow with the square of the distance; a length grows with the distance itself."),
            ),
            "measured from the point the camera looks at: twice as far, twice as wide.",
            beside=(
                ("(is )?divided by (2|two)|twice as (near|close|narrow)", RAYS_SPREAD),
                (r"(2|two)[ -]thirds?|[<>].*", "a ray goes straight on. At twice the depth, how many times as far to the side is it? Write that number."),
                (r"x2|2 ?: ?1|2 to 1|200 ?%", "write as one number how many times it is, without any sign."),
            ),
            small="then the ray would bend to the middle on its way. It goes straight on: how far to the side is it at twice the depth?",
            large="then the ray would bend outwards on its way (and how many times is asked for, not how many mm). It goes straight on: how far to the side is it at twice the depth?",
        ),
        hints=(
            "One pixel is one ray. Follow it away from the camera.",
            "x = (u − c)·Z/f: what does twice Z do?",
            "times = ____   # x is proportional to Z",
        ),
        code="times = 2",
        reason="A ray goes straight on: at twice the depth it is twice as far to the side.",
        reference=2.0,
    )  # fmt: skip


def _perspective(tries):
    return dict(
        asks="Write x in the camera's frame from a column u and a depth Z.",
        answer=Function(
            camera_x, tries, 0.01, "mm",
            (
                Wrong(lambda u, z, f, c: u - c * z / f, "brackets are missing: (u - center_px) first."),
                Wrong(lambda u, z, f, c: u * z / f - c, "the centre is in pixels: take it from u, before the rest."),
                Wrong(lambda u, z, f, c: u * f / z + c, "that is the other way, from mm to pixels (lesson 01). Turn it round: c away first, then times Z, over f."),
                Wrong(lambda u, z, f, c: (u + c) * z / f, "take the centre away from u: minus."),
                Wrong(lambda u, z, f, c: u / f * z + c, "take the centre away from u, first of all: minus, in brackets."),
                Wrong(lambda u, z, f, c: z / (f * (u - c)), "u − c belongs above the line: the farther from the middle, the farther to the side."),
                Wrong(lambda u, z, f, c: z * f / (u - c), "u − c belongs above the line, the focal length below it."),
                Wrong(lambda u, z, f, c: (u - c) + z / f, "a slope times a depth is a length: times, not plus."),
                Wrong(lambda u, z, f, c: (u * f - c) / z, "that is the other way, from mm to pixels, and the centre goes away first. Then times Z, over f."),
                Wrong(lambda u, z, f, c: u * f / z - c, "that is the other way, from mm to pixels (lesson 01). Turn it round: c away first, then times Z, over f."),
                Wrong(lambda u, z, f, c: (u / f - c) * z, "the centre is in pixels: take it from u, before you divide."),
                Wrong(lambda u, z, f, c: (u - c / f) * z, "brackets are missing: (u - center_px) first."),
                Wrong(lambda u, z, f, c: u - c / f * z, "brackets are missing: (u - center_px) first."),
                Wrong(lambda u, z, f, c: f / ((u - c) * z), "upside down."),
                Wrong(lambda u, z, f, c: (u * z - c) / f, "brackets: (u - center_px) first, then times Z."),
                Wrong(lambda u, z, f, c: (u - c) * z / f + c, "the centre is in pixels, your result in mm: it was taken away once, that is all."),
                Wrong(lambda u, z, f, c: (u - c) * z, "divide by the focal length: pixels over pixels is a slope."),
                Wrong(lambda u, z, f, c: (u - c) * z * f, "the focal length belongs below the line."),
                Wrong(lambda u, z, f, c: f * (u - c) / z + c, "that is the other way, from mm to pixels (lesson 01)."),
                Wrong(lambda u, z, f, c: u * z / f, "u counts from the picture's edge: take away the column c that looks straight ahead."),
                Wrong(lambda u, z, f, c: (u - c) * f / z, "your x shrinks with depth. Rays spread: Z belongs above the line."),
                Wrong(lambda u, z, f, c: (c - u) * z / f, "left and right are turned: u grows to the right, and so does x."),
                Wrong(lambda u, z, f, c: (u - c) / f, "that is x for one millimetre of depth. Multiply it by Z."),
            ),
            "pixels over pixels, times millimetres: millimetres.",
            also=(lambda u, z, f, c: z * (u - c) / f,),
        ),
        hints=(
            "Undo the steps of the formula, the last one first: there c was added last.",
            "u − c is f·X/Z. Which two steps bring X out of that?",
            "return (u - ____) * z_mm / ____",
        ),
        code="def camera_x(u, z_mm, focal_px, center_px):\n    return (u - center_px) * z_mm / focal_px",
        reason="Similar triangles again: x is to Z as u − c is to f.",
        reference=camera_x,
    )  # fmt: skip


def _finer_pixels(slope, offset, slope_of_y):
    return dict(
        asks="The same scene with twice as many columns: what is the slope of Eq. 2 then, in mm per px?",
        answer=Number(
            slope / 2, 0.006, "mm per px",  # slopes are printed to a hundredth
            (
                Wrong(2 * slope, "then a pixel would cover more of the bench. There are more of them now, side by side on the same width."),
                Wrong(slope, "then twice as many pixels would cover twice the width. But the camera sees what it saw before."),
                Wrong(slope / 4, "there are twice as many columns, not twice as many rows: half once, not twice."),
                Wrong(0.5, "that is how much of the slope is left. The slope itself is asked for, in mm per px."),
                Wrong(2.0, "by 2, but which way? And the slope itself is asked for, in mm per px."),
                Wrong(slope**2, "a square has no place here. How many mm does one of the finer pixels cover?"),
                Wrong(1 / slope, "that is px per mm. How many mm does one of the finer pixels cover?"),
                Wrong(1 / (2 * slope), "that is px per mm. How many mm does one of the finer pixels cover?"),
                Wrong(2 / slope, "that is px per mm. How many mm does one of the finer pixels cover?"),
                Wrong(slope**0.5, "a root has no place here. How many mm does one of the finer pixels cover?"),
                Wrong(slope - 2, "not two less: the width that was one pixel is two pixels now. What part of it does one cover?"),
                Wrong(slope + 2, "not two more: the width that was one pixel is two pixels now. What part of it does one cover?"),
                Wrong(slope - 0.5, "not a half less, but half of it."),
                Wrong(0.0, "then every pixel would lie at the same x. How many mm does one of the finer pixels cover?"),
                Wrong(4 * slope, "then a pixel would cover more of the bench. There are more of them now, side by side on the same width."),
            ),
            "the same millimetres, shared by twice as many pixels.",
            known={"x_line.slope_mm_per_px": slope, "x_line.offset_mm": offset, "y_line.slope_mm_per_px": slope_of_y, "640": 640},
            ask="How many mm does one of the finer pixels cover?",
            beside=(("(it )?(stays )?(the )?(same|unchanged|equal)( as before)?", "then twice as many pixels would cover twice the width. But the camera sees what it saw before."),),
            small="then twice as many pixels would cover less than the camera saw before.",
            large="then twice as many pixels would cover more than the camera saw before.",
        ),
        hints=(
            "How many millimetres of the bench does one pixel cover now? And how many if there are twice as many of them?",
            "The width that the camera sees stays; the number of pixels on it doubles.",
            "slope_there = x_line.slope_mm_per_px * ____",
        ),
        code="slope_there = x_line.slope_mm_per_px / 2",
        reason="The slope is millimetres per pixel. More pixels on the same millimetres: fewer millimetres for each.",
        reference=slope / 2,
    )  # fmt: skip


def _slopes(pixels, lengths_mm):
    return (lengths_mm - lengths_mm.mean()) / (pixels - pixels.mean())


def _products(pixels, lengths_mm):
    return (pixels - pixels.mean()) * (lengths_mm - lengths_mm.mean())


def line_slope(pixels: np.ndarray, lengths_mm: np.ndarray) -> float:
    """Slope of the least-squares line, mm per px."""
    dp = pixels - pixels.mean()
    return (dp * (lengths_mm - lengths_mm.mean())).sum() / (dp * dp).sum()


def camera_x(u: float, z_mm: float, focal_px: float, center_px: float) -> float:
    """The x coordinate in the rectified left frame, mm."""
    return (u - center_px) * z_mm / focal_px


@lru_cache(maxsize=4)
def _facts(path):
    """(v, y) of two samples as the paper's way sees them, slope and offset of its Eq. 2 and slope of its Eq. 1, the focal length, the principal column."""
    recording = open_recording(path)
    localizer = Localizer.fit(recording, method="paper")
    seen = []
    for sample in recording.samples("position"):
        pair = localizer.detect(sample.pair.left, sample.pair.right) if sample.use == "fit" else None
        if pair is not None:
            seen.append((localizer.calibration.rectify_centers(*pair)[0][1], sample.measured.y_mm))
    seen.sort()
    calibration = localizer.calibration
    x_line, y_line = localizer.way.x_line, localizer.way.y_line
    lines = x_line.slope_mm_per_px, x_line.offset_mm, y_line.slope_mm_per_px
    return seen[0], seen[-1], lines, calibration.focal_px, calibration.center_px[0]
