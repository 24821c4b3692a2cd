"""What a calibration is worth, and which sets of boards are refused: on rigs that are known exactly."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from rigs import BOARD, bent_board, hold, known_rig, turned

from stereo_lab.calibration import bundle, calibrate_stereo, recipe, refusals, search
from stereo_lab.calibration.advice import depth_map
from stereo_lab.calibration.verdict import verdict_on
from stereo_lab.calibration.views import View
from stereo_lab.errors import CalibrationError, SwappedSidesError
from stereo_lab.recording import Board, StereoPair
from stereo_lab.recording.bounds import unit_asked

SIZE = (640, 480)


@pytest.fixture
def calibrate(monkeypatch):
    """The whole recipe, from views instead of pictures."""

    def run(views):
        monkeypatch.setattr(recipe, "find_views", lambda *_: (list(views), [], SIZE))
        return calibrate_stereo([StereoPair(v.name, None, None) for v in views], BOARD)

    return run


@pytest.fixture(scope="module")
def case():
    rng = np.random.default_rng(21)
    rig, board = known_rig(rng), bent_board(rng)
    return rig, board, hold(rng, rig, board, 16)


def with_sigma(calibration, most_mm, half_mm=None):
    """The calibration, its covariance made so large that nine tenths (or half) of the field are within so much."""
    sigma = depth_map(calibration).sigma_mm
    now = np.percentile(sigma, 90) if half_mm is None else np.median(sigma)
    return replace(calibration, covariance=calibration.covariance * ((half_mm or most_mm) / now) ** 2)


def test_good_is_half_a_percent_and_usable_one(case, calibrate):
    """At 1 m: nine tenths within 5 mm, or half within 10."""
    found = calibrate(case[2])
    assert found.verdict == "good" and found.depth_mm == 1000
    grades = [verdict_on(with_sigma(found, mm), BOARD)[0] for mm in (4.9, 5.1)]
    assert grades == ["good", "usable"]
    grades = [verdict_on(with_sigma(found, 0, mm), BOARD)[0] for mm in (9.9, 10.1)]
    assert grades == ["usable", "poor"]


def test_the_first_reason_is_the_sigma_of_the_field(case, calibrate):
    found = with_sigma(calibrate(case[2]), 3.0)
    first = verdict_on(found, BOARD)[1][0]
    assert "At 1.0 m" in first and "by 3.0 mm or less in nine tenths" in first


def test_boards_that_contradict_each_other_are_never_good(case, calibrate):
    found = calibrate(case[2])
    for misfit, grade in ((2.9, "good"), (3.1, "usable")):
        assert verdict_on(replace(found, misfit=misfit), BOARD)[0] == grade
    few = replace(found, misfit=3.1, used=found.used[:7], pairs=7)
    assert verdict_on(few, BOARD)[0] == "good"  # seven boards cannot tell


def test_boards_in_the_middle_leave_the_rim_open(case, calibrate):
    rig, board, views = case
    middle = calibrate(hold(np.random.default_rng(2), rig, board, 16, reach=0.1))
    everywhere = calibrate(views)
    rim, centre = [[250.0, 180.0, 1000.0]], [[50.0, 0.0, 1000.0]]
    times = lambda c: c.sigma_mm(rim)[0, 2] / c.sigma_mm(centre)[0, 2]
    assert times(middle) > 2 * times(everywhere)
    assert middle.boards_at([(20.0, 20.0)], "left")[0] == 0 < everywhere.boards_at([(320.0, 240.0)], "left")[0]


def test_a_far_off_camera_is_told_by_its_misfit(case, calibrate):
    """One camera's corners shifted by half a pixel in some pairs: no rig explains it."""
    shifted = [View(v.name, v.left, v.right + (0.5 * (k % 3 == 0), 0)) for k, v in enumerate(case[2])]
    spoilt, found = calibrate(shifted), calibrate(case[2])
    assert len(spoilt.used) < len(found.used) or spoilt.misfit > 2 * found.misfit


def test_swapped_sides(case, calibrate):
    with pytest.raises(SwappedSidesError, match="swapped"):
        calibrate([View(v.name, v.right, v.left) for v in case[2]])


def test_cameras_that_turn_inwards_are_not_taken_for_swapped_ones(calibrate):
    rng = np.random.default_rng(4)
    rig = known_rig(rng)
    inwards = turned((0, 40, 0))
    rig = replace(rig, rotation=inwards, translation=-inwards @ [350.0, 0, 180.0])
    views = hold(rng, rig, bent_board(rng), 12, reach=0.15)
    assert calibrate(views).baseline_mm == pytest.approx(np.hypot(350, 180), rel=0.02)


def test_three_pairs_are_too_few(case, calibrate):
    with pytest.raises(CalibrationError, match="found in 3 of 3 pairs; at least 4"):
        calibrate(case[2][:3])


