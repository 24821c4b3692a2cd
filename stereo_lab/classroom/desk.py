"""Where one notebook runs: a process of its own, in the room, with no answers in it.

It hears from the examiner and speaks to it by lines of JSON through its standard input and output, which the notebook does not get.
"""

from __future__ import annotations

import _thread
import ast
import contextlib
import json
import os
import re
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

from stereo_lab.classroom.wire import pack, unpack
from stereo_lab.common.vectors import as_arrays

TOO_LONG = "it took longer than"
OF_A_CELL = re.compile(r"<ipython-input-[\w-]+>, ")  # a name that is another one for each notebook
QUESTION = re.compile(r"q(\d{1,2})")
FUNCTION = re.compile(r"^def (\w+)", re.MULTILINE)


class _Line:
    """The line to the examiner, and the functions that the examiner may call by number."""

    def __init__(self):
        self.hears = os.fdopen(os.dup(0), "r", encoding="utf-8")
        self.speaks = os.fdopen(os.dup(1), "w", encoding="utf-8")
        nowhere = os.open(os.devnull, os.O_RDWR)
        for number in (0, 1, 2):
            os.dup2(nowhere, number)
        self.functions: list[Any] = []

    def number_of(self, function: Any) -> int:
        known = next((k for k, one in enumerate(self.functions) if one is function), None)
        if known is not None:
            return known
        self.functions.append(function)
        return len(self.functions) - 1

    def tell(self, **message: Any) -> None:
        self.speaks.write(json.dumps(message) + "\n")
        self.speaks.flush()

    def ask(self, **message: Any) -> dict[str, Any]:
        """Tell something and wait for the answer; the examiner may call functions before it gives one."""
        self.tell(**message)
        while True:
            line = self.hears.readline()
            if not line:
                os._exit(0)  # the examiner has gone
            heard = json.loads(line)
            if "call" not in heard:
                return heard
            self.tell(**self._called(heard))

    def _called(self, heard):
        """What a learner's function gives, or what it stopped with."""
        arguments = [unpack(a) for a in heard["arguments"]]
        limit: dict[str, Any] = {"rang": False}
        try:
            with _watch.limit(heard["seconds"]) as limit:
                return {"returned": pack(self.functions[heard["call"]](*arguments), self.number_of)}
        except BaseException as error:
            if limit["rang"]:
                return {
                    "raised": "TimeoutError",
                    "kinds": ["TimeoutError"],
                    "text": _too_long(heard["seconds"]),
                    "inside": True,
                }
            inside = error.__traceback__ is not None and error.__traceback__.tb_next is not None
            kinds = [kind.__name__ for kind in type(error).__mro__]
            text = _text(error)
            return {
                "raised": kinds[0],
                "kinds": kinds,
                "text": text,
                "inside": inside,
                "name": str(getattr(error, "name", "")),
            }


class _Watch:
    """Stops what takes too long, as the learner's own Interrupt would."""

    def __init__(self):
        self._limits: list[dict[str, Any]] = []
        threading.Thread(target=self._look, daemon=True).start()

    def _look(self):
        while True:
            time.sleep(0.05)
            late = [limit for limit in list(self._limits) if time.monotonic() > limit["until"] and not limit["rang"]]
            if late:
                late[-1]["rang"] = True
                _thread.interrupt_main()

    @contextlib.contextmanager
    def limit(self, seconds: float) -> Iterator[dict[str, Any]]:
        """Interrupt what is in here after so long; "rang" tells whether that was done."""
        limit = {"until": time.monotonic() + seconds, "rang": False}
        self._limits.append(limit)
        try:
            yield limit
        finally:
            self._limits.remove(limit)


_line: Any = None
_watch: Any = None
_shell: Any = None


def check(lesson: str, number: int, answer: Any) -> None:
    """Tell the examiner an answer; a function is called meanwhile, with inputs that come from outside."""
    _line.ask(say="check", lesson=lesson, question=number, answer=pack(answer, _line.number_of))


def carry(lesson: str, number: int, answer: Any) -> Any:
    """What the cells below go on with."""
    told = _line.ask(say="carry", lesson=lesson, question=number, answer=pack(answer, _line.number_of))
    if "own" in told:
        return as_arrays(answer) if told.get("lists") else answer
    if "code" in told:
        return _made_here(told["code"])
    return _from_outside(lesson, number) if "function" in told else unpack(told["value"])


def help_taken(lesson: str, number: int, what: str) -> None:
    """Tell the examiner that a hint or a solution was asked for."""
    _line.tell(say="help", lesson=lesson, question=number, what=what)


