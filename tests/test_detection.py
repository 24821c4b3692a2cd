"""The detector against drawn balls, the shipped truth, and real photographs."""

import cv2
import numpy as np
import pytest

from conftest import ROOT
from stereo_lab.calibration import calibrate_recording, homography
from stereo_lab.common.files import read_table
from stereo_lab.detection import HUES, BallColor, BallDetector, cone, curves, hough
from stereo_lab.errors import StereoLabError
from stereo_lab.recording import open_recording, read_image
from stereo_lab.results.evaluation import is_hit
from tests.written import assert_as_written

MATRIX = np.array([[600.0, 0, 319.5], [0, 600, 239.5], [0, 0, 1]])
CAMERA = (MATRIX, np.zeros(5))


def draw_ball(center_mm, radius_mm=20.0, scale=6, ground=(190, 190, 190)):
    """An exactly projected, shaded red ball: every ray that meets the sphere is red. Drawn large round the ball only."""
    center = np.asarray(center_mm, float)
    pixel = MATRIX[:2] @ (center / center[2])
    reach = int(1.3 * 600 * radius_mm / center[2]) + 12
    (x0, y0), size = pixel.astype(int) - reach, 2 * reach
    v, u = np.mgrid[: size * scale, : size * scale]
    rays = np.stack(
        [(x0 + (u + 0.5) / scale - 0.5 - 319.5) / 600, (y0 + (v + 0.5) / scale - 0.5 - 239.5) / 600, np.ones(u.shape)],
        -1,
    )
    along = rays @ center
    square = (rays**2).sum(-1)
    inside = along**2 - square * (center @ center - radius_mm**2)
    hit = inside > 0
    point = rays * ((along - np.sqrt(np.clip(inside, 0, None))) / square)[..., None]
    light = np.clip((point - center) / radius_mm @ [-0.4, -0.7, -0.6], 0, 1)
    linear = np.full((*hit.shape, 3), (np.array(ground) / 255) ** 2.2)
    linear[hit] = (np.array([0.02, 0.02, 0.5]) * (0.25 + 0.75 * light[..., None]))[hit]
    linear = cv2.resize(cv2.GaussianBlur(linear, (0, 0), 0.7 * scale), (size, size), interpolation=cv2.INTER_AREA)
    image = np.full((480, 640, 3), ground, np.uint8)
    image[y0 : y0 + size, x0 : x0 + size] = np.round(255 * linear ** (1 / 2.2))
    return image, pixel


@pytest.mark.parametrize("center", [(0, 0, 800), (300, -180, 800), (-150, 120, 1500), (-220, 160, 550), (20, -10, 120)])
def test_cone_finds_the_centre_of_a_drawn_ball(center):
    image, pixel = draw_ball(center)
    found = BallDetector(BallColor.named("red"), "cone", CAMERA).detect(image)
    assert np.hypot(found.u - pixel[0], found.v - pixel[1]) < 0.06
    radius = 600 * 20 / np.sqrt(np.dot(center, center) - 400)
    assert found.radius_px == pytest.approx(radius, rel=0.03)


def test_near_gives_the_same_as_a_whole_search():
    image, _ = draw_ball((40, 30, 900))
    detector = BallDetector("red", "cone", CAMERA)
    whole = detector.detect(image)
    again = detector.detect(image, near=whole)
    assert (again.u, again.v) == pytest.approx((whole.u, whole.v), abs=0.03)


def test_cone_recovers_an_exact_cone():
    """Rays that touch a sphere, made without the detector: axis and half angle come back."""
    center, radius = np.array([120.0, -60, 700]), 25.0
    axis = center / np.linalg.norm(center)
    half = np.arcsin(radius / np.linalg.norm(center))
    side = np.linalg.svd(axis[None])[2][1:]
    angle = np.linspace(0, 2 * np.pi, 60)[:, None]
    rays = np.cos(half) * axis + np.sin(half) * (np.cos(angle) * side[0] + np.sin(angle) * side[1])
    pixels = rays @ MATRIX.T
    rays = curves.to_rays(pixels[:, :2] / pixels[:, 2:], CAMERA)
    fitted = curves.fit_cone(rays, CAMERA, (0, 0), np.ones(60))
    assert np.allclose(fitted.axis, axis, atol=1e-9)
    assert fitted.half_angle == pytest.approx(half, abs=1e-9)


