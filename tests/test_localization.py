"""The localizer's two ways, and the numbers by which it weighs and judges."""

import json
import math
import re
import shutil
from dataclasses import replace
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from conftest import ROOT
from stereo_lab.cli import main
from stereo_lab.detection import BallDetector, Detection
from stereo_lab.errors import StereoLabError
from stereo_lab.live import open_source, touch_in_turn
from stereo_lab.live import run as run_cell
from stereo_lab.localization import Localizer, disparities, doubt, find_pair, matching, ours, paper, sphere
from stereo_lab.position import RigidFit
from stereo_lab.recording import open_recording
from stereo_lab.results import evaluation, figures, report
from stereo_lab.results.limit import DepthLimit
from tests.written import assert_as_written


@pytest.fixture(scope="module")
def by_paper(bench, bench_calibration):
    return Localizer.fit(bench, "paper", bench_calibration)


@pytest.fixture(scope="module")
def by_cone(bench, bench_calibration):
    return Localizer.fit(bench, calibration=bench_calibration)


def test_both_ways_detect_in_raw_pixels(bench, by_paper, by_cone):
    for localizer, allowed in ((by_paper, 3.0), (by_cone, 0.3)):
        apart = []
        for sample in bench.samples("evaluation")[:6]:
            true = bench.true_ball("evaluation", sample.pair.name)
            pair = localizer.detect(sample.pair.left, sample.pair.right)
            apart += [math.dist(d.center_px, true[side][:2]) for d, side in zip(pair, ("left", "right"), strict=True)]
        assert np.median(apart) < allowed  # one circle of Hough's may sit on the rim's other side


def test_residuals_of_the_papers_way_stand_where_a_model_is_fitted(bench, by_paper):
    """x and y of the four position samples, depth of the three depth samples, and nothing else."""
    told = np.isfinite(by_paper.residuals_mm)
    assert told.tolist() == [[True, True, False]] * 4 + [[False, False, True]] * 3
    assert 0 < np.nanmax(np.abs(by_paper.residuals_mm[:, :2])) < 20
    assert np.abs(by_paper.residuals_mm[4:, 2]).max() < 1e-6  # Eq. 4 goes through its three samples
    found = [s for s in bench.samples("position") if s.use == "fit"]
    place = by_paper.locate(found[1].pair.left, found[1].pair.right)
    assert by_paper.residuals_mm[1, 0] == pytest.approx(place.x_mm - found[1].measured.x_mm, abs=1e-6)


def test_residuals_of_our_way_are_model_minus_ruler(bench, by_cone):
    sample = bench.samples("depth")[2]
    place = by_cone.locate(sample.pair.left, sample.pair.right)
    gap = [
        place.x_mm - sample.measured.x_mm,
        place.y_mm - sample.measured.y_mm,
        place.depth_mm - sample.measured.depth_mm,
    ]
    assert by_cone.residuals_mm[8 + 2] == pytest.approx(gap, abs=1e-6)


def test_samples_left_out_are_not_fitted_on(bench, bench_calibration):
    judges = [s for s in bench.samples("depth") if s.use == "check"]
    assert len(Localizer.fit(bench, calibration=bench_calibration, leave_out=judges).residuals_mm) == 14 - len(judges)


def test_unknown_method(bench):
    with pytest.raises(StereoLabError, match="no method 'magic'"):
        Localizer.fit(bench, "magic")


class Eyes:
    """A detector that sees what it is told to, one picture after the other."""

    def __init__(self, *seen):
        self.seen = list(seen)

    def detect(self, image):
        return self.seen.pop(0)


def test_a_wrong_lock_is_a_missed_sample(bench, bench_calibration):
    """One pair of circles with a disparity of zero or less, and one without a circle, are missed; the rest goes on."""
    good = [Detection(300 + d, 200, 20, 1) for d in (90, 0, 70, 0, 50, 0)]
    fit = [replace(s, use="fit") for s in bench.samples("depth")[:5]]
    eyes = Eyes(good[1], good[0], None, good[1], *good)
    seen, places, missed, _ = paper._rectified_samples(bench, "depth", {"depth": fit}, bench_calibration, eyes, 3)
    assert seen[:, 2].tolist() == [90, 70, 50] and missed == ["depth/000", "depth/001"]
    assert places[:, 2].tolist() == [s.measured.depth_mm for s in fit[2:]]


def test_swapped_cameras_are_guessed_by_the_papers_way(bench, bench_calibration):
    fit = [replace(s, use="fit") for s in bench.samples("depth")[:3]]
    eyes = Eyes(*[Detection(300 + d, 200, 20, 1) for d in (0, 90, 0, 70, 0, 50)])
    with pytest.raises(StereoLabError, match="swapped"):
        paper._rectified_samples(bench, "depth", {"depth": fit}, bench_calibration, eyes, 3)


