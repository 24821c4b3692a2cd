"""The live view without a browser: play, sliders, stop, and a page that falls silent."""

import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest
from servo_twin import Twin, TwinPort

from stereo_lab import widgets
from stereo_lab.arm import connect
from stereo_lab.arm.feetech import port
from stereo_lab.arm.virtual.served import served_arm
from stereo_lab.errors import ArmError, StereoLabError
from stereo_lab.kinematics import JointAngles
from stereo_lab.live import open_source
from stereo_lab.localization import Localizer
from stereo_lab.widgets import LiveCell
from stereo_lab.widgets.panel import PRESS, answer_while_busy
from stereo_lab.widgets.running import NOT_HEARD

WAIT_S = 60.0


@pytest.fixture(scope="module")
def localizer(bench):
    return Localizer.fit(bench)


class Opened(list):
    """Arms and sources that a panel opened. They keep the arm's own time: as fast as this computer goes."""

    def arm(self):
        self.append(connect("virtual://arm"))
        return self[-1]


@pytest.fixture
def cell(bench, localizer):
    opened = Opened()
    panel = LiveCell(
        opened.arm, lambda arm: open_source("virtual", recording=bench, arm=arm), bench, localizer, silent_s=1e9
    )
    panel.opened = opened
    yield panel
    panel.play.playing = False
    if panel.thread is not None:
        panel.thread.join(WAIT_S)
        assert not panel.thread.is_alive()


def until(what):
    end = time.monotonic() + WAIT_S
    while not (found := what()) and time.monotonic() < end:
        time.sleep(0.01)
    assert found
    return found


def press(panel):
    """As the page does it: playing, and a tick."""
    panel.play.playing = True
    panel.play.value += 1


def test_nothing_is_opened_before_play_is_pressed(cell):
    assert cell.opened == [] and cell.thread is None and cell.text.value == PRESS
    assert bytes(cell.picture.value).startswith(b"\xff\xd8")
    cell.x.value, cell.follow.value = 50, False
    assert cell.opened == [] and repr(cell) == "panel: the live cell"


def test_the_hand_follows_the_sliders_until_stop(cell, bench):
    press(cell)
    until(lambda: cell.text.value.startswith("follows"))
    before = bytes(cell.picture.value)
    arm = cell.opened[0]
    tip = bench.arm.extended(cell._follower.beyond_mm)

    def at(x, y):
        return lambda: np.hypot(*np.subtract(tip.forward(JointAngles(*arm.port.link_deg)), (x, y))) < 12

    until(at(cell.x.value, cell.y.value))
    cell.x.value, cell.y.value = -120, 300
    until(at(-120, 300))
    assert bytes(cell.picture.value) != before and " ms from the picture" in cell.text.value
    cell.follow.value = False
    until(lambda: cell.text.value.startswith("following is switched off"))
    cell.follow.value = True
    cell.off.value = 60
    until(lambda: "before the arm's plane" in cell.text.value)
    cell.play.playing = False
    until(lambda: not cell.thread.is_alive())
    assert cell.text.value.startswith("Ended") and not arm.port.is_open


@pytest.mark.parametrize("why", ["Ended. ", "Ended: nothing was heard"])
def test_homing_is_seen_and_can_be_stopped(bench, localizer, why):
    """By the clock, as in the notebook: homing takes seconds, and whoever presses stop must not wait for it."""
    panel = widgets.live_cell("virtual", "virtual://arm", bench, localizer)
    grey = bytes(panel.picture.value)
    press(panel)
    panel._silent_s = 1e9
    until(lambda: panel._source is not None and bytes(panel.picture.value) != grey)
    arm = panel._source.arm
    assert panel.text.value.startswith("The arm moves: homing")
    if why == "Ended. ":
        panel.play.playing = False
    else:
        panel._silent_s = 0.0
    until(lambda: not panel.thread.is_alive())
    assert panel.text.value.startswith(why) and not arm.is_open and panel._follower is None


def test_the_ball_glides_to_where_the_sliders_say(cell):
    """A jump would be another ball: lost for a moment, then found. One that glides is never lost."""
    press(cell)
    until(lambda: cell.text.value.startswith("follows"))
    said = set()
    cell.text.observe(lambda change: said.add(change["new"].partition(";")[0]), "value")
    cell.x.value, cell.y.value = -150, 250
    until(lambda: np.allclose(cell._source.ball_mm[:2], (-150, 250)))
    assert said <= {"follows"}


def test_it_can_be_played_again(cell):
    for _ in range(2):
        press(cell)
        until(lambda: cell.text.value.startswith(("follows", "a new ball")))
        cell.play.playing = False
        until(lambda: not cell.thread.is_alive())
    assert len(cell.opened) == 2 and not any(arm.port.is_open for arm in cell.opened)


def on_a_wire(url, bench, localizer):
    """A panel for an arm behind a port: no drawn arm is in its pictures."""
    return LiveCell(
        lambda: connect(url),
        lambda arm: open_source("virtual", recording=bench),
        bench,
        localizer,
        silent_s=1e9,
    )


def test_an_arm_that_keeps_its_power_is_played_again_and_again(bench, localizer):
    """It knows where it stands when it is connected anew, and its motors are off."""
    with served_arm() as url:
        panel = on_a_wire(url, bench, localizer)
        for _ in range(3):
            press(panel)
            until(lambda: panel.text.value.startswith(("follows", "The motors", "The arm on")))
            assert panel.text.value.startswith("follows")
            panel.play.playing = False
            until(lambda: not panel.thread.is_alive())


