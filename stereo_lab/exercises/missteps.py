"""A formula with one step of it gone wrong: an operator, a bracket, a function, a name, or a part that is left out."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from stereo_lab.exercises.mistyping import PART, Misstep, mistyped, shortened, with_brackets

OTHER = {
    "sin": "cos", "cos": "sin", "acos": "asin", "degrees": "radians", "radians": "degrees", "sum": "mean", "mean": "sum",
}  # fmt: skip


def missteps(formula: ast.expr, names: Sequence[str]) -> Iterator[Misstep]:
    """Each formula that comes of one step gone wrong, the commonest first.

    Parameters
    ----------
    formula : the right one
    names : of the arguments, one of which may stand for another; () where that is not to be looked for
    """
    yield from mistyped(formula)
    yield from _everywhere(formula)
    nodes = [node for node in ast.walk(formula) if isinstance(node, ast.expr)]
    for at in (_left_out, _turned_round, _of_a_power, _of_a_call):
        for node in nodes:
            for new, told in at(node):
                if "left out" in told and PART in told:
                    continue  # so much is no slip
                yield Misstep(replaced(formula, node, new), told)
    yield from with_brackets(formula)
    for node in nodes if names else ():
        for new, told in _by_another_name(node, names):
            yield Misstep(replaced(formula, node, new), told)


def replaced(formula: ast.expr, old: ast.expr, new: ast.expr) -> ast.expr:
    """The formula with one node of it replaced."""
    return new if formula is old else rebuilt(formula, lambda part: replaced(part, old, new))


def rebuilt(node: Any, change: Callable) -> Any:
    """A copy of a node of which each part has been changed."""
    of = lambda part: change(part) if isinstance(part, ast.AST) else part
    return type(node)(
        **{name: [of(p) for p in part] if isinstance(part, list) else of(part) for name, part in ast.iter_fields(node)}
    )


def name_of(call: ast.expr) -> str | None:
    """The name of the function that is called, without its module; None where nothing is called by a name."""
    if not isinstance(call, ast.Call):
        return None
    return call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", None)


def _everywhere(formula):
    """A function left out, or another one taken, wherever it stands."""
    calls = {name_of(node) for node in ast.walk(formula)} - {None}
    for name in sorted(calls):
        mine = [node for node in ast.walk(formula) if name_of(node) == name]
        if len(mine) > 1 and all(len(node.args) == 1 for node in mine):
            yield Misstep(_all(formula, name, lambda node: node.args[0]), f"{name}() is left out")
        if len(mine) > 1 and name in OTHER:
            yield Misstep(_all(formula, name, _renamed(OTHER[name])), f"{OTHER[name]} stands where {name} belongs")
    if {"sin", "cos"} <= calls:
        turned = _all(_all(_all(formula, "sin", _renamed("?")), "cos", _renamed("sin")), "?", _renamed("cos"))
        yield Misstep(turned, "sin and cos have changed places")
    if "mean" in calls:
        median = ast.Attribute(ast.Name("np", ast.Load()), "median", ast.Load())
        yield Misstep(
            _all(formula, "mean", lambda node: ast.Call(median, [node.func.value], [])),
            "the median stands where the mean belongs",
        )


def _left_out(node):
    """A part of a sum, of a product, of a question, or of what stands in a function's brackets."""
    if isinstance(node, ast.BinOp):
        a, b = node.left, node.right
        if not isinstance(node.op, ast.Pow):
            yield a, f"{_text(b)} is left out"
        if isinstance(node.op, ast.Sub):
            yield ast.UnaryOp(ast.USub(), b), f"{_text(a)} is left out"
            yield b, f"{_text(a)} is left out, and a minus with it"
        elif isinstance(node.op, ast.Div):
            yield ast.BinOp(ast.Constant(1), ast.Div(), b), f"{_text(a)} is left out"
            yield b, f"{_text(a)} is left out, and {_text(b)} does not divide"
        elif not isinstance(node.op, ast.Pow):
            yield b, f"{_text(a)} is left out"
    if isinstance(node, ast.IfExp):
        yield node.orelse, f"the case {_text(node.test)} is left out, or never reached"
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        yield node.operand, f"the minus before {_text(node.operand)} is left out"
    if isinstance(node, ast.Call) and len(node.args) > 1:
        for k, part in enumerate(node.args):
            yield ast.Call(node.func, [*node.args[:k], *node.args[k + 1 :]], []), f"{_text(part)} is left out"


