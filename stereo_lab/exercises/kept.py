"""What the learner wrote comes back in later lessons: kept as readable text, judged again before it is used."""

from __future__ import annotations

import ast
import inspect
import textwrap
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

import numpy as np

from stereo_lab.common.files import read_text, write_whole
from stereo_lab.errors import StereoLabError
from stereo_lab.exercises.answers import PASS, Choice, Command, Function, Number, judge
from stereo_lab.exercises.blank import ____
from stereo_lab.exercises.wording import error_in_words
from stereo_lab.work import own_folder

HEAD = "# Your answer to question {name}. Change it as you like: later lessons use it as long as it passes.\n\n"
LONGEST = 2000  # letters of a value


def keep(name: str, answer: Any) -> None:
    """Write an answer that has passed into the learner's folder: a value as it is, a function as its lines.

    What cannot be written as text, or not at all (a full disk), is not kept, and nobody is stopped.

    Parameters
    ----------
    name : str, such as "5.3"
    answer : anything
    """
    try:
        lines = _function(answer) if callable(answer) else f"answer = {_value(answer)}\n"
        write_whole(_path(name), HEAD.format(name=name) + lines)
    except (StereoLabError, TypeError, ValueError, AttributeError, OSError, SyntaxError, RecursionError):
        return


def recall(name: str, kind: Number | Choice | Function | Command) -> tuple[Any, str]:
    """The answer that is kept, where it passes on the recording in use.

    Parameters
    ----------
    name : str, such as "5.3"
    kind : what judges it

    Returns
    -------
    answer : anything, or None where there is none to be used
    why : str, why there is none; empty where there is one
    """
    path = _path(name)
    if not path.exists():
        return None, "you have not passed it in this folder yet"
    there: dict[str, Any] = {"__name__": "__main__"}  # as in the notebook that it comes from
    try:
        exec(compile(read_text(path), str(path), "exec"), there)  # the learner's own lines, in the learner's own kernel
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        return None, f"{path.name} stops with {error_in_words(error)}"
    answer = there.get("answer", ____)
    return (
        (answer, "") if judge(kind, answer).status == PASS else (None, f"{path.name} does not pass on this recording")
    )


def _path(name: str) -> Path:
    lesson, number = name.split(".")
    return own_folder() / "answers" / f"question_{lesson.zfill(2)}_{number}.py"


def _value(answer):
    """A number, a text or a row of them as Python writes it."""
    text = repr(_plain(answer))
    if len(text) > LONGEST:
        raise TypeError("a picture, say, and no answer")
    ast.literal_eval(text)  # an object that only looks like a value is not kept
    return text


def _plain(answer):
    """Without numpy's own types, which Python's do not write as values."""
    if isinstance(answer, (np.ndarray, np.generic)):
        return answer.tolist()
    return type(answer)(map(_plain, answer)) if type(answer) in (list, tuple) else answer


def _function(function):
    """The lines of a function, and before them those of everything of the learner's that it uses."""
    if not isinstance(function, FunctionType):
        raise TypeError("no function of the learner's")
    lines: dict[str, str] = {}
    name = _add(function, lines)
    imports = [line for line in lines.values() if line.startswith(("import ", "from "))]
    rest = [line for line in lines.values() if line not in imports]
    return "\n\n\n".join(["\n".join(imports), *rest][not imports :]) + f"\n\n\nanswer = {name}\n"


def _add(function, lines):
    """Put a function into ``lines`` after what it needs; gives its name."""
    source = textwrap.dedent(inspect.getsource(function)).strip()
    tree = ast.parse(source)
    name = _name(tree.body[0])
    lines[name] = ""  # one that calls itself ends here
    words = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load)}
    for word in sorted(words & set(function.__globals__) - set(lines)):
        _add_needed(word, function.__globals__[word], function.__module__, lines)
    del lines[name]  # after what it needs
    lines[name] = source
    return name


def _add_needed(word, thing, module, lines):
    """A line that makes ``word`` mean the same thing again."""
    if isinstance(thing, ModuleType):
        lines[word] = f"import {thing.__name__}" + f" as {word}" * (word != thing.__name__)
    elif isinstance(thing, FunctionType) and thing.__module__ == module:
        if (name := _add(thing, lines)) != word:  # one that came back has the name that it had in its own lesson
            lines[word] = f"{word} = {name}"
    elif callable(thing):
        lines[word] = f"from {thing.__module__} import {thing.__name__}" + f" as {word}" * (word != thing.__name__)
    elif isinstance(thing, np.ndarray):
        lines["numpy"] = "import numpy"
        lines[word] = f"{word} = numpy.array({_value(thing)})"
    else:
        lines[word] = f"{word} = {_value(thing)}"


def _name(first):
    """What a function's own lines call it: by def, or as ``name = lambda …``."""
    if isinstance(first, ast.FunctionDef):
        return first.name
    if isinstance(first, ast.Assign) and isinstance(first.value, ast.Lambda) and isinstance(first.targets[0], ast.Name):
        return first.targets[0].id
    raise TypeError("no lines of its own")
