"""Following a ball: on the virtual bench with exact truth, on the film of a recording, and on detections made up."""

from dataclasses import replace

import numpy as np
import pytest

from stereo_lab.detection import Detection
from stereo_lab.live import Frame, Tracker, VirtualBench, open_source
from stereo_lab.live.tracker import PATIENCE_S
from stereo_lab.localization import Localizer
from stereo_lab.recording import Position

PICTURE = np.zeros((4, 4, 3), np.uint8)


@pytest.fixture(scope="module")
def localizer(bench):
    return Localizer.fit(bench)


def follow(bench, localizer, path, seconds, rate_hz=30.0):
    """The tracks of a ball on a path, with its true place in each picture."""
    drawn, tracker = VirtualBench(bench, rate_hz=rate_hz, fast=True), Tracker(localizer)
    drawn.path = path
    for _ in range(round(seconds * rate_hz)):
        frame = drawn.read()
        yield tracker.update(frame), path(frame.time_s), frame.time_s


def off(track, place):
    here = track.position
    return np.subtract((here.x_mm, here.y_mm, here.depth_mm), place)


def test_a_ball_on_a_circle(bench, localizer):
    """Place, velocity, and how sure both are, against the path itself."""

    def path(t):
        return 150 * np.cos(2 * t), 100 + 100 * np.sin(2 * t), 1000 + 60 * np.sin(t)

    places, speeds, sure = [], [], []
    for track, place, t in follow(bench, localizer, path, 4):
        assert track.seen and track.time_s == t
        if t > 1:
            velocity = (-300 * np.sin(2 * t), 200 * np.cos(2 * t), 60 * np.cos(t))
            places.append(np.linalg.norm(off(track, place)))
            speeds.append(np.abs(np.subtract(track.velocity_mm_s, velocity)) / track.velocity_sigma_mm_s)
            sure.append(np.abs(off(track, place)) / track.position.sigma_mm)
    assert np.mean(places) < 1.2 and np.max(places) < 3
    assert np.mean(np.array(speeds) < 2) > 0.9 and np.mean(np.array(sure) < 3) > 0.9


def test_a_ball_that_hides_for_a_moment_is_predicted(bench, localizer):
    def path(t):
        return None if 1.0 < t < 1.19 else (-150 + 150 * t, 100.0, 1000.0)

    gone = [(track, t) for track, place, t in follow(bench, localizer, path, 2) if place is None]
    assert len(gone) >= 5 and all(
        track is not None and not track.seen and track.detections is None for track, _ in gone
    )
    for track, t in gone:
        true = (-150 + 150 * t, 100.0, 1000.0)
        assert np.linalg.norm(off(track, true)) < 12
        assert (np.abs(off(track, true)) < 3 * np.array(track.position.sigma_mm)).all()
    sigmas = [track.position.sigma_mm[0] for track, _ in gone]
    assert sigmas == sorted(sigmas) and sigmas[-1] > 5 * sigmas[0] > 0


def test_a_ball_that_leaves_is_lost_and_one_that_comes_back_is_a_new_one(bench, localizer):
    def path(t):
        return None if 0.5 < t < 1.5 else ((-100.0, 100.0, 1000.0) if t < 1 else (200.0, -50.0, 1200.0))

    tracks = list(follow(bench, localizer, path, 2))
    assert all(track is not None for track, _, t in tracks if t < 0.5 + PATIENCE_S - 0.04 or t > 1.5)
    assert all(track is None for track, _, t in tracks if 0.5 + PATIENCE_S + 0.04 < t < 1.49)
    again = next(track for track, _, t in tracks if t > 1.5)
    assert again.seen and np.linalg.norm(off(again, (200.0, -50.0, 1200.0))) < 4
    assert np.abs(again.velocity_mm_s).max() < 1 and min(again.velocity_sigma_mm_s) > 300


def test_no_frame_of_the_film_is_lost(bench, localizer):
    tracker, errors = Tracker(localizer), []
    with open_source(bench.path, fast=True) as source:
        for frame, pair in zip(source, bench.pairs("track"), strict=True):
            track = tracker.update(frame)
            assert track is not None and track.seen
            errors.append(np.linalg.norm(off(track, bench.true_ball("track", pair.name)["ball"])))
    assert np.mean(errors) < 1.5 and max(errors) < 8


class MadeUp:
    """In place of a Localizer: what both cameras see is written down; a pixel is a millimetre."""

    def __init__(self, places):
        self.places, self.asked = iter(places), []

    def detect(self, left, right, near=None):
        self.asked.append(near)
        place = next(self.places)
        if place is None:
            return None
        x, y = place
        return Detection(x, y, 10.0, 0.9), Detection(x - 50.0, y, 10.0, 0.9)

    def position(self, left, right):
        return Position(left.u, left.v, 1000.0, (1.0, 1.0, 1.0))


def update_all(places, step_s=1 / 30, times=None):
    made_up = MadeUp(places)
    tracker = Tracker(made_up)
    times = [1 + k * step_s for k in range(len(places))] if times is None else times
    return [tracker.update(Frame(t, PICTURE, PICTURE)) for t in times], made_up


