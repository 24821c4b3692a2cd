"""The teacher's guide: its timetable is that of the lessons, its commands are commands, its prices are those of the parts."""

import json
import re
import shlex

import pytest

from conftest import ROOT
from stereo_lab.cli import _parser
from stereo_lab.results.cost import cost_usd

INSTRUCTOR = ROOT / "notebooks" / "instructor"
GUIDE = (INSTRUCTOR / "guide.md").read_text(encoding="utf-8")
NOTEBOOKS = sorted((ROOT / "notebooks").glob("[0-9][0-9]_*.ipynb"))


def sittings(path):
    """(minutes, first heading) of each sitting of a lesson, as its notebook tells them."""
    texts = [
        "".join(c["source"])
        for c in json.loads(path.read_text(encoding="utf-8"))["cells"]
        if c["cell_type"] == "markdown"
    ]
    whole = int(re.search(r"\*\*Time:\*\* (\d+) minutes", texts[0]).group(1))
    rest = [
        (k, int(found.group(1)))
        for k, text in enumerate(texts)
        if (found := re.search(r"This sitting takes about (\d+) minutes", text))
    ]
    begins = [
        next(
            found.group(1)
            for t in texts[k:]
            for found in re.finditer(r"^##+ (.+)$", t, re.MULTILINE)
            if not found.group(1).startswith("Sitting")
        )
        for k, _ in rest
    ]
    return [(whole - sum(m for _, m in rest), ""), *((m, begin) for (_, m), begin in zip(rest, begins, strict=True))]  # fmt: skip


def rows(part):
    """The rows of the first table under a heading."""
    text = GUIDE.partition(f"## {part}\n")[2]
    table = re.search(r"(?:^\|.*\n)+", text, re.MULTILINE).group(0).splitlines()[2:]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in table]


def test_the_timetable_is_that_of_the_lessons():
    """Whoever adds a lesson or changes its minutes changes the timetable in guide.md."""
    wanted = [
        (path.stem[:2], k, minutes, begin) for path in NOTEBOOKS for k, (minutes, begin) in enumerate(sittings(path), 1)
    ]
    told = rows("Timetable")
    assert [int(hour) for hour, *_ in told] == list(range(1, len(wanted) + 1))
    assert [(row[1], int(row[2])) for row in told] == [(f"{n}, sitting {k}", m) for n, k, m, _ in wanted]
    for row, (*_, begin) in zip(told, wanted, strict=True):
        assert row[3].startswith(begin or "the top"), row
    assert all(minutes <= 45 for *_, minutes, _ in wanted)  # an hour has 50


def test_every_lesson_has_its_sentence_and_its_wait():
    lessons = [path.stem[:2] for path in NOTEBOOKS]
    assert [row[0] for row in rows("What goes wrong in each lesson")] == lessons
    waits = re.search(r"^\|(?: \|)?(( \d\d \|)+)$", GUIDE, re.MULTILINE).group(1)
    assert re.findall(r"\d\d", waits) == lessons


def test_it_is_read_in_twenty_minutes():
    assert len(GUIDE.split()) < 20 * 200


def test_a_price_is_that_of_the_parts():
    told = [int(row[1]) for row in rows("What it costs")]
    assert told == [0, *(round(cost_usd(what)) for what in ("eyes", "DC", "servo"))]


def test_every_link_leads_somewhere():
    for link, mark in re.findall(r"\]\(([^)#]*)(#[^)]*)?\)", GUIDE):
        assert link.startswith("http") or (INSTRUCTOR / link).exists(), link
        assert link or re.search(rf"^#+ {mark[1:].replace('-', ' ')}$", GUIDE, re.MULTILINE | re.IGNORECASE), mark


COMMANDS = re.findall(r"(?:`|^    )(?:python3 lab\.py|stereo-lab) ([^`\n]+)", GUIDE, re.MULTILINE)


@pytest.mark.parametrize("command", sorted(set(COMMANDS)))
def test_every_command_is_one(command):
    if not command.startswith(("--help", "--offline")):  # lab.py's own
        assert callable(_parser().parse_args(shlex.split(command)).run)
