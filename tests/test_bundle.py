"""The one least-squares fit of a calibration: its derivatives, OpenCV beside it, what it leaves out, what it knows."""

import cv2
import numpy as np
import pytest
from rigs import BOARD, ball_places, bent_board, hold, known_rig

from stereo_lab.calibration import bundle, heldout, solver, uncertainty
from stereo_lab.calibration.shapes import board_shapes
from stereo_lab.calibration.start import first_rig
from stereo_lab.calibration.views import View, stacked
from stereo_lab.errors import CalibrationError

SHAPES = board_shapes(BOARD)
FLAT = bundle.Shapes(SHAPES.flat, SHAPES.ways[..., :0], SHAPES.sigma_mm[:0])


def solve(rig, views, shapes=SHAPES):
    cameras, boards, together = first_rig(views, shapes.flat, rig.size, len(shapes.sigma_mm))
    chosen = [v for v, same in zip(views, together, strict=True) if same]
    return solver.solve(cameras, boards.some(together), chosen, shapes, rig.size), together


def seen(views):
    return np.stack([[v.left for v in views], [v.right for v in views]], 2)


@pytest.fixture(scope="module")
def case():
    """A rig, twenty views of a bent board, and the fit."""
    rng = np.random.default_rng(3)
    rig = known_rig(rng)
    views = hold(rng, rig, bent_board(rng), 20)
    return rig, views, solve(rig, views)[0]


def test_slopes_are_those_of_small_steps(case):
    _, views, fit = case
    rig, boards = fit.solution.rig, fit.solution.boards.some(np.arange(3))
    pixels, by_shared, by_held = bundle.look(rig, boards, SHAPES)
    step = 1e-5
    still = np.zeros((3, 6))
    for k in range(by_shared.shape[-1]):
        move = np.zeros(by_shared.shape[-1])
        move[k] = step
        there = bundle.look(rig.moved(move), boards.moved(move[bundle.CAMERAS :], still), SHAPES)[0]
        assert (there - pixels) / step == pytest.approx(
            by_shared[..., k], rel=1e-3, abs=1e-3 * np.abs(by_shared[..., k]).max()
        )
    for k in range(6):
        held = still.copy()
        held[:, k] = step
        there = bundle.look(rig, boards.moved(np.zeros(len(boards.bends)), held), SHAPES)[0]
        assert (there - pixels) / step == pytest.approx(
            by_held[..., k], rel=1e-3, abs=1e-3 * np.abs(by_held[..., k]).max()
        )


def test_it_finds_what_opencv_finds_for_a_flat_board(case):
    """With nothing but the cameras free, ``cv2.stereoCalibrate`` has the same optimum."""
    rig, views, _ = case
    cameras, boards, _ = first_rig(views, FLAT.flat, rig.size, 0)
    free = np.full(bundle.CAMERAS, np.inf)
    ours = bundle.fit(cameras, boards, seen(views), np.ones((20, 54, 2)), FLAT, free, 0.05**2)
    flat = [FLAT.flat.astype(np.float32)] * len(views)
    sides = [[v.left.astype(np.float32) for v in views], [v.right.astype(np.float32) for v in views]]
    alone = [cv2.calibrateCamera(flat, side, rig.size, None, None)[1:3] for side in sides]
    _, k1, d1, k2, d2, rotation, step, *_ = cv2.stereoCalibrate(
        flat, *sides, *alone[0], *alone[1], rig.size, flags=cv2.CALIB_USE_INTRINSIC_GUESS,
        criteria=(cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 300, 1e-14),
    )  # fmt: skip
    for lens, (matrix, distortion) in ((ours.rig.left, (k1, d1)), (ours.rig.right, (k2, d2))):
        assert lens[:4] == pytest.approx((matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2]), abs=0.01)
        assert lens[4:] == pytest.approx(distortion.ravel(), abs=1e-3)
    assert ours.rig.translation == pytest.approx(step.ravel(), abs=1e-3)
    assert ours.rig.rotation == pytest.approx(rotation, abs=1e-6)


def depth_errors(rig, cameras, count=200):
    """Depth of places told by the fitted cameras from exact pixels, minus the true depth, after one rigid fit; mm."""
    places = ball_places(np.random.default_rng(9), rig, count)
    exact = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 100, 1e-12)
    flat = [
        cv2.undistortPoints(p.reshape(-1, 1, 2), *bundle.matrices(lens), criteria=exact).reshape(-1, 2).T
        for p, lens in zip(rig.see(places), (cameras.left, cameras.right), strict=True)
    ]
    right = np.column_stack([cameras.rotation, cameras.translation])
    told = cv2.triangulatePoints(np.eye(3, 4), right, *flat)
    told = (told[:3] / told[3]).T
    a, b = told - told.mean(0), places - places.mean(0)
    u, _, vt = np.linalg.svd(a.T @ b)
    return told, places, (a @ u @ vt - b)[:, 2]


