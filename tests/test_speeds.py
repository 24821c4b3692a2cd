"""What ``stereo-lab bench`` tells of the detectors: every set, every way, against the same pictures."""

import numpy as np
import pytest

from stereo_lab.detection import Detection
from stereo_lab.results import speeds


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
