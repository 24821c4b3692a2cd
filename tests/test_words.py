"""words.md: every term is explained where a reader first meets it."""

import ast
import json
import re

import numpy as np
import pytest

from conftest import ROOT

NOTEBOOKS = sorted((ROOT / "notebooks").glob("0*.ipynb"))
ROWS = [
    [cell.strip() for cell in line.strip("|").split("|")]
    for line in (ROOT / "notebooks" / "words.md").read_text(encoding="utf-8").splitlines()
    if re.fullmatch(r"\|.*\| \d\d \|", line)
]


def texts():
    """(lesson, text) of every markdown cell, without code and links: those are names."""
    for path in NOTEBOOKS:
        for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
            if cell["cell_type"] == "markdown":
                text = re.sub(r"`[^`]*`|\[[^\]]*\]\([^)]*\)", " ", "".join(cell["source"]))
                yield path.name[:2], text


TEXTS = list(texts())


def test_there_are_words():
    assert len(ROWS) > 40 and len({word for word, *_ in ROWS}) == len(ROWS)
    assert [lesson for *_, lesson in ROWS] == sorted(lesson for *_, lesson in ROWS)


@pytest.mark.parametrize(("word", "meaning", "lesson"), ROWS, ids=[word for word, *_ in ROWS])
def test_a_word_is_explained_where_it_first_comes(word, meaning, lesson):
    stem = re.escape(word.removesuffix("ion") if word.endswith("ation") else word)
    comes = re.compile(rf"(?<!\w){stem}", re.IGNORECASE)
    first, text = next((there, text) for there, text in TEXTS if comes.search(text))
    assert first == lesson, f"it first comes in lesson {first}: {text}"
    bold = re.findall(r"\*\*(.+?)\*\*", text, re.DOTALL)
    assert any(comes.search(words) for words in bold), f"not in bold where it first comes: {text}"
    assert len(meaning.split()) >= 3


PYTHON = [
    [part.strip() for part in re.split(r"(?<!\\)\|", line.strip("|"))]
    for line in (ROOT / "notebooks" / "words.md").read_text(encoding="utf-8").partition("## Python")[2].splitlines()
    if line.startswith("| `")
]


@pytest.mark.parametrize("row", [row for row in PYTHON if row[2]], ids=[row[0] for row in PYTHON if row[2]])
def test_a_line_of_python_gives_what_stands_beside_it(row):
    example, gives = (part.strip("`") for part in row[2:])
    assert eval(example, {"np": np}) == eval(gives)


def ways_of_writing():
    """What in the lessons' code a beginner has not met: the name of its row."""
    kinds = {
        ast.JoinedStr: 'f"{x:.1f}"', ast.ListComp: "[… for x in …]", ast.GeneratorExp: "(… for x in …)",
        ast.DictComp: "{…: … for x in …}", ast.IfExp: "a if … else b", ast.Starred: "*a", ast.Lambda: "lambda x: …",
        ast.NamedExpr: "(a := …)", ast.Slice: "a[1:3]", ast.MatMult: "a @ b", ast.Invert: "a[a > 2]", ast.With: "with … as a:",
        ast.Try: "try: … except E: …",
    }  # fmt: skip
    calls = {"zip": "zip(a, b)", "enumerate": "enumerate(a)", "getattr": 'getattr(a, "b", c)', "globals": "globals()"}
    names = {"T": "a.T", "eye": "np.eye(2)", "trace": "np.trace(a)", "hypot": "np.hypot(a, b)", "percentile": "np.percentile(a, 95)", "linspace": "np.linspace(a, b, n)"}  # fmt: skip
    for path in NOTEBOOKS:
        for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
            for node in ast.walk(ast.parse("".join(cell["source"]))) if cell["cell_type"] == "code" else ():
                yield kinds.get(type(node))
                if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
                    yield calls.get(node.func.id)
                if isinstance(node, ast.Attribute):
                    yield names.get(node.attr)
                if isinstance(node, ast.Starred) and isinstance(node.ctx, ast.Store):
                    yield "a, *b = …"
                if isinstance(node, ast.Name) and node.id == "_" and isinstance(node.ctx, ast.Store):
                    yield "_ = …"
                if isinstance(node, ast.Slice) and node.step is not None:
                    yield "a[::3]"
                if isinstance(node, ast.Constant) and node.value is ...:
                    yield "a[..., 0]"


def test_every_way_of_writing_is_explained():
    told = {row[0].strip("`") for row in PYTHON}
    used = set(ways_of_writing()) - {None}
    assert used <= told and told - used <= {"a[:, 0]"}
