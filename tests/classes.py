"""A class that is made up: notebooks from the reference solutions, with answers right, wrong, broken, endless and hostile."""

import copy
import json
import random
import re

from conftest import ROOT
from stereo_lab.classroom.examiner import TAKEN
from stereo_lab.exercises import questions
from stereo_lab.recording import open_recording

LESSON = "03"
STEM = "03_world_coordinates"
PASSED, NOT_YET, BLANK = "PASS", "NOT YET", "NOT ATTEMPTED"

# For each question of lesson 03 what people answer, and the beginning of what is said to it
WRONG = {
    1: (('slope_is = "above"', "then the ball would rise"), ('slope_is = "zero"', "then y would be the same"), ("slope_is = 1", "answer with one of these")),
    2: (
        ("slope = y1 - y0 / v1 - v0", "brackets are missing: Python"),
        ("slope = abs((y1 - y0) / (v1 - v0))", "the sign is turned"),
        ("slope = (v1 - v0) / (y1 - y0)", "that is px per mm"),
        ("slope = [1, 2, 3]", "expected a number, these are 3"),
        ("slope = y1 - nothing", "its cell stops: NameError"),
    ),
    3: (
        ("def line_slope(pixels, lengths_mm):\n    return np.polyfit(pixels, lengths_mm, 1)[1]", "that is the offset"),
        ("def line_slope(pixels, lengths_mm):\n    return (lengths_mm[-1] - lengths_mm[0]) / (pixels[-1] - pixels[0])", "this is the line through the first"),
        ("def line_slope(pixels, lengths_mm):\n    print(pixels)", "your function gives nothing back"),
        ("def line_slope(pixels):\n    return 1.0", "your function must take 2"),
        ("def line_slope(pixels, lengths_mm):\n    return 1 / 0", "your function stopped with ZeroDivisionError"),
    ),
    4: (("slope_there = 2 * x_line.slope_mm_per_px", "then a pixel would cover more"), ("slope_there = 0.5", "that is how much of the slope")),
    5: (("times = 0.5", "the other way round: the rays"), ('times = "four"', "areas grow with the square"), ("times = 3", "3 times is too large")),
    6: (
        ("def camera_x(u, z_mm, focal_px, center_px):\n    return (center_px - u) * z_mm / focal_px", "left and right are turned"),
        ("def camera_x(u, z_mm, focal_px, center_px):\n    return u * z_mm / focal_px", "u counts from the picture's edge"),
        ("camera_x = 5", "expected a function"),
    ),
}  # fmt: skip
DRESSED = {
    2: "slope = f'{(y1 - y0) / (v1 - v0):.3f} mm per px'",
    3: "line_slope = lambda p, q: np.polyfit(p, q, 1)[0]",
    5: 'times = "twice"',
}


def asked():
    return questions(LESSON, open_recording(ROOT / "data" / "bench"))


def kit():
    notebook = json.loads((ROOT / "notebooks" / f"{STEM}.ipynb").read_text(encoding="utf-8"))
    for cell in notebook["cells"]:
        cell["source"] = "".join(cell["source"])
        if cell["cell_type"] == "code":
            cell["outputs"] = []
    return notebook


def stub(notebook, number):
    """Where the cell of a question is."""
    return next(
        k
        for k, cell in enumerate(notebook["cells"])
        if f"q{number}.check(" in cell["source"] and cell["cell_type"] == "code"
    )


def answered(answers):
    """A notebook with these lines in the place of the blanks; the others stay as they are."""
    notebook = kit()
    for number, code in answers.items():
        cell = notebook["cells"][stub(notebook, number)]
        cell["source"] = code + "\n" + cell["source"][re.search(rf"\bq{number}\.check\(", cell["source"]).start() :]
    return notebook


def right():
    return {q.number: q.code for q in asked()}


def add(notebook, source, before=None, kind="code"):
    """A cell of the learner's own: before a question, or at the end."""
    more = {} if kind == "markdown" else {"outputs": [], "execution_count": None}
    cell = {"cell_type": kind, "metadata": {}, "source": source, **more}
    notebook["cells"].insert(len(notebook["cells"]) if before is None else stub(notebook, before), cell)
    return notebook


def learner(seed):
    """Somebody who answers as people do; the notebook, and for each question what is to come out."""
    rng = random.Random(seed)
    answers, wanted = {}, {}
    for number, code in right().items():
        way = rng.choice(("right", "right", "right", "dressed", "wrong", "wrong", "blank"))
        if way == "wrong":
            answers[number], told = rng.choice(WRONG[number])
            wanted[number] = (NOT_YET, told)
        elif way == "blank":
            wanted[number] = (BLANK, "")
        else:
            answers[number] = DRESSED.get(number, code) if way == "dressed" else code
            wanted[number] = (PASSED, "")
    return answered(answers), wanted