@pytest.mark.parametrize(("needed", "stand_ins"), [(2, []), (3, ["depth/003"])])
def test_a_check_sample_stands_in_where_too_few_are_left(bench, bench_calibration, needed, stand_ins):
    first = bench.samples("depth")[:5]
    samples = [replace(s, use="fit" if k < 3 else "check") for k, s in enumerate(first)]
    good = [Detection(300 + d, 200, 20, 1) for d in (90, 0, 70, 0, 50, 0)]
    eyes = Eyes(*good[:4], None, None, *good[4:])
    told = paper._rectified_samples(bench, "depth", {"depth": samples}, bench_calibration, eyes, needed)
    assert told[2:] == (["depth/002"], stand_ins) and len(told[0]) == 2 + len(stand_ins)


def test_missed_samples_are_named_with_their_set(bench, bench_calibration, tmp_path):
    samples = {"position": bench.samples("position"), "depth": bench.samples("depth")}
    black = tmp_path / "position" / "left" / "black.png"
    black.parent.mkdir(parents=True)
    cv2.imwrite(str(black), np.zeros((480, 640, 3), np.uint8))
    broken = replace(samples["position"][2], pair=replace(samples["position"][2].pair, left_path=black))
    samples["position"] = (*samples["position"][:2], broken, *samples["position"][3:])
    assert ours.ConeWay.fit(bench, samples, bench_calibration, "red")[2] == ("position/002",)


def test_disparity_is_told_in_rectified_pixels(bench, bench_calibration, by_cone):
    samples = bench.samples("depth")
    told, found = disparities(by_cone, samples)
    true = [bench.true_ball("depth", s.pair.name) for s in found]
    columns = [bench_calibration.rectify_points([t[side][:2] for t in true], side)[:, 0] for side in ("left", "right")]
    assert len(found) == len(samples) and np.abs(told - (columns[0] - columns[1])).max() < 0.3


def test_the_ruler_is_as_good_as_the_recordings_say(bench):
    """Half a millimetre of reading and the rounding to whole ones; held against what was really measured."""
    samples = [*bench.samples("position"), *bench.samples("depth")]
    gaps = [
        getattr(s.measured, axis) - getattr(s.truth, axis) for s in samples for axis in ("x_mm", "y_mm", "depth_mm")
    ]
    assert pytest.approx(math.hypot(0.5, 1 / math.sqrt(12)), rel=0.1) == doubt.RULER_SIGMA_MM
    assert pytest.approx(np.std(gaps), rel=0.35) == doubt.RULER_SIGMA_MM


def test_samples_are_weighed_by_what_is_known_of_them(bench_calibration):
    """Far away the pixels decide along the line of sight, near by and across it the ruler."""
    pixels = doubt.pixel_sigma(bench_calibration, np.array([[0, 0, 500.0], [0, 0, 4000.0]]))
    near, far = np.hypot(pixels, doubt.RULER_SIGMA_MM)
    assert near == pytest.approx([doubt.RULER_SIGMA_MM] * 3, rel=0.1)
    pixels = bench_calibration.depth_per_px(4000.0) * doubt.CENTER_SIGMA_PX * math.sqrt(2)
    assert far[2] == pytest.approx(math.hypot(pixels, doubt.RULER_SIGMA_MM)) and far[2] > 10 * far[0] / 2


def test_both_pictures_must_tell_one_size(bench, bench_calibration):
    """A round thing on the same row, half as large again, is another thing; so is one of two and a half radii off the row."""
    sample = bench.samples("depth")[1]
    true = bench.true_ball("depth", sample.pair.name)
    left, right = (Detection(*true[side], 0.9) for side in ("left", "right"))
    same = lambda one, other: matching.size_errors(bench_calibration, bench.ball.diameter_mm, one, other)
    assert same(left, right) and same(replace(left, radius_px=1.1 * left.radius_px), right)
    for share in (0.65, 1.5):
        assert not same(replace(left, radius_px=share * left.radius_px), right)
        assert not same(left, replace(right, radius_px=share * right.radius_px))
    assert not same(left, replace(right, v=right.v + 0.5 * right.radius_px))