def test_a_bent_board_does_not_bend_the_places(case):
    rig, views, fit = case
    bent = np.percentile(np.abs(depth_errors(rig, fit.solution.rig)[2]), 95)
    held_flat = np.percentile(np.abs(depth_errors(rig, solve(rig, views, FLAT)[0].solution.rig)[2]), 95)
    assert bent < 1.0 and held_flat > 3 * bent


def test_a_corner_that_is_off_is_left_out_and_changes_nothing(case):
    rig, views, fit = case
    off = views[5].right.copy()
    off[17] += (5.0, -3.0)
    spoilt = solve(rig, [*views[:5], View("005", views[5].left, off), *views[6:]])[0]
    assert spoilt.solution.weights[5, 17, 1] == 0 and (spoilt.solution.weights == 0).sum() < 8
    apart = depth_errors(rig, spoilt.solution.rig)[0] - depth_errors(rig, fit.solution.rig)[0]
    assert np.abs(apart).max() < 0.5


def test_pairs_of_two_moments_are_found_even_if_they_are_many(case):
    rig, views, _ = case
    mixed = [View(v.name, v.left, views[(k + 1) % 9].right) if k < 9 else v for k, v in enumerate(views)]
    fit, together = solve(rig, mixed)
    assert not together[:9].any() and together[9:].all()
    assert np.percentile(np.abs(depth_errors(rig, fit.solution.rig)[2]), 95) < 2


def test_a_blurred_view_is_left_out_whole(case):
    rig, views, _ = case
    shaken = views[4].left + np.random.default_rng(0).normal(0, 0.6, views[4].left.shape)
    fit = solve(rig, [*views[:4], View("004", shaken, views[4].right), *views[5:]])[0]
    assert fit.bad == [4]
    assert "left picture are off by" in solver.why_bad(fit, View("004", shaken, views[4].right), SHAPES)


@pytest.mark.parametrize("count", [5, 6, 8])
def test_the_wrong_board_among_few_is_found(count):
    """It pulls all others with it, and lies no farther off than they."""
    for seed in range(4):
        rng = np.random.default_rng(seed)
        rig = known_rig(rng)
        views, k = hold(rng, rig, bent_board(rng), count), seed % count
        assert solve(rig, views)[0].bad == []
        views[k] = View(views[k].name, views[k].left, views[k].right + (6.0, 3.6))
        assert solve(rig, views)[0].bad == [k]


def test_a_board_that_loses_all_its_corners_is_left_out():
    """Single corners may be left out, one by one, until nothing holds their board."""
    rng = np.random.default_rng(0)
    rig = known_rig(rng)
    views = hold(rng, rig, bent_board(rng), 12)
    shapes, (seen, there) = SHAPES, stacked(views)
    fit = solve(rig, views)[0]
    seen[3, :, 1] += (0, 1.0)  # the right camera's rows: no place of the board explains it
    assert solver._exact(seen, there, shapes, rig.size, fit.solution, 0.04)[2].tolist() == [k == 3 for k in range(12)]


def test_one_wrong_board_of_four_is_named():
    rng = np.random.default_rng(5)
    rig = known_rig(rng)
    views = hold(rng, rig, bent_board(rng), 4)
    views[2] = View("002", views[2].left, views[2].right + (6.0, 3.6))
    with pytest.raises(
        CalibrationError, match="The board of 002 contradicts the others, and without it too few are left"
    ):
        solve(rig, views)


def test_a_board_that_one_camera_sees_counts_for_that_camera(case):
    rig, views, _ = case
    nowhere = np.full((54, 2), np.nan)
    few = views[:8]
    more = (
        few
        + [View(v.name, v.left, nowhere) for v in views[8:14]]
        + [View(v.name, nowhere, v.right) for v in views[14:]]
    )
    without, together = (np.sqrt(np.diag(uncertainty.covariance(solve(rig, v)[0].solution))) for v in (few, more))
    assert (together[:18] < without[:18]).all()
    assert np.percentile(np.abs(depth_errors(rig, solve(rig, more)[0].solution.rig)[2]), 95) < 2


