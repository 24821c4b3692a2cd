"""words.md: every term is explained where a reader first meets it."""

import json
import re

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
