"""An answer that is a line for the controller of the arm."""

from __future__ import annotations

import math
import re
import reprlib
from dataclasses import dataclass
from typing import Any

from stereo_lab.exercises.verdict import NOT_ATTEMPTED, NOT_YET, PASS, Verdict, Wrong
from stereo_lab.exercises.wording import a_kind

SIGNS = {
    "−": "the arm does not know the sign − of a printed page. Type the minus of the keyboard: -",
    "°": "no sign ° in the line: the arm counts in degrees anyway.",
    ",": "no comma in the line: its words are parted by blanks.",
    "*": "the checksum is put behind it for you: leave it away.",
    '"': "no quotes inside the line: one pair round it is enough.",
    "'": "no quotes inside the line: one pair round it is enough.",
    "–": "the arm does not know the long dash of a printed page. Type the minus of the keyboard: -",
    "=": "no sign = in the line: its words are parted by blanks.",
    "(": "no brackets in the line: its words are parted by blanks.",
    ":": "no colon in the line: its words are parted by blanks.",
    ";": "no semicolon in the line: it ends where the quotes end.",
}
FORMS = {
    r"^[a-z]+-?\d": "between the command and the joint a blank is missing.",
    r"^\S+\s+\d-\d": "between the joint and the angle a blank is missing.",
    r"-\s+\d": "the minus belongs to its number: no blank between the two.",
    r"\b(deg|degrees?)\b": "no unit in the line: the arm counts in degrees anyway.",
    r"^MV\s+[12]\s+[12]\s": "one line turns one joint: leave the other one out.",
    r"\b(ten|twenty|thirty|forty|fifty|sixty|seventy|eighty|ninety)\b": "numbers stand in figures in the line.",
    r"\bminus\b": "the minus is a sign in the line: -30, not the word.",
    r"\s[-+]{2}|\s\+|\d\.(\s|$)": "a number is written plainly in the line, such as 45, -45 or 12.5.",
    r"^m\s+v\b": "the command is one word: MV.",
    r"^EN\b": "EN switches the motors on. Which command turns a joint?",
    r"^-?\d": "the command comes first: what should the arm do?",
    r"\b(to|by|cw|ccw|joint|elbow|theta2)\b": "the line has the command and two numbers, the joint and the angle; no other words.",
}

NUMBER = re.compile(r"-?[0-9]{1,7}(\.[0-9]{1,6})?")  # as the controller reads them
ROUGHLY = 0.05  # so near, as a part of it, a number may be rounded to be taken for another
FULL_SPEED = 100.0  # percent; the next cell waits for no slower turn


@dataclass(frozen=True, eq=False)
class Command:
    """A line for the controller of the arm: words, and numbers that may be written in any way; only the joint is one digit.

    The full speed, 100, may stand behind it.

    Attributes
    ----------
    right : str
    wrong : tuple of Wrong, their answers lines
    praise, also : as in :class:`Number`
    """

    right: str
    wrong: tuple[Wrong, ...] = ()
    praise: str = ""
    also: tuple[Any, ...] = ()

    def carried(self, answer: Any) -> Any:
        """The line itself, where it stands in a list of one."""
        return answer[0] if isinstance(answer, (list, tuple)) and len(answer) == 1 else answer

    def judge(self, answer: Any) -> Verdict:
        """PASS for the same words and numbers; else what the line says instead."""
        answer = self.carried(answer)
        if isinstance(answer, bytes):
            return Verdict(NOT_YET, "the b before the quotes is put there for you: leave it away.")
        if not issubclass(type(answer), str):
            return Verdict(NOT_YET, f"expected a line in quotes, this is {a_kind(answer)}.")
        if "____" in answer:
            return Verdict(NOT_ATTEMPTED)
        answer = str.strip(answer)
        for sign, message in SIGNS.items():
            if sign in answer:
                return Verdict(NOT_YET, message)
        if re.search(r"[^ -~]", answer):
            return Verdict(
                NOT_YET,
                "plain letters, figures and blanks: something in the line is none. Type it anew, do not paste it.",
            )
        words, right = _words(answer), _words(self.right)
        if re.fullmatch(r"N\d+", answer.split()[0], re.IGNORECASE):
            return Verdict(NOT_YET, "the number of the line is put before it for you: leave it away.")
        if words in (right, [*right, FULL_SPEED]):
            return Verdict(PASS, self.praise)
        for mistake in self.wrong:
            if words == _words(mistake.answer):
                return Verdict(NOT_YET, mistake.message)
        for form, message in FORMS.items():
            if re.search(form, answer, re.IGNORECASE):
                return Verdict(NOT_YET, message)
        if len(words) != len(right):
            more = " A fourth is a part of the full speed: leave it away." if len(words) == len(right) + 1 else ""
            return Verdict(
                NOT_YET, f"expected {len(right)} words with blanks between them, this has {len(words)}.{more}"
            )
        if words[:-1] == right[:-1] and isinstance(words[-1], float):
            radians = math.radians(right[-1])
            if abs(abs(words[-1]) - abs(radians)) <= ROUGHLY * abs(radians):
                return Verdict(NOT_YET, "those are radians. The arm counts in degrees.")
            return Verdict(NOT_YET, f"that turns it to {words[-1]:g} degrees. Read the question again: to which angle?")
        k = next(k for k, pair in enumerate(zip(words, right, strict=True)) if pair[0] != pair[1])
        place, meant = (("first", "the command"), ("second", "the number of the joint"), ("third", "the angle"))[k]
        return Verdict(
            NOT_YET,
            f"look at the {place} word of {reprlib.repr(answer)}: it says something else. There stands {meant}.",
        )


def _words(line):
    """Numbers as numbers, but the second word, the joint, as it stands."""
    words = line.upper().split()
    return [float(w) if k != 1 and NUMBER.fullmatch(w) else w for k, w in enumerate(words)]
