"""What the grading stands on: the pipe, the drawn inputs, the papers, the table."""

import ast
import csv
import dataclasses
import json
import os
import shutil
from array import array
from collections import deque
from decimal import Decimal
from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest

from conftest import ROOT, skip_unless_ci
from stereo_lab.classroom import desk, grading
from stereo_lab.classroom.desk import _ByNumber
from stereo_lab.classroom.grading import LESSONS as NOTEBOOKS
from stereo_lab.classroom.grading import Graded, solved, source_of
from stereo_lab.classroom.hearing import Answer, Heard, _Asked
from stereo_lab.classroom.line import LONGEST_LINE
from stereo_lab.classroom.marking import marks_of
from stereo_lab.classroom.marks import Mark, Row, kind_of_mistake, tally
from stereo_lab.classroom.missing import with_what_is_missing
from stereo_lab.classroom.opened import name_of, on_a_shelf, opened, opens_what_it_gets
from stereo_lab.classroom.page import write_page
from stereo_lab.classroom.papers import (
    Paper,
    kit_cells,
    latest,
    not_looked_at,
    papers_in,
    read_paper,
    whole_work_folders,
    written,
)
from stereo_lab.classroom.room import build_room
from stereo_lab.classroom.store import Store
from stereo_lab.classroom.table import read_teacher, write_table
from stereo_lab.classroom.wire import DEEPEST, LARGEST_ARRAY, legible, pack, unpack
from stereo_lab.cli import main
from stereo_lab.errors import StereoLabError
from stereo_lab.exercises import LESSONS, ____, questions
from stereo_lab.exercises.answers import NOT_ATTEMPTED, NOT_YET, PASS, Function, Number, Verdict, judge
from stereo_lab.exercises.draws import with_fresh_inputs
from stereo_lab.recording import Position, open_recording
from tests.classes import BROKEN, LESSON, STEM, add, answered, asked, kit, right, stub, without


@pytest.fixture(scope="module", params=LESSONS)
def lesson(request):
    return questions(request.param, open_recording(ROOT / "data" / "bench"))


def through(value):
    return unpack(json.loads(json.dumps(pack(value))))


def same(a, b):
    if isinstance(a, (tuple, list)):
        return type(a) is type(b) and len(a) == len(b) and all(map(same, a, b))
    return np.array_equal(a, b, equal_nan=isinstance(a, float)) and np.shape(a) == np.shape(b)


def test_all_that_questions_try_and_want_goes_through_the_pipe(lesson):
    for q in lesson:
        if isinstance(q.answer, Function):
            for f in (q.answer, with_fresh_inputs(q.name, q.answer, 5)):
                for arguments in f.inputs:
                    assert all(same(a, through(a)) for a in arguments), q.name
                    assert same(f.right(*arguments), through(f.right(*arguments))), q.name
        else:
            assert same(q.reference, through(q.reference)), q.name
            assert judge(q.answer, through(q.reference)).status == PASS


def test_drawn_inputs_are_other_ones_and_judge_alike(lesson):
    for q in (q for q in lesson if isinstance(q.answer, Function)):
        for seed in range(20):
            fresh = with_fresh_inputs(q.name, q.answer, seed)
            assert len(fresh.inputs) == len(q.answer.inputs)
            for right_one in (q.reference, *q.answer.also):
                assert judge(fresh, right_one).status == PASS, (q.name, seed)
        other = sum(not same(a, b) for a, b in zip(fresh.inputs, q.answer.inputs, strict=True))
        assert other >= 0.6 * len(fresh.inputs), q.name
        wrong = [judge(fresh, w.answer).status for w in q.answer.wrong]
        assert wrong.count(PASS) <= len(wrong) // 2, q.name  # the lesson's own inputs are tried as well


class Evil(str):
    def __str__(self):
        raise SystemExit

    __len__ = __iter__ = __float__ = __array__ = __str__


@pytest.mark.parametrize(
    "value",
    [
        object(),
        lambda: 1,
        {"a": 1},
        {1, 2},
        10**9999,
        np.array([object()]),
        np.ones((1000, 1000)),
        np.array("text"),
        1j,
        {(1, 2): 3},
        Ellipsis,
    ],
    ids=lambda v: type(v).__name__,
)
def test_what_is_no_plain_data_goes_as_its_kind(value):
    assert type(through(value)).__name__ == type(value).__name__ or callable(value)