@pytest.mark.parametrize(("focal_px", "baseline_mm", "depth_mm"), [(690, 120, 400), (400, 300, 400), (320, 300, 600)])
@pytest.mark.parametrize("u", [20, 600])
def test_each_camera_sees_a_ball_from_its_own_place(bench_calibration, focal_px, baseline_mm, depth_mm, u):
    """Near a wide rig, at the rim of both pictures, it is half as far again from one camera as from the other."""
    matrix = np.array([[focal_px, 0, 319.5], [0, focal_px, 239.5], [0, 0, 1.0]])
    lens = {"left_distortion": np.zeros(5), "right_distortion": np.zeros(5), "rotation": np.eye(3)}
    apart = {"translation_mm": np.array([-baseline_mm, 0, 0.0])}
    rig = replace(bench_calibration, left_matrix=matrix, right_matrix=matrix, **lens, **apart)
    x = (u - 319.5) / focal_px * depth_mm + baseline_mm * (u < 320)
    seen = []
    for lens_x in (0, baseline_mm):
        distance = np.linalg.norm([x - lens_x, 0, depth_mm])
        radius = focal_px * 20 / np.sqrt(distance**2 - 20**2)
        seen.append(Detection(focal_px * (x - lens_x) / depth_mm + 319.5, 239.5, radius, 0.9))
    assert sum(matching.size_errors(rig, 40.0, *seen)) < 0.1


@pytest.mark.parametrize("place", [(700, 350, 2000), (0, 0, 1000), (-300, 200, 800)])
def test_noise_moves_a_place_along_its_ray(bench_calibration, by_cone, place):
    """What is told of x, y and depth is what ten thousand noisy pixels do; off the axis most of x is the depth's error."""
    rig, rigid, rng = bench_calibration, by_cone.way.rigid, np.random.default_rng(7)
    f, b, (x, y, z), sigmas = rig.focal_px, rig.baseline_mm, place, (0.1, 0.13)
    left, right = (
        np.array([f * (x - lens_x) / z, f * y / z]) + rng.normal(0, s, (10_000, 2))
        for lens_x, s in zip((0, b), sigmas, strict=True)
    )
    depth = f * b / (left[:, 0] - right[:, 0])
    points = np.stack([left[:, 0] * depth / f, (left[:, 1] + right[:, 1]) / 2 * depth / f, depth], 1)
    told = np.linalg.norm(doubt._by_pixels(rig, rigid, np.array([place], float), sigmas)[0], axis=1)
    assert told == pytest.approx(rigid.predict(points).std(axis=0), rel=0.03)


def test_a_size_that_is_off_speaks_against_a_pair(bench, bench_calibration):
    true = bench.true_ball("depth", bench.samples("depth")[1].pair.name)
    left, right = (Detection(*true[side], 0.9) for side in ("left", "right"))
    off = [
        sum(matching.size_errors(bench_calibration, 40.0, replace(left, radius_px=share * left.radius_px), right))
        for share in (1.0, 1.05, 1.1, 1.15)
    ]
    assert off[0] < 0.5 and off == sorted(off)
    assert off[2] > off[0] + 1.5  # a tenth is worth some usual errors, not a part of one


@pytest.mark.parametrize("side", ["left", "right"])
def test_where_the_other_camera_must_see_it(bench, bench_calibration, side):
    """By the ball's size alone; one of the circles lies on the ball, and all on its epipolar line."""
    for sample in bench.samples("depth"):
        true = bench.true_ball("depth", sample.pair.name)
        other = {"left": "right", "right": "left"}[side]
        circles = np.array(matching.seen_by_the_other(bench_calibration, 40.0, Detection(*true[side], 0.9), side))
        off = circles - true[other]
        nearest = np.abs(off[:, 0]).argmin()
        assert np.hypot(*off[nearest, :2]) < 0.5 * true[other][2] and abs(off[nearest, 2]) < 0.1 * true[other][2]
        rows = bench_calibration.rectify_points(circles[:, :2], other)[:, 1]
        assert (
            np.ptp(rows) < 0.1 and abs(rows[0] - bench_calibration.rectify_points([true[side][:2]], side)[0, 1]) < 0.5
        )


@pytest.mark.slow
def test_one_camera_tells_the_other_where_to_look(bench_calibration):
    """In one picture the ball is sure, in the other a red thing touches it: there its first look fails."""
    room = open_recording(ROOT / "data" / "clutter_test")
    detectors = [BallDetector("red", camera=bench_calibration.camera(side)) for side in ("left", "right")]
    for pair in (p for p in room.pairs("pairs") if p.name in ("001", "032")):
        true = room.true_ball("pairs", pair.name)
        found = find_pair(bench_calibration, detectors, room.ball.diameter_mm, pair.left, pair.right)
        for ball, side in zip(found, ("left", "right"), strict=True):
            assert np.hypot(ball.u - true[side][0], ball.v - true[side][1]) < 1