def test_it_never_jumps_to_another_ball_without_saying_lost_first():
    """A second ball of the same colour, 200 mm away, is what the detector finds from the tenth picture on."""
    places = [(100.0 + k, 50.0) for k in range(10)] + [(300.0, 50.0)] * 20
    tracks, _ = update_all(places)
    x = [None if track is None else track.position.x_mm for track in tracks]
    lost = x.index(None)
    assert 10 + 30 * PATIENCE_S - 1 <= lost <= 10 + 30 * PATIENCE_S + 2
    assert all(value < 160 for value in x[:lost]) and not any(track.seen for track in tracks[10:lost])
    assert x[lost + 1] == pytest.approx(300) and tracks[lost + 1].seen


def test_the_window_is_where_the_ball_should_be():
    """Both cameras are asked to look on the line that the last two pictures make; nowhere at first, and after a loss."""
    tracks, made_up = update_all([(100.0, 50.0), (106.0, 50.0), (112.0, 50.0), *[None] * 15, (40.0, 40.0)])
    assert made_up.asked[0] is None and made_up.asked[-1] is None and tracks[-1].seen
    assert made_up.asked[1][0].u == 100 and made_up.asked[2][0].u == pytest.approx(112, abs=0.5)
    assert made_up.asked[3][1].u == pytest.approx(118 - 50, abs=0.7) and made_up.asked[3][0].v == pytest.approx(50)


def test_a_velocity_is_forgotten_in_slow_footage():
    """Two pictures a second of a ball moved by hand: what it did before says little, the last place most."""
    _, made_up = update_all([(100.0, 50.0), (200.0, 50.0), (120.0, 50.0)], step_s=0.5)
    assert made_up.asked[2][0].u < 200 + 60
    tracks, _ = update_all([(100.0 + 2 * k, 50.0) for k in range(30)] + [None], step_s=1 / 30)
    assert tracks[-1].velocity_mm_s[0] == pytest.approx(60, abs=8)


def test_a_frame_that_was_dropped_only_makes_it_less_sure():
    times = [1.0, 1.1, 1.2, 1.4, 1.5]
    tracks, _ = update_all([(100.0 + 100 * (t - 1), 50.0) for t in times], times=times)
    assert all(track.seen for track in tracks)
    assert tracks[3].velocity_sigma_mm_s[0] > 0.9 * tracks[2].velocity_sigma_mm_s[0]


def test_a_film_that_begins_anew_is_a_new_ball():
    tracks, made_up = update_all([(100.0, 50.0), (101.0, 50.0), (400.0, 50.0)], times=[5.0, 5.1, 0.0])
    assert tracks[2].seen and tracks[2].position.x_mm == 400 and made_up.asked[2] is None


def test_a_place_that_tells_no_sigma_is_followed_as_well():
    made_up = MadeUp([(100.0, 50.0)] * 3)
    plain = made_up.position
    made_up.position = lambda left, right: replace(plain(left, right), sigma_mm=None)
    tracker = Tracker(made_up)
    tracks = [tracker.update(Frame(t, PICTURE, PICTURE)) for t in (0.1, 0.2, 0.3)]
    assert all(track.seen and 1 < track.position.sigma_mm[0] <= 5 for track in tracks)


@pytest.mark.parametrize("step_s", [0.1, 0.2, 0.5, 2.0])
def test_slow_footage_does_not_make_a_velocity_sure(step_s):
    """A ball at 300 mm/s: what is told is within two standard deviations, however far apart its pictures are."""
    tracks, _ = update_all([(100.0 + 300 * step_s * k, 50.0) for k in range(20)], step_s=step_s)
    assert all(abs(track.velocity_mm_s[0] - 300) < 2 * track.velocity_sigma_mm_s[0] for track in tracks[2:])


def test_a_place_may_tell_its_sigma_in_whole_numbers():
    made_up = MadeUp([(100.0, 50.0), (101.0, 50.0)])
    plain = made_up.position
    made_up.position = lambda left, right: replace(plain(left, right), sigma_mm=(1, 1, 3))
    tracker = Tracker(made_up)
    assert all(tracker.update(Frame(t, PICTURE, PICTURE)).seen for t in (0.1, 0.2))


@pytest.mark.parametrize("off_mm", [15, 20, 30, 38])
def test_one_wrong_place_costs_one_picture(off_mm):
    """The right place that comes next is near the wrong one, and still nearer to where the ball should be."""
    places = [(100.0 + 3 * k, 50.0 + (off_mm if k == 20 else 0)) for k in range(30)]
    tracks, _ = update_all(places)
    assert [k for k, track in enumerate(tracks) if track is None or not track.seen] in ([], [20])


def test_a_thing_that_stands_beside_the_balls_way_is_not_taken_for_it():
    """Nearer than a ball's diameter: unseen for longer the ball may be anywhere near, and yet this is what was refused before."""
    places = [(100.0 + 3 * k, 50.0) for k in range(15)] + [(145.0, 85.0)] * 9
    tracks, _ = update_all(places)
    assert not any(track.seen for track in tracks[15:])
