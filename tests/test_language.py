"""A lesson in another language: the same code, other sentences. Shown by a made-up language with an accent on every letter."""

import ast
import json
import re

import nbformat
import pytest
from nbclient import NotebookClient

from conftest import ROOT
from stereo_lab.classroom import grading
from stereo_lab.classroom.store import Store
from stereo_lab.cli import main
from stereo_lab.errors import StereoLabError
from stereo_lab.exercises import language, questions
from stereo_lab.exercises.answers import Choice, Number
from stereo_lab.work import lay_out
from tests.test_notebooks import STUB

LESSONS = ROOT / "notebooks"
LETTERS = str.maketrans(
    "abcdefghijklmnoprstuvwxyzABCDEFGHIJKLMNOPRSTUVWXYZ", "áƀçđéƒǵĥíĵķĺɱńóþŕšťúṽŵẋýžÁɃÇĐÉƑǴĤÍĴĶĹⱮŃÓÞŔŠŤÚṼŴẊÝŽ"
)  # all but q, which no answer has
NAMES = re.compile(r"`[^`]*`|\$[^$]*\$|\]\([^)]*\)|<[^>]*>|\{\}")  # code, formulas, links: no language


def accented(text):
    """A text in the made-up language."""
    parts, last = [], 0
    for found in NAMES.finditer(text):
        parts += [text[last : found.start()].translate(LETTERS), found.group()]
        last = found.end()
    return "".join([*parts, text[last:].translate(LETTERS)])


def in_accents(source):
    """A code cell with its comments and its sentences in the made-up language."""
    source = re.sub(r"(?m)# .*$", lambda comment: accented(comment.group()), source)
    return re.sub(r'(?<!f)"([A-Z][^"{}]* [^"{}]*)"', lambda text: f'"{accented(text[1])}"', source)


@pytest.fixture
def made_up(tmp_path, monkeypatch):
    """The folder of the language: lesson 00, and the table of the checks' sentences."""
    folder = tmp_path / "xx"
    folder.mkdir()
    language.renew(folder / language.TABLE)
    table = json.loads((folder / language.TABLE).read_text(encoding="utf-8"))
    table["sentences"] = {english: accented(english) for english in table["sentences"]}
    table["words"] = {english: [accented(english)] for english in table["words"]}
    (folder / language.TABLE).write_text(json.dumps(table), encoding="utf-8")
    notebook = nbformat.read(LESSONS / "00_start_here.ipynb", 4)
    for cell in notebook.cells:
        cell.source = in_accents(cell.source) if cell.cell_type == "code" else accented(cell.source)
    nbformat.write(notebook, folder / "00_start_here.ipynb")
    monkeypatch.setenv("STEREO_LAB_LANGUAGE", str(folder))
    monkeypatch.setenv("STEREO_LAB_WORK", str(tmp_path / "work"))
    language._table.cache_clear()
    return folder


class Wordless(ast.NodeTransformer):
    """Takes the texts out of a program, and leaves what is worked out in them."""

    def visit_Constant(self, node):
        return ast.Constant("") if isinstance(node.value, str) else node

    def visit_JoinedStr(self, node):
        return ast.JoinedStr([self.visit(part) for part in node.values if not isinstance(part, ast.Constant)])


def program(source):
    return ast.dump(Wordless().visit(ast.parse(source)))


def assert_the_same_code(translated, english):
    """All code cells are the same but for strings and comments."""
    ours, theirs = ([c for c in nbformat.read(p, 4).cells if c.cell_type == "code"] for p in (english, translated))
    assert [c.id for c in ours] == [c.id for c in theirs], translated
    for cell, other in zip(ours, theirs, strict=True):
        assert program(cell.source) == program(other.source), f"{translated}: {cell.id}"


def assert_a_good_table(path):
    """Nothing is left out of a sentence, and no word means something else in English."""
    table = json.loads(path.read_text(encoding="utf-8"))
    for english, other in table["sentences"].items():
        places = re.findall(r"\{\d?\}", other)
        assert not other or len(places) == english.count("{}"), other
    for english, others in table["words"].items():
        assert not [o for o in others if o in table["words"] and o != english], others


