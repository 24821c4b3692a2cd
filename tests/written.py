"""Results that are written down: held against tests/written/NAME.json, so that no change gets away unseen.

Whoever changes one on purpose runs the test once with STEREO_LAB_WRITE_DOWN=1, and reads the difference.
"""

import json
import os
from pathlib import Path

from tests.printed import differences

FOLDER = Path(__file__).with_name("written")


def assert_as_written(name, lines, room=None):
    """Compare lines of text with those written down: words exactly, numbers with the room of tests/printed.py.

    Parameters
    ----------
    name : str, file and entry, as in "plots/heat"
    lines : list of str
    room : dict, optional; see :class:`tests.printed.Printed`
    """
    file, entry = name.split("/", 1)
    path = FOLDER / f"{file}.json"
    known = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    if os.environ.get("STEREO_LAB_WRITE_DOWN"):
        path.parent.mkdir(exist_ok=True)
        known[entry] = lines
        path.write_text(json.dumps(known, indent=1, ensure_ascii=False, sort_keys=True) + "\n", encoding="utf-8")
    assert entry in known, f"{name} is not written down yet"
    found = differences("\n".join(known[entry]), "\n".join(lines), room)
    assert not found, f"{name}: written down | now: " + "; ".join(f"{a!r} | {b!r}" for a, b in found[:5])
