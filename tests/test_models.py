"""Position and depth: made truth, recovered."""

import re

import cv2
import numpy as np
import pytest

from stereo_lab.depth import NO_CURVE, IdealDepth, OffsetDepth, PaperDepth
from stereo_lab.errors import StereoLabError
from stereo_lab.position import HUBER, LineFit, RigidFit, kabsch

RNG = np.random.default_rng(5)


def test_line_fit_recovers_a_line():
    pixels = np.array([10.0, 80, 300, 500])
    fit = LineFit.fit(pixels, 1.6 * pixels - 420)
    assert fit.slope_mm_per_px == pytest.approx(1.6) and fit.offset_mm == pytest.approx(-420)
    assert np.allclose(fit.residuals_mm, 0, atol=1e-9)


def test_line_fit_needs_two_pixels():
    with pytest.raises(StereoLabError, match="different"):
        LineFit.fit([5, 5, 5], [1, 2, 3])


def test_ideal_depth():
    assert IdealDepth(120, 600).predict(72) == pytest.approx(1000)


def test_paper_depth_solves_three_samples_exactly():
    d, depth = np.array([140.0, 70, 37]), np.array([520.0, 1030, 1980])
    fit = PaperDepth.fit(d, depth)
    assert np.allclose(fit.predict(d), depth)
    assert np.allclose(np.linalg.solve(np.column_stack([1 / d, -d, np.ones(3)]), depth), [fit.m, fit.n, fit.c])


@pytest.mark.parametrize("squint_px", [-3, -1, 1, 3])
def test_paper_depth_not_below_zero_is_the_best_of_those(squint_px):
    """No allowed change makes it better: the error has no slope along a free coefficient, and rises along one held at zero."""
    depth = np.array([520.0, 813, 1104, 1397, 1688, 1980])
    d = 83000 / depth + squint_px + np.random.default_rng(1).normal(0, 0.3, 6)
    fit, free = PaperDepth.fit(d, depth, not_below_zero=True), PaperDepth.fit(d, depth)
    solved, terms = np.array([fit.m, fit.n, fit.c]), np.column_stack([1 / d, -d, np.ones(6)])
    slope = terms.T @ fit.residuals_mm / np.linalg.norm(terms, axis=0)
    held = solved == 0
    assert (solved >= 0).all() and np.allclose(slope[~held], 0, atol=1e-6) and (slope[held] > -1e-6).all()
    assert held.any() == (min(free.m, free.n, free.c) < 0) == (squint_px > 0)


def test_offset_depth_recovers_its_coefficients():
    d = np.array([140.0, 90, 70, 50, 40, 37])
    fit = OffsetDepth.fit(d, 73000 / (d - 1.7) + 12)
    assert (fit.a, fit.d0, fit.c) == pytest.approx((73000, 1.7, 12), rel=1e-4)


def test_offset_depth_counts_its_errors_in_pixels():
    """A pixel is worth Z², so 1/d², millimetres: no small change of a coefficient makes the errors in px smaller."""
    d = np.array([140.0, 90, 70, 50, 40, 37, 33])
    depth = 73000 / (d - 1.7) + 12 + np.array([0.5, -0.8, 1.4, -2.0, 6.0, -9.0, 7.0])
    fit = OffsetDepth.fit(d, depth)

    def in_pixels(a, d0, c):
        return ((d**2 * (a / (d - d0) + c - depth)) ** 2).sum()

    best = in_pixels(fit.a, fit.d0, fit.c)
    for nudge in np.vstack([np.eye(3), -np.eye(3)]) * [5.0, 0.01, 0.1]:
        assert in_pixels(fit.a + nudge[0], fit.d0 + nudge[1], fit.c + nudge[2]) > best


@pytest.mark.parametrize(
    ("d", "depth"),
    [([138.3, 83.0, 55.3, 41.5], [600, 1500, 1500, 2000]), ([10, 20, 30, 40], [2000, 1900, 1700, 1000])],
)
def test_depths_that_bend_the_other_way_have_no_curve(d, depth):
    """The nearest one is a straight line, which a/(d − d0) + c comes to where d0 runs away."""
    with pytest.raises(StereoLabError, match=re.escape(NO_CURVE)):
        OffsetDepth.fit(d, depth)


@pytest.mark.parametrize("model", [PaperDepth, OffsetDepth])
def test_negative_disparity_is_named(model):
    with pytest.raises(StereoLabError, match="swapped"):
        model.fit([-10, -20, -30], [1, 2, 3])


def test_rigid_fit_recovers_a_motion_and_ignores_one_blunder():
    angle = np.radians([178, 3, -2])
    rotation = cv2.Rodrigues(angle)[0]
    camera = RNG.uniform([-400, -300, 500], [400, 300, 2000], (14, 3))
    bench = camera @ rotation.T + [10, 140, 1000]
    fit = RigidFit.fit(camera, bench)
    assert np.allclose(fit.predict(camera), bench, atol=1e-6)
    bench[3] += [0, 100, 0]
    robust = RigidFit.fit(camera, bench, np.full_like(camera, 0.6))
    good = np.arange(14) != 3
    assert np.abs(robust.predict(camera)[good] - bench[good]).max() < 25


def test_rigid_fit_refuses_a_line_of_points():
    points = np.outer(np.arange(5.0), [1, 2, 3])
    with pytest.raises(StereoLabError, match="one line"):
        RigidFit.fit(points, points)
    cloud = np.random.default_rng(0).normal(0, 100, (6, 3))
    with pytest.raises(StereoLabError, match="one line"):
        RigidFit.fit(cloud, np.tile([0.0, 100.0, 1000.0], (6, 1)))  # a table whose first row was copied down
    with pytest.raises(StereoLabError, match="above zero"):
        RigidFit.fit(cloud, cloud, np.zeros((6, 3)))