def test_two_pictures_of_one_ball_correct_each_other(bench, bench_calibration, by_cone):
    """A bar of the ball's lightness behind it leads the left edge astray; the right picture shows the whole rim."""
    alone, both = [], []
    for sample in bench.samples("evaluation")[:10]:
        true = bench.true_ball("evaluation", sample.pair.name)
        u, v, r = true["left"]
        barred = sample.pair.left.copy()
        cv2.rectangle(
            barred, (round(u + 0.7 * r), round(v - 2 * r)), (round(u + 1.3 * r), round(v + 2 * r)), (70, 60, 70), -1
        )
        ball = np.zeros(barred.shape[:2], np.uint8)
        cv2.circle(ball, (round(u), round(v)), round(r), 255, -1, cv2.LINE_AA)
        share = ball[..., None] / 255
        left = np.round(share * sample.pair.left + (1 - share) * barred).astype(np.uint8)
        seen = [d.detect(image) for d, image in zip(by_cone.way.detectors, (left, sample.pair.right), strict=True)]
        fitted = sphere.one_sphere(bench_calibration, *seen)
        alone.append(math.dist(seen[0].center_px, true["left"][:2]))
        both.append(math.dist(fitted[0].center_px, true["left"][:2]))
        assert math.dist(fitted[1].center_px, true["right"][:2]) < 0.25
    assert np.mean(both) < 0.75 * np.mean(alone)


def test_clean_rims_have_the_disparity_of_the_ball_that_fits_both(bench, bench_calibration, by_cone, monkeypatch):
    """So they are spared the fit, which would take a seventh of the time of following a pair."""
    moved = []
    for sample in bench.samples("evaluation")[:10]:
        seen = [d.detect(i) for d, i in zip(by_cone.way.detectors, (sample.pair.left, sample.pair.right), strict=True)]
        if min(ball.cone.on for ball in seen) >= sphere.CLEAN:
            assert sphere.one_sphere(bench_calibration, *seen) == tuple(seen)
            with monkeypatch.context() as patch:
                patch.setattr(sphere, "CLEAN", 2)
                left, right = sphere.one_sphere(bench_calibration, *seen)
            assert (left, right) != tuple(seen)
            moved.append((left.u - right.u) - (seen[0].u - seen[1].u))
    assert len(moved) >= 5 and np.abs(moved).max() < 0.01


def test_before_books_and_plants_both_edges_are_looked_for_again(monkeypatch):
    """Nearly every ball of the third rig is unsure at first sight. By what is quiet round it its depth gains a third."""
    third = open_recording(ROOT / "data" / "third_rig")
    fitted = Localizer.fit(third, "cone")
    localizer = replace(fitted, way=replace(fitted.way, backgrounds=()))

    def depth_errors():
        samples = third.samples("evaluation")
        places = [localizer.locate(sample.pair.left, sample.pair.right) for sample in samples]
        return [abs(p.depth_mm - s.truth.depth_mm) for p, s in zip(places, samples, strict=True)]

    again = depth_errors()
    monkeypatch.setattr(matching, "surer", lambda looks, pair, backgrounds: pair)
    assert np.mean(again) < 0.67 * np.mean(depth_errors())


def test_where_one_picture_is_unsure_the_other_is_looked_at_by_the_same():
    looked = []
    ball = Detection(320, 240, 15, 0.9, sigma_px=0.03)
    detector = SimpleNamespace(again=lambda image, ball: looked.append(image) or replace(ball, u=0.0))
    looks = (detector, "left"), (detector, "right")
    assert matching.surer(looks, (ball, ball)) == (ball, ball) and not looked
    pair = matching.surer(looks, (ball, replace(ball, sigma_px=0.3)))
    assert looked == ["left", "right"] and [b.u for b in pair] == [0, 0]


def test_rays_that_do_not_meet_before_the_cameras_are_no_place(by_cone):
    here = Detection(320, 240, 15, 0.9)
    assert by_cone.position(here, Detection(250, 240, 15, 0.9)).depth_mm > 0
    assert by_cone.position(here, here) is None or by_cone.position(here, here).depth_mm > 3000
    assert by_cone.position(Detection(250, 240, 15, 0.9), here) is None


def test_a_picture_that_was_not_found_is_said(by_cone, bench):
    with pytest.raises(StereoLabError, match="there is none; was its file found"):
        by_cone.locate(None, bench.pairs("evaluation")[0].right)


def test_detections_without_edges_stay_where_they_are(bench_calibration):
    pair = Detection(320, 240, 15, 0.9), Detection(250, 241, 15, 0.9)
    assert sphere.one_sphere(bench_calibration, *pair) == pair


