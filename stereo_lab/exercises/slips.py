"""The slip in a learner's function: which one or two missteps make the right formula do what it does."""

from __future__ import annotations

import ast
import contextlib
import dataclasses
import inspect
import io
import math
import textwrap
from collections.abc import Callable, Iterator, Sequence
from types import FunctionType, SimpleNamespace
from typing import Any

import numpy as np

from stereo_lab.exercises.missteps import missteps, name_of, rebuilt
from stereo_lab.exercises.trying import EXACT, numbers_of

PROBES = 20  # inputs beside the tries at which they are compared
BEYOND = 1e3  # radians, where acos of a number beyond 1 is put
# Numbers that are known rounded, to a part of ROUGHLY, and what to write instead of them
ROUGHLY = 0.01
EXACTLY = {
    math.pi: "Python knows π to all its decimals: pi, from math.",
    2 * math.pi: "Python knows π to all its decimals: 2 * pi, from math.",
    180 / math.pi: "degrees() and radians() turn the one into the other, with all decimals.",
    math.pi / 180: "degrees() and radians() turn the one into the other, with all decimals.",
}
MOST_PAIRS = 2500  # of missteps that are looked through, for a second or so


def slip_in(function: Callable, right: Callable, inputs: Sequence[tuple], solution: str = "", at_once: int = 2) -> str:
    """What went wrong in a function, in a sentence; "" where no misstep, nor two together, does as it does.

    Parameters
    ----------
    function, right : callables
    inputs : tuples of arguments; others like them are tried as well
    solution : str, the lines of a function that does as ``right`` does; without them its own are read
    at_once : int, how many missteps together are looked for, 1 or 2
    """
    read = _read(solution or _source(right))
    if read is None:
        return ""
    names, before, formulas = read
    tries = [*inputs, *_others(inputs)]
    floats = [tuple(map(_as_float, arguments)) for arguments in tries]  # a power of whole numbers may have no end
    make = lambda formula: _made(names, before, formula, _scope(right))
    with contextlib.redirect_stdout(io.StringIO()):  # it may print
        given = [numbers_of(_widened(function), arguments) for arguments in tries]
    wanted = [numbers_of(_widened(right), arguments) for arguments in tries]
    found = []
    for k, formula in enumerate(formulas):
        mine, its = given, wanted
        if len(formulas) > 1:
            mine, its = (
                [None if g is None or g.size != len(formulas) else g[k : k + 1] for g in all_]
                for all_ in (given, wanted)
            )
        if _same(mine, its):
            continue
        found.append(_slip(formula, names, make, floats, mine, at_once))
    told = list(dict.fromkeys(found))
    if not all(told) or not told:
        return ""
    return f"{'. And '.join(told) if len(told) < 3 else told[0]}."


def _slip(formula, names, make, tries, mine, at_once):
    """What is said of the first misstep, or of the first two, that give the learner's numbers; "" where none do."""
    seen, once = {ast.dump(formula)}, []
    for step in _new(missteps(formula, names if at_once > 1 else ()), seen):
        once.append(step)
        if _does(make(step.formula), tries, mine):
            return step.told
    for first in once if at_once > 1 else ():
        for step in _new(missteps(first.formula, names), seen):
            if _does(make(step.formula), tries, mine):
                return (
                    f"{first.told}, twice"
                    if first.told == step.told
                    else f"two things at once: {first.told}; and {step.told}"
                )
        if len(seen) > MOST_PAIRS:
            return ""
    return ""


def strange_number(function: Callable, right: Callable, solution: str = "") -> str:
    """A number of the learner's that the solution does not have, where one of the solution's is missing; "" where there is none."""
    mine, its = _numbers(_source(function)), _numbers(solution or _source(right))
    strange = sorted(mine - its)
    return f"the task says nothing of {strange[0]:g}: which number belongs there?" if strange and its - mine else ""


