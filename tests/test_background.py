"""The background that cameras which stand still know: against drawn balls whose place and light are exact, and rendered ones."""

from dataclasses import replace
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from stereo_lab.detection import BallColor, BallDetector, Detection
from stereo_lab.detection.model import usual_camera
from stereo_lab.localization import Localizer, sphere
from stereo_lab.localization.background import GAMMA, backgrounds_of, fit_on_background, median_picture
from stereo_lab.recording import Position, open_recording

WIDTH, HEIGHT = 320, 240
CAMERA = usual_camera((HEIGHT, WIDTH))
ORANGE = np.array([0.03, 0.19, 0.6])  # light, of 1
FINE = 8


def light_of(stored):
    return (np.asarray(stored) / 255) ** GAMMA


def shelf(rng):
    """Books: upright bars of all colours, as light."""
    room = np.empty((HEIGHT, WIDTH, 3))
    x = 0
    while x < WIDTH:
        wide = int(rng.integers(4, 16))
        room[:, x : x + wide] = rng.uniform(0.02, 0.5) * rng.uniform(0.4, 1, 3) * [1, 0.9, 0.7]
        x += wide
    return cv2.GaussianBlur(room, (0, 0), 0.7)


def put(room, u, v, r, gloss=0.0):
    """A ball in the room, lit from above: exactly what its cone of rays covers, blurred by the lens.

    Of one with gloss 1 the rim mirrors the room as plastic does.
    """
    (focal, _, middle_u), (_, _, middle_v), _ = CAMERA[0]
    ray = np.array([(u - middle_u) / focal, (v - middle_v) / focal, 1.0])
    axis = ray / np.linalg.norm(ray) * np.hypot(1, r / focal)
    left, top, side = int(u) - 24, int(v) - 24, 50
    y, x = (np.mgrid[: side * FINE, : side * FINE] + 0.5) / FINE - 0.5
    rays = np.stack([(x + left - middle_u) / focal, (y + top - middle_v) / focal, np.ones_like(x)], -1)
    fine = (rays @ axis >= np.linalg.norm(rays, axis=-1)).astype(np.float32)
    middle = rays @ axis / np.linalg.norm(rays, axis=-1) / np.linalg.norm(axis)
    out = np.sqrt((1 - middle**2) / (1 - 1 / (axis @ axis)))  # radii from its middle
    mirrors = gloss * fine * (1 - np.sqrt(np.clip(1 - out**2, 0, 1))) ** 5
    covered, mirrored = (np.zeros((HEIGHT, WIDTH, 1)) for _ in range(2))
    for whole, part in ((covered, fine), (mirrored, mirrors.astype(np.float32))):
        blurred = cv2.resize(cv2.GaussianBlur(part, (0, 0), 0.6 * FINE), (side, side), interpolation=cv2.INTER_AREA)
        whole[top : top + side, left : left + side, 0] = blurred
    below = (np.mgrid[:HEIGHT, :WIDTH][0] - v)[..., None] / r
    ball = ORANGE * (0.7 - 0.4 * below)
    return room + covered * (ball - room) + mirrored * (room.mean((0, 1)) - ball)


def taken(light, rng, gain=1.0):
    """What a webcam stores: noise, and JPEG."""
    stored = 255 * np.clip(gain * light, 0, 1) ** (1 / GAMMA) + rng.normal(0, 2, light.shape)
    return cv2.imdecode(cv2.imencode(".jpg", np.clip(np.rint(stored), 0, 255).astype(np.uint8))[1], 1)


@pytest.fixture(scope="module")
def books():
    """A background, and balls before it: (picture, what is found there at first, its true (u, v, radius))."""
    rng = np.random.default_rng(1)
    room, detector = shelf(rng), BallDetector("orange", camera=CAMERA)
    background = median_picture([taken(room, rng) for _ in range(9)])
    balls = []
    for _ in range(12):
        true = rng.uniform(60, 260), rng.uniform(60, 180), rng.uniform(7, 13)
        image = taken(put(room, *true), rng)
        balls.append((image, detector.detect(image), true))
    return background, balls


def off(ball, true):
    return np.hypot(ball.u - true[0], ball.v - true[1])


def test_the_edge_of_a_book_is_no_edge_of_the_ball(books):
    background, balls = books
    found = [(fit_on_background(background, image, ball), ball, true) for image, ball, true in balls]
    fitted = [(off(better, true), off(ball, true)) for better, ball, true in found if better is not None]
    assert len(fitted) >= 10
    better, before = np.mean(fitted, axis=0)
    assert better < 0.1 and better < 0.5 * before
    assert all(abs(better.radius_px - true[2]) < 0.3 for better, _, true in found if better is not None)


