"""The limit of depth: what the pictures' noise alone does to a ball's outline."""

import numpy as np
import pytest

from stereo_lab.detection import BallDetector, Detection
from stereo_lab.localization import find_pair
from stereo_lab.results import limit
from stereo_lab.results.limit import DepthLimit, center_sigma_px, sensor_noise

BALL = Detection(40.3, 38.6, 14.0, 1.0)
BLUR_PX, CONTRAST, NOISE = 1.2, 120.0, 3.0


def drawn(contrast=CONTRAST, radius=BALL.radius_px):
    """A grey ball with a Gaussian edge before white, three equal channels."""
    from math import erf

    v, u = np.mgrid[:80, :80]
    off = (np.hypot(u - BALL.u, v - BALL.v) - radius) / (BLUR_PX * 2**0.5)
    edge = np.vectorize(erf)(off)
    return np.repeat((128 + contrast / 2 * edge)[..., None], 3, 2)


def noise(sigma=NOISE, seed=0, shots=8):
    """Differences of two shots of white noise."""
    return np.random.default_rng(seed).normal(0, sigma * 2**0.5, (shots, 80, 80, 3)).round().astype(np.int16)


def test_the_shift_is_the_cramer_rao_bound_of_a_disc_in_white_noise():
    """The information about u: contrast² / noise² · π·r / (2·√π·blur), and once for each channel."""
    information = 3 * (CONTRAST / NOISE) ** 2 * np.pi * BALL.radius_px / (2 * np.sqrt(np.pi) * BLUR_PX)
    assert center_sigma_px(drawn(), BALL, noise()) == pytest.approx(information**-0.5, rel=0.15)


def test_more_noise_less_contrast_and_a_smaller_ball_are_worse():
    plain = center_sigma_px(drawn(), BALL, noise())
    assert center_sigma_px(drawn(), BALL, noise(2 * NOISE)) == pytest.approx(2 * plain, rel=0.1)
    assert center_sigma_px(drawn(CONTRAST / 2), BALL, noise()) == pytest.approx(2 * plain, rel=0.1)
    small = Detection(BALL.u, BALL.v, BALL.radius_px / 2, 1.0)
    assert center_sigma_px(drawn(radius=7), small, noise()) == pytest.approx(2**0.5 * plain, rel=0.2)


def test_a_ball_that_was_moved_between_two_shots_is_no_noise():
    moved = noise()
    moved[2] += (drawn() - drawn(radius=9)).astype(np.int16)
    assert center_sigma_px(drawn(), BALL, moved) == pytest.approx(center_sigma_px(drawn(), BALL, noise()), rel=0.2)


def test_a_ball_at_the_rim_and_a_picture_without_edges():
    rim = Detection(2.0, 3.0, 14.0, 1.0)
    assert 0 < center_sigma_px(np.roll(drawn(), (-36, -38), (0, 1)), rim, noise()) < 1
    assert center_sigma_px(np.full((80, 80, 3), 9.0), BALL, noise()) == float("inf")


@pytest.fixture(scope="module")
def find(bench, bench_calibration):
    """The ball in both pictures of a pair."""
    detectors = [BallDetector("red", "cone", bench_calibration.camera(side)) for side in ("left", "right")]
    return lambda pair: find_pair(bench_calibration, detectors, bench.ball.diameter_mm, pair.left, pair.right)


@pytest.fixture(scope="module")
def places(bench, bench_calibration, find):
    """For three places of the set still: the limit there, and how the detector's disparity trembles."""
    told, seen, calibration = sensor_noise(bench), [], bench_calibration
    for first in (0, 40, 80):
        pairs = bench.pairs("still")[first : first + 8]
        balls = [find(p) for p in pairs]
        centers = np.array([calibration.rectify_centers(*pair) for pair in balls])
        trembles = (centers[:, 0, 0] - centers[:, 1, 0]).std(ddof=1)
        seen.append((limit.disparity_sigma_px(calibration, pairs[0], balls[0], told), trembles))
    return np.array(seen)


def test_the_detector_trembles_more_than_the_limit_and_not_much_more(places):
    """Pooled over the places: 8 shots alone know a standard deviation to a quarter."""
    bound, reached = np.sqrt((places**2).mean(0))
    assert bound < reached < 3 * bound


def test_without_repeated_shots_the_noise_is_much_the_same(bench, bench_calibration, find, monkeypatch):
    samples = bench.judges("volume")[:6]
    balls = [find(s.pair) for s in samples]
    best = DepthLimit.of(bench_calibration, sensor_noise(bench), samples, balls)
    monkeypatch.setattr(limit, "SETS", ("evaluation",))
    other = DepthLimit.of(bench_calibration, sensor_noise(bench), samples, balls)
    assert (best.source, other.source) == ("still", "evaluation")
    assert other.mean_mm == pytest.approx(best.mean_mm, rel=0.35)
    assert best.names[0] == "evaluation/000"
    depths = np.array([s.reference.depth_mm for s in samples])
    assert best.sigma_mm == pytest.approx(
        depths**2 * best.sigma_d_px / (bench_calibration.focal_px * bench_calibration.baseline_mm)
    )


def test_single_pictures_tell_no_noise(bench, monkeypatch):
    monkeypatch.setattr(limit, "SETS", ("snaps", "nothing"))
    assert sensor_noise(bench) is None