def rounded_number(function: Callable, right: Callable, inputs: Sequence[tuple]) -> str:
    """A rounded π, or degrees in a radian, of the learner's: what to write in its place. "" where that would not make all right."""
    if not isinstance(function, FunctionType):
        return ""
    code = function.__code__
    for number in code.co_consts:
        for exact, instead in EXACTLY.items():
            if isinstance(number, float) and number != exact and abs(number / exact - 1) < ROUGHLY:
                mended = code.replace(co_consts=tuple(exact if known == number else known for known in code.co_consts))
                if do_alike(_as(function, mended, function.__globals__), right, inputs):
                    return f"right but for {number:g}, which is rounded. {instead}"
    return ""


def _numbers(source):
    """Those that are written in some lines."""
    try:
        parts = ast.walk(ast.parse(source))
    except SyntaxError:
        return set()
    return {part.value for part in parts if isinstance(part, ast.Constant) and type(part.value) in (int, float)}


def _new(steps, seen):
    """Those that lead to a formula which has not been seen."""
    for step in steps:
        if (dump := ast.dump(step.formula)) not in seen:
            seen.add(dump)
            yield step


def _source(function):
    try:
        return textwrap.dedent(inspect.getsource(function))
    except (OSError, TypeError):
        return ""


def _scope(function):
    """What the names outside of a function stand for."""
    seen = inspect.getclosurevars(function)
    return {**vars(math), "np": np, **function.__globals__, **seen.nonlocals, "acos": _acos, "math": MATH}


def _widened(function):
    """A function of Python's that goes on where acos stops: an angle no arm has, but another one for each number."""
    if not isinstance(function, FunctionType):
        return function
    scope = {
        name: _acos if thing is math.acos else MATH if thing is math else thing
        for name, thing in function.__globals__.items()
    }
    return _as(function, function.__code__, scope)


def _as(function, code, scope):
    """A function of Python's with other lines, or with other things that the names in them stand for."""
    other = FunctionType(code, scope, function.__name__, function.__defaults__, function.__closure__)
    other.__kwdefaults__ = function.__kwdefaults__
    return other


def _acos(x):
    return math.acos(x) if abs(x) <= 1 else BEYOND + x


MATH = SimpleNamespace(**{**vars(math), "acos": _acos})


def _read(source: str) -> tuple[list[str], list[ast.stmt], list[ast.expr]] | None:
    """Names of the arguments, what stands before the formula, and a formula for each number that comes out.

    None where a function has more to it than that.
    """
    try:
        (function,) = [line for line in ast.parse(source).body if isinstance(line, ast.FunctionDef)]
    except (SyntaxError, ValueError):
        return None
    before: list[ast.stmt] = []
    known: dict[str, ast.expr] = {}
    cases: list[tuple[ast.expr, ast.expr]] = []
    for line in function.body[:-1]:
        if isinstance(line, ast.If) and not line.orelse and isinstance(line.body[0], ast.Return) and line.body[0].value:
            cases.append((line.test, line.body[0].value))
        elif isinstance(line, ast.Assign) and not cases:
            (target,), value = line.targets, _filled_in(line.value, known)
            if isinstance(target, ast.Name):
                known[target.id] = value
            elif isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
                known |= {
                    name.id: part
                    for name, part in zip(target.elts, value.elts, strict=True)
                    if isinstance(name, ast.Name)
                }
            else:  # what is taken apart keeps the names of its parts
                before.append(line)
        elif not (isinstance(line, ast.Expr) and isinstance(line.value, ast.Constant)):  # a docstring
            return None
    last = function.body[-1]
    if not isinstance(last, ast.Return) or last.value is None:
        return None
    whole = last.value
    for case in reversed(cases):
        whole = ast.IfExp(*case, whole)
    formula = _without_hypot(_filled_in(whole, known))
    parts = formula.elts if isinstance(formula, ast.Tuple) else [formula]
    return [argument.arg for argument in function.args.args], before, parts


