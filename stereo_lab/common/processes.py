"""The same work on many things, on all cores of a computer."""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager

import cv2

AT_ONCE = 8  # things that a process takes with it at a time


def on_all_cores(work: Callable, things: Sequence, cores: int) -> Iterator:
    """``work(thing)`` for each of ``things``, in their order.

    Parameters
    ----------
    work : callable, of a module's top level or a ``functools.partial`` of one: it is sent to other processes
    things : sequence
    cores : int
        So many processes; with 1, or where a computer does not let a program start others, this one does it.
    """
    done = 0
    if cores > 1:
        try:
            for answer in _spread(work, things, cores):
                yield answer
                done += 1
        except (OSError, BrokenProcessPool):
            pass
    yield from map(work, things[done:])


def _spread(work, things, cores):
    # "spawn" everywhere: a forked copy of a program whose OpenCV has threads may wait for them for ever
    pool = ProcessPoolExecutor(cores, multiprocessing.get_context("spawn"), _alone)
    try:
        with _interrupts_wait():
            answers = pool.map(work, things, chunksize=AT_ONCE)  # starts all processes
        yield from answers
    finally:
        pool.shutdown(cancel_futures=True)


@contextmanager
def _interrupts_wait() -> Iterator[None]:
    """A Ctrl-C waits until the end of this; a process that starts meanwhile never hears one, not even while Python loads in it."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows: ``_alone`` does what can be done
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _alone():
    """In each of the processes: one thread, and Ctrl-C is for the one that started it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    cv2.setNumThreads(1)
