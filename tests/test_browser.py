"""The course, its panels and its clips in a real browser: JupyterLab, headless Chromium, the keyboard."""

import ast
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from types import SimpleNamespace

import nbformat
import numpy as np
import psutil
import pytest
from nbformat.v4 import new_code_cell, new_notebook

from conftest import ROOT, skip_unless_ci
from stereo_lab.recording.marks import read_marks
from stereo_lab.widgets import Clip
from stereo_lab.widgets.lesson09 import ZOOM_PX
from tests.axe import PAGE, serious

SETUP = """from stereo_lab import widgets
from stereo_lab.motion import Motor
from stereo_lab.calibration import calibrate_recording
from stereo_lab.recording import open_recording
recording = open_recording("bench")
calibration = calibrate_recording(recording)
pair = recording.samples("evaluation")[0].pair
print("ready")"""
PANELS = (
    'widgets.color_thresholds(pair.left, "red")',
    'widgets.hough_parameters(pair.left, "red")',
    "widgets.epipolar_line(calibration, pair.left, pair.right)",
    "widgets.ball_against_disparity(120.0, 690.0, 40.0)",
    "widgets.arm_reaches(recording.arm)",
    "widgets.stopping(Motor())",
    "widgets.registering(recording.arm)",
    "widgets.depth_samples([160.0, 103.0, 73.0, 60.0], [520.0, 813.0, 1104.0, 1397.0])",
)
LIVE = (
    """import threading, time
from pathlib import Path

import psutil
from stereo_lab import widgets
from stereo_lab.localization import Localizer
from stereo_lab.recording import open_recording
stage = open_recording("bench")
panel = widgets.live_cell("virtual", "virtual://arm", stage, Localizer.fit(stage))


def watch():  # from outside: whether the run goes on, where ball and arm are, and what the kernel holds
    while True:
        alive = panel.thread is not None and panel.thread.is_alive()
        source, memory = panel._source, psutil.Process().memory_info().rss / 1e6
        place = (source.ball_mm, source.arm.link_deg) if source is not None and source.arm is not None else None
        Path("seen.txt.part").write_text(repr((alive, place, memory)))
        Path("seen.txt.part").replace("seen.txt")
        time.sleep(0.2)


threading.Thread(target=watch, daemon=True).start()""",
    "panel",
    "print('free')",
    "while not Path('enough').exists():\n    time.sleep(0.1)",
)
MARKING = (
    """from stereo_lab import widgets
from stereo_lab.recording.marks import shots_of
panel = widgets.mark_balls(shots_of("clutter", "snaps", ["002", "012"]), "marks.csv", "red")""",
    "panel",
)
FLAGS = (
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--disable-dev-shm-usage",
)  # fmt: skip
ALL_RUN = r"""() => {
    const prompts = [...document.querySelectorAll('.jp-NotebookPanel .jp-CodeCell .jp-InputPrompt')];
    return prompts.length > 0 && prompts.every(p => /^\[\d+\]:$/.test(p.textContent.trim()));
}"""


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    """JupyterLab on a notebook with one cell for each panel; gives its address."""
    folder = tmp_path_factory.mktemp("lab")
    notebook = new_notebook(cells=[new_code_cell(source) for source in (SETUP, *PANELS)])
    live = new_notebook(cells=[new_code_cell(source) for source in LIVE])
    marking = new_notebook(cells=[new_code_cell(source) for source in MARKING])
    for name, content in (("panels", notebook), ("live", live), ("marking", marking)):
        content.metadata["kernelspec"] = {"display_name": "Python 3", "language": "python", "name": "python3"}
        nbformat.write(content, folder / f"{name}.ipynb")
    settings = folder / "settings" / "@jupyterlab" / "apputils-extension"
    settings.mkdir(parents=True)
    quiet = {"fetchNews": "false", "checkForUpdates": False}
    (settings / "notification.jupyterlab-settings").write_text(json.dumps(quiet))
    port = free_port()
    environment = {
        **os.environ, "PYTHONPATH": str(ROOT), "JUPYTER_CONFIG_DIR": str(folder / "config"),
        "JUPYTERLAB_SETTINGS_DIR": str(folder / "settings"), "JUPYTERLAB_WORKSPACES_DIR": str(folder / "workspaces"),
    }  # fmt: skip
    command = [
        sys.executable, "-m", "jupyterlab", "--no-browser", "--ip=127.0.0.1", f"--port={port}", "--allow-root",
        "--ServerApp.port_retries=0", "--IdentityProvider.token=panels", f"--ServerApp.root_dir={folder}",
        "--LabApp.expose_app_in_browser=True", f"--LabApp.extra_labextensions_path={PAGE}", "--LabApp.news_url=None",
        "--LabApp.check_for_updates_class=jupyterlab.NeverCheckForUpdate",
    ]  # fmt: skip
    with open(folder / "server.log", "w") as log:
        running = subprocess.Popen(command, env=environment, stdout=log, stderr=subprocess.STDOUT)
    try:
        _wait_until_up(running, f"http://127.0.0.1:{port}/api/status?token=panels", folder / "server.log")
        yield SimpleNamespace(
            folder=folder,
            process=running,
            page=lambda name: f"http://127.0.0.1:{port}/lab/tree/{name}.ipynb?token=panels&reset",
        )
    finally:
        running.terminate()
        running.wait(20)