@pytest.mark.parametrize("gloss", [0, 1])
def test_a_ring_that_mirrors_the_room_makes_no_ball_smaller(monkeypatch, gloss):
    """And a matt ball, which has none, no larger: the rim tells which it is, and a wrong guess would not do."""
    rng = np.random.default_rng(5)
    room, detector = shelf(rng), BallDetector("orange", camera=CAMERA)
    background = median_picture([taken(room, rng) for _ in range(9)])
    told, guessed = [], []
    for _ in range(12):
        u, v, r = rng.uniform(60, 260), rng.uniform(60, 180), rng.uniform(8, 13)
        image = taken(put(room, u, v, r, gloss), rng)
        ball = detector.detect(image)
        with monkeypatch.context() as wrong:
            for name, value in (("GLOSS", 1 - gloss), ("GLOSS_SIGMA", 1e-3)):
                wrong.setattr(f"stereo_lab.localization.background.{name}", value)
            fits = fit_on_background(background, image, ball)
        if (fitted := fit_on_background(background, image, ball)) and fits:
            told.append(fitted.radius_px - r)
            guessed.append(fits.radius_px - r)
    assert len(told) >= 10
    assert abs(np.mean(told)) < 0.6 * abs(np.mean(guessed)) and abs(np.mean(told)) < 0.1


def test_it_tells_how_sure_it_is(books):
    background, balls = books
    found = [(fit_on_background(background, image, ball), true) for image, ball, true in balls]
    sizes = [abs(ball.u - true[0]) / ball.sigma_px for ball, true in found if ball is not None]
    assert np.mean(np.array(sizes) < 2) > 0.9 and max(ball.sigma_px for ball, _ in found if ball is not None) < 0.3
    assert all(ball.sigma_radius_px > 0 for ball, _ in found if ball is not None)


def test_more_or_less_light_does_no_harm(books):
    """Cheap cameras choose their exposure anew in each picture."""
    background, balls = books
    darker = np.rint(255 * (0.7 * light_of(background)) ** (1 / GAMMA)).astype(np.uint8)
    for image, ball, true in balls:
        as_before, then = (fit_on_background(seen, image, ball) for seen in (background, darker))
        if as_before is not None:
            assert off(then, true) < 0.25 and abs(then.u - as_before.u) < 0.1


@pytest.mark.parametrize(
    "changed",
    [
        lambda room, ball: np.roll(room, 37, 1),  # another room, or another way to look
        lambda room, ball: np.roll(room, 4, 1),  # a camera that was turned a little
        lambda room, ball: np.hstack([room[:, : int(ball.u)], np.roll(room, 31, 1)[:, int(ball.u) :]]),  # half of it
    ],
)
def test_a_room_that_changed_since_tells_nothing(books, changed):
    background, balls = books
    told = [fit_on_background(changed(background, ball), image, ball) for image, ball, _ in balls]
    assert sum(ball is None for ball in told) >= 11


def test_a_ball_that_looks_like_what_is_behind_it_is_left_as_it_is(books):
    rng = np.random.default_rng(3)
    room = np.ones((HEIGHT, WIDTH, 3)) * ORANGE * 0.8
    ball = books[1][0][1]
    assert fit_on_background(taken(room, rng), taken(room, rng), ball) is None


def test_what_has_no_edges_is_smeared_or_of_another_size_is_left_as_it_is(books):
    background, balls = books
    image, ball, _ = balls[0]
    assert fit_on_background(background, image, Detection(ball.u, ball.v, ball.radius_px, 0.9)) is None
    assert fit_on_background(background[:-2], image, ball) is None
    assert fit_on_background(background, image, replace(ball, cone=ball.cone._replace(smeared=True))) is None
    for u in (-3.0, WIDTH + 3.0, np.nan, np.inf):
        assert fit_on_background(background, image, replace(ball, cone=ball.cone._replace(u=u))) is None


def test_in_the_median_of_samples_there_is_no_ball(bench):
    samples = [s for name in ("position", "depth") for s in bench.samples(name)]
    like = BallColor.named("red").likeness(median_picture([s.pair.left for s in samples]))
    for sample in samples:
        u, v, r = bench.true_ball(sample.pair.set_name, sample.pair.name)["left"]
        inside = like[int(v - r / 2) : int(v + r / 2), int(u - r / 2) : int(u + r / 2)]
        assert BallColor.named("red").likeness(sample.pair.left)[int(v), int(u)] > 128 and np.median(inside) < 128


