"""Who sees little, sees no colours or has no mouse: words, headings, contrast, names."""

import json
import os
import re
import shutil
import subprocess
import sys

import numpy as np
import pytest

from conftest import ROOT
from tests.axe import PAGE, judged
from tests.test_browser import _wait_until_up, browser, free_port  # noqa: F401 - browser is a fixture

LESSONS = sorted((ROOT / "notebooks").glob("[0-9][0-9]_*.ipynb"))
PAGES = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "notebooks").rglob("*.md"), *(ROOT / "stereo_lab").rglob("*.md")]  # fmt: skip
PAGES = sorted(page for page in PAGES if not any(part.startswith(".") for part in page.relative_to(ROOT).parts))
OPEN = """path => window.jupyterapp.commands.execute("docmanager:open", {path, factory: "Notebook"})
    .then(shown => { window.shown = shown; return shown.context.ready; }).then(() => true)"""
# Formulas are set one after the other, and are too wide for a moment: nothing has moved for five looks
STILL = """() => {
    const now = [...window.shown.node.querySelectorAll(".jp-MarkdownOutput")].map(e => [e.scrollWidth, e.scrollHeight]).join();
    window.looks = now === window.before ? window.looks + 1 : 0;
    window.before = now;
    return window.looks >= 5;
}"""
NAMED = """() => window.shown.content.widgets.length > 20 && window.shown.node.querySelectorAll(".jp-OutputArea img").length > 2
    && [...window.shown.node.querySelectorAll(".jp-OutputArea img")].every(img => img.alt)"""


@pytest.mark.slow
def test_axe_finds_nothing_serious_in_any_lesson(browser, tmp_path):  # noqa: F811
    lessons, port = tmp_path / "lessons", free_port()
    lessons.mkdir()
    for lesson in LESSONS:
        shutil.copy(lesson, lessons)
    settings = tmp_path / "settings" / "@jupyterlab" / "notebook-extension"
    settings.mkdir(parents=True)
    (settings / "tracker.jupyterlab-settings").write_text('{"windowingMode": "none"}')  # every cell is there at once
    environment = {
        **os.environ,
        "JUPYTERLAB_SETTINGS_DIR": str(tmp_path / "settings"),
        "JUPYTER_CONFIG_DIR": str(tmp_path),
    }
    environment["JUPYTERLAB_WORKSPACES_DIR"] = str(tmp_path / "workspaces")
    command = [sys.executable, "-m", "jupyterlab", "--no-browser", "--ip=127.0.0.1", f"--port={port}", "--allow-root",
               "--IdentityProvider.token=axe", f"--ServerApp.root_dir={lessons}", "--LabApp.expose_app_in_browser=True",
               "--LabApp.news_url=None", f"--LabApp.extra_labextensions_path={PAGE}"]  # fmt: skip
    with open(tmp_path / "server.log", "w") as log:
        running = subprocess.Popen(command, env=environment, stdout=log, stderr=subprocess.STDOUT)
    try:
        _wait_until_up(running, f"http://127.0.0.1:{port}/api/status?token=axe", tmp_path / "server.log")
        page = browser.chromium.new_page(viewport={"width": 1400, "height": 1000})
        page.goto(f"http://127.0.0.1:{port}/lab?token=axe&reset")
        page.wait_for_function("() => window.jupyterapp", timeout=90_000)
        page.evaluate("() => window.jupyterapp.restored.then(() => true)")
        told = {}
        for lesson in LESSONS:
            page.evaluate(OPEN, lesson.name)
            page.wait_for_function(NAMED, polling=300, timeout=120_000)
            page.wait_for_function(STILL, polling=300, timeout=120_000)
            told[lesson.name], passed = judged(page, "window.shown.node")
            # a page on which nothing is judged passes as well: all kinds must have been there
            assert passed["color-contrast"] > 50 and passed["heading-order"] > 5 and passed["image-alt"] > 2, passed
            page.evaluate("() => window.shown.dispose()")
        assert told == {lesson.name: [] for lesson in LESSONS}
        page.close()
    finally:
        running.terminate()
        running.wait(20)


def headings(text):
    """The levels of a page's headings, those in code left out."""
    return [
        len(marks) for marks in re.findall(r"^(#{1,6}) ", re.sub(r"^```.*?^```", "", text, flags=re.M | re.S), re.M)
    ]


@pytest.mark.parametrize("path", LESSONS, ids=lambda p: p.name)
def test_a_lessons_headings_are_in_order(path):
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    levels = headings("\n".join("".join(c["source"]) for c in cells if c["cell_type"] == "markdown"))
    assert levels[0] == 1 and levels.count(1) == 1 and len(levels) > 5
    assert not [k for k, (a, b) in enumerate(zip(levels, levels[1:], strict=False)) if b > a + 1]


@pytest.mark.parametrize("path", PAGES, ids=lambda p: str(p.relative_to(ROOT)))
def test_a_pages_headings_are_in_order_and_its_pictures_are_told(path):
    text = path.read_text(encoding="utf-8")
    levels = headings(text)
    assert levels[:1] == [1] and levels.count(1) == 1
    assert not [k for k, (a, b) in enumerate(zip(levels, levels[1:], strict=False)) if b > a + 1]
    assert all(len(words.split()) >= 4 for words in re.findall(r"!\[([^\]]*)\]\(", text))


def test_no_message_tells_by_colour():
    """The terminal's colours are not used at all: what is fit, passed or wrong is said in words."""
    colour = re.compile(r"(\\033|\\x1b|\\e)\[[0-9;]*m", re.IGNORECASE)
    files = sorted((ROOT / "stereo_lab").rglob("*.py"))
    assert len(files) > 100 and not [path for path in files if colour.search(path.read_text(encoding="utf-8"))]


def test_a_panel_has_a_name_and_its_controls_have_labels(bench):
    from stereo_lab import widgets

    panels = [widgets.arm_reaches(bench.arm), widgets.color_thresholds(np.zeros((48, 64, 3), np.uint8), "red")]
    for panel in panels:
        assert len(repr(panel)) > len("panel: ") and repr(panel).startswith(
            "panel: "
        )  # the page names its picture by it
        assert all(control.description for control in panel._controls.values()) and panel.text.value