def free_port():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return free.getsockname()[1]


def _wait_until_up(running, address, log):
    for _ in range(300):
        assert running.poll() is None, log.read_text()
        try:
            urllib.request.urlopen(address, timeout=2)
            return
        except (urllib.error.URLError, OSError):
            time.sleep(0.2)
    raise AssertionError(log.read_text())


@pytest.fixture(scope="module")
def browser():
    """A headless Chromium; gives it and what its waiting raises when it is too late."""
    browser_path = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if browser_path is None:
        skip_unless_ci("no Chromium on this computer")
    playwright = pytest.importorskip("playwright.sync_api") if not os.environ.get("STEREO_LAB_NO_SKIPS") else None
    if playwright is None:
        import playwright.sync_api as playwright
    with playwright.sync_playwright() as api:
        chromium = api.chromium.launch(executable_path=browser_path, args=list(FLAGS))
        yield SimpleNamespace(chromium=chromium, late=playwright.TimeoutError)
        chromium.close()


@pytest.mark.slow
def test_panels_answer_the_keyboard(server, browser):
    page = browser.chromium.new_page(viewport={"width": 1400, "height": 1100})
    outside = []
    page.on(
        "request",
        lambda r: (
            None if r.url.startswith(("http://127.0.0.1", "data:", "blob:", "ws://127")) else outside.append(r.url)
        ),
    )
    _run_all_cells(page, server.page("panels"), browser.late)
    _check_panels(page)
    assert not outside
    assert all(picture.get_attribute("alt") for picture in page.locator("img.widget-image").all())
    assert serious(page, "window.jupyterapp.shell.currentWidget.node") == []
    page.close()


@pytest.mark.slow
def test_the_live_cell_is_seen_steered_and_stopped(server, browser):
    """Play, pictures that change, a ball that is dragged and an arm behind it; stop while another cell is busy; a closed tab."""
    page = browser.chromium.new_page(viewport={"width": 1400, "height": 1200})
    enough = server.folder / "enough"  # until it is there, the last cell is busy
    enough.touch()
    _run_all_cells(page, server.page("live"), browser.late)  # nothing is pressed yet
    text, picture = page.locator(".widget-label").last, page.locator(".widget-image").first
    play, stop = page.locator(".widget-play button").nth(0), page.locator(".widget-play button").nth(1)
    assert not seen(server)[0]

    play.click()
    until(lambda: text.inner_text().startswith("follows"))
    shown = {
        picture.get_attribute("src") or picture.evaluate("e => e.src")
        for _ in range(6)
        if not page.wait_for_timeout(300)
    }
    assert len(shown) >= 4  # pictures that change

    alive, (ball, links), _ = seen(server)
    handle = page.locator(".widget-slider .noUi-handle").first
    handle.focus()
    for _ in range(60):
        page.keyboard.press("ArrowLeft")
    until(lambda: seen(server)[1][0][0] <= ball[0] - 50)
    until(lambda: max(abs(a - b) for a, b in zip(seen(server)[1][1], links, strict=True)) > 3)  # the arm goes after it

    enough.unlink()
    run_cell(page, 3)
    busy = page.locator(".jp-CodeCell").nth(3).locator(".jp-InputPrompt")
    until(lambda: busy.inner_text() == "[*]:")
    stop.click()
    until(lambda: not seen(server)[0] and text.inner_text().startswith("Ended"))
    assert busy.inner_text() == "[*]:"
    enough.touch()
    page.wait_for_function(ALL_RUN, timeout=60_000)
    run_cell(page, 2)  # the kernel is free
    page.wait_for_function("() => document.body.innerText.includes('free')", timeout=20_000)

    play.click()
    until(lambda: text.inner_text().startswith("follows"))
    server_mb = psutil.Process(server.process.pid).memory_info().rss / 1e6
    kernel_mb = seen(server)[2]
    page.close()  # the tab, in mid-run
    until(lambda: not seen(server)[0], 12)  # 5 s of silence, and what a busy computer needs
    time.sleep(2)
    assert psutil.Process(server.process.pid).memory_info().rss / 1e6 < server_mb + 40
    assert seen(server)[2] < kernel_mb + 40


