"""What the checks say, in the language of the class: one table for each language, `notebooks/LANGUAGE/checks.json`.

$STEREO_LAB_LANGUAGE chooses it. What a table lacks is said in English, and English answers count in every language.

`python -m stereo_lab.exercises.language de` writes the table of a language, or brings it up to date: what is translated stays.
"""

from __future__ import annotations

import ast
import os
import re
import sys
from functools import lru_cache
from pathlib import Path
from typing import Any

from stereo_lab.common.files import read_json, write_json
from stereo_lab.errors import StereoLabError
from stereo_lab.work import chosen_language

TABLE = "checks.json"
STATUS = ("PASS", "NOT YET", "NOT ATTEMPTED")
SIGNS = ".:;?!"
ENDS = re.compile(rf"(?<=[{SIGNS}])(\s+)")  # what is said comes in sentences, and in parts of them

# What stands in patterns and in no sentence: \b, (?: and .*, a part that may be missing, words parted by |
PATTERN = re.compile(r"\\[\w(.]|\(\?|\.\*|\)\?.|\S\|\S")
COMMAND = re.compile(r"[A-Z]{2,4}(?= .*[\d{])( +-?[\w{}.]+)+")  # MV 2 -{}


def translated(text: str) -> str:
    """What a check says, in the language chosen.

    Parameters
    ----------
    text : str, in English, numbers and words filled in

    Returns
    -------
    str
        Sentence by sentence in the other language; in English where the table has none.
    """
    table = _table(chosen_language())
    return table.say(text) if table else text


def in_english(answer: Any) -> Any:
    """A learner's answer in English words, where it is a text in the language chosen; any other answer as it is."""
    table = _table(chosen_language())
    return table.english(answer) if table and issubclass(type(answer), str) else answer


class Table:
    """The sentences and words of one language.

    Parameters
    ----------
    sentences : dict, English to translated; {} stands for what is filled in, and comes in both in the same order, or as {1}, {2}
    words : dict, an English answer to the words for it: the first is shown, all count
    """

    def __init__(self, sentences: dict[str, str], words: dict[str, list[str]]):
        found = [(_pattern(english), told) for english, told in map(_without_sign, sentences.items()) if told]
        self._patterns = sorted(found, key=lambda pair: -len(re.findall(r"\w", pair[0].pattern)))
        self._shown = {english: others[0] for english, others in words.items() if others}
        self._english = {other.lower(): english for english, others in words.items() for other in others}

    def say(self, text: str) -> str:
        """A text in this language: the longest parts that the table knows, one after the other."""
        parts, said = ENDS.split(text), ""  # sentence, blank, sentence, …
        while parts:
            for count in range(len(parts), 0, -2):
                if (other := self._whole("".join(parts[:count]))) is not None:
                    break
            else:
                count, other = 1, parts[0]
            said += other + "".join(parts[count : count + 1])
            parts = parts[count + 1 :]
        return said

    def _whole(self, text):
        """A text that is one entry of the table, with or without its last sign; else None."""
        for part, sign in ((text[:-1], text[-1:]), (text, "")):
            if sign and sign not in SIGNS:
                continue
            if part in self._shown:
                return self._shown[part] + sign
            for pattern, other in self._patterns:
                if found := pattern.fullmatch(part):
                    return _filled(other, [self.say(group) for group in found.groups()]) + sign
        return None

    def english(self, answer: str) -> str:
        """An answer with the words that this language has for English ones put back."""
        for other in sorted(self._english, key=len, reverse=True):
            answer = re.sub(rf"(?<!\w){re.escape(other)}(?!\w)", self._english[other], answer, flags=re.IGNORECASE)
        return answer


def _without_sign(entry):
    """An entry without the sign at its end, where that is the same in both languages: what is said may go on."""
    english, other = entry
    same = english[-1:] == other[-1:] and english[-1:] in SIGNS
    return (english[:-1], other[:-1]) if same else entry


def _filled(other, groups):
    """A translated sentence with its {} filled in, in order, or as {1}, {2} say."""
    following = iter(groups)
    return re.sub(r"\{(\d?)\}", lambda place: groups[int(place[1]) - 1] if place[1] else next(following), other)


def _pattern(english):
    parts = map(re.escape, re.split(r"\{\}", english))
    return re.compile("(.*?)".join(parts), re.DOTALL)


def languages() -> list[str]:
    """The short names of the languages into which some of the course is translated."""
    from stereo_lab.recording.places import course

    found = [path.parent.name for path in (course() / "notebooks").glob(f"*/{TABLE}")]
    found += [path.parent.name for path in (course() / "notebooks").glob("*/[0-9][0-9]_*.ipynb")]
    return sorted(set(found))


