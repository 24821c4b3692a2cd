"""Sources of pictures: a recording at its own rate, two cameras that misbehave, and a bench that is drawn."""

import queue
import shutil
import threading
from time import monotonic

import cv2
import numpy as np
import pytest

from stereo_lab.errors import StereoLabError
from stereo_lab.live import CameraSource, RecordingSource, VirtualBench, look, open_source
from stereo_lab.live import cameras as live_cameras
from stereo_lab.live.cameras import what_is_wrong
from stereo_lab.localization import Localizer
from stereo_lab.recording import open_recording

SIZE = (64, 48)


class Time:
    """A clock that stands until it is told to go on."""

    def __init__(self):
        self.now = 100.0

    def __call__(self):
        return self.now

    def sleep(self, seconds):
        self.now += seconds


def picture(k=0):
    return np.random.default_rng(k).integers(40, 200, (*SIZE[::-1], 3), np.uint8)


class Fake:
    """In place of cv2.VideoCapture: gives what it is fed, and waits for it as a driver does."""

    cameras: dict = {}

    def __init__(self, number):
        self.number, self.feed, self.open = number, queue.Queue(), Fake.cameras.get(number, True)
        self.asked, self.released = {}, threading.Event()
        Fake.cameras.setdefault("all", []).append(self)

    def isOpened(self):
        return self.open

    def set(self, what, value):
        self.asked[what] = value
        return True

    def read(self):
        while not self.released.is_set():
            try:
                got = self.feed.get(timeout=0.02)
            except queue.Empty:
                if self.number == "silent" or Fake.cameras.get("closing"):
                    return False, None
                continue
            if callable(got):
                got = got()
            return got is not None, got
        return False, None

    def release(self):
        self.released.set()


@pytest.fixture
def cameras():
    """Two fake cameras behind a source whose time stands still; gives (source, left, right, time)."""
    Fake.cameras = {"all": []}
    time = Time()
    source = CameraSource(0, 1, SIZE, 30.0, Fake, 0.3, time)
    left, right = Fake.cameras["all"]
    yield source, left, right, time
    Fake.cameras["closing"] = True
    source.close()
    assert not any(side.thread.is_alive() for side in source._sides)


def shoot(camera, time, at, k=0):
    """One picture of a camera, taken at a time; waits until the source has it."""
    done = threading.Event()

    def take():
        time.now = at
        done.set()
        return picture(k)

    camera.feed.put(take)
    assert done.wait(60)


def settle(source, *counts):
    """Until both sides have so many pictures."""
    with source._news:
        assert source._news.wait_for(lambda: tuple(len(side.taken) for side in source._sides) == counts, 2)


def test_a_pair_is_matched_by_time(cameras):
    source, left, right, time = cameras
    assert left.asked[cv2.CAP_PROP_FRAME_WIDTH] == SIZE[0] and left.asked[cv2.CAP_PROP_FPS] == 30
    shoot(right, time, 1.000, 1)
    settle(source, 0, 1)
    shoot(left, time, 1.004, 2)
    frame = source.read()
    assert frame.time_s == 1.004 and frame.skew_s == pytest.approx(-0.004) and frame.dropped == 0
    assert np.array_equal(frame.left, picture(2)) and np.array_equal(frame.right, picture(1))


def test_the_newest_pair_wins_and_the_others_are_counted(cameras):
    source, left, right, time = cameras
    for k in range(3):
        shoot(left, time, 1 + k / 30, k)
        settle(source, k + 1, k)
        shoot(right, time, 1.001 + k / 30, 10 + k)
        settle(source, k + 1, k + 1)
    frame = source.read()
    assert frame.time_s == pytest.approx(1 + 2 / 30) and frame.dropped == 2 and np.array_equal(frame.right, picture(12))
    assert len(source._sides[0].taken) <= 4
    with pytest.raises(StereoLabError, match="is open and gives no pictures"):
        source.read()  # nobody gets the same pair twice


def test_pictures_far_apart_in_time_are_no_pair(cameras):
    source, left, right, time = cameras
    shoot(left, time, 1.0)
    settle(source, 1, 0)
    shoot(right, time, 1.1)
    settle(source, 1, 1)
    with pytest.raises(StereoLabError, match="100 ms apart, half a frame is 17"):
        source.read()