@pytest.mark.parametrize("along", [[1.0, 0, 0], [0, 0.6, 0.8]])
def test_rigid_fit_refuses_a_line_with_errors_and_takes_one_ball_beside_it(along):
    """Errors put samples beside their line, which tells nothing of the turn about it: such places were decimetres off."""
    sigma, across = np.array([0.6, 0.6, 1.2]), np.cross(along, [0, 1, 0])
    row = np.outer(np.linspace(-300, 300, 7), along) + [0, 0, 1000]
    one_beside = row + np.outer(np.arange(7) == 3, 30 * across)
    for seed in range(30):
        errors, rounded = np.random.default_rng(seed).normal(0, [[sigma] * 7, [[0.5] * 3] * 7])
        with pytest.raises(StereoLabError, match="one line"):
            RigidFit.fit(row + errors, np.rint(row + rounded), sigma)
        fit = RigidFit.fit(one_beside + errors, np.rint(one_beside + rounded), sigma)
        assert np.abs(fit.predict([[0, 100, 1000]]) - [0, 100, 1000]).max() < 35


@pytest.mark.parametrize("count", [4, 5, 6, 8])
def test_rigid_fit_ends_where_no_small_move_is_better_though_one_sample_is_wrong(count):
    sigma = np.array([0.6, 0.6, 3.0])

    def cost(rotation, shift):
        """Squares of how far off samples are in the cameras' own standard deviations, beyond HUBER of them straight on."""
        far = np.sqrt((((bench - shift) @ rotation - camera) ** 2 / sigma**2).sum(1) / 3)
        return np.where(far < HUBER, far**2, HUBER * (2 * far - HUBER)).sum()

    for seed in range(20):
        rng = np.random.default_rng(seed)
        camera = rng.uniform([-300, -200, 800], [300, 200, 1900], (count, 3))
        bench = camera + rng.normal(0, sigma, camera.shape)
        bench[0, 0] += 200
        fit = RigidFit.fit(camera, bench, sigma)
        reached = cost(fit.rotation, fit.shift_mm)
        for turn, shift in np.vstack([np.eye(6), -np.eye(6)]).reshape(-1, 2, 3):
            moved = cv2.Rodrigues(0.002 * turn)[0] @ fit.rotation, fit.shift_mm + shift
            assert reached < 1.001 * cost(*moved)
        assert reached <= cost(*kabsch(camera, bench))


WORDS = ["near", "far", "far away"]


@pytest.mark.parametrize(
    "fit",
    [
        lambda: LineFit.fit(WORDS, [1, 2, 3]),
        lambda: LineFit.fit([1, 2, 3], [[1], [2, 3], []]),
        lambda: PaperDepth.fit(WORDS, [1, 2, 3]),
        lambda: OffsetDepth.fit([1, 2, 3], WORDS),
        lambda: RigidFit.fit([WORDS] * 3, np.eye(3)),
        lambda: RigidFit.fit(np.eye(3), np.eye(3), "small"),
    ],
)
def test_samples_that_are_no_numbers_are_named(fit):
    with pytest.raises(StereoLabError, match="Expected numbers, in rows of one length; got "):
        fit()


@pytest.mark.parametrize("points", [[[320, 240], [330, 250], [1, 2]], [1, 2], None, "abc", np.ones((2, 3, 4))])
def test_a_rigid_fit_takes_points_of_three_numbers_alone(points):
    """Six numbers in three pairs are no two points."""
    fit = RigidFit.fit(100 * np.eye(3), 100 * np.eye(3))
    for told in (fit.predict, fit.slopes):
        with pytest.raises(StereoLabError, match="Expected points of 3 numbers each"):
            told(points)
    assert fit.predict([1, 2, 3]).shape == (1, 3) and fit.predict([]).shape == (0, 3)


def test_as_many_standard_deviations_as_points():
    points = 100 * np.eye(3)
    with pytest.raises(StereoLabError, match=r"as many standard deviations as points, \(3, 3\); got \(5, 3\)"):
        RigidFit.fit(points, points, np.ones((5, 3)))
    for sigma in (2.0, [1.0, 1.0, 3.0], np.ones((3, 1)), np.ones((3, 3))):
        assert np.allclose(RigidFit.fit(points, points, sigma).residuals_mm, 0, atol=1e-6)


def test_rays_that_meet_nowhere_have_no_depth():
    """At d0 they are parallel; below it they part, and the curve would tell a place behind the cameras."""
    d = np.array([150.0, 100, 70, 50, 40])
    fit = OffsetDepth.fit(d, 73000 / (d - 1.7) + 12)
    depth = fit.predict([fit.d0 - 1, fit.d0, 70])
    assert np.isnan(depth[:2]).all() and depth[2] == pytest.approx(73000 / 68.3 + 12)
    assert np.isnan(fit.predict(0.0)) and np.ndim(fit.predict(70.0)) == 0
    for model in (IdealDepth(120, 600), PaperDepth.fit([140.0, 70, 37], [520.0, 1030, 1980])):
        assert np.isnan(model.predict([-30, 0, np.nan])).all() and np.isfinite(model.predict([1e-3, 70])).all()


def test_a_depth_is_of_numbers_however_they_were_typed():
    assert IdealDepth("120", 600).predict("72") == pytest.approx(1000)
    with pytest.raises(StereoLabError, match="focal_px: expected a number, got None"):
        IdealDepth(120, None).predict(72)
    with pytest.raises(StereoLabError, match="Expected numbers, in rows of one length; got 'far'"):
        IdealDepth(120, 600).predict("far")