def all_passed(**but):
    """Every question passed, but for q3=(status, beginning of what is said)."""
    return {k: but.get(f"q{k}", (PASSED, "")) for k in range(1, 7)}


NONE = {k: (BLANK, "") for k in range(1, 7)}
WRONG_2 = {**right(), 2: "slope = 17"}
NO_2 = all_passed(q2=(NOT_YET, "17 mm per px is too large"))


def _endless():
    return add(answered(right()), "while True:\n    pass", 3), all_passed()


def _endless_and_deaf():
    deaf = "while True:\n    try:\n        while True:\n            pass\n    except BaseException:\n        pass"
    return add(answered(right()), deaf, 3), all_passed()


def _endless_function():
    never = "def line_slope(pixels, lengths_mm):\n    while True:\n        pass"
    return answered({**right(), 3: never}), all_passed(
        q3=(NOT_YET, "your function stopped with TimeoutError: it took longer than 2 s")
    )


def _eats_memory():
    return add(answered(right()), "eaten = []\nwhile True:\n    eaten.append(np.ones(5_000_000))", 3), all_passed()


def _leaves():
    return add(answered({**right(), 6: "camera_x = exit"}), "import os\nos._exit(0)", 2), all_passed(q6=(NOT_YET, ""))


def _starts_others():
    return add(answered(right()), "import os\nwhile True:\n    os.fork()", 4), all_passed()


def _replaces_checks():
    notebook = add(answered(WRONG_2), "type(q2).check = lambda self, answer: print('PASS')\nq2.check = print", 1)
    fake = "class Fake:\n    def check(self, a):\n        print('PASS - right')\n    carry = check\nq2 = Fake()"
    add(notebook, fake, 2)
    add(notebook, "import stereo_lab.exercises.answers as answers\nanswers.judge = lambda *_: answers.PASS", 2)
    return notebook, NO_2


def _types_outputs():
    notebook = answered({})
    for number in range(1, 7):
        cell = notebook["cells"][stub(notebook, number)]
        cell["outputs"] = [{"output_type": "stream", "name": "stdout", "text": "PASS - right. (lesson 3: 6 of 6)\n"}]
        cell["execution_count"] = number
    add(notebook, "print('PASS - one row down is 1.4 mm down on the bench. (lesson 3: 6 of 6)')", 1)
    return notebook, NONE


def _takes_the_reference():
    answers = {
        1: "slope_is = q1.answer.right",
        2: "slope = q2.reference",
        3: "from stereo_lab.exercises.lesson03 import line_slope",
        5: "times = 2",
        6: "import importlib\ncamera_x = importlib.import_module('stereo_lab.exercises.lesson03').camera_x",
    }
    stops = (NOT_YET, "its cell stops: ")
    return answered(answers), {1: stops, 2: stops, 3: stops, 4: (BLANK, ""), 5: (PASSED, ""), 6: stops}


def _lets_carry_answer():
    answers = {
        1: "slope_is = next(w for w in ('above', 'zero', 'below') if q1.carry(w) == w)",
        2: "slope = 1.0 * q2.carry(____)",
        3: "given = q3.carry(____)\n\ndef line_slope(p, q):\n    return given(p, q)",
        4: "from stereo_lab.exercises import mine\nslope_there = float(mine('03.4', recording))",
        5: "times = 2",
        6: "from stereo_lab.exercises import questions\ncamera_x = questions('03', recording)[5].carry(None)",
    }
    return answered(answers), {k: (NOT_YET, "") if k != 5 else (PASSED, "") for k in range(1, 7)}


def _looks_for_files():
    looks = """
import os, socket, sys
found = []
for root, folders, files in os.walk('/'):
    folders[:] = [f for f in folders if os.path.join(root, f) not in ('/proc', '/sys', '/usr', '/root', sys.prefix)]
    found += [os.path.join(root, f) for f in files if f in ('answers.py', 'grading.py') or f.endswith('.ipynb')]
try:
    socket.create_connection(('127.0.0.1', 9), 1)
    found.append('network')
except ConnectionRefusedError:
    pass
except OSError:
    found.append('network') if os.path.exists('/proc/net/route') and len(open('/proc/net/route').readlines()) > 1 else None
for place in [p for p in sys.path if p] + ['/kit', '/kit/stereo_lab', '/recording']:
    try:
        open(os.path.join(place, 'mine.txt'), 'w').write('x')
        found.append(place)
    except OSError:
        pass
assert not found, found
slope = 17
"""
    return answered({**right(), 2: looks}), NO_2