@pytest.mark.parametrize(
    ("bad", "says"),
    [
        (np.zeros((*SIZE[::-1], 3), np.uint8), "lens covered"),
        (np.full((24, 32, 3), 90, np.uint8), "32x24 instead of 64x48"),
        (np.vstack([picture()[:20], np.full((28, 64, 3), 128, np.uint8)]), "cut off"),
        (np.vstack([np.zeros((2, 64, 3), np.uint8), picture()[:20], np.zeros((26, 64, 3), np.uint8)]), "cut off"),
        (np.vstack([bar := np.zeros((9, 64, 3), np.uint8), picture()[:30], bar]), "a plain bar above .* --size 64x30"),
    ],
)
def test_useless_pictures_are_passed_over_and_told(cameras, bad, says):
    source, left, right, time = cameras
    left.feed.put(bad)
    with pytest.raises(StereoLabError, match=says):
        source.read()
    shoot(left, time, 2.0)
    settle(source, 1, 0)
    shoot(right, time, 2.0)
    assert source.read().dropped == 1


def test_pictures_that_nobody_fetched_are_counted_all(cameras):
    source, left, right, time = cameras
    for k in range(10):
        for camera in (left, right):
            shoot(camera, time, 1 + k / 30, k)
    with source._news:
        assert source._news.wait_for(lambda: all(s.taken and s.taken[-1][0] > 1.29 for s in source._sides), 2)
    assert source.read().dropped == 9


def test_a_driver_that_fails_is_opened_again(cameras, monkeypatch):
    source, left, right, time = cameras
    monkeypatch.setattr(live_cameras, "AGAIN_S", 0.02)

    def fails():
        raise cv2.error("the driver fell over")

    left.feed.put(fails)
    with pytest.raises(StereoLabError, match="opened again"):
        source.read()
    while len(Fake.cameras["all"]) < 3:
        threading.Event().wait(0.01)
    again = Fake.cameras["all"][2]
    shoot(again, time, 2.0)
    shoot(right, time, 2.0)
    assert source.read().time_s == 2.0


def test_a_recording_that_is_closed_ends_at_once(bench):
    time = Time()
    source = RecordingSource(bench, clock=time, sleep=time.sleep)
    source.read()
    source.close()
    assert source.read() is None and time.now == 100


def test_a_white_floor_is_no_fault():
    floor = picture()
    floor[20:] = 255
    assert what_is_wrong(floor, SIZE) == ""


def test_a_camera_that_went_away_and_comes_back(cameras, monkeypatch):
    source, left, right, time = cameras
    monkeypatch.setattr("stereo_lab.live.cameras.AGAIN_S", 0.02)
    left.feed.put(lambda: None)
    with pytest.raises(StereoLabError, match=r"The left camera \(0\) gave no picture"):
        source.read()
    with source._news:
        assert source._news.wait_for(lambda: len(Fake.cameras["all"]) > 2 or source._news.wait(0.05), 60)
    again = Fake.cameras["all"][-1]
    assert again.number == 0 and left.released.is_set()
    shoot(again, time, 3.0)
    settle(source, 1, 0)
    shoot(right, time, 3.0)
    assert source.read().time_s == 3.0


def test_a_camera_that_does_not_open_is_told_and_the_other_let_go():
    Fake.cameras = {"all": [], 1: False}
    with pytest.raises(StereoLabError, match=r"Camera 1 \(right\) does not open"):
        CameraSource(0, 1, SIZE, 30.0, Fake)
    assert all(camera.released.is_set() for camera in Fake.cameras["all"])


def test_a_closed_source_ends(cameras):
    source, *_ = cameras
    waiting = []
    thread = threading.Thread(target=lambda: waiting.append(source.read()))
    thread.start()
    Fake.cameras["closing"] = True
    source.close()
    thread.join(2)
    assert waiting == [None] and list(source) == []