@pytest.mark.parametrize(
    "value",
    [Decimal("1.5"), Fraction(3, 2), np.array(1.5, ">f8"), np.array([1.5], object), deque([1.5]), array("d", [1.5]), np.float16(1.5)],
    ids=lambda v: type(v).__name__,
)  # fmt: skip
def test_numbers_in_any_dress_count_as_they_do_in_a_notebook(value):
    number = Number(1.5, 0.001)
    assert judge(number, value).status == judge(number, through(value)).status == PASS


@pytest.mark.parametrize("value", [{1.5}, {"a": 1.5}, 1.5 + 0j, True, np.array([True])], ids=lambda v: type(v).__name__)
def test_what_is_no_number_is_told_as_in_a_notebook(value):
    number = Number(1.5, 0.001)
    assert judge(number, value) == judge(number, through(value)) and judge(number, through(value)).status == NOT_YET


class Endless(list):
    def __len__(self):
        return 1

    def __iter__(self):
        while True:
            yield 1


def test_pictures_go_through_the_pipe_whole():
    hue = np.random.default_rng(1).integers(0, 180, (720, 1280)).astype(float)
    assert same(hue, through(hue)) and len(json.dumps(pack(hue))) < LONGEST_LINE
    assert len(json.dumps(pack(np.zeros(LARGEST_ARRAY // 8)))) < LONGEST_LINE


def test_a_list_that_lies_is_read_past_its_own_methods():
    assert through(Endless([1, 2])) == [1, 2]


def test_what_a_learner_says_can_be_written_and_shown():
    assert legible("a\ud800b\x1b[31m\r\nc\td") == "a\\ud800b\N{REPLACEMENT CHARACTER}[31m\nc\td"
    assert legible("Zoë 🤖 ∂", 5) == "Zoë 🤖"
    turning = "\u061c\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069"
    assert legible(f"bob{turning}(deppots") == "bob" + len(turning) * "\N{REPLACEMENT CHARACTER}" + "(deppots"
    assert legible("محمد שלום") == "محمد שלום"


def test_monsters_go_through_as_plain_things():
    deep = []
    for _ in range(3000):
        deep = [deep]
    assert type(through(Evil("below"))) is str and through(Evil("below")) == "below"
    level, depth = through(deep), 0
    while isinstance(level, list):
        level, depth = level[0], depth + 1
    assert depth == DEEPEST
    assert through([1, ____]) is ____ and len(through("x" * 10**6)) == 2000
    endless = []
    endless.append(endless)
    assert through(endless)
    assert through(Position(1, 2, 3)) == Position(1, 2, 3)


@pytest.mark.parametrize(
    "told",
    [
        [],
        {},
        {"list": 5},
        {"array": "AA", "type": "O", "shape": [1]},
        {"array": "AA==", "type": "<f8", "shape": [10**9]},
        {"array": "AAAAAAAAAAA=", "type": "(1,", "shape": [1]},
        {"bare": "list"},
        {"place": [1]},
    ],
)
def test_what_nobody_packed_is_refused(told):
    with pytest.raises((ValueError, TypeError, KeyError)):
        unpack(told)


def test_the_room_has_no_answers_in_it(tmp_path):
    build_room(tmp_path)
    files = {
        path.relative_to(tmp_path / "kit" / "stereo_lab").as_posix()
        for path in (tmp_path / "kit" / "stereo_lab").rglob("*.py")
    }
    assert {f for f in files if f.startswith("exercises/")} == {"exercises/__init__.py", "exercises/blank.py"}
    assert {f for f in files if f.startswith("classroom/")} == {
        f"classroom/{n}.py" for n in ("__init__", "wire", "desk")
    }
    text = "".join((tmp_path / "kit" / "stereo_lab" / f).read_text(encoding="utf-8") for f in files)
    for q in asked():
        assert q.reason not in text and q.hints[0] not in text


def put(folder, name, notebook):
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(notebook if isinstance(notebook, bytes) else json.dumps(notebook).encode())
    return path


@pytest.mark.parametrize("name", BROKEN)
def test_a_broken_paper_says_so(tmp_path, name):
    paper = read_paper(put(tmp_path, "03_x.ipynb", BROKEN[name]), tmp_path)
    assert paper.lesson == "03" and paper.learners == ("x",)
    assert ("no notebook that can be read" in paper.trouble) == (name != "no_cells")


def test_a_class_one_folder_deeper_is_a_class(tmp_path):
    for name in ("ada", "ben", "cy"):
        put(tmp_path, f"home/{name}/work/03_world_coordinates.ipynb", kit())
    assert [paper.learners for paper in papers_in(tmp_path)] == [("ada",), ("ben",), ("cy",)]
    put(tmp_path / "own", "ada/old/03_world_coordinates.ipynb", kit())
    put(tmp_path / "own", "ada/new/04_depth.ipynb", kit())
    assert {paper.learners for paper in papers_in(tmp_path / "own")} == {("ada",)}


@pytest.mark.parametrize(
    ("files", "learners"),
    [
        (("10a/ada/S", "10a/bob/S", "10b/ada/S", "10b/dua/S"), ("10a/ada", "10a/bob", "10b/ada", "10b/dua")),
        (("10a/ada/S", "10a/bob/S", "10b/cem/S", "10b/S", "10b/03_owl-1_2026-10-05_12-00-00"), ("10a/ada", "10a/bob", "10b/cem", "10b", "owl-1")),
        (("10b/S_ada", "10b/S_bob", "10b/S_cem"), ("ada", "bob", "cem")),
        (("10b/ada/S", "10b/bob/S", "cem_03"), ("ada", "bob", "cem")),
        (("ada/old/S", "ada/new/S", "ben/S", "cy/S_cy"), ("ada", "ada", "ben", "cy")),
        (("ada 1/S_ada", "ada 1/S_ada_better", "ben 2/S_ben", "cy 3/S_cy"), ("ada 1", "ada 1", "ben 2", "cy 3")),
        (("ada/S", "ada/S_2026-11-01_10-00", "ada/S-Copy1"), ("ada", "ada", "ada")),
        (("S_ada", "S_ada_2026-11-01_10-00", "S_2026-11-01_10-00"), ("ada", "ada", STEM)),  # kept by `reset`
    ],
)  # fmt: skip
def test_each_learner_of_each_class_has_a_row(tmp_path, files, learners):
    for k, name in enumerate(files):
        put(tmp_path, f"{name.replace('S', STEM)}.ipynb", {**kit(), "k": k})
    found = {paper.file: paper.learners for paper in papers_in(tmp_path)}
    assert [found[f"{name.replace('S', STEM)}.ipynb"] for name in files] == [(learner,) for learner in learners]


def test_where_only_folders_count_no_learner_takes_anothers_name(tmp_path):
    for name in ("10b/S_ada", "10b/S_bob"):
        put(tmp_path / "one", f"{name.replace('S', STEM)}.ipynb", kit())
    for name in ("bob/S", "eve/bob/S", "eve/x/S"):
        put(tmp_path / "two", f"{name.replace('S', STEM)}.ipynb", kit())
    assert {paper.learners for paper in papers_in(tmp_path / "one", by_folder=True)} == {("10b",)}
    assert {paper.learners for paper in papers_in(tmp_path / "two", by_folder=True)} == {("bob",), ("eve",)}


def test_what_a_mac_lays_beside_files_is_nobodys_work(tmp_path):
    for name in (
        "ada/03_world_coordinates.ipynb",
        "ada/._03_world_coordinates.ipynb",
        "__MACOSX/ada/._03_world_coordinates.ipynb",
    ):
        put(tmp_path, name, kit())
    assert [paper.file for paper in papers_in(tmp_path)] == ["ada/03_world_coordinates.ipynb"]


def test_another_ending_is_told(tmp_path):
    put(tmp_path, "ada/03_world_coordinates.IPYNB", kit())
    others = ["ben/03_world_coordinates.ipynb.txt", "cy/work.zip", "dee/03_world_coordinates.html", "eve/03.py"]
    for name in (*others, "ada/progress.json", "ada/answers/question_03_1.py", "ada/.stereo_lab.json", "Thumbs.db"):
        put(tmp_path, name, b"{}")
    assert [paper.learners for paper in papers_in(tmp_path)] == [("ada",)]
    assert not_looked_at(tmp_path) == others


def test_whole_work_folders_are_told(tmp_path):
    for name in (
        f"class/work-ada/{STEM}",
        "class/work-ada/handed_in/03_owl-1_2026-10-05_12-00-00",
        f"class/ben/{STEM}",
    ):
        put(tmp_path, f"{name}.ipynb", kit())
    assert whole_work_folders(tmp_path) == ["class/work-ada"] and whole_work_folders(tmp_path / "class/work-ada") == []


def test_a_handed_in_file_that_is_cut_off_still_tells_whose_it_is(tmp_path):
    (tmp_path / "03_calm-owl-2_brave-fox-77_2026-10-05_12-00-00.ipynb").write_text('{"cells": [')
    (paper,) = papers_in(tmp_path)
    assert paper.learners == ("calm-owl-2", "brave-fox-77") and paper.lesson == "03" and paper.trouble


def test_an_older_file_that_is_cut_off_hides_no_newer_one(tmp_path):
    """A copy of a file has the date of its copying; its name has the time of handing in."""
    put(tmp_path, "03_calm-owl-2_2026-10-05_11-00-00.ipynb", kit())
    put(tmp_path, "03_calm-owl-2_2026-10-05_10-00-00.ipynb", b'{"cells": [')
    newest, older = latest(papers_in(tmp_path))["calm-owl-2", "03"]
    assert newest.handed_in == "2026-10-05 11:00:00" and not newest.trouble and older.trouble


def test_the_questions_tell_the_lesson_before_a_number_in_the_name(tmp_path):
    (paper,) = [read_paper(put(tmp_path, "05_anna_03_world_coordinates.ipynb", kit()), tmp_path)]
    assert paper.lesson == "03" and paper.learners == ("05_anna",)


def test_marks_find_the_names_that_a_spreadsheet_changed(tmp_path):
    store = Store(tmp_path / "kept.json")
    store.name({(name, "03"): [Paper(f"{name}.ipynb", (name,), "03", "")] for name in ("01", "Łukasz", "ada")})
    nobody = store.remember(
        {("1", "03"): {1: "passed"}, ("?ukasz", "03"): {2: "not yet"}, ("eve", "03"): {1: "passed"}, ("zoe", "03"): {}}
    )
    assert store.teacher("01", "03") == {1: "passed"} and store.teacher("Łukasz", "03") == {2: "not yet"}
    assert len(nobody) == 1 and "'eve'" in nobody[0]


def test_marks_follow_a_learner_whose_class_folder_gets_a_second_one(tmp_path):
    """10a/ada alone is called 10a, and 10a/ada beside 10a/ben."""
    for name in ("10a/ada", "10b/ada"):
        put(tmp_path / "in", f"{name}/{STEM}.ipynb", kit())
    store = Store(tmp_path / "kept.json")
    store.name(latest(papers_in(tmp_path / "in")))
    store.remember({("10a", "03"): {}, ("10b", "03"): {2: "passed"}})
    for name in ("10a/ben", "10b/ben"):
        put(tmp_path / "in", f"{name}/{STEM}.ipynb", kit())
    found = latest(papers_in(tmp_path / "in"))
    assert {learner for learner, _ in found} == {"10a/ada", "10b/ada", "10a/ben", "10b/ben"}
    for marks in (
        {("10a", "03"): {}, ("10b", "03"): {1: "no", 2: "passed"}},
        {},
    ):  # written meanwhile; and no table today
        store = Store(tmp_path / "kept.json")
        store.name(found)
        assert store.remember(marks) == [] and store.teacher("10b/ada", "03") == {1: "no", 2: "passed"}
        assert store.teacher("10b/ben", "03") == store.teacher("10a/ada", "03") == {}


def test_in_a_learners_own_folder_the_folder_tells_whose_it_is(tmp_path):
    forged = kit()
    forged["metadata"]["stereo_lab_hand_in"] = {"learners": ["bob"], "handed_in": "2026-10-01 12:00:00", "seat": 3}
    put(tmp_path, "bob/03_world_coordinates.ipynb", kit())
    os.utime(put(tmp_path, "eve/03_world_coordinates.ipynb", forged), (2_000_000_000, 2_000_000_000))
    assert [paper.learners for paper in papers_in(tmp_path)] == [("bob",), ("bob",)]
    bob, eve = papers_in(tmp_path, by_folder=True)
    assert (bob.learners, eve.learners, eve.seat) == (("bob",), ("eve",), 3) and eve.handed_in.startswith("2033")


@pytest.mark.skipif(os.name == "nt", reason="making a link asks for rights there")
def test_a_link_is_nobodys_work(tmp_path):
    put(tmp_path, "bob/03_world_coordinates.ipynb", kit())
    (tmp_path / "eve").mkdir()
    (tmp_path / "eve" / "03_world_coordinates.ipynb").symlink_to("../bob/03_world_coordinates.ipynb")
    bob, eve = papers_in(tmp_path)
    assert bob.cells and not eve.cells and "a link" in eve.trouble


def test_whose_it_is_and_which_lesson(tmp_path):
    for name, lesson, learner in (
        ("03_world_coordinates_ada.ipynb", "03", "ada"),
        ("ada_03_world_coordinates.ipynb", "03", "ada"),
        ("ben/03_world_coordinates.ipynb", "03", "ben"),
        ("cy/deep/mine.ipynb", "03", "cy"),  # told by its questions
        ("2026-10-03.ipynb", "03", "2026-10-03"),
        ("03_world_coordinates_carl (1).ipynb", "03", "carl"),
        ("03_world_coordinates_carl - Kopie.ipynb", "03", "carl"),
        ("Copy of 03_world_coordinates_carl.ipynb", "03", "carl"),
    ):
        paper = read_paper(put(tmp_path, name, kit()), tmp_path)
        assert (paper.lesson, paper.learners) == (lesson, (learner,)), name
    nothing = read_paper(put(tmp_path, "notes.ipynb", {"cells": []}), tmp_path)
    assert nothing.lesson == "" and "which lesson" in nothing.trouble


def test_the_latest_is_found_whatever_is_claimed(tmp_path):
    first, second = put(tmp_path, "a/03_x.ipynb", kit()), put(tmp_path, "a/03_y.ipynb", kit())
    os.utime(first, (2_000_000_000, 2_000_000_000))
    os.utime(second, (1_000_000_000, 1_000_000_000))
    put(tmp_path, "a/.ipynb_checkpoints/03_z.ipynb", kit())
    assert [p.file for p in latest(papers_in(tmp_path))["a", "03"]] == ["a/03_x.ipynb", "a/03_y.ipynb"]
    given_up = put(tmp_path, "a/03_x_2026-11-29_14-22.ipynb", kit())  # as `reset` names what it keeps
    os.utime(given_up, (2_000_000_001, 2_000_000_001))
    assert [p.file for p in latest(papers_in(tmp_path))["a", "03"]][0] == "a/03_x.ipynb"
    with pytest.raises(StereoLabError, match="no notebook"):
        papers_in(tmp_path / "a" / ".ipynb_checkpoints")
    with pytest.raises(StereoLabError, match="is none"):
        papers_in(first)


def test_deleted_cells_are_put_back(tmp_path):
    notebook = without(answered(right()), "cell-01", "cell-07")
    notebook["cells"].pop(stub(notebook, 5))
    cells = read_paper(put(tmp_path, "03_a.ipynb", notebook), tmp_path).cells
    code, count, checks = with_what_is_missing(cells, kit_cells(NOTEBOOKS, LESSON))
    assert (count, checks) == (2, [5]) and "questions(" in code[0]
    assert [c for c in code if "q5.check(" in c] == [
        c.source for c in kit_cells(NOTEBOOKS, LESSON) if "q5.check(" in c.source
    ]
    assert next(k for k, c in enumerate(code) if "(v0, y0), (v1" in c) < next(
        k for k, c in enumerate(code) if "q2.check" in c
    )
    whole, none, no_checks = with_what_is_missing(kit_cells(NOTEBOOKS, LESSON), kit_cells(NOTEBOOKS, LESSON))
    assert none == len(no_checks) == 0 and len(whole) == sum(c.code for c in kit_cells(NOTEBOOKS, LESSON))


TAIL = "q2.check(slope)\nslope = q2.carry(slope)"


@pytest.mark.parametrize(
    ("left", "runs"),
    [
        ("slope = 1.4\nslope = q2.carry(slope)", "slope = 1.4\nq2.check(slope)\nslope = q2.carry(slope)"),
        ("slope = 1.4\n# q2.check(slope)", f"slope = 1.4\n# q2.check(slope)\n{TAIL}"),
        ("slope = 1.4", f"slope = 1.4\n{TAIL}"),
    ],
)
@pytest.mark.parametrize("kind", ["code", "raw"])
def test_a_check_that_was_deleted_is_put_back(tmp_path, left, runs, kind):
    notebook = answered(right())
    cell = notebook["cells"][stub(notebook, 2)]
    cell.update(source=left, cell_type=kind)
    cells = read_paper(put(tmp_path, "03_a.ipynb", notebook), tmp_path).cells
    code, count, checks = with_what_is_missing(cells, kit_cells(NOTEBOOKS, LESSON))
    assert (count, checks) == (0, [2]) and runs in code and written(cells, kit_cells(NOTEBOOKS, LESSON)) == []


@pytest.mark.parametrize("number", [2, 3])
def test_an_answer_in_a_cell_of_ones_own_is_checked(tmp_path, number):
    notebook = answered(right())
    cell = notebook["cells"].pop(stub(notebook, number))
    add(notebook, cell["source"][: cell["source"].index(f"q{number}.")], 4)
    cells = read_paper(put(tmp_path, "03_a.ipynb", notebook), tmp_path).cells
    code, _, checks = with_what_is_missing(cells, kit_cells(NOTEBOOKS, LESSON))
    (put_back,) = [source for source in code if f"q{number}.check(" in source]
    assert checks == [number] and put_back.startswith(f"q{number}.check(")


@pytest.mark.parametrize(
    ("line", "told", "shelf"),
    [
        ('recording = open_recording("second_rig")', "second_rig", "second_rig"),
        ("recording = open_recording( 'data/second_rig' )  # ours", "data/second_rig", "second_rig"),
        ('recording = open_recording(r"C:\\ada\\mine")', r"C:\ada\mine", None),
        ('recording = open_recording("../data/second_rig")', "../data/second_rig", None),
        ('recording = open_recording()  # or a name: open_recording("second_rig")', "", None),
        ('# recording = open_recording("second_rig")', "", None),
        ('other = open_recording("second_rig")', "", None),
    ],
)
def test_the_recording_that_a_notebook_names(line, told, shelf):
    code = ["import x", f'{line}\nq1, = questions("03", recording)', 'recording = open_recording("third_rig")']
    assert opened(code) == told and name_of(told) == told.replace("\\", "/").split("/")[-1]
    assert on_a_shelf(told) == (shelf and ROOT.resolve() / "data" / shelf)
    first, last = opens_what_it_gets(code)[1:]
    assert ("recording = open_recording()" in first) == (told != "" or "recording = open_recording()" in line)
    assert last == code[2]  # whatever the learner looks at further down


def test_what_learners_write_is_collected(tmp_path):
    notebook = add(kit(), "I think the lines hold **only** in one plane.", kind="markdown")
    notebook["cells"][0]["source"] += "\nMy remark."
    cells = read_paper(put(tmp_path, "03_a.ipynb", notebook), tmp_path).cells
    assert written(cells, kit_cells(NOTEBOOKS, LESSON)) == [
        "My remark.",
        "I think the lines hold **only** in one plane.",
    ]


def test_live_pictures_come_from_where_the_lesson_takes_them():
    sources = {lesson: source_of(kit_cells(NOTEBOOKS, lesson)) for lesson in LESSONS}
    assert sources["03"] == "recording" and sources["07"] == "virtual" and sources["05"] == ""
    changed = ast.unparse(_ByNumber("virtual").visit(ast.parse("source_name = 'cameras:0,1'\nq3.check(x)")))
    assert changed == "source_name = 'virtual'\n__checked__(3, q3, x)"


def test_solved_has_no_blank_left():
    assert "____  " not in "\n".join(solved(LESSON, asked()))


ROWS = [
    Row(
        "ada",
        "03",
        "a.ipynb",
        "2026-10-01 08:00:00",
        (Mark(PASS), Mark(NOT_YET, "the sign is turned")),
        ("late",),
        ("My words",),
    ),
    Row("=cmd()", "03", "b.ipynb", "", (Mark(NOT_ATTEMPTED), Mark(NOT_YET, "17 px is too large.")), ("<script>",)),
    Row("cy", "03", "c.ipynb", "", (Mark(PASS, help="2 hints"), Mark(NOT_YET, "18 px is too large."))),
]


def test_a_teachers_mark_comes_back_from_a_spreadsheet(tmp_path):
    table = tmp_path / "class.csv"
    write_table(table, ROWS)
    assert read_teacher(table) == {(name, "03"): {} for name in ("ada", "=cmd()", "cy")}
    lines = table.read_text(encoding="utf-8-sig").splitlines()
    assert lines[2].startswith("'=cmd()")  # no formula
    with open(table, "a", encoding="utf-8") as file:
        file.write("\r\n")  # an empty line at the end is nobody's row
    assert set(read_teacher(table)) == {(name, "03") for name in ("ada", "=cmd()", "cy")}
    for parted in (",", ";", "\t"):
        cells = [line.split(",") for line in lines]
        for row in (1, 2):
            cells[row][cells[0].index("2 teacher")] = "passed"
        table.write_text("\n".join(parted.join(row) for row in cells), encoding="cp1252")
        assert read_teacher(table) == {("ada", "03"): {2: "passed"}, ("=cmd()", "03"): {2: "passed"}, ("cy", "03"): {}}
    store = Store(tmp_path / "kept.json")
    store.remember(read_teacher(table))
    store.remember({})  # the table is not there today
    assert store.teacher("ada", "03") == {2: "passed"}
    write_table(table, ROWS)  # and now it is, with that mark taken back
    store.remember(read_teacher(table))
    assert Store(tmp_path / "kept.json").teacher("ada", "03") == {}
    row = ROWS[0].marked_by({2: "passed"})
    assert row.passed == 2 and ROWS[0].passed == 1 and row.marks[1].status == NOT_YET
    table.write_text("a,b\n1,2\n")
    with pytest.raises(StereoLabError, match="another file"):
        read_teacher(table)
    (tmp_path / "kept.json").write_text('{"rows": [1]}')
    with pytest.raises(StereoLabError, match="another file"):
        Store(tmp_path / "kept.json")


def test_a_table_stays_parted_as_a_spreadsheet_saved_it(tmp_path):
    table = tmp_path / "class.csv"
    write_table(table, ROWS)
    rows = list(csv.reader(table.read_text(encoding="utf-8-sig").splitlines()))
    with open(table, "w", encoding="utf-8-sig", newline="") as file:
        csv.writer(file, delimiter=";").writerows(rows)
    write_table(table, ROWS)
    assert list(csv.reader(table.read_text(encoding="utf-8-sig").splitlines(), delimiter=";")) == rows


def test_no_part_of_a_cell_is_a_formula(tmp_path):
    stopped = Mark(NOT_YET, 'ValueError: x;=HYPERLINK("http://evil/");y')
    write_table(tmp_path / "class.csv", [Row("ada", "03", "a.ipynb", "", (stopped, stopped))])
    text = (tmp_path / "class.csv").read_text(encoding="utf-8-sig")
    cells = [cell for row in csv.reader(text.splitlines(), delimiter=";") for cell in row]
    assert any("HYPERLINK" in cell for cell in cells) and not any(cell[:1] in ("=", "+", "-", "@") for cell in cells)


def test_a_number_below_zero_needs_no_apostrophe(tmp_path):
    write_table(tmp_path / "class.csv", [Row("-1", "03", "a.ipynb", "", (Mark(NOT_YET, "-0.86 mm is too small."),))])
    text = (tmp_path / "class.csv").read_text(encoding="utf-8-sig")
    assert ",−0.86 mm is too small.," in text and "\n'-1," in text.replace("\r", "")


def test_the_same_slip_of_the_pen_is_one_mistake():
    told = [
        desk._text(SyntaxError("expected ':'", (f"<ipython-input-1-{k}>", 1, 1, "if x", 1, 2))) for k in ("52e", "99a")
    ]
    assert told == ["expected ':' (line 1)"] * 2


def answers_of(text):
    return Heard({3: Answer(Verdict(NOT_YET, text))})


@pytest.mark.parametrize(
    ("below", "why"),
    [
        ("def fit(p, q):\n    return 1", "fit is defined further down: run from top to bottom, it is not there yet."),
        ("fit = 3", "fit is defined further down: run from top to bottom, it is not there yet."),
        ("fit == 3", "your function stopped with NameError: name 'fit' is not defined."),
    ],
)
def test_a_helper_below_the_question_is_told_as_that(below, why):
    heard = answers_of("your function stopped with NameError: name 'fit' is not defined.")
    marks = marks_of(Paper("a", ("ada",), "03", ""), ["", "q3.check(line_slope)", "x = 1", below], heard, 3)
    assert marks[2] == Mark(NOT_YET, why)


def test_a_function_in_the_room_is_judged_as_one_on_the_screen():
    """Its lines are not here to be looked at."""
    question = asked()[2]

    def told(gives, blank=False):
        return question.judge(_Asked(SimpleNamespace(call=lambda *_: gives), 0, blank))

    assert told(1.0).text == question.judge(lambda pixels, lengths_mm: 1.0).text
    assert told(____, blank=True).status == NOT_ATTEMPTED


def test_how_many_fell_for_what():
    first, second = tally(ROWS, "03", asked()[:2])
    assert (first.passed, first.not_yet, first.not_attempted, first.learners) == (2, 0, 1, 3)
    assert second.fell_for == (("… px is too large.", 2), ("the sign is turned", 1))
    assert (
        kind_of_mistake("2 and 3 of 4 are off") == "… and … of … are off"
        and kind_of_mistake("Eq. 2 says so") == "Eq. 2 says so"
    )


def test_the_page_shows_all_of_it_and_runs_nothing(tmp_path):
    rows = [ROWS[0].marked_by({1: "not yet"}), *ROWS[1:]]
    write_page(tmp_path / "class.html", rows, {"03": tally(rows, "03", asked()[:2])}, ["How it was done"])
    page = (tmp_path / "class.html").read_text(encoding="utf-8")
    assert "<script>" not in page and "&lt;script&gt;" in page
    for part in (
        "2 of 3: <bdi>… px is too large.</bdi>",
        "<bdi>My words",
        "teacher: <bdi>not yet</bdi>",
        "2 hints",
        "How it was done",
    ):
        assert part in page


@pytest.fixture
def page_of_names(tmp_path):
    """The page of a class with names of any length and script."""
    names = "x" * 300, "Wolfeschlegelsteinhausen " * 12, "محمد عبد الله", "<b>Ann"
    marks = (Mark(NOT_YET, "w" * 400, "2 hints"),) * 2
    rows = [dataclasses.replace(ROWS[0], learner=name, marks=marks, notes=("one", "two")) for name in names]
    rows += [dataclasses.replace(ROWS[0], learner="Eve", lesson="", marks=(), notes=("no notebook",))]
    write_page(tmp_path / "class.html", rows, {"03": tally(rows, "03", asked()[:2])}, [])
    return tmp_path / "class.html"


def test_what_learners_wrote_runs_its_own_way(page_of_names):
    """From right to left as well: the kit's words beside it do not."""
    page = page_of_names.read_text(encoding="utf-8")
    for name in ("x" * 300, "محمد عبد الله", "&lt;b&gt;Ann"):
        assert page.count(name) == page.count(f"<bdi>{name}</bdi>") == 2  # in the table, and over what was written
    assert "<li><bdi>Eve</bdi>: " in page and "<bdi>one</bdi>; <bdi>two</bdi>" in page


@pytest.mark.parametrize("width", [1366, 800])
def test_a_long_name_makes_no_wide_page(page_of_names, width):
    """It is broken; and a table that is too wide all the same moves in a box of its own."""
    api = pytest.importorskip("playwright.sync_api") if shutil.which("chromium") else skip_unless_ci("no Chromium")
    with api.sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        page = chromium.new_page(viewport={"width": width, "height": 700})
        page.goto(page_of_names.as_uri())
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        names = page.evaluate("[...document.querySelectorAll('.who')].map(e => e.getBoundingClientRect().width)")
        assert min(names) > 120 and max(names) < 300  # whole words
        boxes = "[...document.querySelectorAll('table')].map(e => getComputedStyle(e.parentElement).overflowX)"
        assert page.evaluate(boxes) == ["auto", "auto"]
        chromium.close()


def test_a_row_survives_the_file():
    assert all(Row.from_json(json.loads(json.dumps(row.as_json()))) == row for row in ROWS)
    assert dataclasses.is_dataclass(ROWS[0])


def test_rows_of_a_lesson_that_is_not_there_any_more_are_told(tmp_path, monkeypatch, capsys):
    put(tmp_path, "out/ada/03_world_coordinates.ipynb", kit())
    table = tmp_path / "class.csv"
    for lesson in ("00", "03"):
        rows = [
            Row(
                "ada",
                lesson,
                "file",
                "2026-10-05 12:00:00",
                (Mark(PASS),) * len(questions(lesson, open_recording("bench"))),
            )
        ]
        monkeypatch.setattr(grading, "grade", lambda *_, rows=rows: Graded(rows, "how", 1, []))
        assert main(["grade", str(tmp_path / "out"), "--csv", str(table)]) == 0
    assert "class.csv had rows of lesson 00" in capsys.readouterr().out