def test_k3_is_found_where_there_is_one_and_not_invented():
    for k3 in (0.0, 0.35):
        rng = np.random.default_rng(12)
        rig = known_rig(rng, k3)
        middle = solve(rig, hold(rng, rig, bent_board(rng), 20, reach=0.12))[0].solution.rig
        whole = solve(rig, hold(rng, rig, bent_board(rng), 24, reach=0.6))[0].solution.rig
        if k3:
            assert whole.left[8] == pytest.approx(k3, abs=0.12) and whole.right[8] == pytest.approx(k3, abs=0.12)
        else:
            assert max(abs(middle.left[8]), abs(middle.right[8])) < 0.05


def test_leaving_one_out_is_what_a_fit_without_it_gives(case):
    rig, views, fit = case
    told = uncertainty.rigs_without(fit.solution)
    for k in (2, 11):
        rest = [v for j, v in enumerate(views) if j != k]
        chosen = np.array([j != k for j in range(len(views))])
        again = bundle.fit(
            fit.solution.rig, fit.solution.boards.some(chosen), seen(rest), fit.solution.weights[chosen], SHAPES,
            fit.solution.prior, fit.solution.variance,
        ).rig  # fmt: skip
        moved, really = told[k].left - fit.solution.rig.left, again.left - fit.solution.rig.left
        assert moved[:4] == pytest.approx(really[:4], abs=0.15 * np.abs(really[:4]).max() + 0.01)
        assert heldout.pair_errors(told[k], views[k], BOARD, rig.size) == pytest.approx(
            heldout.pair_errors(again, views[k], BOARD, rig.size), rel=0.2, abs=0.003
        )


def test_a_place_moves_as_its_slopes_say(case):
    rig, _, fit = case
    cameras, places = fit.solution.rig, ball_places(np.random.default_rng(1), rig, 5)
    pixels = [bundle.project(places, cameras.left)[0]]
    pixels.append(bundle.project(places @ cameras.rotation.T + cameras.translation, cameras.right)[0])
    slopes = uncertainty.place_slopes(places, cameras)
    for k, step in ((0, 0.1), (2, 0.1), (4, 1e-3), (12, 0.1), (18, 1e-5), (19, 1e-5), (21, 0.01), (23, 0.01)):
        move = np.zeros(bundle.CAMERAS)
        move[k] = step
        moved = cameras.moved(move)
        there = closest(places, pixels, moved)
        assert there - places == pytest.approx(slopes[..., k] * step, rel=0.02, abs=1e-3)


def closest(places, pixels, cameras):
    """Places that explain four coordinates best, by Gauss-Newton from near by."""
    for _ in range(20):
        left, by_left, _ = bundle.project(places, cameras.left)
        right, by_right, _ = bundle.project(places @ cameras.rotation.T + cameras.translation, cameras.right)
        slopes = np.concatenate([by_left, by_right @ cameras.rotation], 1)
        missing = np.concatenate([pixels[0] - left, pixels[1] - right], 1)
        places = places + (np.linalg.pinv(slopes) @ missing[..., None])[..., 0]
    return places


def test_sigma_tells_the_errors_that_there_are():
    """Over many rigs, two thirds of the errors lie within one sigma, and nearly all within two."""
    sizes = []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        rig = known_rig(rng, rng.choice((0.0, 0.2)))
        solution = solve(rig, hold(rng, rig, bent_board(rng), (8, 14, 20)[seed % 3]))[0].solution
        told, places, _ = depth_errors(rig, solution.rig, 100)
        knows = uncertainty.covariance(solution) * max(1, uncertainty.misfit(solution, rig.size, 1000.0)) ** 2
        sizes.append(np.abs(told - places) / uncertainty.sigmas(uncertainty.place_slopes(told, solution.rig), knows))
    sizes = np.concatenate(sizes)
    assert 0.55 < (sizes < 1).mean() < 0.88 and (sizes < 2).mean() > 0.9


def test_one_cameras_corners_shifted_are_noticed(case):
    """Half a pixel to one side in a third of the right pictures: no rig explains it, and the misfit says so."""
    rig, views, fit = case
    shifted = [View(v.name, v.left, v.right + (0.5 * (k % 3 == 0), 0)) for k, v in enumerate(views)]
    spoilt = solve(rig, shifted)[0]
    size = rig.size
    assert spoilt.bad or uncertainty.misfit(spoilt.solution, size, 1000.0) > 2 * uncertainty.misfit(
        fit.solution, size, 1000.0
    )
