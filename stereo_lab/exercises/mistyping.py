"""Formulas mistyped: another operator, a pair of brackets too few or too many."""

from __future__ import annotations

import ast
import contextlib
import re
from collections.abc import Iterator
from itertools import accumulate
from typing import NamedTuple

PART = "a part with"
LONG = 30  # letters: a longer part of a formula is not told, for it would be half of the solution
OPERATORS = {
    "+": (ast.Add, "a plus"), "-": (ast.Sub, "a minus"), "*": (ast.Mult, "a *"), "/": (ast.Div, "a /"), "//": (ast.FloorDiv, "a //"),
    "**": (ast.Pow, "a **"), "<": (ast.Lt, "<"), "<=": (ast.LtE, "<="), ">": (ast.Gt, ">"), ">=": (ast.GtE, ">="), "|": (ast.BitOr, "|"), "&": (ast.BitAnd, "&"),
}  # fmt: skip
MIXED_UP = {  # what stands in the place of an operator
    "+": ("-", "*", "/"), "-": ("+", "*", "/"), "*": ("/", "+", "-", "**"), "/": ("*", "//", "-", "+"), "**": ("*", "+"),
    "<": ("<=", ">", ">="), "<=": ("<", ">", ">="), ">": (">=", "<", "<="), ">=": (">", "<", "<="), "|": ("&",), "&": ("|",),
}  # fmt: skip
OPERATOR = re.compile(r" (\*\*|//|<=|>=|[-+*/<>|&]) |(\*\*)")


class Misstep(NamedTuple):
    """A formula that went wrong, and what to say of it."""

    formula: ast.expr
    told: str


def mistyped(formula: ast.expr) -> Iterator[Misstep]:
    """Each formula that comes of one slip of the keyboard; a pair of brackets too many is left to :func:`with_brackets`."""
    for slips in (_operators, _without_brackets, _operator_everywhere, _squared_together):
        yield from slips(formula)


def _operators(formula):
    """Another operator typed: what then belongs together may change as well."""
    text = ast.unparse(formula)
    for found in OPERATOR.finditer(text):
        sign, rest = found[1] or found[2], text[found.end() :]
        before = re.match(r"[\w.]*(\(.*\)|\[\d\])?|.*", rest)[0] if not rest.startswith("(") else ""
        for other in MIXED_UP.get(sign, ()):
            new = text[: found.start()] + f" {other} " + rest
            with contextlib.suppress(SyntaxError):
                place = f" before {shortened(before)}" if before else ""
                yield Misstep(
                    ast.parse(new, mode="eval").body,
                    f"{OPERATORS[other][1]} stands{place} where {OPERATORS[sign][1]} belongs",
                )


def _operator_everywhere(formula):
    """Another operator typed, wherever one of its kind stands."""
    text = ast.unparse(formula)
    for sign in dict.fromkeys(found[1] or found[2] for found in OPERATOR.finditer(text)):
        for other in MIXED_UP.get(sign, ()):
            new = OPERATOR.sub(
                lambda found, sign=sign, other=other: f" {other} " if sign in (found[1], found[2]) else found[0], text
            )
            told = f"{OPERATORS[other][1]} stands where {OPERATORS[sign][1]} belongs"
            yield Misstep(ast.parse(new, mode="eval").body, told)


def _squared_together(formula):
    """Two squares one after the other taken for one: a - b**2 - c**2 as a - (b - c)**2."""
    text = ast.unparse(formula)
    for found in re.finditer(r"(?=([-+]) (\w+)( \*\* 2) [-+] (\w+)( \*\* 2))", text):
        for sign in "+-":
            new = f"{text[: found.start()]}{found[1]} ({found[2]} {sign} {found[4]}) ** 2{text[found.end(5) :]}"
            yield Misstep(
                ast.parse(new, mode="eval").body,
                f"{found[2]} and {found[4]} are squared together: square each by itself",
            )


def _without_brackets(formula):
    """One pair of brackets taken away."""
    text = ast.unparse(formula)
    for start, sign in enumerate(text):
        if sign != "(" or start and (text[start - 1].isalnum() or text[start - 1] in "_)]"):
            continue
        end = _closing(text, start)
        inside = text[start + 1 : end]
        with contextlib.suppress(SyntaxError):
            new = ast.parse(text[:start] + inside + text[end + 1 :], mode="eval").body
            yield Misstep(new, f"brackets are missing round {shortened(inside)}")


def with_brackets(formula: ast.expr) -> Iterator[Misstep]:
    """One pair of brackets too many: round what stands between the beginning of a word and the end of another."""
    text = ast.unparse(formula)
    starts = [found.start() for found in re.finditer(r"(?<![\w.])[\w(]", text)]
    ends = [found.end() for found in re.finditer(r"[\w)\]](?![\w.(\[])", text)]
    for start in starts:
        for end in ends:
            inside = text[start:end]
            if end > start and " " in inside and _is_balanced(inside):
                with contextlib.suppress(SyntaxError):
                    new = ast.parse(f"{text[:start]}({inside}){text[end:]}", mode="eval").body
                    yield Misstep(new, f"brackets stand round {shortened(inside)}, and none belong there")


def _is_balanced(text):
    """Whether each bracket that opens in a text closes in it."""
    depths = list(accumulate({"(": 1, ")": -1}.get(sign, 0) for sign in text))
    return min(depths) >= 0 and depths[-1] == 0


def _closing(text, start):
    """Where the bracket ends that begins here."""
    depth = 0
    for k in range(start, len(text)):
        depth += {"(": 1, ")": -1}.get(text[k], 0)
        if not depth:
            return k
    return len(text)


def shortened(text: str) -> str:
    """A part of a formula as it is told; of a long one, the names in it."""
    text = text.replace("math.", "").replace("np.", "")
    if len(text) <= LONG:
        return text
    names = list(dict.fromkeys(re.findall(r"\b[a-zA-Z_][\w.]*\b(?!\()", text)))
    return f"{PART} {' and '.join(names[:3])}"