def test_two_films_through_opencv(tmp_path):
    """The real driver call, on files: two films of which every frame is told by its grey."""
    for name, first in (("left.avi", 60), ("right.avi", 160)):
        film = cv2.VideoWriter(str(tmp_path / name), cv2.VideoWriter_fourcc(*"MJPG"), 30, SIZE)
        for k in range(20):
            film.write(np.clip(picture().astype(int) // 8 + first + 3 * k, 0, 255).astype(np.uint8))
        film.release()
    began = monotonic()
    with CameraSource(str(tmp_path / "left.avi"), str(tmp_path / "right.avi"), SIZE, 10.0) as source:
        greys = [(frame.left.mean(), frame.right.mean()) for frame in source]
        assert source.read() is None and monotonic() - began > 18 / 30  # as fast as it was taken, and once
    greys = np.array(greys)
    assert (np.diff(greys, axis=0) > 0).all() and greys[:, 1] - greys[:, 0] == pytest.approx(100, abs=12)


def test_the_film_of_a_recording_as_fast_as_it_goes(bench):
    with open_source(bench.path, fast=True) as source:
        frames = list(source)
    assert source.size == bench.image_size and len(frames) == len(bench.pairs("track")) == 60
    assert [f.time_s for f in frames[:3]] == pytest.approx([0, 0.1, 0.2]) and not any(f.dropped for f in frames)
    assert np.array_equal(frames[7].left, bench.pairs("track")[7].left) and source.read() is None


def test_the_film_of_a_recording_at_its_own_rate(bench):
    time = Time()
    source = RecordingSource(bench, clock=time, sleep=time.sleep)
    assert [source.read().time_s for _ in range(3)] == pytest.approx([0, 0.1, 0.2])
    assert time.now == pytest.approx(100.2)
    time.now += 0.55  # somebody took long
    late = source.read()
    assert late.time_s == pytest.approx(0.7) and late.dropped == 4
    assert source.read().time_s == pytest.approx(0.8)
    time.now += 60
    assert source.read() is None


def test_a_recording_without_a_film_shows_its_largest_set(second_rig):
    with open_source(second_rig.path, fast=True) as source:
        assert source.name.startswith("second_rig, ") and source.read() is not None


@pytest.mark.parametrize(
    ("name", "says"),
    [("cameras:0", "two different cameras"), ("cameras:1,1", "two different cameras"), ("cameras:", "two different"), ("nowhere", "nowhere"),
     (0, 'as in "cameras:0,1"; got 0'), ((0, 1), 'as in "cameras:0,1"; got'), ("", 'as in "cameras:0,1"; got')],
)  # fmt: skip
def test_a_source_that_cannot_be_understood(name, says):
    with pytest.raises(StereoLabError, match=says):
        open_source(name)


def test_left_pictures_alone_are_no_film(tmp_path, bench):
    for side in ("left",):
        (tmp_path / "half" / "track" / side).mkdir(parents=True)
        shutil.copy(bench.path / "track" / side / "000.jpg", tmp_path / "half" / "track" / side)
    shutil.copy(bench.path / "recording.json", tmp_path / "half")
    with pytest.raises(StereoLabError, match="has no right picture"):
        RecordingSource(open_recording(tmp_path / "half"))


class Joints:
    link_deg = (40.0, -60.0)


def by_hand(eye, place):
    """The pinhole and the lens written out, for one place of the bench frame."""
    x, y, z = eye.rotation @ (np.array(place) - eye.position_mm)
    x, y = x / z, y / z
    k1, k2, p1, p2, k3 = np.resize(np.append(eye.distortion.ravel(), np.zeros(5)), 5)
    r2 = x * x + y * y
    bend = 1 + k1 * r2 + k2 * r2**2 + k3 * r2**3
    x, y = x * bend + 2 * p1 * x * y + p2 * (r2 + 2 * x * x), y * bend + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
    return eye.matrix[0, 0] * x + eye.matrix[0, 2], eye.matrix[1, 1] * y + eye.matrix[1, 2]


@pytest.fixture(scope="module")
def drawn(bench):
    return VirtualBench(bench, fast=True)


def test_the_virtual_bench_projects_as_the_book_says(drawn):
    for place in np.random.default_rng(1).uniform((-300, -200, -200), (300, 250, 300), (20, 3)):
        for eye in drawn.eyes:
            assert eye.project(place)[0] == pytest.approx(by_hand(eye, place), abs=1e-6)
            column, row = np.round(eye.project(place)[0]).astype(int)
            if 0 <= column < SIZE[0] * 10 and 0 <= row < SIZE[1] * 10:
                ray = eye.rays[row, column]
                x, y, z = eye.seen_from(place)[0]
                assert ray == pytest.approx((x / z, y / z), abs=1.0 / eye.matrix[0, 0])


@pytest.mark.parametrize("name", ["bench", "second_rig"])
def test_drawn_balls_are_where_the_renderer_puts_them(name, request):
    """The same places, drawn and rendered: the same detector finds the same centres, and errs as much."""
    recording = request.getfixturevalue(name)
    judges = recording.judges()
    localizer, drawn = Localizer.fit(recording, leave_out=judges), VirtualBench(recording, fast=True)
    apart, errors = [], {"drawn": [], "rendered": []}
    for sample in judges[::2]:
        place = (sample.truth.x_mm, sample.truth.y_mm, sample.truth.depth_mm)
        pictures = {"rendered": (sample.pair.left, sample.pair.right), "drawn": drawn.draw(place)}
        found = {kind: localizer.detect(*pair) for kind, pair in pictures.items()}
        if None in found.values():
            continue
        apart.append([(a.u - b.u, a.v - b.v) for a, b in zip(*found.values(), strict=True)])
        for kind, (left, right) in found.items():
            here = localizer.position(left, right)
            errors[kind].append(np.subtract((here.x_mm, here.y_mm, here.depth_mm), place))
    apart = np.array(apart).reshape(-1, 4)
    assert len(apart) > 10 and np.abs(apart.mean(axis=0)).max() < 0.06 and apart.std(axis=0).max() < 0.08
    off = {kind: np.linalg.norm(e, axis=1).mean() for kind, e in errors.items()}
    assert 0.5 < off["drawn"] / off["rendered"] < 1.5


def test_the_arm_hides_what_is_behind_it_and_nothing_else(bench):
    """The hand's joint is drawn where its projection is, and a ball on the link is seen before the arm alone."""
    drawn = VirtualBench(bench, arm=Joints(), fast=True)
    elbow = bench.arm.l1_mm * np.array([np.cos(np.radians(40)), np.sin(np.radians(40))])
    for eye, picture in zip(drawn.eyes, drawn.draw(None), strict=True):
        (u, v) = np.round(eye.project((*elbow, 0.0))[0]).astype(int)
        patch = picture[v - 12 : v + 13, u - 12 : u + 13].mean(axis=2) < 120
        rows, columns = np.nonzero(patch)
        exact = eye.project((*elbow, 0.0))[0] - (u - 12, v - 12)
        assert (columns.mean(), rows.mean()) == pytest.approx(exact.tolist(), abs=0.3)
    middle = elbow / 2

    def red(depth):
        left, _ = drawn.draw((*middle, depth))
        return int(np.sum(left[..., 2].astype(int) - left[..., 1] > 60))

    before, behind = red(bench.arm_depth_mm - 60), red(bench.arm_depth_mm + 60)
    assert before > 300 and behind < 0.5 * before


def test_a_moving_ball_is_smeared_over_its_exposure(bench):
    drawn = VirtualBench(bench, fast=True)
    drawn.path = lambda seconds: (-100 + 3000 * seconds, 100.0, 1000.0)
    for _ in range(2):
        frame = drawn.read()
    still, _ = drawn.draw(drawn.path(frame.time_s))

    def width(picture):
        return np.nonzero((picture[..., 2].astype(int) - picture[..., 1] > 12).sum(axis=0) > 4)[0]

    smeared, sharp = width(frame.left), width(still)
    assert len(smeared) > len(sharp) + 5
    assert smeared.mean() == pytest.approx(sharp.mean(), abs=1)  # told is the middle of its exposure


def test_no_ball_no_answer_and_every_picture_says_that_it_is_drawn(bench, drawn):
    drawn.ball_mm = None
    frame = drawn.read()
    assert Localizer.fit(bench).locate(frame.left, frame.right) is None
    corner = frame.left[-22:-6, 6:60].mean(axis=2)
    assert (corner.min(axis=0) < 165).sum() > 15 and corner.max() > 170


def test_the_virtual_bench_keeps_time(bench):
    time = Time()
    drawn = VirtualBench(bench, rate_hz=20, clock=time, sleep=time.sleep)
    assert [drawn.read().time_s for _ in range(3)] == pytest.approx([0, 0.05, 0.1])
    time.now += 0.31
    late = drawn.read()
    assert late.dropped == 5 and late.time_s == pytest.approx(0.4)
    drawn.close()
    assert drawn.read() is None and list(drawn) == []


def test_only_rendered_cameras_and_at_a_rate_can_be_drawn(tmp_path, bench):
    shutil.copytree(bench.path / "track", tmp_path / "real" / "track")
    shutil.copy(bench.path / "recording.json", tmp_path / "real")
    with pytest.raises(StereoLabError, match="real was taken with real cameras"):
        VirtualBench(open_recording(tmp_path / "real"))
    with pytest.raises(StereoLabError, match="pairs a second; got 0"):
        VirtualBench(bench, rate_hz=0)
    with open_source("virtual:second_rig") as source:
        assert source.name == "virtual:second_rig" and source.read().left.shape[1::-1] == source.size


def test_one_look_from_wherever_a_lesson_is_told(bench, monkeypatch):
    pair = bench.samples("evaluation")[0].pair
    assert (look("recording", bench, pair).right == pair.right).all()
    alone = bench.pairs("snaps")[0]
    assert alone.right_path is not None or (look("recording", bench, alone).right == alone.left).all()
    place = Localizer.fit(bench).locate(*(getattr(look("virtual", bench, pair), side) for side in ("left", "right")))
    assert (place.x_mm, place.y_mm, place.depth_mm) == pytest.approx((0, 120, 1000), abs=2)
    for word in ("Virtual", "bench", "cameras"):
        with pytest.raises(StereoLabError, match='Expected "recording", "virtual" or "cameras:0,1"'):
            look(word, bench, pair)
    Fake.cameras.clear()
    monkeypatch.setattr("stereo_lab.live.cameras.CameraSource.read", lambda self: None)
    monkeypatch.setattr("stereo_lab.live.cameras.CameraSource.__init__", lambda self, *_, **__: None)
    monkeypatch.setattr("stereo_lab.live.cameras.CameraSource.close", lambda self: None)
    with pytest.raises(StereoLabError, match="gave no pictures"):
        look("cameras:0,1", bench, pair)


def test_cameras_are_asked_for_the_size_of_the_recording(second_rig, monkeypatch):
    Fake.cameras = {"all": []}
    monkeypatch.setattr(live_cameras.CameraSource.__init__, "__defaults__", (Fake, 0.3, Time()))
    sizes = []
    for recording in (second_rig, None):
        with open_source("cameras:0,1", recording=recording):
            sizes.append(
                [Fake.cameras["all"][-1].asked[k] for k in (cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT)]
            )
    assert sizes == [list(second_rig.image_size), [640, 480]] and tuple(second_rig.image_size) != (640, 480)


def test_a_frame_can_be_taken_apart(bench):
    time_s, left, right = open_source(bench.path, fast=True).read()
    assert time_s == 0 and left.shape == right.shape == (480, 640, 3)


def test_clutter_shows_its_pairs():
    with open_source("clutter", fast=True) as source:
        assert source.name == "clutter, pairs" and source.read() is not None


def test_a_driver_that_raises_when_it_is_opened_again_is_tried_again(monkeypatch):
    """Opened at first, gone, raises, and is there again."""
    monkeypatch.setattr(live_cameras, "AGAIN_S", 0.01)
    Fake.cameras, opened = {"all": []}, []

    def opens(number):
        opened.append(number)
        if opened.count(0) == 2 and number == 0:
            raise RuntimeError("no such bus")
        return Fake(number)

    with CameraSource(0, 1, SIZE, 30.0, opens, 0.3, Time()) as source:
        Fake.cameras["all"][0].feed.put(None)
        with source._news:
            assert source._news.wait_for(lambda: opened.count(0) == 3, 10)
            assert source._sides[0].thread.is_alive()
        Fake.cameras["closing"] = True
