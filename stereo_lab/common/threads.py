"""One thread where a result must not depend on how many cores a computer has."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager

import cv2

_lock = threading.Lock()
_inside = 0  # how many are in one_thread() now
_threads = 0  # what OpenCV used before the first of them came in


@contextmanager
def one_thread() -> Iterator[None]:
    """Let OpenCV use one thread inside: sums are then taken in the same order on every computer.

    OpenCV has one number of threads for the whole program, so whoever leaves last sets it back.
    """
    _enter()
    try:
        yield
    finally:
        _leave()


def _enter():
    global _inside, _threads
    with _lock:
        if _inside == 0:
            _threads = cv2.getNumThreads()
            cv2.setNumThreads(1)
        _inside += 1


def _leave():
    global _inside
    with _lock:
        _inside -= 1
        if _inside == 0:
            cv2.setNumThreads(_threads)
