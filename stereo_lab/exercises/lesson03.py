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


def questions(recording: Recording) -> tuple[Question, ...]:
    """Six questions; see :mod:`stereo_lab.exercises`."""
    (v0, y0), (v1, y1), slope, focal, center = _facts(str(recording.path))
    tries = ((center + 100.0, 1000.0, focal, center), (center - 50.0, 2000.0, focal, center))
    return lesson(
        "03",
        _sign(),
        _slope(v0, y0, v1, y1),
        _least_squares(),
        _finer_pixels(slope),
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
                ("(less|smaller|lower) than zero", "below"), ("under zero|negative|minus", "below"), ("below zero", "below"),
                ("(more|larger|greater|higher) than zero", "above"), ("over zero|positive|plus", "above"), ("above zero", "above"),
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
            right, 0.02 * abs(right), "mm per px",
            (
                Wrong(y1 - y0 / v1 - v0, "brackets are missing: Python divides before it takes away. (… - …) / (… - …)"),
                Wrong((y1 - y0) / v1 - v0, "brackets are missing below the line: / (v1 - v0)."),
                Wrong(y1 - y0 / (v1 - v0), "brackets are missing above the line: (y1 - y0) / …"),
                Wrong(-right, "the sign is turned: one row down is less y, so the slope is below zero. Take the same order above and below the line, and no abs."),
                Wrong(1 / right, "that is px per mm. Millimetres belong above the line, pixels below."),
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
                Wrong(lambda p, q: np.polyfit(p, q, 1), "np.polyfit gives two numbers, slope and offset. The slope is [0]."),
                Wrong(lambda p, q: np.polyfit(p, q, 1)[1], "that is the offset, where the line meets pixel 0. The slope is [0]."),
                Wrong(lambda p, q: np.cov(p, q)[0, 1] / p.var(), "np.cov divides by one less than there are, .var() by all. Take sums both times."),
                Wrong(lambda p, q: (q / p).mean(), "that is a mean of lines through (0, 0). Take the means away first."),
                Wrong(
                    lambda p, q: ((p - p.mean()) * (q - q.mean())).sum() / ((q - q.mean()) ** 2).sum(),
                    "the pixels belong below the line, squared: you divided by the millimetres.",
                ),
            ),
            "the line with the smallest sum of squared misses.",
            also=(lambda p, q: np.polyfit(p, q, 1)[0],),
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
                Wrong(0.5, "the other way round: the rays spread. Far away, one pixel covers more millimetres."),
                Wrong(1.0, "Eq. 2 says so, because it knows nothing of depth. Look along one ray: where is it at twice the depth?"),
                Wrong(0.25, "the other way round, and not squared: a length grows with the distance itself."),
                Wrong(4.0, "areas grow with the square of the distance; a length grows with the distance itself."),
            ),
            "measured from the point the camera looks at: twice as far, twice as wide.",
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


def _finer_pixels(slope):
    return dict(
        asks="The same scene with twice as many columns: what is the slope of Eq. 2 then, in mm per px?",
        answer=Number(
            slope / 2, 0.02 * slope, "mm per px",
            (
                Wrong(2 * slope, "then a pixel would cover more of the bench. There are more of them now, side by side on the same width."),
                Wrong(slope, "then twice as many pixels would cover twice the width. But the camera sees what it saw before."),
                Wrong(slope / 4, "there are twice as many columns, not twice as many rows: half once, not twice."),
                Wrong(0.5, "that is how much of the slope is left. The slope itself is asked for, in mm per px."),
                Wrong(2.0, "by 2, but which way? And the slope itself is asked for, in mm per px."),
                Wrong(slope**2, "a square has no place here. How many mm does one of the finer pixels cover?"),
                Wrong(4 * slope, "then a pixel would cover more of the bench. There are more of them now, side by side on the same width."),
            ),
            "the same millimetres, shared by twice as many pixels.",
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
    """(v, y) of two samples as the paper's way sees them, its slope of Eq. 2, the focal length, the principal column."""
    recording = open_recording(path)
    localizer = Localizer.fit(recording, method="paper")
    seen = []
    for sample in recording.samples("position"):
        pair = localizer.detect(sample.pair.left, sample.pair.right) if sample.use == "fit" else None
        if pair is not None:
            seen.append((localizer.calibration.rectify_centers(*pair)[0][1], sample.measured.y_mm))
    seen.sort()
    calibration = localizer.calibration
    return seen[0], seen[-1], localizer.way.x_line.slope_mm_per_px, calibration.focal_px, calibration.center_px[0]