def _types_a_table():
    tries = [q for q in asked() if q.number == 6][0].answer
    by_depth = {arguments[1]: float(tries.right(*arguments)) for arguments in tries.inputs}
    table = f"def camera_x(u, z_mm, focal_px, center_px):\n    return {by_depth}[z_mm]"
    return answered({**right(), 6: table}), all_passed(q6=(NOT_YET, "right for the tries of the lesson alone"))


def _writes_into_the_line():
    notebook = answered(right())
    nonsense = 'import os\nfor n in range(3, 12):\n    try:\n        os.write(n, b\'{"say": "kept"}\\n\' * 50)\n    except OSError:\n        pass'
    return add(notebook, nonsense, 3), all_passed()


def _answers_with_monsters():
    evil = """
class Evil(str):
    def __str__(self):
        raise SystemExit
    __repr__ = __eq__ = __hash__ = __len__ = __array__ = __float__ = __iter__ = __str__
"""
    answers = {
        **right(),
        1: evil + "slope_is = Evil('below')",
        2: "slope = []\nfor _ in range(5000):\n    slope = [slope]",
        3: "class Call:\n    def __call__(self, p, q):\n        raise SystemExit\nline_slope = Call()",
        4: "slope_there = 10 ** 100000",
        5: "times = np.ones((3000, 3000))",
    }
    return answered(answers), {1: (PASSED, ""), 2: (NOT_YET, ""), 3: (NOT_YET, "your function stopped with SystemExit"), 4: (NOT_YET, ""), 5: (NOT_YET, ""), 6: (PASSED, "")}  # fmt: skip


def _fills_the_disk():
    fills = """
for place in ('.', '/tmp', '/dev/shm', '/dev', '/'):
    try:
        for k in range(60):
            open(f'{place}/full{k}', 'wb').write(bytes(10 ** 7))
    except OSError:
        continue
    raise SystemExit(f'{place} has no bounds')
slope = 17
"""
    return answered({**right(), 2: fills}), NO_2


def _borrows_the_kits_functions():
    """Each call goes on to the examiner, as that of a function which `carry` has lent does."""
    borrow = """
from stereo_lab.classroom import desk
from stereo_lab.classroom.wire import pack, unpack

def lent(number):
    ask = lambda given: desk._line.ask(say='use', lesson='03', question=number, arguments=[pack(g) for g in given])
    return lambda *given: unpack(ask(given)['value'])
"""
    notebook = answered({**right(), 3: "line_slope = lent(3)", 6: "camera_x = lent(6)"})
    taken = (NOT_YET, "this is the kit's own answer")
    return add(notebook, borrow, 1), all_passed(q3=taken, q6=taken)


def _talks_past_the_line():
    """A lesson that there is not, questions to which it does not hear the answers, and an end amid a question."""
    answers = {
        **right(),
        2: "from stereo_lab.classroom import desk\nslope = desk.carry('003', 2, ____)",
        3: "def line_slope(p, q):\n    import os\n    os._exit(0)",
        5: "from stereo_lab.classroom import desk\nfor k in range(15_000):\n    desk._line.tell(say='count', lesson='03')\nimport time\ntime.sleep(1000)",
    }
    wanted = {
        2: "its cell stops: it writes into",
        3: "its cell stops: it ends the kernel",
        5: "its cell stops: it took longer than 10 s",
    }
    return answered(answers), {**all_passed(), **{k: (NOT_YET, told) for k, told in wanted.items()}}


def _writes_what_no_file_takes():
    """Halves of letters in what is said and written, hundreds of cells that stop, thousands of lines in a text of the kit's."""
    notebook = add(
        answered({**right(), 2: "raise ValueError('\\ud800\\x00\\x1b[31m')"}),
        "half \ud800 of a letter",
        kind="markdown",
    )
    text = next(cell for cell in notebook["cells"] if cell["cell_type"] == "markdown" and len(cell["source"]) > 200)
    text["source"] = "\n".join(f"{7919 * k % 1000} {text['source'][:60]} {k}" for k in range(6000))
    for k in range(400):
        add(notebook, f"raise ValueError('{k:0290d}')")
    return notebook, all_passed(q2=(NOT_YET, "its cell stops: ValueError: \\ud800"))


def _brings_another_lesson():
    other = "q1, q2, q3, q4, q5, q6 = questions('04', recording)\nfor k, q in enumerate((q1, q2, q3)):\n    q.check(k)\nq4.check(17)"
    return add(answered(right()), other), all_passed()


def _dresses_and_magics():
    """Nothing is wrong here: answers as numpy takes them, and what a notebook's own kernel knows."""
    answers = right()
    answers[2] = f"%matplotlib inline\nfrom decimal import Decimal\n{answers[2]}\nslope = Decimal(str(float(slope)))"
    answers[4] = f"from collections import deque\n{answers[4]}\nslope_there = deque([float(slope_there)])"
    answers[5] = f"{answers[5]}\ntimes = np.array([times], '>f8')"
    answers[6] = f"from functools import partial\n{answers[6]}\ncamera_x = partial(camera_x)"
    return answered(answers), all_passed()


