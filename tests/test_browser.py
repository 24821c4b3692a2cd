"""The panels in a real browser: JupyterLab, headless Chromium, the keyboard."""

import json
import os
import shutil
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request

import nbformat
import pytest
from nbformat.v4 import new_code_cell, new_notebook

from conftest import ROOT, skip_unless_ci

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
    notebook.metadata["kernelspec"] = {"display_name": "Python 3", "language": "python", "name": "python3"}
    nbformat.write(notebook, folder / "panels.ipynb")
    settings = folder / "settings" / "@jupyterlab" / "apputils-extension"
    settings.mkdir(parents=True)
    quiet = {"fetchNews": "false", "checkForUpdates": False}
    (settings / "notification.jupyterlab-settings").write_text(json.dumps(quiet))
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    environment = {
        **os.environ, "PYTHONPATH": str(ROOT), "JUPYTER_CONFIG_DIR": str(folder / "config"),
        "JUPYTERLAB_SETTINGS_DIR": str(folder / "settings"), "JUPYTERLAB_WORKSPACES_DIR": str(folder / "workspaces"),
    }  # fmt: skip
    command = [
        sys.executable, "-m", "jupyterlab", "--no-browser", "--ip=127.0.0.1", f"--port={port}", "--allow-root",
        "--ServerApp.port_retries=0", "--IdentityProvider.token=panels", f"--ServerApp.root_dir={folder}",
        "--LabApp.expose_app_in_browser=True", "--LabApp.news_url=None",
        "--LabApp.check_for_updates_class=jupyterlab.NeverCheckForUpdate",
    ]  # fmt: skip
    with open(folder / "server.log", "w") as log:
        running = subprocess.Popen(command, env=environment, stdout=log, stderr=subprocess.STDOUT)
    try:
        _wait_until_up(running, f"http://127.0.0.1:{port}/api/status?token=panels", folder / "server.log")
        yield f"http://127.0.0.1:{port}/lab/tree/panels.ipynb?token=panels&reset"
    finally:
        running.terminate()
        running.wait(20)


def _wait_until_up(running, address, log):
    for _ in range(300):
        assert running.poll() is None, log.read_text()
        try:
            urllib.request.urlopen(address, timeout=2)
            return
        except (urllib.error.URLError, OSError):
            time.sleep(0.2)
    raise AssertionError(log.read_text())


@pytest.mark.slow
def test_panels_answer_the_keyboard(server):
    browser_path = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if browser_path is None:
        skip_unless_ci("no Chromium on this computer")
    playwright = pytest.importorskip("playwright.sync_api") if not os.environ.get("STEREO_LAB_NO_SKIPS") else None
    if playwright is None:
        import playwright.sync_api as playwright
    with playwright.sync_playwright() as api:
        browser = api.chromium.launch(executable_path=browser_path, args=list(FLAGS))
        page = browser.new_page(viewport={"width": 1400, "height": 1100})
        outside = []
        page.on(
            "request",
            lambda r: (
                None if r.url.startswith(("http://127.0.0.1", "data:", "blob:", "ws://127")) else outside.append(r.url)
            ),
        )
        try:
            _run_all_cells(page, server, playwright.TimeoutError)
            _check_panels(page)
            assert not outside
        finally:
            browser.close()


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
