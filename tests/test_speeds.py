"""What ``stereo-lab bench`` tells of the detectors: every set, every way, against the same pictures."""

from dataclasses import replace

import numpy as np
import pytest

from stereo_lab.detection import BallColor, BallDetector, Detection
from stereo_lab.results import scaling, speeds


@pytest.fixture(scope="module")
def rows(bench):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(speeds, "PICTURES", 3)
        patch.setattr(speeds, "LOOKS", 1)
        return speeds.detecting(bench)


def test_every_set_is_measured_against_the_papers_chain(rows):
    assert [row["set"] for row in rows if "shares" in row] == ["evaluation", "track", "snaps", "clutter"]
    for row in rows:
        assert row["ms"] > 0 and row["times"] > 0
        if "shares" in row:
            assert sum(row["shares"].values()) == pytest.approx(1) and min(row["shares"].values()) > 0
    ways = {(row["set"], row["way"]) for row in rows}
    assert {("evaluation", "cone, near the last place"), ("track", "cone, near the last place")} < ways
    assert ("snaps", "cone, near the last place") not in ways  # its pictures do not follow one another


def test_the_times_are_of_the_same_set(rows):
    paper = {row["set"]: row["ms"] for row in rows if "shares" in row}
    assert all(row["times"] == pytest.approx(paper[row["set"]] / row["ms"]) for row in rows)


def test_the_ball_of_the_film_is_followed(rows):
    searched, followed = (row for row in rows if row["set"] == "track" and "shares" not in row)
    assert (searched["of"], followed["of"]) == (120, 118)  # nothing comes before the first picture of a camera
    assert followed["lost"] == followed["wrong"] == 0 and followed["center_px"] < 0.15
    page = "\n".join(speeds.page(rows))
    assert "0 lost and 0 wrong of 118" in page and "rectify" in page


def test_a_prediction_is_half_a_radius_off():
    ball = Detection(100, 50, 12, 0.9)
    near = speeds.expected(ball, np.random.default_rng(1))
    assert np.hypot(near.u - 100, near.v - 50) == pytest.approx(6) and near.radius_px == 12


def test_what_is_lost_and_what_is_wrong():
    view = speeds.View("left", "red", np.zeros((1, 1, 3), np.uint8), (100.0, 50.0, 12.0))
    found = [(1.0, Detection(100.3, 50.4, 12, 1), view), (2.0, Detection(140, 50, 12, 1), view), (3.0, None, view)]
    told = speeds._told(found, 10.0)
    assert (told["of"], told["lost"], told["wrong"]) == (3, 1, 1)
    assert told["ms"] == 2 and told["times"] == 5 and told["center_px"] == pytest.approx(0.5)


@pytest.mark.parametrize("size", [(320, 240), (1280, 720), (640, 480)])
def test_a_larger_picture_shows_the_same_ball_to_larger_cameras(bench, bench_calibration, size):
    """The ball of a picture that was made larger, and its sides drawn out, lies on the same ray."""
    sample = bench.samples("evaluation")[0]
    cameras = scaling.calibration_for(bench_calibration, size)
    whole = BallDetector("red", camera=bench_calibration.camera("left")).detect(sample.pair.left)
    picture = scaling.fitted(sample.pair.left, size)
    assert picture.shape == (size[1], size[0], 3)
    ball = BallDetector("red", camera=cameras.camera("left")).detect(picture)
    rays = [c.rectify_points([b.center_px], "left")[0] for c, b in ((bench_calibration, whole), (cameras, ball))]
    own = [
        (ray - c.rectified["left"][1][:2, 2]) / c.focal_px
        for ray, c in zip(rays, (bench_calibration, cameras), strict=True)
    ]
    assert own[0] == pytest.approx(own[1], abs=0.4 / bench_calibration.focal_px * 640 / size[0] + 1e-3)


def test_a_wider_picture_is_cut_off_at_both_sides(bench_calibration):
    picture = np.arange(160, dtype=np.uint8)[None, :, None].repeat(90, 0).repeat(3, 2)
    cut = scaling.fitted(picture, (120, 90))
    assert cut.shape == (90, 120, 3) and cut[0, 0, 0] == 20 and cut[0, -1, 0] == 139
    wide = replace(bench_calibration, image_size=(160, 90))
    shifted = scaling.calibration_for(wide, (120, 90)).left_matrix[0, 2] - bench_calibration.left_matrix[0, 2]
    assert shifted == pytest.approx(-20)


def test_painted_things_have_the_balls_color_and_leave_the_picture_alone(bench):
    picture = bench.samples("evaluation")[0].pair.left
    before = picture.copy()
    red = [np.count_nonzero(BallColor.named("red").mask(scaling.painted(picture, n))) for n in (0, 8, 32)]
    assert (picture == before).all() and red[0] + 8 * 100 < red[1] < red[2]


def test_the_time_is_told_for_every_size_and_for_full_pictures(bench, monkeypatch):
    monkeypatch.setattr(scaling, "PICTURES", 2)
    monkeypatch.setattr(speeds, "LOOKS", 1)
    rows = scaling.scaling(bench)
    assert [(*row["size"], row["things"]) for row in rows] == [(*size, 0) for size in scaling.SIZES] + [
        (640, 480, n) for n in scaling.THINGS
    ]
    assert all(row["paper_ms"] > 0 and row["search_ms"] > 0 and row["track_ms"] > 0 for row in rows)
    assert "1920x1080" in "\n".join(scaling.page(rows))