def test_copies_make_no_calibration_surer(case, calibrate):
    """A board on a stand, taken again and again: to the thousandth of a pixel the same, so no camera is known better."""
    rng, views = np.random.default_rng(3), case[2][:6]
    again = [
        View(f"again {k}", *(side + rng.normal(0, 0.005, side.shape) for side in (v.left, v.right)))
        for k, v in enumerate(views * 3)
    ]
    once, often = calibrate(views), calibrate([*views, *again])
    assert len(often.used) == 6  # of each place one, whichever
    assert len(often.dropped) == 18 and all("tells nothing new" in why for _, why in often.dropped)
    assert not any("had to be dropped" in reason for reason in often.reasons)
    for place in ([[0, 0, 1000.0]], [[150, -80, 1400.0]]):
        assert often.sigma_mm(place) == pytest.approx(once.sigma_mm(place), rel=0.05)


def test_three_places_of_a_board_are_too_few(case, calibrate):
    with pytest.raises(CalibrationError, match="in 3 different places in 9 pairs; at least 4"):
        calibrate([View(f"{k:03d}", v.left, v.right) for k, v in enumerate(case[2][:3] * 3)])


def test_a_camera_that_moved_makes_no_copies(case, calibrate):
    """The left camera sees the board where it was, the right one does not: that tells something."""
    views = case[2][:8]
    moved = [View(f"moved {v.name}", v.left, v.right + (3.0, 0)) for v in views[:2]]
    assert not any("nothing new" in why for _, why in calibrate([*views, *moved]).dropped)


@pytest.mark.parametrize("degrees", [-90, 90, 180, 45])
def test_a_camera_on_its_side_is_refused(calibrate, degrees):
    rng = np.random.default_rng(4)
    rig = known_rig(rng)
    rolled = turned((0, 0, degrees)) @ rig.rotation
    rig = replace(rig, rotation=rolled, translation=rolled @ rig.rotation.T @ rig.translation)
    with pytest.raises(CalibrationError, match=r"turned by \d+° about its own axis") as refused:
        calibrate(hold(rng, rig, bent_board(rng), 12, reach=0.2))
    assert refused.value.fault == "upside_down"


def test_a_large_picture_may_miss_by_more_pixels(case, calibrate):
    """What is rough is told in pixels of a picture of 640 across: four thousand pixels are finer ones."""
    found = replace(calibrate(case[2]), rms_px=1.2)
    assert verdict_on(found, BOARD)[0] == "poor"
    four = lambda matrix: matrix * np.array([[6.0], [6.0], [1.0]])
    large = replace(
        found, image_size=(3840, 2880), left_matrix=four(found.left_matrix), right_matrix=four(found.right_matrix)
    )
    assert not any("reprojection error" in reason for reason in verdict_on(large, BOARD)[1])


def test_a_place_in_the_rectified_frame_moves_as_its_slopes_say(case, calibrate):
    """The frame turns with the cameras: the same pixels, through a rig that was changed a little."""
    found = calibrate(case[2])
    places = np.array([[0, 0, 1000.0], [200, -100, 1500.0], [-150, 80, 700.0]])
    raw = places @ found.rectified["left"][0]
    pixels = [bundle.project(raw, found.rig.left)[0]]
    pixels.append(bundle.project(raw @ found.rotation.T + found.translation_mm, found.rig.right)[0])
    for k, step in ((19, 1e-5), (20, 1e-5), (21, 0.01), (22, 0.01), (23, 0.01)):
        rig = found.rig.moved(step * (np.arange(bundle.CAMERAS) == k))
        moved = replace(found, rotation=rig.rotation, translation_mm=rig.translation)
        told = moved.triangulate(
            *(moved.rectify_points(p, side) for p, side in zip(pixels, ("left", "right"), strict=True))
        )
        assert told - places == pytest.approx(found.place_slopes(places)[..., k] * step, rel=0.05, abs=1e-3)


def test_two_cameras_that_share_no_corner_know_no_row_error(case, calibrate):
    """The left one sees the left half of each board, the right one the other half."""
    half = np.arange(54) % 9 < 4
    views = [
        View(v.name, np.where(half[:, None], v.left, np.nan), np.where(half[:, None], np.nan, v.right)) for v in case[2]
    ]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert np.isnan(calibrate(views).vertical_error_px)


def test_parallel_boards_are_refused(case, calibrate):
    rig, board, _ = case
    rng, views = np.random.default_rng(5), []
    middle = board.mean(0)
    while len(views) < 14:
        far = rng.uniform(350, 800)
        across = rng.uniform(-0.25, 0.25, 2) * SIZE / rig.matrices[0][0, 0] * far
        held = (board - middle) @ turned((0, 0, rng.uniform(-20, 20))).T + [*across, far]
        if rig.inside(held):
            views.append(View(f"{len(views):03d}", *(p + rng.normal(0, 0.04, p.shape) for p in rig.see(held))))
    with pytest.raises(CalibrationError, match="Tilt the board"):
        calibrate(views)