def _turned_round(node):
    """Two things that have changed places."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Sub):
        a, b = node.left, node.right
        yield ast.BinOp(b, ast.Sub(), a), f"{_text(a)} and {_text(b)} are subtracted the other way round"
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Div):
        a, b = node.left, node.right
        yield (
            ast.BinOp(b, ast.Div(), a),
            f"a fraction is upside down: {_text(a)} belongs above the line, {_text(b)} below it",
        )
        yield ast.BinOp(a, ast.Mult(), b), f"{_text(b)} multiplies and should divide"
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult):
        a, b = node.left, node.right
        yield ast.BinOp(a, ast.Div(), b), f"{_text(b)} divides and should multiply"
        yield ast.BinOp(b, ast.Div(), a), f"{_text(a)} divides and should multiply"
    if isinstance(node, ast.IfExp):
        turned = ast.IfExp(node.test, node.orelse, node.body)
        yield turned, f"what comes where {_text(node.test)} and what comes elsewhere have changed places"
    if isinstance(node, ast.Call) and len(node.args) == 2:
        a, b = node.args
        yield _call(node, b, a), f"the two things in the brackets of {name_of(node)} have changed places"


def _of_a_power(node):
    """A square or a root left out, or taken of something else; or decimals that are cut off."""
    if not isinstance(node, ast.BinOp):
        return
    if isinstance(node.op, (ast.Mult, ast.Div)):
        for name, does in (("int", "cuts off"), ("round", "rounds away")):
            yield ast.Call(ast.Name(name, ast.Load()), [node], []), f"{name}() {does} decimals of {_text(node)}"
    if isinstance(node.op, ast.Pow) and isinstance(node.right, ast.Constant):
        base, root = node.left, node.right.value == 0.5
        yield base, f"the root of {_text(base)} is left out" if root else f"{_text(base)} is not squared"
        if not root:
            yield ast.BinOp(base, ast.Mult(), node.right), f"{_text(base)} is doubled where it should be squared"
            yield (
                ast.BinOp(base, ast.Pow(), ast.Constant(3)),
                f"{_text(base)} stands there three times, and should twice",
            )
        else:
            yield ast.BinOp(base, ast.Mult(), node.right), f"{_text(base)} is halved where its root belongs"
    parts = (node.left, node.right)
    if isinstance(node.op, (ast.Add, ast.Sub)) and all(
        isinstance(p, ast.BinOp) and isinstance(p.op, ast.Pow) for p in parts
    ):
        (a, b), power = (part.left for part in parts), parts[0].right
        together = ast.BinOp(ast.BinOp(a, node.op, b), ast.Pow(), power)
        yield together, f"{_text(a)} and {_text(b)} are squared together: square each by itself first"
        yield ast.BinOp(a, node.op, b), f"{_text(a)} and {_text(b)} are not squared"


def _of_a_call(node):
    """A function that is left out, another one, or one that works on something else."""
    name = name_of(node)
    if name is None:
        return
    if not node.args and isinstance(node.func, ast.Attribute):  # such as pixels.mean()
        yield node.func.value, f"{name}() is left out"
    if name in OTHER:
        yield _renamed(OTHER[name])(node), f"{OTHER[name]} stands where {name} belongs"
    if name == "acos":
        yield _renamed("cos")(node), "cos stands where acos belongs"
    if name == "atan2" and len(node.args) == 2:  # of two missteps the first may have left one out
        a, b = node.args
        yield _renamed("atan")(_call(node, ast.BinOp(a, ast.Div(), b))), "atan stands where atan2 belongs"
    if len(node.args) != 1:
        return
    (inside,) = node.args
    yield inside, f"{name}() is left out round {_text(inside)}"
    yield _call(node, _call(node, inside)), f"{name}() works twice"
    if isinstance(inside, ast.Call) and len(inside.args) == 1:
        turned = _call(inside, _call(node, inside.args[0]))
        yield turned, f"{name}() and {name_of(inside)}() have changed places: the inner one works first"
        if isinstance(inside.args[0], ast.BinOp):
            a, op, b = inside.args[0].left, inside.args[0].op, inside.args[0].right
            both = ast.BinOp(_call(node, _call(inside, a)), op, _call(node, _call(inside, b)))
            yield both, f"{name} of a sum is not the sum of two {name}: add first"
    if isinstance(inside, ast.BinOp):
        a, op, b = inside.left, inside.op, inside.right
        for new, other in ((ast.BinOp(_call(node, a), op, b), b), (ast.BinOp(a, op, _call(node, b)), a)):
            yield new, f"{name}() works on a part alone: {_text(other)} belongs in its brackets as well"
        if isinstance(op, (ast.Add, ast.Sub)):
            yield (
                ast.BinOp(_call(node, a), op, _call(node, b)),
                f"{name} of a sum is not the sum of two {name}: add first",
            )


def _by_another_name(node, names):
    """One name typed for another, or another one of several numbers."""
    if isinstance(node, ast.Name) and node.id in names:
        for name in names:
            if name != node.id:
                yield ast.Name(name, ast.Load()), f"{name} stands where {node.id} belongs"
    if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Constant):
        for k in {0, 1, 2} - {node.slice.value}:
            other = ast.Subscript(node.value, ast.Constant(k), ast.Load())
            yield other, f"{_text(other)} stands where {_text(node)} belongs"


def _all(formula, name, change):
    """The formula with all calls of one function changed."""
    formula = rebuilt(formula, lambda part: _all(part, name, change))
    return change(formula) if name_of(formula) == name else formula


def _renamed(name):
    """What gives a call another function's name, of the same module."""

    def rename(node):
        func = node.func
        attribute = isinstance(func, ast.Attribute)
        return ast.Call(
            ast.Attribute(func.value, name, ast.Load()) if attribute else ast.Name(name, ast.Load()), node.args, []
        )

    return rename


def _call(node, *arguments):
    return ast.Call(node.func, list(arguments), [])


def _text(node):
    return shortened(ast.unparse(ast.fix_missing_locations(node)))