def test_no_ball_is_none():
    rng = np.random.default_rng(3)
    empty = np.full((480, 640, 3), 190, np.uint8)
    noisy = rng.integers(0, 255, (480, 640, 3), np.uint8)
    square = empty.copy()
    cv2.rectangle(square, (200, 200), (300, 300), (30, 30, 180), -1)
    for image in (empty, noisy, square):
        assert BallDetector("red").detect(image) is None
    assert BallDetector("red", "paper").detect(empty) is None


def test_a_flat_disc_is_not_a_ball():
    image = np.full((480, 640, 3), 190, np.uint8)
    cv2.circle(image, (300, 200), 30, (40, 40, 190), -1, cv2.LINE_AA)
    assert BallDetector("red").detect(image) is None


def test_green_ball_is_not_red():
    image, _ = draw_ball((0, 0, 800))
    assert BallDetector("green").detect(image) is None
    assert BallDetector("green").detect(np.ascontiguousarray(image[..., [0, 2, 1]])) is not None


@pytest.mark.parametrize("image", [np.zeros((10, 10)), np.zeros((10, 10, 4), np.uint8), np.zeros((10, 10, 3))])
def test_other_arrays_are_refused(image):
    with pytest.raises(StereoLabError, match="colour picture"):
        BallDetector("red").detect(image)


def test_unknown_names_are_refused():
    with pytest.raises(StereoLabError, match="pink"):
        BallDetector("pink")
    with pytest.raises(StereoLabError, match="magic"):
        BallDetector("red", "magic")


def test_image_is_not_changed():
    image, _ = draw_ball((0, 0, 800))
    before = image.copy()
    for method in ("paper", "cone"):
        BallDetector("red", method).detect(image)
    assert np.array_equal(image, before)


def test_a_ball_that_stands_alone_is_found_without_votes(monkeypatch):
    """It is partly hidden, so its score is not what ends the search: nothing else in the picture is red."""
    image, (u, v) = draw_ball((0, 0, 600))
    image[:, : round(u) - 12] = 190
    monkeypatch.setattr(cone, "voted_circles", lambda copy: pytest.fail("votes are dear and not needed here"))
    ball = BallDetector("red", "cone", CAMERA).detect(image)
    assert np.hypot(ball.u - u, ball.v - v) < 0.1 and ball.score < cone.CLEAN


def test_shipped_snaps(bench, bench_calibration):
    detector = BallDetector("red", "cone", bench_calibration.camera("left"))
    paper = BallDetector("red", "paper")
    pairs = bench.pairs("snaps")[::5]
    for method, least in ((detector, len(pairs)), (paper, len(pairs) - 1)):
        hits = sum(is_hit(method.detect(p.left), bench.true_ball("snaps", p.name)["left"]) for p in pairs)
        assert hits >= least


@pytest.mark.slow
def test_real_green_ball(real_pictures):
    folder = real_pictures / "green_ball"
    taught = {"ball2_0060.jpg", "ball2_0624.jpg", "ball3_0235.jpg", "ball4_0230.jpg"}
    rows = [row for _, row in read_table(folder / "labels.csv", ("file", "u", "v", "radius_px"))]
    lessons = [r for r in rows if r["file"] in taught]
    circles = [tuple(float(r[k]) for k in ("u", "v", "radius_px")) for r in lessons]
    color = BallColor.from_samples([read_image(folder / r["file"]) for r in lessons], circles)
    detector, hits, false = BallDetector(color), 0, 0
    for row in (r for r in rows if r["file"] not in taught):
        found = detector.detect(read_image(folder / row["file"]))
        if row["u"]:
            hits += is_hit(found, [float(row[k]) for k in ("u", "v", "radius_px")])
        else:
            false += found is not None
    assert hits >= 15 and false <= 1


def test_tangent_circle_is_where_rays_touch():
    center, radius = np.array([120.0, -60.0, 700.0]), 20.0
    points = curves.tangent_circle(center, radius)
    assert np.allclose(np.linalg.norm(points - center, axis=1), radius)
    assert np.allclose(np.einsum("ij,ij->i", points, points - center), 0, atol=1e-6)


def test_hough_by_hand_finds_what_opencv_finds():
    mask = np.zeros((120, 160), np.uint8)
    cv2.circle(mask, (70, 50), 18, 255, -1, cv2.LINE_AA)
    grey = cv2.GaussianBlur(mask, (9, 9), 0)
    (u, v, radius), layers = hough.hough_circle(grey, np.arange(8.0, 40.0))
    found = cv2.HoughCircles(grey, cv2.HOUGH_GRADIENT, 1, 200, param1=200, param2=10, minRadius=8, maxRadius=40)
    assert np.allclose((u, v, radius), found.reshape(-1, found.shape[-1])[0, :3], atol=1.6)
    assert layers.shape == (32, 120, 160) and layers[10].sum() == len(hough.edges(grey)[0])