@pytest.mark.slow
def test_a_ball_is_marked_by_clicks_and_by_keys(server, browser):
    """Two clicks at known places, an arrow key, a button: the table has them."""
    page = browser.chromium.new_page(viewport={"width": 1400, "height": 1300})
    _run_all_cells(page, server.page("marking"), browser.late)
    picture = page.locator('img[alt^="picture"]')
    picture.wait_for(timeout=30_000)
    picture.scroll_into_view_if_needed()
    truth = (436.2, 372.1, 16.2)  # of 002

    def click(u, v):
        box = picture.bounding_box()
        scale = box["width"] / (640 + ZOOM_PX)
        page.mouse.click(box["x"] + (u + 0.5) * scale, box["y"] + (v + 0.5) * scale)

    click(*truth[:2])
    page.get_by_text("Now click the rim").wait_for(timeout=20_000)
    click(truth[0] + truth[2], truth[1])
    page.get_by_text("Does the circle follow the rim").wait_for(timeout=20_000)
    page.locator(".noUi-handle").nth(2).focus()
    page.keyboard.press("ArrowRight")
    page.wait_for_timeout(500)
    for name in ("next", "no ball", "save"):
        page.get_by_role("button", name=name, exact=True).click()
    page.get_by_text("is written: 1 with the ball, 1 without").wait_for(timeout=20_000)
    marks = read_marks(server.folder / "marks.csv")
    assert marks["012"] is None and marks["002"][2] == 17
    assert np.hypot(*np.subtract(marks["002"][:2], truth[:2])) < 2
    page.close()


@pytest.mark.slow
def test_a_clip_plays_and_pauses(browser):
    block = [np.full((240, 320, 3), 20 * k, np.uint8) for k in range(10)]
    page = browser.chromium.new_page()
    page.set_content(Clip(block, 10, "a page that grows light")._repr_mimebundle_()["text/html"])
    page.wait_for_function("() => document.querySelector('video').readyState >= 2", timeout=20_000)
    video = page.locator("video")
    assert 0.8 <= video.evaluate("v => v.duration") <= 1.2 and video.evaluate("v => v.paused")
    video.evaluate("v => v.play()")
    page.wait_for_function("() => document.querySelector('video').currentTime > 0.3", timeout=20_000)
    video.evaluate("v => v.pause()")
    assert video.evaluate("v => v.paused && v.error === null")
    page.close()