def samples_at(places):
    """Samples with the ball at these (x, y), whose pictures are all of one grey, their number; and what was read of them."""
    read = []

    class Pair:
        def __init__(self, k):
            self.k = k

        def __getattr__(self, side):
            read.append((side, self.k))
            return np.full((4, 4, 3), self.k, np.uint8)

    return [SimpleNamespace(pair=Pair(k), measured=Position(x, y, 900)) for k, (x, y) in enumerate(places)], read


def test_the_background_is_taken_of_few_samples_from_all_over():
    """However many there are: pictures fill a small computer's memory."""
    samples, read = samples_at([(100 * k, 0) for k in range(101)])
    left, right = backgrounds_of(samples, 40)
    assert np.all(left == 50) and np.all(right == 50)
    assert len(read) <= 24 and {("left", 0), ("left", 100), ("right", 0), ("right", 100)} <= set(read)
    assert backgrounds_of(samples[:4], 40) == ()


def test_samples_on_one_line_of_sight_do_not_leave_a_ball_in_the_background():
    """The depth samples lie behind each other, so that most pictures may show the ball at one place."""
    line, plane = [(3 * k, 0) for k in range(6)], [(300, 0), (-300, 0), (0, 200), (0, -200)]
    samples, read = samples_at(plane + line)
    assert len(backgrounds_of(samples, 40)) == 2
    assert {k for _, k in read} == {0, 1, 2, 3, 4, 5}
    assert backgrounds_of(samples[4:], 40) == ()


@pytest.fixture(scope="module")
def third():
    """The third rig's localizer, the same without what it knows of the background, and the true places."""
    recording = open_recording("third_rig")
    localizer = Localizer.fit(recording)
    blind = replace(localizer, way=replace(localizer.way, backgrounds=()))
    return recording, localizer, blind


def test_before_books_and_plants_centres_are_half_as_far_off(third):
    """Only what is known of the background differs between the two."""
    recording, *both = third
    errors = []
    for localizer in both:
        errors.append([])
        for sample in recording.samples("evaluation"):
            true = recording.true_ball("evaluation", sample.pair.name)
            found = localizer.detect(sample.pair.left, sample.pair.right)
            errors[-1] += [off(ball, true[side]) for ball, side in zip(found, ("left", "right"), strict=True)]
    known, blind = np.mean(errors, axis=1)
    assert known < 0.092 and known < 0.65 * blind


def test_of_four_errors_three_are_smaller_than_told(third):
    """Two of three should be: so sure is it told, and no surer."""
    recording, localizer, _ = third
    sizes = []
    for sample in recording.samples("evaluation"):
        true = recording.true_ball("evaluation", sample.pair.name)
        for ball, side in zip(localizer.detect(sample.pair.left, sample.pair.right), ("left", "right"), strict=True):
            sizes += [abs(ball.u - true[side][0]) / ball.sigma_px, abs(ball.v - true[side][1]) / ball.sigma_px]
    assert 0.6 < np.mean(np.array(sizes) < 1) < 0.84 and np.mean(np.array(sizes) < 2) > 0.9


def test_balls_that_are_known_by_their_background_are_one_sphere_however_sure(third, monkeypatch):
    """Their rims look clean, and they were not sure before: nothing speaks against joining them."""
    recording, localizer, _ = third
    sample = recording.samples("evaluation")[0]
    joined = localizer.detect(sample.pair.left, sample.pair.right)
    monkeypatch.setattr(sphere, "CLEAN", 0.0)
    monkeypatch.setattr(sphere, "KNOWN", 1.0)
    assert localizer.detect(sample.pair.left, sample.pair.right) == joined


def test_pictures_that_contradict_each_other_have_no_single_edges_to_be_asked(third, monkeypatch):
    recording, localizer, _ = third
    monkeypatch.setattr(
        sphere, "_by_edges", lambda cone: pytest.fail("asked for edges that a fit on the background has not")
    )
    monkeypatch.setattr(sphere, "CONTRADICT", 0.0)
    sample = recording.samples("evaluation")[0]
    assert not any(ball.cone.weights.any() for ball in localizer.detect(sample.pair.left, sample.pair.right))


def test_from_few_samples_no_background_is_taken(third):
    recording, localizer, _ = third
    samples = [s for name in ("position", "depth") for s in recording.samples(name)]
    assert Localizer.fit(recording, calibration=localizer.calibration, leave_out=samples[4:]).way.backgrounds == ()
    assert len(localizer.way.backgrounds) == 2