def test_translations_hold():
    for path in sorted(LESSONS.glob("*/[0-9][0-9]_*.ipynb")):
        assert_the_same_code(path, LESSONS / path.name)
    for path in sorted(LESSONS.glob(f"*/{language.TABLE}")):
        assert_a_good_table(path)


def test_what_holds_translations_sees_other_code(made_up):
    path = made_up / "00_start_here.ipynb"
    assert_the_same_code(path, LESSONS / path.name)
    assert_a_good_table(made_up / language.TABLE)
    text = path.read_text(encoding="utf-8")
    assert "Ŕúń" in text
    path.write_text(text.replace("samples[:16]", "samples[:15]"), encoding="utf-8")
    with pytest.raises(AssertionError, match="xx/00_start_here"):
        assert_the_same_code(path, LESSONS / path.name)
    (made_up / language.TABLE).write_text(json.dumps({"sentences": {"{} px": "px"}, "words": {}}))
    with pytest.raises(AssertionError):
        assert_a_good_table(made_up / language.TABLE)


def plain_words(text):
    """The English words in a text; what stands in quotes is somebody's answer."""
    return re.findall(r"\b[A-Za-z]{3,}\b", re.sub(r"'[^']*'|`[^`]*`", "", text))


def test_everything_a_check_of_lesson_00_says_is_translated(made_up, bench, capsys):
    for q in questions("00", bench):
        answers = [..., None, "?", [1, 2], q.reference, *(wrong.answer for wrong in q.answer.wrong)]
        for answer in answers:
            q.check(answer)
        for _ in q.hints:
            q.hint()
    said = capsys.readouterr().out
    for line in (line for q in questions("00", bench) for line in q.hints if language._is_for_programs(line)):
        said = said.replace(line, "")
    assert len(said.splitlines()) > 60 and "ƤÁŠŠ" not in said and "ÞÁŠŠ - " in said and "ŃÓŤ ÝÉŤ - " in said
    assert set(plain_words(said)) <= {"ellipsis", "list"}, sorted(set(plain_words(said)))


@pytest.mark.parametrize("lesson", ["01", "02", "03", "04", "05", "06", "07", "08"])
def test_what_the_other_lessons_say_is_translated(lesson, made_up, bench, capsys):
    for q in questions(lesson, bench):
        for answer in (q.reference, *(wrong.answer for wrong in q.answer.wrong)):
            q.check(answer)
    said = capsys.readouterr().out
    words = [word for line in said.splitlines() for word in plain_words(line)]
    assert len(words) < 0.02 * len(said.split()), sorted(set(words))


def test_no_translator_is_asked_for_patterns_and_programs():
    said = language.sentences()
    for no_sentence in (
        "import numpy",
        "MV elbow -{}",
        "(the )?edge",
        "jump_px = ball_left.u - ____",
        "m|the slope|slope",
    ):
        assert no_sentence not in said
    assert not [text for text in said if re.search(r"\\[bsd]|\(\?[:!=<]|\.\*", text)]
    for sentence in ("NOT YET", "a ring", "join them by | or &.", "down, as (columns, rows)?", "Squared is **2."):
        assert any(text.endswith(sentence) for text in said), sentence


def test_words_count_in_both_languages(made_up, bench):
    q = questions("00", bench)[0]
    assert isinstance(q.answer, Choice)
    for answer in ("right", "ŕíǵĥť", "Ŕíǵĥť."):
        assert q.carry(answer).lower().startswith("right"), answer
    assert q.carry("ĺéƒť") == "right"  # the reference: that was wrong


def test_what_a_table_lacks_is_said_in_english(made_up, bench, capsys):
    (made_up / language.TABLE).write_text(json.dumps({"sentences": {"NOT YET": "noch nicht"}, "words": {}}))
    language._table.cache_clear()
    q = questions("00", bench)[0]
    q.check("left")
    assert capsys.readouterr().out.startswith("noch nicht - hold a finger up")


def test_english_needs_no_table(bench, capsys, monkeypatch):
    for named in ("", "en", "../../etc", "zz"):
        monkeypatch.setenv("STEREO_LAB_LANGUAGE", named)
        questions("00", bench)[0].check("left")
        assert capsys.readouterr().out.startswith("NOT YET - hold a finger up")