@pytest.mark.slow
def test_the_course_opens_and_its_first_picture_comes(browser, tmp_path):
    """As `lab.py` opens it, in an empty home: a copy with nothing in it; the first cells are run by the keyboard."""
    port = free_port()
    environment = {
        **os.environ,
        "PYTHONPATH": str(ROOT),
        "HOME": str(tmp_path / "home"),
        "STEREO_LAB_WORK": str(tmp_path / "work"),
    }
    options = ["--no-browser", "--ip=127.0.0.1", f"--port={port}", "--allow-root", "--IdentityProvider.token=panels"]
    command = [sys.executable, "-m", "stereo_lab", "start", "--", *options]
    with open(tmp_path / "server.log", "w") as log:
        running = subprocess.Popen(
            command, env=environment, stdout=log, stderr=subprocess.STDOUT, start_new_session=True
        )
    try:
        _wait_until_up(running, f"http://127.0.0.1:{port}/api/status?token=panels", tmp_path / "server.log")
        page = browser.chromium.new_page(viewport={"width": 1400, "height": 1000})
        page.goto(f"http://127.0.0.1:{port}/lab/tree/00_start_here.ipynb?token=panels")
        page.locator('.jp-NotebookPanel .jp-Notebook-ExecutionIndicator[data-status="idle"]').wait_for(timeout=90_000)
        assert (
            page.locator(".jp-OutputArea img, .jp-OutputArea pre").count() == 0
            and page.get_by_text("instructor").count() == 0
        )
        page.wait_for_timeout(1500)  # the page is still being laid out
        page.locator(".jp-CodeCell .jp-InputArea-editor").first.click()
        page.locator(".jp-CodeCell .cm-focused").first.wait_for(timeout=10_000)
        for _ in range(6):  # two cells of code, and the text between them
            page.keyboard.press("Shift+Enter")
            page.wait_for_timeout(500)
        page.locator(".jp-OutputArea img").first.wait_for(timeout=60_000)
        assert page.get_by_text("Jupyter news").count() == 0 or not (ROOT / ".venv").exists()
        page.close()
    finally:
        os.killpg(running.pid, signal.SIGTERM)
        running.wait(30)


def seen(server):
    """Whether the run goes on; (ball, links) or None; the kernel's memory in MB."""
    return ast.literal_eval((server.folder / "seen.txt").read_text())


def until(what, seconds=60):
    end = time.monotonic() + seconds
    while not what() and time.monotonic() < end:
        time.sleep(0.1)
    assert what()


def run_cell(page, number):
    """Click into a cell and run it."""
    page.locator(".jp-CodeCell .jp-InputArea-editor").nth(number).click()
    page.keyboard.press("Control+Enter")


def _run_all_cells(page, server, late):
    """Where the page loses its kernel while both start, as on a busy computer, nothing runs: it is loaded once more."""
    for last in (False, True):
        page.goto(server)
        page.locator('.jp-NotebookPanel .jp-Notebook-ExecutionIndicator[data-status="idle"]').wait_for(timeout=90_000)
        page.wait_for_timeout(1500)
        assert page.locator(".jp-Dialog").count() == 0, page.locator(".jp-Dialog").inner_text()
        page.evaluate("() => window.jupyterapp.commands.execute('notebook:clear-all-cell-outputs')")
        page.evaluate(
            "() => { window.jupyterapp.commands.execute('notebook:run-all-cells'); }"
        )  # not waited for without an end
        try:
            page.wait_for_function(ALL_RUN, timeout=120_000)
            return
        except late:
            if last:
                raise


def _check_panels(page):
    errors = '.jp-RenderedText[data-mime-type="application/vnd.jupyter.error"], [data-mime-type="application/vnd.jupyter.stderr"]'
    assert page.locator(errors).count() == 0, page.locator(errors).all_inner_texts()
    assert page.get_by_text("Error displaying widget").count() == 0
    pictures = page.locator("img.widget-image")
    pictures.nth(len(PANELS) - 1).wait_for(timeout=30_000)
    assert pictures.count() == len(PANELS)
    for k in range(len(PANELS)):
        picture = pictures.nth(k)
        picture.scroll_into_view_if_needed()
        before = picture.get_attribute("src")
        panel = picture.locator("xpath=ancestor::div[contains(@class,'widget-vbox')][1]")
        handle = panel.locator(".noUi-handle, input[type=checkbox]").first
        handle.focus()
        for _ in range(6):
            page.keyboard.press("Space" if k == len(PANELS) - 1 else "ArrowRight")
            page.wait_for_timeout(60)
            if picture.get_attribute("src") != before:
                break
        page.wait_for_function(
            "([e, s]) => e.getAttribute('src') !== s", arg=[picture.element_handle(), before], timeout=15_000
        )
    assert page.locator(".jp-Dialog").count() == 0
    if os.environ.get("STEREO_LAB_SCREENSHOT"):
        page.screenshot(path=os.environ["STEREO_LAB_SCREENSHOT"])
