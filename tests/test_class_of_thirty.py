"""A class of thirty, made up: every row must be right."""

import json
import shutil
import time

import pytest

from conftest import ROOT
from stereo_lab.classroom import room
from stereo_lab.classroom.grading import NOT_HERE, grade
from stereo_lab.classroom.table import read_teacher, write_table
from stereo_lab.recording import open_recording
from tests.classes import (
    BROKEN,
    HOSTILE,
    NONE,
    STEM,
    carries_before_it_checks,
    learner,
    on_recording,
    remembers_by_dying,
)


def hand_in(folder, learners):
    """Write notebooks into a folder; gives what is to come out, by learner."""
    folder.mkdir(parents=True, exist_ok=True)
    wanted = {}
    for name, (content, wants) in learners.items():
        data = content if isinstance(content, bytes) else json.dumps(content).encode()
        (folder / f"{STEM}_{name}.ipynb").write_bytes(data)
        wanted[name] = wants
    return wanted


def wrong_rows(rows, wanted):
    """What a row says other than it should."""
    odd = []
    for row in rows:
        for k, (status, told) in wanted[row.learner].items():
            mark = row.marks[k - 1]
            if mark.status != status or not mark.why.startswith(told):
                odd.append((row.learner, k, (status, told), mark, row.notes))
    return odd


@pytest.mark.slow
def test_every_row_of_a_class_of_thirty_is_right(tmp_path):
    hostile = {name: make() for name, make in HOSTILE.items()}
    shut = room.build_room(tmp_path / "room").shut_by == room.BUBBLEWRAP
    if not shut:  # what only a closed room can hold back
        for name in ("fills_the_disk", "looks_for_files"):
            del hostile[name]
    broken = {name: (content, NONE) for name, content in list(BROKEN.items())[:1]}
    honest = {f"learner{k}": learner(k) for k in range(30 - len(hostile) - len(broken))}
    assert len(hostile) >= 12 and len(honest) >= 5
    wanted = hand_in(tmp_path / "in", {**honest, **hostile, **broken})
    assert len(wanted) == 30
    began = time.monotonic()
    graded = grade(tmp_path / "in", open_recording(ROOT / "data" / "bench"), tmp_path / "kept.json")
    print(f"{time.monotonic() - began:.0f} s for {len(wanted)} notebooks. {graded.how}")
    assert {row.learner for row in graded.rows} == set(wanted)
    assert wrong_rows(graded.rows, wanted) == []
    assert max(len("".join(row.notes)) for row in graded.rows) < 5_000  # csv reads no cell of 131072 letters back
    write_table(tmp_path / "class.csv", graded.rows)
    assert set(read_teacher(tmp_path / "class.csv")) == {(row.learner, row.lesson) for row in graded.rows}


@pytest.mark.slow
def test_a_notebook_is_judged_by_the_recording_that_it_names(tmp_path):
    """One of the kit's wherever it is named; one's own with --recording, and without it one sentence says so."""
    bench, own = open_recording(ROOT / "data" / "bench"), tmp_path / "data" / "mine"
    shutil.copytree(ROOT / "data" / "second_rig", own)
    wanted = hand_in(tmp_path / "in", {name: on_recording(name) for name in ("second_rig", "mine")})
    rows = {row.learner: row for row in grade(tmp_path / "in", bench, tmp_path / "kept.json").rows}
    assert wrong_rows([rows["second_rig"]], wanted) == [] and rows["second_rig"].notes == (
        "on the recording second_rig",
    )
    assert (rows["mine"].notes, wrong_rows([rows["mine"]], {"mine": NONE})) == ((NOT_HERE.format("data/mine"),), [])
    graded = grade(tmp_path / "in", open_recording(own), tmp_path / "kept.json")
    assert wrong_rows(graded.rows, wanted) == []


@pytest.mark.slow
def test_what_carry_gives_is_the_learners_only_where_it_was_theirs(tmp_path):
    wanted = hand_in(tmp_path / "in", {"honest": carries_before_it_checks(), "sly": remembers_by_dying()})
    graded = grade(tmp_path / "in", open_recording(ROOT / "data" / "bench"), tmp_path / "kept.json")
    assert {row.learner for row in graded.rows} == set(wanted) and wrong_rows(graded.rows, wanted) == []
    again = grade(tmp_path / "in", open_recording(ROOT / "data" / "bench"), tmp_path / "kept.json")
    assert (again.run, again.how) == (0, "No notebook had to be run.") and again.rows == graded.rows