def test_homography_agrees_with_opencv():
    rng = np.random.default_rng(8)
    board = rng.uniform(0, 200, (12, 2))
    true = np.array([[1.1, 0.2, 30], [-0.1, 0.9, 60], [2e-4, -3e-4, 1.0]])
    pixels = homography.apply(true, board)
    assert np.allclose(homography.find_homography(board, pixels), true, atol=1e-8)
    noisy = pixels + rng.normal(0, 0.3, pixels.shape)
    ours, library = homography.find_homography(board, noisy), cv2.findHomography(board, noisy)[0]
    assert np.abs(homography.apply(ours, board) - homography.apply(library, board)).max() < 0.2
    with pytest.raises(StereoLabError, match="four points"):
        homography.find_homography(board[:3], pixels[:3])


def test_focal_length_from_one_exact_picture():
    matrix = np.array([[650.0, 0, 320], [0, 650.0, 240], [0, 0, 1]])
    turn = cv2.Rodrigues(np.array([0.4, -0.5, 0.1]))[0]
    h = matrix @ np.column_stack([turn[:, :2], [-50.0, -40.0, 600.0]])
    assert homography.focal_from_homography(h, (320, 240)) == pytest.approx(650.0)
    facing = matrix @ np.column_stack([np.eye(3)[:, :2], [0.0, 0.0, 600.0]])
    assert homography.focal_from_homography(facing, (320, 240)) is None


LOOKS = [("clutter/snaps", k, "red") for k in (0, 7, 14, 33, 58, 77)]
LOOKS += [(f"clutter/{color}", 3, color) for color in ("green", "blue", "yellow", "orange")]
LOOKS += [("bench/evaluation", 5, "red"), ("bench/track", 20, "red"), ("second_rig/evaluation", 2, "green")]


def told(found):
    return (
        "nothing"
        if found is None
        else f"u {found.u:.2f} px v {found.v:.2f} px r {found.radius_px:.2f} px score {found.score:.2f}"
    )


@pytest.mark.parametrize(("place", "number", "color"), LOOKS, ids=str)
def test_candidates_are_those_written_down(place, number, color):
    name, set_name = place.split("/")
    image = open_recording(ROOT / "data" / name).pairs(set_name)[number].left
    camera = calibrate_recording(open_recording(ROOT / "data" / name)).camera("left")
    lines = [told(c) for c in BallDetector(color, camera=camera).candidates(image)]
    lines += [
        f"no camera: {told(BallDetector(color).detect(image))}",
        f"paper: {told(BallDetector(color, 'paper').detect(image))}",
    ]
    assert_as_written(f"detections/{place}/{number}", lines, {"absolute": 0.04})


@pytest.mark.parametrize("name", HUES)
def test_a_colours_table_is_the_one_written_down(name):
    color = BallColor.named(name)
    coarse = color.table.reshape(8, 4, 8, 4, 8, 4).astype(float).mean((1, 3, 5))
    assert_as_written(f"colors/{name}", [str(color.ranges), " ".join(f"{v:.0f}" for v in coarse.ravel())], {"whole": 1})


def test_a_ball_of_one_single_hue_is_learned_as_that_hue():
    """Its lowest and its highest hue are the same: that is no range that wraps round."""
    image = np.full((60, 60, 3), (40, 160, 40), np.uint8)
    image[:30] = (60, 60, 200)
    color = BallColor.from_samples([image], [(30, 12, 8)])
    assert len(color.ranges) == 1 and color.ranges[0][0][0] == color.ranges[0][1][0] == 0
    assert (color.mask(image) > 0).sum() == 30 * 60


def test_a_learned_colour_is_the_one_written_down(bench):
    names = [pair for pair in bench.pairs("position")][:3]
    circles = [bench.true_ball("position", pair.name)["left"] for pair in names]
    color = BallColor.from_samples([pair.left for pair in names], circles)
    coarse = color.table.reshape(8, 4, 8, 4, 8, 4).astype(float).mean((1, 3, 5))
    assert_as_written("colors/learned", [str(color.ranges), " ".join(f"{v:.0f}" for v in coarse.ravel())], {"whole": 1})
