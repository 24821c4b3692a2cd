"""The grid of lesson 04: ways to find pixels by formulas, one change at a time."""

import numpy as np
import pytest

from stereo_lab import results
from stereo_lab.localization import Localizer
from stereo_lab.position import RigidFit
from stereo_lab.results.grid import FORMULAS, DepthGrid, depth_grid, fair_chances


@pytest.fixture(scope="module")
def second(second_rig):
    ours = Localizer.fit(second_rig)
    return ours, Localizer.fit(second_rig, "paper", calibration=ours.calibration)


@pytest.fixture(scope="module")
def grid(second_rig, second):
    return depth_grid(second_rig, *second)


def test_the_cells_are_what_the_formulas_give(second_rig, second, grid):
    """Two cells worked out again by hand: Eq. 3 on the true centres, and the rigid fit on the cone's and the depth samples."""
    ours = second[0]
    calibration = ours.calibration
    place = lambda s: ours.way.calibration.triangulate(
        *([c] for c in calibration.rectify_centers(*ours.detect(s.pair.left, s.pair.right)))
    )[0]
    depth = [(place(s), [s.measured.x_mm, s.measured.y_mm, -s.measured.depth_mm]) for s in second_rig.samples("depth")]
    rigid = RigidFit.fit(*zip(*depth, strict=True))
    eq3, by_rigid = [], []
    for sample in second_rig.judges("volume"):
        true = second_rig.true_ball("evaluation", sample.pair.name)
        u = [calibration.rectify_points([true[side][:2]], side)[0, 0] for side in ("left", "right")]
        eq3.append(calibration.baseline_mm * calibration.focal_px / (u[0] - u[1]) - true["ball"][2])
        by_rigid.append(-rigid.predict(place(sample))[0, 2] - true["ball"][2])
    cell = lambda row, column: grid.mean_mm[grid.pixels.index(row), FORMULAS.index(column)]
    assert cell("true centres", "Eq. 3") == pytest.approx(np.abs(eq3).mean(), rel=1e-6)
    assert cell("cone", "rigid fit, all samples") == pytest.approx(np.abs(by_rigid).mean(), rel=1e-6)


def test_one_change_at_a_time_tells_what_helps(grid):
    """With true pixels the formulas of d alone agree, for they cannot know of the tilt; the rigid fit does."""
    exact = grid.mean_mm[grid.pixels.index("true centres")]
    assert exact[:4].max() < 1.2 * exact[:4].min() and exact[4] < 0.1 * exact[:4].min()
    whole_pixels = grid.mean_mm[grid.pixels.index("Hough circle")]
    assert whole_pixels[4] > 10 * grid.mean_mm[grid.pixels.index("cone"), 4]


def test_another_things_pixels_are_counted_and_not_averaged(second_rig, grid):
    """In many pictures a poster has the largest patch of the ball's colour."""
    left_out = dict(zip(grid.pixels, grid.left_out, strict=True))
    assert grid.judged == len(second_rig.judges("volume"))
    assert left_out["cone"] == left_out["true centres"] == 0 and left_out["mask's middle"] > 5
    assert np.nanmax(grid.mean_mm) < 50


def test_a_fair_chance_changes_one_thing_at_a_time(second_rig, second, grid):
    """The rows that are in the grid as well agree with it; a poster among the three samples leaves no fit."""
    chances = {chance.name: chance for chance in fair_chances(second_rig, *second)}
    cell = lambda row, column: grid.mean_mm[grid.pixels.index(row), FORMULAS.index(column)]
    assert np.isnan(chances["as it stands"].mean_mm) and np.isnan(cell("Hough circle", "Eq. 4, 3 samples"))
    assert chances["all depth samples for three"].mean_mm == cell("Hough circle", "Eq. 4, all samples")
    middle, learned = (
        chances[name] for name in ("the mask's middle for the circle's", "colour bounds learned from its samples")
    )
    assert middle.left_out == grid.left_out[grid.pixels.index("mask's middle")] > 5
    assert learned.left_out < 5 and learned.mean_mm < 20  # tight bounds leave the posters out
    assert chances["the first three changes"].mean_mm < learned.mean_mm
    assert chances["all four changes"].mean_mm >= chances["the first three changes"].mean_mm


def test_no_picture_is_looked_at_twice_in_one_way(second_rig, second, monkeypatch):
    """Of seven variants most ask for the same pixels; only learned colours are new."""
    looks = []
    for name in ("_by_way", "_middle_of_mask"):
        real = getattr(results.grid, name)
        monkeypatch.setattr(
            results.grid, name, lambda way, sample, real=real: looks.append((real, way, sample)) or real(way, sample)
        )
    fair_chances(second_rig, *second)
    assert len(looks) == len(set(looks))


def test_the_page_tells_what_is_missing():
    grid = DepthGrid(("Hough circle", "cone"), np.array([[12.34, np.nan, 3, 4, 5], [1, 2, 3, 4, 5.0]]), 16, (3, 0))
    heads, more, first, second = grid.page().splitlines()
    assert heads.split() == ["Eq.", "3", "Eq.", "4", "Eq.", "4", "a/(d−d0)+c", "rigid", "fit"]
    assert more.split()[:2] == ["3", "samples"]
    assert first.split() == ["Hough", "circle", "12.3", "-", "3.0", "4.0", "5.0", "(3", "of", "16", "left", "out)"]
    assert second.split() == ["cone", "1.0", "2.0", "3.0", "4.0", "5.0"]
    assert grid.rows() == ["Hough circle\n(3 of 16 left out)", "cone"]