def _filled_in(formula, known):
    """The formula with the expressions that names in it stand for."""
    if isinstance(formula, ast.Name) and formula.id in known:
        return rebuilt(known[formula.id], lambda part: _filled_in(part, {}))
    return rebuilt(formula, lambda part: _filled_in(part, known))


def _without_hypot(formula):
    """The formula with the root of the squares written out, for a misstep may lie in those."""
    formula = rebuilt(formula, _without_hypot)
    if name_of(formula) != "hypot":
        return formula
    squares = [ast.BinOp(part, ast.Pow(), ast.Constant(2)) for part in formula.args]
    total = squares[0]
    for square in squares[1:]:
        total = ast.BinOp(total, ast.Add(), square)
    return ast.BinOp(total, ast.Pow(), ast.Constant(0.5))


def _made(names, before, formula, scope):
    """A function of a formula."""
    arguments = ast.arguments([], [ast.arg(name) for name in names], None, [], [], None, [])
    whole = ast.FunctionDef("made", arguments, [*before, ast.Return(formula)], [], None, None)
    if "type_params" in whole._fields:  # from Python 3.12 on
        whole.type_params = []
    made: dict[str, Any] = {}
    module = ast.fix_missing_locations(ast.Module([whole], []))
    exec(compile(module, "<formula>", "exec"), scope, made)
    return made["made"]


def do_alike(function: Callable, other: Callable, inputs: Sequence[tuple]) -> bool:
    """Whether two functions give the same for inputs like these."""
    return all(
        _same([numbers_of(function, arguments)], [numbers_of(other, arguments)])
        for arguments in _others(inputs, 10 * PROBES)
    )


def _does(function, tries, mine):
    """Whether a function gives these numbers for these tries, and stops where they are None."""
    met = 0
    for arguments, number in zip(tries, mine, strict=True):
        value = numbers_of(function, arguments)
        if (value is None) != (number is None) or value is not None and not _near(value, number):
            return False
        met += value is not None
    return met >= 2


def _same(mine, its):
    return all((m is None) == (i is None) and (m is None or _near(m, i)) for m, i in zip(mine, its, strict=True))


def _near(value, other):
    return value.shape == other.shape and bool(np.all(np.abs(value - other) <= EXACT * (1e-12 + np.abs(other))))


def _others(inputs: Sequence[tuple], count: int = PROBES) -> Iterator[tuple]:
    """More inputs, of the same kinds: each number between a third and three times what it is in one of these."""
    rng = np.random.default_rng(0)
    for k in range(count):
        yield tuple(_shaken(argument, rng) for argument in inputs[k % len(inputs)])


def _as_float(argument):
    """The argument with floats for whole numbers."""
    if isinstance(argument, tuple):
        return tuple(map(_as_float, argument))
    if dataclasses.is_dataclass(argument) and not isinstance(argument, type):
        fields = {field.name: _as_float(getattr(argument, field.name)) for field in dataclasses.fields(argument)}
        return dataclasses.replace(argument, **fields)
    if isinstance(argument, np.ndarray):
        return argument.astype(float)
    return float(argument) if isinstance(argument, int) else argument


def _shaken(argument, rng):
    """A number or several, each times another number."""
    if isinstance(argument, np.ndarray):
        return (argument * 3 ** rng.uniform(-1, 1, argument.shape)).astype(argument.dtype)
    if isinstance(argument, tuple):
        return tuple(_shaken(part, rng) for part in argument)
    if dataclasses.is_dataclass(argument) and not isinstance(argument, type):
        fields = {field.name: getattr(argument, field.name) for field in dataclasses.fields(argument)}
        return dataclasses.replace(argument, **{name: _shaken(part, rng) for name, part in fields.items()})
    if isinstance(argument, (int, float)) and not isinstance(argument, bool):
        number = argument * 3 ** rng.uniform(-1, 1)
        return number if isinstance(argument, float) else round(number)
    return argument
