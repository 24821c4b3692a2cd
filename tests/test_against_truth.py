"""A calibration against the cameras as they were rendered."""

from dataclasses import replace

import numpy as np
import pytest

from stereo_lab.results.against_truth import as_rendered, distance_errors_mm


@pytest.fixture(scope="module")
def true(bench, bench_calibration):
    return as_rendered(bench, bench_calibration)


def test_the_truth_sees_every_ball_where_it_is(bench, true):
    """The renderer's own centres of all evaluation balls, triangulated by the true cameras: one rigid move from the bench."""
    names = [sample.pair.name for sample in bench.samples("evaluation")]
    balls = [bench.true_ball("evaluation", name) for name in names]
    pixels = {side: true.rectify_points([ball[side][:2] for ball in balls], side) for side in ("left", "right")}
    found = true.triangulate(pixels["left"], pixels["right"])
    places = np.array([ball["ball"] for ball in balls])
    between = lambda points: np.linalg.norm(points[:, None] - points[None], axis=-1)
    assert np.abs(between(found) - between(places)).max() < 0.3  # mm; centres are told to a thousandth of a pixel


def test_the_truth_is_not_off(true):
    assert np.abs(distance_errors_mm(true, true, 1000)).max() < 1e-3


def test_a_baseline_too_long_makes_everything_farther(true):
    longer = replace(true, translation_mm=1.01 * true.translation_mm)
    errors = distance_errors_mm(longer, true, 1000)
    assert errors.min() > 9 and errors.max() < 1.01 * 1300 * 0.011


def test_the_kits_calibration_is_near_the_truth(bench_calibration, true):
    assert np.abs(distance_errors_mm(bench_calibration, true, 1000)).mean() < 0.4


def test_nobody_knows_real_cameras(bench, bench_calibration):
    assert as_rendered(replace(bench, truth={}), bench_calibration) is None
