"""Which cameras there are: fakes in the place of drivers."""

import json
import threading
import time

import cv2
import numpy as np
import pytest

from stereo_lab import cli
from stereo_lab.capture import find_cameras, found, which_is_covered
from stereo_lab.errors import StereoLabError


class Driver:
    """Cameras by number: what sizes they give, how fast, how bright; None hangs."""

    def __init__(self, cameras):
        self.cameras, self.opened, self.light = cameras, [], {}
        self.ends = threading.Event()

    def __call__(self, number):
        capture = Capture(self, number)
        self.opened.append(capture)
        return capture


class Capture:
    def __init__(self, driver, number):
        self.driver, self.number, self.size, self.is_open = driver, number, [320, 240], True

    def isOpened(self):
        return self.number in self.driver.cameras

    def set(self, what, value):
        self.size[0 if what == cv2.CAP_PROP_FRAME_WIDTH else 1] = value

    def read(self):
        kind = self.driver.cameras[self.number]
        if kind == "hangs":
            self.driver.ends.wait(20)
        if kind in ("hangs", "silent"):
            return False, None
        time.sleep(1 / kind["rate"])
        size = tuple(self.size) if tuple(self.size) in kind["sizes"] else kind["sizes"][0]
        return True, np.full((*size[::-1], 3), self.driver.light.get(self.number, 100), np.uint8)

    def release(self):
        self.is_open = False


GOOD = {"sizes": [(640, 480), (1280, 720)], "rate": 200}


@pytest.fixture
def driver():
    made = []

    def make(**cameras):
        made.append(Driver({int(name[1:]): kind for name, kind in cameras.items()}))
        return made[-1]

    yield make
    for one in made:
        one.ends.set()


def test_what_opens_is_told_with_its_sizes_and_rate(driver):
    fakes = driver(n0=GOOD, n2={"sizes": [(640, 480)], "rate": 50}, n3="silent")
    first, second, silent = find_cameras(fakes, 5, 0.3)
    assert (first.number, first.sizes) == (0, ((640, 480), (1280, 720)))
    assert (second.number, second.sizes) == (2, ((640, 480),)) and 0 < second.rate_hz < 51
    assert (silent.number, silent.sizes, silent.rate_hz) == (3, (), 0.0)
    assert not any(capture.is_open for capture in fakes.opened)


def test_a_driver_that_hangs_does_not_hang_us(driver):
    fakes = driver(n0="hangs", n1=GOOD)
    hung, good = find_cameras(fakes, 2, 0.1, patience_s=0.3)
    assert (hung.number, hung.sizes) == (0, ()) and good.number == 1 and good.sizes


def test_the_covered_lens_is_found_and_a_dark_room_is_not(driver):
    fakes = driver(n0=GOOD, n2=GOOD)
    count = [0]

    def clock():
        count[0] += 1
        fakes.light = {0: 100, 2: 100} if count[0] < 4 else {0: 95, 2: 20} if count[0] > 8 else {0: 20, 2: 20}
        return count[0]

    assert which_is_covered([0, 2], fakes, 30, clock) == 2
    assert not any(capture.is_open for capture in fakes.opened)
    fakes.light, ticks = {0: 100, 2: 100}, iter(range(100))
    with pytest.raises(StereoLabError, match="No lens was covered for 5 s"):
        which_is_covered([0, 2], fakes, 5, lambda: next(ticks))
    with pytest.raises(StereoLabError, match="Camera 1 does not open"):
        which_is_covered([0, 1], fakes, 5)


def test_names_and_ports_where_linux_tells_them(driver, tmp_path, monkeypatch):
    (tmp_path / "class" / "video0").mkdir(parents=True)
    (tmp_path / "class" / "video0" / "name").write_text("HD Webcam\n")
    (tmp_path / "dev").mkdir()
    (tmp_path / "dev" / "video0").touch()
    (tmp_path / "path").mkdir()
    (tmp_path / "path" / "usb-0:1.2-video-index0").symlink_to(tmp_path / "dev" / "video0")
    monkeypatch.setattr(found, "SYSTEM", tmp_path / "class")
    monkeypatch.setattr(found, "BY_PATH", tmp_path / "path")
    (camera,) = find_cameras(driver(n0=GOOD), 1, 0.05)
    assert (camera.name, camera.port) == ("HD Webcam", "usb-0:1.2-video-index0")


def test_the_command(driver, monkeypatch, capsys, tmp_path):
    fakes = driver(n0=GOOD, n1=GOOD)
    from stereo_lab import capture

    monkeypatch.setattr(capture, "find_cameras", lambda: find_cameras(fakes, 3, 0.05))
    monkeypatch.setattr(capture, "which_is_covered", lambda numbers: numbers[1])
    assert cli.main(["cameras", "--which", "--json", str(tmp_path / "c.json")]) == 0
    said = capsys.readouterr().out
    assert "camera 0: 640x480, 1280x720;" in said and "Left is camera 1, right is camera 0: cameras:1,0" in said
    assert [c["number"] for c in json.loads((tmp_path / "c.json").read_text())["cameras"]] == [0, 1]
    monkeypatch.setattr(capture, "find_cameras", lambda: [])
    assert cli.main(["cameras"]) == 1 and "No camera opens" in capsys.readouterr().out
    assert cli.main(["cameras", "--which"]) == 2 and "there are 0" in capsys.readouterr().err