def settle_language() -> str:
    """Take $STEREO_LAB_LANGUAGE in any case, for this program and those that it starts; refuse a language that is not there.

    Returns
    -------
    str
        A sentence that says which language it is; empty where there is only English.

    Raises
    ------
    StereoLabError
        If nothing is translated into the language that is named.
    """
    named, there = os.environ.get("STEREO_LAB_LANGUAGE", "").strip(), ["en", *languages()]
    if Path(named).is_absolute() and Path(named).is_dir():
        return f"The language is that of {named}."
    found = [each for each in there if each.lower() == (named.lower() or "en")]
    if not found:
        raise StereoLabError(
            f"Expected a language of the course in STEREO_LAB_LANGUAGE, got {named!r}. There are: {', '.join(there)}. Set it to one of these."
        )
    if named:
        os.environ["STEREO_LAB_LANGUAGE"] = found[0]
    return (
        f"The language is {found[0]}; STEREO_LAB_LANGUAGE chooses among {', '.join(there)}." if len(there) > 1 else ""
    )


@lru_cache(maxsize=4)
def _table(language: str) -> Table | None:
    path = _folder(language) / TABLE
    if not language or not path.is_file():
        return None
    known = read_json(path)
    return Table(known.get("sentences", {}), known.get("words", {}))


def _folder(language):
    from stereo_lab.recording.places import course

    return course() / "notebooks" / language


def sentences() -> list[str]:
    """Everything that the checks of all lessons may say, in English, {} for what is filled in."""
    found: dict[str, None] = {}
    for path in sorted(Path(__file__).parent.glob("*.py")):
        if path.name != Path(__file__).name:
            tree = ast.parse(path.read_text(encoding="utf-8"))
            found.update(dict.fromkeys(text for text in _said(tree, _silent(tree)) if not _is_for_programs(text)))
    return list(found)


def _silent(tree):
    """The strings that nobody is told: docstrings, and parts of other strings."""
    nodes = [node for node in ast.walk(tree) if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)]
    silent = {id(node.value) for node in nodes}
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            silent |= {id(part) for part in node.values}
    return silent


def _is_for_programs(text):
    """Whether a text is a pattern for answers, a line to the arm's controller, or Python with no text in it: nobody translates these."""
    if PATTERN.search(text) or COMMAND.fullmatch(text):
        return True
    if set(text) & set("\"'#"):
        return False
    try:
        told = ast.walk(ast.parse(text.replace("{}", "x").replace("return ", "x = ")))
    except SyntaxError:
        return False
    return any(isinstance(node, (ast.Assign, ast.FunctionDef, ast.Import, ast.ImportFrom)) for node in told)


def _said(tree, silent):
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            text = "".join(part.value if isinstance(part, ast.Constant) else "{}" for part in node.values)
            if re.search(r"[A-Za-z]{2}", text) and not text.startswith("stereo_lab."):
                yield text.strip()
            inner = [n for part in node.values if isinstance(part, ast.FormattedValue) for n in ast.walk(part.value)]
            yield from (n.value for n in inner if isinstance(n, ast.Constant) and _is_word(n.value))
        elif isinstance(node, ast.Constant) and id(node) not in silent and _is_sentence(node.value):
            yield node.value.strip()


def _is_word(value):
    return isinstance(value, str) and re.search("[A-Za-z]{2}", value) is not None


def _is_sentence(value):
    return value in STATUS or (_is_word(value) and " " in value.strip())


def words() -> list[str]:
    """Every answer in words that some question has."""
    from stereo_lab.exercises import LESSONS, questions
    from stereo_lab.exercises.answers import Choice
    from stereo_lab.recording import open_recording

    asked = [q for lesson in LESSONS for q in questions(lesson, open_recording("bench"))]
    return sorted({word for q in asked if isinstance(q.answer, Choice) for word in q.answer.options})


def renew(path: Path) -> tuple[int, int]:
    """Write the table of a language, or bring it up to date; gives how many entries it has, and how many wait."""
    known = read_json(path) if path.is_file() else {}
    told = {text: known.get("sentences", {}).get(text, "") for text in sentences()}
    named = {word: known.get("words", {}).get(word, []) for word in words()}
    write_json(path, {"sentences": told, "words": named})
    return len(told) + len(named), sum(not entry for entry in (*told.values(), *named.values()))


def main() -> None:
    """Write the table of the language that is named."""
    if len(sys.argv) != 2 or not re.fullmatch(r"[a-z]{2,3}(-[A-Za-z]+)?", sys.argv[1]):
        sys.exit("Expected the short name of a language, as in: python -m stereo_lab.exercises.language de")
    path = _folder(sys.argv[1]) / TABLE
    try:
        path.parent.mkdir(exist_ok=True)
        entries, waiting = renew(path)
    except (StereoLabError, OSError) as error:
        sys.exit(str(error))
    print(f"{path}: {entries} entries, {waiting} wait for a translation.")


if __name__ == "__main__":
    main()