@pytest.fixture
def german(tmp_path, monkeypatch):
    """A kit with one word of German."""
    folder = tmp_path / "kit" / "notebooks" / "de"
    folder.mkdir(parents=True)
    (folder / language.TABLE).write_text(json.dumps({"sentences": {}, "words": {"right": ["rechts"]}}))
    monkeypatch.setattr("stereo_lab.recording.places.course", lambda: tmp_path / "kit")
    monkeypatch.setattr(grading, "LESSONS", tmp_path / "kit" / "notebooks")
    language._table.cache_clear()
    yield folder
    language._table.cache_clear()


def test_a_language_counts_in_capitals_and_an_unknown_one_is_told(german, monkeypatch):
    for named, known in (("de", "de"), ("DE", "de"), ("EN", "en"), ("", "en"), (str(german), str(german))):
        monkeypatch.setenv("STEREO_LAB_LANGUAGE", named)
        assert f" {known}" in language.settle_language()
    monkeypatch.setenv("STEREO_LAB_LANGUAGE", "DE")
    language.settle_language()
    assert language.in_english("rechts") == "right"
    for named in ("xx", "../de", str(german / "none")):
        monkeypatch.setenv("STEREO_LAB_LANGUAGE", named)
        with pytest.raises(StereoLabError, match=re.escape(f"got {named!r}. There are: en, de")):
            language.settle_language()


@pytest.mark.parametrize("command", [["start"], ["reset", "00"], ["grade", "handed_in", "--csv", "class.csv"]])
def test_no_command_takes_an_unknown_language_for_english(command, monkeypatch, tmp_path, capsys):
    monkeypatch.setenv("STEREO_LAB_LANGUAGE", "xx")
    monkeypatch.setenv("STEREO_LAB_WORK", str(tmp_path))
    assert main(command) == 2 and "There are: en" in capsys.readouterr().err and not list(tmp_path.iterdir())


def test_what_was_marked_in_one_language_is_marked_anew_in_another(german, bench, monkeypatch, tmp_path):
    def edition():
        return grading._Examiners(bench, Store(tmp_path / "kept.json")).edition("00")

    monkeypatch.delenv("STEREO_LAB_LANGUAGE", raising=False)
    in_english = edition()
    monkeypatch.setenv("STEREO_LAB_LANGUAGE", "de")
    in_german = edition()
    (german / language.TABLE).write_text(json.dumps({"sentences": {}, "words": {"right": ["rechts", "rechte"]}}))
    assert len({in_english, in_german, edition()}) == 3


def test_a_part_may_change_its_place():
    table = language.Table({"{} is left of {}": "{2} steht rechts von {1}", "the ball": "der Ball"}, {})
    assert table.say("the ball is left of 3.") == "3 steht rechts von der Ball."


def test_the_work_folder_has_the_lessons_that_are_translated(made_up, tmp_path):
    lay_out(LESSONS, tmp_path / "work")
    first, second = sorted((tmp_path / "work").glob("*.ipynb"))[:2]
    assert "Šťáŕť ĥéŕé" in first.read_text(encoding="utf-8") and "Calibration" in second.read_text(encoding="utf-8")
    assert main(["reset", "00"]) == 0
    assert "Šťáŕť ĥéŕé" in first.read_text(encoding="utf-8")


@pytest.mark.slow
def test_lesson_00_runs_and_passes_in_the_other_language(made_up, bench, monkeypatch):
    notebook = nbformat.read(made_up / "00_start_here.ipynb", 4)
    asked = questions("00", bench)
    for cell in notebook.cells:
        if cell.cell_type == "code" and (found := STUB.search(cell.source)):
            q = asked[int(found.group(1)) - 1]
            code = (
                re.sub(r'"(\w+)"', lambda word: f'"{accented(word[1])}"', q.code)
                if isinstance(q.answer, Choice)
                else q.code
            )
            stub = cell.source[: found.start()] if isinstance(q.answer, Number) else ""
            cell.source = f"{stub}\n{code}\n{cell.source[found.start() :]}"
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    NotebookClient(
        notebook, timeout=240, kernel_name="python3", resources={"metadata": {"path": str(made_up)}}
    ).execute()
    said = "".join(
        o["text"] for c in notebook.cells if c.cell_type == "code" for o in c.outputs if o.output_type == "stream"
    )
    assert said.count("ÞÁŠŠ - ") == 5 and "NOT" not in said
