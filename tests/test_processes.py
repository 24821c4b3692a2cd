"""Work spread over processes: the same answers, in their order, whatever the computer allows."""

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from concurrent.futures.process import BrokenProcessPool
from functools import partial

import pytest

from stereo_lab.common import processes
from stereo_lab.common.processes import on_all_cores
from stereo_lab.errors import RecordingError


def square(number):
    return number * number


def where(_):
    return os.getpid()


def refuse(wrong, number):
    if number == wrong:
        raise RecordingError(f"number {number} is not wanted")
    return number


@pytest.mark.parametrize("cores", [1, 2])
def test_answers_come_in_order(cores):
    assert list(on_all_cores(square, range(21), cores)) == [n * n for n in range(21)]


def test_the_work_is_done_by_others():
    assert os.getpid() not in set(on_all_cores(where, range(20), 2))
    assert set(on_all_cores(where, range(20), 1)) == {os.getpid()}


@pytest.mark.parametrize("cores", [1, 2])
def test_what_is_raised_there_is_raised_here(cores):
    answers = on_all_cores(partial(refuse, 9), range(20), cores)
    with pytest.raises(RecordingError, match="number 9"):
        list(answers)
    assert not multiprocessing.active_children()


@pytest.mark.parametrize("trouble", [PermissionError("no processes here"), BrokenProcessPool("killed")])
def test_the_rest_is_done_here_where_others_are_lost(monkeypatch, trouble):
    def some(work, things, cores):
        yield from map(work, things[:5])
        raise trouble

    monkeypatch.setattr(processes, "_spread", some)
    assert list(on_all_cores(square, range(12), 2)) == [n * n for n in range(12)]


@pytest.mark.skipif(os.name == "nt", reason="Windows sends Ctrl-C another way")
def test_ctrl_c_ends_all_of_them_without_a_word(tmp_path):
    """The second of two processes takes its time to start, so Ctrl-C comes while it does."""
    script = tmp_path / "busy.py"
    script.write_text(
        "import multiprocessing, time\nfrom stereo_lab.common.processes import on_all_cores\n"
        "if multiprocessing.current_process().name.endswith('2'):\n    time.sleep(1.5)\n"
        "def slow(n):\n    time.sleep(0.05)\n    return n\n"
        "if __name__ == '__main__':\n"
        "    try:\n        for n in on_all_cores(slow, range(10_000), 2):\n            print(n, flush=True)\n"
        "    except KeyboardInterrupt:\n        print('ended', flush=True)\n"
    )
    run = subprocess.Popen(
        [sys.executable, script], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    assert run.stdout.readline() == "0\n"
    os.killpg(run.pid, signal.SIGINT)
    out, err = run.communicate(timeout=60)
    assert (out[-6:], err, run.returncode) == ("ended\n", "", 0)
    with pytest.raises(ProcessLookupError):
        for _ in range(100):
            os.killpg(run.pid, 0)
            time.sleep(0.1)
