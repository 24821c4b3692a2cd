"""The printed sheets: two sides, whatever the paper, and commands that work."""

import re
import shlex
import shutil
from html.parser import HTMLParser

import pytest

from conftest import ROOT, skip_unless_ci
from stereo_lab.arm import connect
from stereo_lab.cli import _parser, main
from stereo_lab.exercises import questions

SHEETS = sorted((ROOT / "notebooks" / "instructor" / "handouts").glob("*.html"))
NOTEBOOKS = sorted((ROOT / "notebooks").glob("[0-9][0-9]_*.ipynb"))
every_sheet = pytest.mark.parametrize("path", SHEETS, ids=lambda p: p.stem)


class Sheet(HTMLParser):
    """What stands in the table of what goes wrong: its rows, and the command of each."""

    def __init__(self, path):
        super().__init__()
        self.open, self.rows, self.commands, self.alone = [], 0, [], []
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):
        if tag in ("meta", "link", "br", "line", "circle", "polygon", "polyline", "path", "rect"):
            return
        self.open.append((tag, dict(attributes).get("class", "")))
        if tag == "svg":
            self.alone.append(dict(attributes).get("aria-label"))
        self.rows += tag == "td" and ("table", "wrong") in self.open
        self.commands += [""] * (tag == "code" and ("table", "wrong") in self.open)

    def handle_endtag(self, tag):
        if tag not in ("line", "circle", "polygon", "polyline", "path", "rect"):
            assert self.open.pop()[0] == tag

    def handle_data(self, text):
        if ("code", "") in self.open and ("table", "wrong") in self.open:
            self.commands[-1] += text


def test_there_is_a_sheet_for_every_lesson():
    assert [path.stem for path in SHEETS] == [path.stem for path in NOTEBOOKS]


@every_sheet
def test_it_has_its_parts(path):
    text, sheet = path.read_text(encoding="utf-8"), Sheet(path)
    assert sheet.open == [] and all(sheet.alone) and sheet.alone
    for part in (
        "What you need",
        "Predict, before you run",
        "On the way home",
        "when it goes wrong",
        "Plan B",
        "absent",
    ):
        assert part in text, part
    assert sheet.rows == 10 and len(sheet.commands) == 5 == len(set(sheet.commands))


@every_sheet
def test_an_option_is_not_broken_at_the_end_of_a_line(path):
    """-- on one line and board on the next: who types that gets an error."""
    codes = re.findall(r"<code>.*?</code>", path.read_text(encoding="utf-8"), re.DOTALL)
    assert [code for code in codes if re.search(r"(?<!<span>)(?<![\w-])--\w", code)] == []
    assert "code span { white-space: nowrap; }" in (path.parent / "sheet.css").read_text(encoding="utf-8")


COMMANDS = [(path.stem[:2], command) for path in SHEETS for command in Sheet(path).commands]
ELSEWHERE = (
    "start",
    "ready",
    "cameras",
    "record",
    "detect",
    "run",
    "log",
)  # needs a browser, cameras, pictures, or half a minute


@pytest.mark.parametrize("command", sorted({c for _, c in COMMANDS if c.startswith("python3 lab.py ")}))
def test_a_command_works(command, tmp_path, monkeypatch):
    words = shlex.split(command)[2:]
    assert callable(_parser().parse_args(words).run)
    if words[0] in ELSEWHERE or "data/mine" in words:
        return
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("STEREO_LAB_WORK", str(tmp_path))
    if "--name" in words:  # a folder of that name would be made beside lab.py
        words = words[: words.index("--name")]
    assert main(words) == 0


@pytest.mark.parametrize(("lesson", "line"), [(n, c) for n, c in COMMANDS if not c.startswith("python3 lab.py ")])
def test_a_line_for_a_cell_works(lesson, line, bench, capsys):
    if found := re.fullmatch(r'catch_up\("(\d\d)", sitting=(\d)\)', line):
        (notebook,) = (path for path in NOTEBOOKS if path.stem.startswith(lesson))
        assert found[1] == lesson and line.replace('"', '\\"') in notebook.read_text(encoding="utf-8")
        return
    with connect("virtual://arm") as arm:
        exec(line, {"arm": arm, **{f"q{q.number}": q for q in questions(lesson, bench)}})
    assert capsys.readouterr().out.startswith("Hint 1") == ("hint" in line)


@pytest.fixture(scope="module")
def page():
    api = pytest.importorskip("playwright.sync_api") if shutil.which("chromium") else skip_unless_ci("no Chromium")
    with api.sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        yield chromium.new_page()
        chromium.close()


@every_sheet
def test_it_fits_the_two_sides_of_any_paper(path, page, tmp_path):
    pdf = pytest.importorskip("pypdfium2")
    page.goto(path.as_uri())
    for paper in ("A4", "Letter"):
        page.pdf(path=tmp_path / "sheet.pdf", format=paper)
        sides = [side.get_textpage().get_text_range() for side in pdf.PdfDocument(tmp_path / "sheet.pdf")]
        assert len(sides) == 2, f"{path.name} takes {len(sides)} pages of {paper}"
        assert "On the way home" in sides[0] and "when it goes wrong" in sides[1]