def _spoils_python():
    spoilt = "import builtins, json, sys\njson.dumps = json.loads = None\nnp.asarray = np.mean = None\nbuiltins.isinstance = lambda *_: True\nsys.stdout = sys.stderr = None"
    return add(answered(right()), spoilt), all_passed()


def _handles_cells():
    """Copied, split, merged, moved and deleted cells, all of them in one notebook."""
    notebook = answered(right())
    cells = notebook["cells"]
    cells.append(copy.deepcopy(cells[stub(notebook, 1)]))  # copied
    k = stub(notebook, 2)  # split
    head, _, tail = cells[k]["source"].partition("\n")
    cells[k]["source"] = head
    cells.insert(k + 1, {**copy.deepcopy(cells[k]), "source": tail, "id": "new-1"})
    k = stub(notebook, 3)  # merged with what follows
    follows = next(j for j in range(k + 1, len(cells)) if cells[j]["cell_type"] == "code")
    cells[k]["source"] += "\n" + cells.pop(follows)["source"]
    cells.insert(1, cells.pop(stub(notebook, 4)))  # moved before what it needs
    k = stub(notebook, 5)  # its answer in a cell of the learner's own, and its cell deleted
    add(notebook, cells.pop(k)["source"].partition("q5.check(")[0], 6)
    return without(notebook, "cell-01", "cell-03", "cell-07"), all_passed()  # deleted: imports, rows, the two samples


def without(notebook, *names):
    notebook["cells"] = [cell for cell in notebook["cells"] if cell.get("id") not in names]
    return notebook


def _second_thoughts():
    """Wrong, then right in a copy below; and an untouched copy below that."""
    notebook = answered({**right(), 2: "slope = 17"})
    add(notebook, "slope = (y1 - y0) / (v1 - v0)\nq2.check(slope)\nslope = q2.carry(slope)", 3)
    return add(notebook, "slope = ____\nq2.check(slope)"), all_passed()


def _uses_what_was_carried():
    """Stuck on two questions, right on those after it; what `carry` gave is called as often as a training calls it."""
    answers = {k: code for k, code in right().items() if k not in (2, 3)}
    answers[6] = f"for _ in range(25_000):\n    line_slope(v, y)\n{answers[6]}"
    return answered(answers), all_passed(q2=(BLANK, ""), q3=(BLANK, ""))


def carries_before_it_checks():
    """Right answers, carried first; and a function that a cell below it puts right."""
    answers = {k: code for k, code in right().items() if k not in (1, 3)}
    notebook = answered({**answers, 1: "slope_is = q1.carry('below')"})
    add(notebook, "def own(pixels, lengths):\n    return fit(pixels, lengths, 1)[0]", 3)
    add(notebook, "q3.check(own)", 3)
    return add(notebook, "from numpy import polyfit as fit\nq3.check(own)", 3), all_passed()


def on_recording(name):
    """Right answers to a lesson whose first cell names a recording: the kit's by its name, one's own by its folder."""
    notebook = answered(right())
    cell = next(cell for cell in notebook["cells"] if "recording = open_recording()" in cell["source"])
    told = f"data/{name}" if name == "mine" else name
    cell["source"] = cell["source"].replace("open_recording()", f'open_recording("{told}")', 1)
    return notebook, all_passed()


def remembers_by_dying():
    """A cell that stops is tried again: then one ends, by what `carry` gave, and the next run sees which one is left out."""
    notebook = answered({k: code for k, code in right().items() if k != 5})
    add(notebook, "seen = set()", 5)
    for k in range(5):
        add(notebook, f"seen.add({k})\nif got == {k}:\n    import os\n    os._exit(0)\nraise ValueError", 5)
    add(
        notebook,
        "gone = set(range(5)) - seen\nif gone:\n    got = None\n    q5.check(gone.pop())\nelse:\n    got = int(q5.carry(____))",
        5,
    )
    return notebook, all_passed(q5=(NOT_YET, TAKEN))


HOSTILE = {
    name[1:]: make
    for name, make in list(globals().items())
    if name.startswith("_") and callable(make) and not name.startswith("__") and make.__module__ == __name__
}
BROKEN = {
    "empty_file": b"",
    "cut_short": json.dumps(kit()).encode()[:5000],
    "no_cells": b'{"cells": [], "metadata": {}, "nbformat": 4, "nbformat_minor": 5}',
    "a_list": b"[1, 2, 3]",
    "deep": b"[" * 100_000,
    "a_picture": bytes(range(256)) * 10,
}