def test_bus_servos_follow_at_the_first_press(bench, localizer, monkeypatch):
    """They always know where they stand, and begin with their motors off."""
    twins = TwinPort([Twin(1), Twin(2, 2500)], time.monotonic)
    monkeypatch.setattr(port, "open_bus", lambda name: twins)
    panel = on_a_wire("feetech://wire", bench, localizer)
    press(panel)
    until(lambda: panel.text.value.startswith(("follows", "The motors")))
    assert panel.text.value.startswith("follows")
    panel.play.playing = False
    until(lambda: not panel.thread.is_alive())


def test_a_stop_that_holds_is_not_undone_by_play(bench, localizer):
    """Whoever stopped the arm may still stand beside it."""
    with served_arm() as url:
        arm = connect(url)
        arm.home()
        arm.stop()
        arm.port.close()  # as a program ends that is killed: the stop stays
        panel = on_a_wire(url, bench, localizer)
        press(panel)
        until(lambda: panel._source is None and not panel.thread.is_alive())
        assert "was stopped" in panel.text.value and "arm.enable()" in panel.text.value


def test_more_ticks_make_no_second_run(cell):
    press(cell)
    for _ in range(5):
        cell.play.value += 1
    until(lambda: cell.text.value.startswith("follows"))
    assert len(cell.opened) == 1 and sum(t.name == "LiveCell" for t in threading.enumerate()) == 1


def test_a_page_that_falls_silent_ends_the_run(cell):
    press(cell)
    until(lambda: cell.text.value.startswith("follows"))
    cell._silent_s = 0.0
    until(lambda: not cell.thread.is_alive())
    assert cell.text.value == NOT_HEARD and not cell.opened[0].port.is_open
    stays_ended(cell)


def test_what_goes_wrong_is_a_sentence(bench, localizer):
    def no_arm():
        raise ArmError("There is no port COM9 here.")

    def no_camera(_):
        raise StereoLabError("Camera 0 (left) does not open.")

    for open_arm, open_pictures, words in (
        (no_arm, None, "There is no port COM9 here."), (lambda: None, no_camera, "Camera 0 (left) does not open."),
    ):  # fmt: skip
        panel = LiveCell(open_arm, open_pictures, bench, localizer)
        press(panel)
        until(lambda: not panel.thread.is_alive())  # noqa: B023 - waited for within the loop
        assert panel.text.value == words


def test_an_arm_that_is_unplugged_is_told(cell):
    press(cell)
    until(lambda: cell.text.value.startswith("follows"))
    cell.opened[0].port.faults.unplugged = True
    until(lambda: not cell.thread.is_alive())
    assert "is gone" in cell.text.value
    stays_ended(cell)


def stays_ended(cell):
    """Whatever ended it: ticks that still come from a page, asleep or with its sentence unread, do not set the arm off again."""
    until(lambda: not cell.play.playing)
    opened = len(cell.opened)
    cell.play.value += 1
    cell.play.value += 1
    assert not cell.thread.is_alive() and len(cell.opened) == opened


def test_a_panel_made_again_ends_the_one_before(cell, bench, localizer):
    """The cell of the notebook that is run again: the buttons of the first panel are gone from the page."""
    press(cell)
    until(lambda: cell.text.value.startswith("follows"))
    LiveCell(lambda: None, lambda arm: None, bench, localizer)
    until(lambda: not cell.thread.is_alive())
    stays_ended(cell)


@pytest.mark.parametrize("views", [1, 2])
def test_a_panel_that_no_page_shows_ends(cell, views):
    """Its output is cleared, or its cell deleted: the page itself still ticks. One that was loaded anew counts twice."""
    press(cell)
    cell.play._view_count = views
    until(lambda: cell.text.value.startswith("follows"))
    cell.play._view_count = views - 1
    until(lambda: not cell.thread.is_alive())
    stays_ended(cell)


def test_play_pressed_while_the_last_run_ends_begins_after_it(cell):
    press(cell)
    until(lambda: cell.text.value.startswith("follows"))
    cell.play.playing = False
    press(cell)
    until(lambda: len(cell.opened) == 2 and cell.text.value.startswith("follows"))
    assert not cell.opened[0].port.is_open and cell.play.playing


def test_without_an_arm_the_ball_is_seen(bench, localizer):
    panel = LiveCell(
        lambda: None,
        lambda arm: open_source("virtual", recording=bench, arm=arm, fast=True),
        bench,
        localizer,
        silent_s=1e9,
    )
    press(panel)
    until(lambda: panel.text.value.startswith("sees the ball"))
    panel.play.playing = False
    until(lambda: not panel.thread.is_alive())


def test_a_virtual_arm_keeps_the_time_of_the_clock(bench, localizer):
    for url, clock in (("virtual://arm", True), ("virtual://arm?seed=3", True), ("virtual://arm?realtime=0", False)):
        with widgets.live_cell("virtual", url, bench, localizer)._open_arm() as arm:
            assert arm.port.follows_the_clock is clock
    assert widgets.live_cell("bench", None, bench, localizer)._open_arm() is None


def test_controls_answer_while_a_cell_is_busy_where_the_kernel_can():
    new, old = SimpleNamespace(comm=SimpleNamespace(_reply_subshell_id="a")), SimpleNamespace(comm=SimpleNamespace())
    for control in (new, old, SimpleNamespace(comm=None)):
        answer_while_busy(control)
    assert not hasattr(new.comm, "_reply_subshell_id")