def test_a_less_sure_centre_makes_a_less_sure_place(bench_calibration, by_cone):
    """Along the line of sight both pictures' pixels count; the detector tells how sure it is of each."""
    left, right = Detection(320, 240, 15, 0.9, 0.02), Detection(250, 240, 15, 0.9, 0.02)
    sure = by_cone.position(left, right).sigma_mm
    less = by_cone.position(replace(left, sigma_px=0.5), right).sigma_mm
    assert less[2] > 3 * sure[2] and less[0] > sure[0]
    untold = by_cone.position(*(replace(d, sigma_px=None) for d in (left, right))).sigma_mm
    assert untold == pytest.approx(by_cone.position(*(replace(d, sigma_px=0.03) for d in (left, right))).sigma_mm)


@pytest.mark.parametrize(("toe_deg", "roll_deg"), [(0, 0), (20, 0), (0, 30)])
def test_a_picture_that_rectification_enlarges_is_less_sure_in_its_pixels(bench_calibration, toe_deg, roll_deg):
    """Cameras that look toward each other, or are rolled: the scatter of triangulated depths is what is told of it."""
    turn = cv2.Rodrigues(np.radians([0.0, toe_deg, roll_deg]))[0]
    cameras = replace(bench_calibration, rotation=turn, translation_mm=turn @ [-300.0, 0, 0])
    place = np.array([150.0, 60, 800])
    u, v = (cv2.projectPoints(place, *pose, *cameras.camera(side))[0].ravel() for pose, side in poses_of(cameras))
    pair = [Detection(*center, 15, 0.9, 0.05) for center in (u, v)]
    scatter = np.random.default_rng(1).normal(0, 0.05, (2, 2000, 2))
    points = cameras.triangulate(
        cameras.rectify_points(u + scatter[0], "left"), cameras.rectify_points(v + scatter[1], "right")
    )
    told = doubt.pixel_sigma(cameras, points[:1], [doubt.center_sigmas(cameras, *pair)])
    assert points[:, 2].std() == pytest.approx(told[0, 2], rel=0.08)


def poses_of(cameras):
    """Turn and shift from the left camera's frame, as OpenCV takes them, and the side."""
    still = np.zeros(3)
    return ((still, still), "left"), ((cv2.Rodrigues(cameras.rotation)[0], cameras.translation_mm), "right")


@pytest.mark.parametrize(("wrong", "way"), [(1.006, "longer"), (0.994, "shorter")])
def test_samples_that_contradict_the_squares_are_believed_and_it_is_said(bench, bench_calibration, wrong, way):
    """Squares told 0.6 % wrong move the cameras apart by as much; the samples give it back, to what they know of it."""
    told = replace(bench_calibration, translation_mm=bench_calibration.translation_mm / wrong)
    fitted = Localizer.fit(bench, calibration=told).way
    assert fitted.rigid.scale == pytest.approx(wrong, abs=3 * fitted.rigid.scale_sigma) and fitted.rigid.scale != 1
    assert f"% {way} than they were said" in fitted.squares_told and "standard deviations" in fitted.squares_told


def test_a_few_samples_do_not_speak_against_the_squares(by_cone):
    """Right squares stay, also where three samples alone, 5 mm beside their places, would have them longer."""
    assert by_cone.way.rigid.scale == 1 and by_cone.way.squares_told == ""
    rng = np.random.default_rng(6)
    camera = rng.uniform((-200, -150, 700), (200, 150, 1500), (14, 3))
    sigma, measured = np.full((14, 3), 0.6), camera + rng.normal(0, 0.3, (14, 3))
    assert doubt.fit_bench(camera, 1.006 * measured, sigma).scale == pytest.approx(1.006, abs=0.002)
    widest = np.argsort(-np.abs(camera[:, 0]))[:3]
    measured[widest, 0] += 5 * np.sign(camera[widest, 0])
    assert RigidFit.fit(camera, measured, sigma, free_scale=True).scale > 1.002
    assert doubt.fit_bench(camera, measured, sigma).scale == 1


def test_what_one_sample_does_to_the_scale_is_what_a_fit_without_it_gives():
    """The jackknife to first order against fits without each sample, where errors are larger than they are said to be."""
    rng = np.random.default_rng(5)
    camera = rng.uniform((-200, -150, 700), (200, 150, 1500), (14, 3))
    measured, sigma = camera + rng.normal(0, 1, (14, 3)), np.full((14, 3), 0.6)
    told = RigidFit.fit(camera, measured, sigma, free_scale=True).scale_sigma
    without = [
        RigidFit.fit(*(np.delete(a, k, 0) for a in (camera, measured, sigma)), free_scale=True).scale for k in range(14)
    ]
    assert told == pytest.approx(np.sqrt(13 * np.var(without)), rel=0.15)
    assert RigidFit.fit(camera, measured, sigma).scale_sigma == 0


