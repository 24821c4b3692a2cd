"""One thread where a result must not depend on how many cores a computer has."""

from __future__ import annotations

from contextlib import contextmanager

import cv2


@contextmanager
def one_thread():
    """Let OpenCV use one thread inside: sums are then taken in the same order on every computer."""
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield
    finally:
        cv2.setNumThreads(threads)