def fisheye(points, field_deg):
    """An equidistant lens: the distance from the middle grows with the angle."""
    across = np.hypot(points[:, 0], points[:, 1])
    out = SIZE[0] / np.radians(field_deg) * np.arctan2(across, points[:, 2]) / across
    return points[:, :2] * out[:, None] + np.array(SIZE) / 2


def test_a_fisheye_is_never_called_good(case, calibrate):
    rng, board = np.random.default_rng(6), case[1]
    middle, views = board.mean(0), []
    while len(views) < 20:
        right, down = np.radians(rng.uniform(-60, 60)), np.radians(rng.uniform(-45, 45))
        toward = turned(np.degrees((-down, 0, 0))) @ turned(np.degrees((0, right, 0)))
        held = ((board - middle) @ turned(rng.uniform(-30, 30, 3)).T + [0, 0, rng.uniform(200, 450)]) @ toward.T
        seen = [fisheye(held - [x, 0, 0], 150) for x in (0, 100)]
        if all(((p > 3) & (p < np.array(SIZE) - 3)).all() for p in seen):
            views.append(View(f"{len(views):03d}", *(p + rng.normal(0, 0.04, p.shape) for p in seen)))
    try:
        assert calibrate(views).verdict == "poor"
    except CalibrationError:
        pass


class Counted:
    """Pairs of pictures without a board, that count how often one is looked at."""

    def __init__(self, name, looked):
        self.name, self._looked = name, looked

    @property
    def left(self):
        self._looked.append(self.name)
        return np.full((480, 640), 128, np.uint8)

    right = left


def test_no_boards_are_told_after_two_dozen_pairs(monkeypatch):
    looked = []
    monkeypatch.setattr(search, "find_corners", lambda *_: None)
    monkeypatch.setattr(refusals, "check_board_size", lambda *_: None)  # tries thirty sizes: no matter here
    with pytest.raises(CalibrationError, match="found in 0 of 24 pairs, picked from 90"):
        search.find_views([Counted(f"{k:03d}", looked) for k in range(90)], BOARD)
    assert len(set(looked)) <= 24


def test_two_moments_are_told_after_two_dozen_pairs(case, monkeypatch):
    rig, board, _ = case
    views = hold(np.random.default_rng(8), rig, board, 30)
    looked = []
    corners = iter([p for k, v in enumerate(views) for p in (v.left, views[(k + 7) % 30].right)] * 2)
    monkeypatch.setattr(search, "find_corners", lambda *_: next(corners).astype(np.float32))
    with pytest.raises(CalibrationError, match="same moment"):
        search.find_views([Counted(v.name, looked) for v in views], BOARD)
    assert len(set(looked)) <= 24


@pytest.mark.parametrize(
    ("rms_px", "says"),
    [(0.2, "parallel to the picture"), (0.3, "parallel to the picture"), (1.7, "contradict each other by 1.7 px")],
)
def test_a_focal_length_left_open_has_two_causes(rms_px, says):
    """Boards that fit and tell nothing were never tilted; boards that do not fit were seen by cameras that moved."""
    refusals.check_focal(4.9, rms_px)
    with pytest.raises(CalibrationError, match=says):
        refusals.check_focal(6.0, rms_px)


def test_every_unit_that_squares_may_be_in_is_asked_after():
    assert unit_asked(6, 2.5) == (
        "Is square_mm in centimetres or inches? Then it is 25 or 63.5 mm, and they stand 60 or 152 mm apart."
    )
    assert unit_asked(60, 25) == ""


def test_what_is_no_picture_no_side_and_no_board_is_told(case, calibrate):
    found = calibrate(case[2])
    with pytest.raises(CalibrationError, match="was its file found"):
        found.rectify(None, None)
    with pytest.raises(CalibrationError, match="uint8; got .480, 640. and int64"):
        found.rectify(*[np.zeros((480, 640), np.int64)] * 2)
    for ask in (
        found.camera,
        lambda side: found.boards_at([[1, 2]], side),
        lambda side: found.rectify_points([[1, 2]], side),
    ):
        with pytest.raises(CalibrationError, match='"left" or "right"; got .middle.'):
            ask("middle")
    with pytest.raises(CalibrationError, match="these are no numbers"):
        found.boards_at("here", "left")
    names = [view.name for view in case[2]]
    with pytest.raises(
        CalibrationError, match=r"corners of a board with 7x5 .*shape .35, 2.; 000 has .54, 2. and .54, 2."
    ):
        recipe.calibrate_views(case[2], Board(7, 5, 25.0), SIZE, names)
    with pytest.raises(CalibrationError, match="in 0 different places in 0 pairs"):
        recipe.calibrate_views([], BOARD, SIZE, [])