def test_a_ball_marks_its_own_colour_where_its_name_misses_some(bench, bench_calibration, monkeypatch):
    """By the name two samples are missed here; the colour that the others teach finds them, and the way says so."""
    looked = ours._look

    def short_sighted(calibration, color, *told):
        detectors, seen = looked(calibration, color, *told)
        return detectors, seen if color.name == "learned" else dict(list(seen.items())[2:])

    monkeypatch.setattr(ours, "_look", short_sighted)
    fitted = Localizer.fit(bench, calibration=bench_calibration)
    assert fitted.missed == () and fitted.way.detectors[0].color.marks
    assert "name red the ball was found in 12 of 14" in fitted.way.color_told and "in 14: that" in fitted.way.color_told
    monkeypatch.setattr(ours, "_look", looked)
    plain = Localizer.fit(bench, calibration=bench_calibration)
    assert plain.way.color_told == "" and plain.way.detectors[0].color.name == "red"


@pytest.mark.parametrize(
    ("off", "radius", "hit"), [(2.9, 5, True), (3.1, 5, False), (9.9, 40, True), (10.1, 40, False), (0, 1, True)]
)
def test_what_a_hit_is(off, radius, hit):
    assert evaluation.is_hit(Detection(100 + off, 50, radius, 1), (100, 50, radius)) is hit
    assert not evaluation.is_hit(None, (100, 50, radius))


def test_the_papers_own_numbers():
    """Its Fig. 8: within a centimetre; its Fig. 9: 0.8 cm on average."""
    assert (report.PAPER_DEPTH_MM, figures.PAPER_PLANE_MM) == (8.0, 10.0)
    both = {axis: {"mean": 1.0, "p95": 2.0} for axis in ("x_mm", "y_mm", "depth_mm")}
    facts = {"evaluation": {m: {"volume": both, "plane": both} for m in ("paper", "cone")}, "limit_depth_mm": None}
    told = {what: paper for what, paper, *_ in report._evaluation_rows(facts)}
    assert told["depth in the whole volume, mean (95 %) error (mm)"] == "8"
    assert told["x in the arm's plane, mean (95 %) error (mm)"] == "±10"


@pytest.mark.parametrize("sigma", [0.0, math.inf])
def test_pictures_without_noise_or_without_an_outline_tell_no_limit(bench, bench_calibration, sigma):
    """A program may have smoothed the noise away, or taken one picture again and again: the page comes without that sentence."""
    sample = bench.judges("volume")[0]
    limit = DepthLimit((sample.pair.full_name,), np.array([sigma]), np.array([sigma]), "still")
    found = {"cone": [(sample, replace(sample.reference, sigma_mm=(1.0, 1.0, 1.0)))]}
    results = evaluation.Results(bench, bench_calibration, "made just now", found=found, limit=limit)
    assert results.facts()["reached_over_limit"] is None and "The noise of the pictures" not in report.page(results)
    noisy = replace(results, limit=replace(limit, sigma_d_px=np.array([0.1]), sigma_mm=np.array([1.0])))
    assert "The noise of the pictures" in report.page(noisy)


def test_a_run_goes_on_where_the_papers_way_cannot_be_fitted(bench, bench_calibration, monkeypatch):
    def refuse(*_, **__):
        raise StereoLabError("three samples are needed")

    monkeypatch.setattr(paper.PaperWay, "fit", refuse)
    monkeypatch.setattr(evaluation, "clutter_of", lambda _: None)
    monkeypatch.setattr(evaluation, "_snaps", lambda *_: None)
    few = SimpleNamespace(**{**vars(bench), "judges": lambda: bench.judges("plane")[:2]})
    for name in ("samples", "pairs", "has_samples", "sets", "name", "rendered", "true_ball", "calibrated_by"):
        setattr(few, name, getattr(bench, name))
    results = evaluation.evaluate(few)
    assert set(results.localizers) == {"cone"} and "three samples" in results.failed["paper"]
    page = report.page(results)
    assert "cannot be fitted" in page and "x in the arm's plane" in page


def _exchange(folder):
    """Left for right."""
    for name, new in (("left", "x"), ("right", "left"), ("x", "right")):
        (folder / name).rename(folder / new)


def _in_centimetres(folder):
    """Each number of the table divided by ten."""
    head, *lines = (folder / "measured.csv").read_text().splitlines()
    rows = [line.split(",") for line in lines]
    rows = [[name, *(f"{float(n) / 10:g}" for n in (x, y, depth)), use] for name, x, y, depth, use in rows]
    (folder / "measured.csv").write_text("\n".join([head, *map(",".join, rows)]) + "\n")