def count(lesson: str) -> int:
    """How many questions a lesson has."""
    return int(_line.ask(say="count", lesson=lesson)["count"])


def _made_here(code: str) -> Callable:
    """The kit's own function out of the lines of its solution: a lesson may call it ten thousand times, too often for the line."""
    names = dict(_shell.user_ns)
    exec(code, names)
    return names[FUNCTION.findall(code)[-1]]


def _from_outside(lesson: str, number: int) -> Callable:
    """The kit's own function of another lesson, whose names are not here: it runs at the examiner's."""

    def function(*arguments: Any) -> Any:
        told = _line.ask(say="use", lesson=lesson, question=number, arguments=[pack(a) for a in arguments])
        if "error" in told:
            raise ValueError(told["error"])
        return unpack(told["value"])

    return function


class _ByNumber(ast.NodeTransformer):
    """``q3.check(x)`` tells question 3 whatever ``q3`` has been made into; pictures come from where the lesson takes them."""

    def __init__(self, source: str) -> None:
        self.source = source

    def visit_Call(self, node):
        self.generic_visit(node)
        if isinstance(node.func, ast.Attribute) and node.func.attr == "check" and isinstance(node.func.value, ast.Name):
            found = QUESTION.fullmatch(node.func.value.id)
            if found and len(node.args) == 1 and not node.keywords:
                asked = [ast.Constant(int(found.group(1))), node.func.value, node.args[0]]
                node = ast.Call(ast.Name("__checked__", ast.Load()), asked, [])
        return node

    def visit_Assign(self, node):
        self.generic_visit(node)
        named = [target.id for target in node.targets if isinstance(target, ast.Name)]
        if self.source and named == ["source_name"] and isinstance(node.value, ast.Constant):
            node.value = ast.Constant(self.source)
        return node


def main() -> None:
    """Run the cells that the examiner sends, and tell how each one ended."""
    global _line, _watch, _shell
    _line = _Line()
    paper = json.loads(_line.hears.readline())
    _bound_memory(paper["memory"])
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job is started deaf to it
    _watch = _Watch()
    _shell = _made_shell(paper["lesson"], paper["source"])
    told = {k: _run_told(paper, k) for k in paper["order"]}
    again = [k for k, stopped in told.items() if stopped and not stopped.startswith(TOO_LONG)]
    for k in again:  # a cell that was moved finds now what it needs
        _run_told(paper, k)
    _line.tell(say="done")
    os._exit(0)  # whatever the notebook has left running


def _run_told(paper, k):
    """Run one cell between two messages; gives what it stopped with."""
    _line.tell(say="begins", cell=k)
    stopped = _run(paper["cells"][k], paper["seconds"])
    _line.tell(say="ends", cell=k, stopped=stopped)
    return stopped


def _run(source, seconds):
    """Run one cell; "" or what it stopped with."""
    limit: dict[str, Any] = {"rang": False}
    try:
        with _watch.limit(seconds) as limit:
            done = _shell.run_cell(source, silent=True, store_history=False)
        error = done.error_before_exec or done.error_in_exec
        told = "" if error is None else f"{type(error).__name__}: {_text(error)}"[:300]
    except BaseException as error:
        told = f"{type(error).__name__}: {_text(error)}"[:300]
    if "matplotlib.pyplot" in sys.modules:
        with contextlib.suppress(Exception):
            sys.modules["matplotlib.pyplot"].close("all")
    return _too_long(seconds) if limit["rang"] else told


def _too_long(seconds):
    return f"{TOO_LONG} {seconds:.0f} s"


def _made_shell(lesson, source):
    """What a notebook finds in a kernel, but for its screen."""
    from IPython.core.interactiveshell import InteractiveShell

    from stereo_lab.exercises import Question

    shell = InteractiveShell.instance()
    shell.enable_gui = lambda *_, **__: None  # %matplotlib asks for one
    shell.display_formatter.active_types = ["text/plain"]
    shell.display_pub.publish = lambda *_, **__: None
    shell.showtraceback = shell.showsyntaxerror = lambda *_, **__: None
    shell.ast_transformers.append(_ByNumber(source))

    def checked(number, asked, answer):
        its = (asked.lesson, asked.number) if type(asked) is Question else (lesson, number)
        check(*its, answer)

    shell.user_ns["__checked__"] = checked
    return shell


def _bound_memory(most):
    """So much address space and no more, where the system knows such a thing."""
    try:
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (most, most))
        resource.setrlimit(resource.RLIMIT_FSIZE, (most // 8, most // 8))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    except (ImportError, ValueError, OSError):
        return


def _text(error):
    try:
        return OF_A_CELL.sub("", str(error))[:300]
    except BaseException:
        return ""