@pytest.mark.parametrize(("name", "spoil", "says"), [
    ("position", lambda _: None, None),
    ("position", _exchange, "In 8 of 14 measured pairs the two cameras show no ball in one place, and they are left out of the fit: position/000, "),
    ("evaluation", _exchange, "In 24 of 24 pairs that judge the two cameras show no ball in one place: evaluation/000, "),
    ("evaluation", _in_centimetres, "24 of 24 places are off by more than 6 times what cameras and ruler leave in doubt"),
])  # fmt: skip
def test_a_run_on_a_spoilt_recording_says_that_the_recording_is_at_fault(tmp_path, name, spoil, says):
    folder = tmp_path / "rig"
    shutil.copytree(ROOT / "data" / "second_rig", folder, ignore=shutil.ignore_patterns("truth.json"))
    spoil(folder / name)
    results = evaluation.evaluate(open_recording(folder))
    told, page = report.sentences(results), report.page(results)
    assert (page.find(says or "no such sentence") == 0) == (
        name == "evaluation"
    )  # before the table, where no place can be believed
    assert bool(report.warnings(results)) == (name == "evaluation")
    if says is None:
        assert not any("stereo-lab check" in sentence for sentence in told)
    else:
        assert any(sentence.startswith(says) for sentence in told), told
        assert told[-1].endswith(f"stereo-lab check {folder}")


def test_what_the_papers_way_had_to_fit_on_judges_neither_way(tmp_path):
    """Without an evaluation set the check samples judge; on three samples Eq. 4 has no error, wherever they lie."""
    folder = tmp_path / "rig"
    shutil.copytree(ROOT / "data" / "bench", folder, ignore=shutil.ignore_patterns("evaluation", "truth.json", "track"))
    for side in ("left", "right"):
        cv2.imwrite(str(folder / "depth" / side / "005.jpg"), np.full((480, 640, 3), 200, np.uint8))
    results = evaluation.evaluate(open_recording(folder))
    assert results.localizers["paper"].way.stand_ins == ("depth/004",)
    judges = {method: [s.pair.full_name for s, _ in found] for method, found in results.found.items()}
    assert judges["paper"] == judges["cone"] and "depth/004" not in judges["cone"]
    assert np.abs(results.errors("paper", "volume")[0][:, 2]).min() > 0.1
    assert any("stand in, and judge nothing: depth/004." in sentence for sentence in report.sentences(results))


def test_what_does_not_belong_to_a_recording_is_refused_by_its_fit(bench, bench_calibration):
    other = replace(bench_calibration, image_size=(1280, 720))
    with pytest.raises(StereoLabError, match="is for pictures of 1280x720 pixels; those of .* are 640x480"):
        Localizer.fit(bench, calibration=other)
    for wrong in (["000"], bench.samples("position")[0], 3):
        with pytest.raises(StereoLabError, match="leave_out: expected a list of samples"):
            Localizer.fit(bench, calibration=bench_calibration, leave_out=wrong)


def test_places_in_metres_are_asked_for_their_unit():
    camera = np.array([[0, 0, 900], [200, 0, 900], [0, 150, 1000], [200, 150, 1400]], float)
    with pytest.raises(StereoLabError, match="are they in metres or centimetres"):
        RigidFit.fit(camera, camera * [1, -1, -1] / 1000, np.full((4, 3), 0.6))


def test_what_is_no_pair_of_detections_is_refused(bench, by_cone, by_paper):
    pictures = bench.pairs("position")[0].left, bench.pairs("position")[0].right
    pair = by_cone.detect(*pictures)
    for localizer in (by_cone, by_paper):
        for near in ((1, 2), ((1, 2), (3, 4)), pair[0], pair * 2):
            with pytest.raises(StereoLabError, match="Expected two detections"):
                localizer.locate(*pictures, near=near)
        with pytest.raises(StereoLabError, match=r"Expected two detections, .* got \(None, None\)"):
            localizer.position(None, None)
    assert by_cone.locate(*pictures, near=pair)


def measured_otherwise(folder, mistake):
    """The second rig with other numbers in its tables: ``mistake`` makes them of x, y, depth and the number of the line."""
    shutil.copytree(ROOT / "data" / "second_rig", folder)
    for name in ("position", "depth"):
        table = folder / name / "measured.csv"
        head, *lines = (line.split(",") for line in table.read_text().splitlines())
        lines = [[line[0], *map(str, mistake(*map(float, line[1:4]), k)), *line[4:]] for k, line in enumerate(lines)]
        table.write_text("\n".join(",".join(line) for line in [head, *lines]) + "\n")
    return folder


@pytest.mark.parametrize(
    ("mistake", "doubts", "misleads"),
    [
        (lambda x, y, depth, k: (x, y, depth), "", False),
        (lambda x, y, depth, k: (x + 90 * (k == 6), y, depth), "contradict each other, 1 of 14 by more", False),
        (lambda x, y, depth, k: (x + 90 * (k % 3), y, depth), r"contradict each other, \d of 14 by more", True),
        (lambda x, y, depth, k: (x / 10, y / 10, depth / 10), "0.1 times as long .* in another unit?", True),
        (lambda x, y, depth, k: (x, -y, depth), "fit only as a mirror shows them", True),
        (lambda x, y, depth, k: (y, x, depth), "fit only as a mirror shows them", True),
        (lambda x, y, depth, k: (x, -y, -depth), "y not up, or depth not away", True),
    ],
    ids=["right", "one line", "many lines", "centimetres", "sign of y", "x and y exchanged", "two signs"],
)
def test_tables_that_mislead_are_doubted_and_no_arm_moves_by_them(tmp_path, capsys, mistake, doubts, misleads):
    """One wrong line hardly moves the fit: then it is told, and the arm follows."""
    folder = measured_otherwise(tmp_path / "rig", mistake)
    fitted = Localizer.fit(open_recording(folder))
    assert len(fitted.doubts) == bool(doubts) and re.search(doubts, " ".join(fitted.doubts)), fitted.doubts
    assert fitted.misleads == misleads and not fitted.told
    run = ["run", "--recording", str(folder), "--seconds", "0.2"]
    assert main(run) == 0 and "".join(fitted.doubts) in capsys.readouterr().out
    assert main([*run, "--arm", "virtual://arm"]) == (2 if misleads else 0)
    told = capsys.readouterr()
    assert ("The arm moves" in told.out) != ("wrong places, and does not move" in told.err) == misleads
    if misleads:
        arm = SimpleNamespace(homed=True)
        for moves in (
            run_cell(open_source("bench"), fitted, arm),
            touch_in_turn(open_source("bench"), fitted, arm, None),
        ):
            with pytest.raises(StereoLabError, match="wrong places, and does not move"):
                next(moves)
    assert (f"stereo-lab check {folder}" in told.out) == bool(doubts)


def test_samples_that_contradict_the_others_are_named_the_worst_first(tmp_path):
    folder = measured_otherwise(tmp_path / "rig", lambda x, y, depth, k: (x + {1: 60, 4: 200}.get(k, 0), y, depth))
    unlike = Localizer.fit(open_recording(folder)).unlike
    assert set(unlike[:2]) == {"position/004", "depth/004"} and set(unlike[2:]) == {"position/001", "depth/001"}


class Few:
    """A recording of which only the first pictures of each set are looked at."""

    def __init__(self, recording, pictures):
        self._recording, self._pictures = recording, pictures

    def __getattr__(self, name):
        return getattr(self._recording, name)

    def pairs(self, name):
        return self._recording.pairs(name)[: None if name == "calibration" else self._pictures]

    def judges(self):
        return [*self._recording.judges("volume")[:3], *self._recording.judges("plane")[:3]]


def test_a_small_run_finds_what_is_written_down(bench, monkeypatch):
    monkeypatch.setattr(evaluation, "clutter_of", lambda _: Few(open_recording(ROOT / "data" / "clutter"), 2))
    steps = []
    results = evaluation.evaluate(Few(bench, 5), lambda *step: steps.append(step))
    facts = {key: value for key, value in results.facts().items() if key != "calibration"}
    pixels = {key: facts.pop(key) for key in ("center_px", "sigma_d_px", "limits")}
    said = lambda told: json.dumps(told, indent=0).splitlines()
    between_processors = {"absolute": 0.15, "relative": 0.03}  # mm: single pairs move by 0.1
    assert_as_written("evaluation/five pictures of a set", said(facts), between_processors)
    assert_as_written("evaluation/its pixels", said(pixels), {"absolute": 0.01, "relative": 0.03})
    assert_as_written("evaluation/its page", report.page(results).splitlines(), {"absolute": 0.2, "relative": 0.02})
    assert steps[0] == ("find the ball in single pictures", 0, 5)
    assert {(done, total) for step, done, total in steps if step == "locate the ball in pairs"} == {
        (k, 6) for k in range(7)
    }


def test_offsets_are_found_minus_true():
    balls = (Detection(5.0, 7.0, 3.0, 1.0), None, Detection(1.0, 2.0, 3.0, 1.0))
    assert evaluation._offsets(balls, ((4.0, 9.0, 3.0), (0, 0, 3.0), (1.5, 2.5, 3.0))) == [(1.0, -2.0), (-0.5, -0.5)]
