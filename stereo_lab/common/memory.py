"""Memory for one picture after another."""

from __future__ import annotations

import numpy as np

LARGEST = 16_000_000  # bytes; glibc follows up to 32 MB, and a picture of 2560x1920 has 15


def keep_freed_memory() -> None:
    """Let pictures be put where the ones before them lay.

    Linux's C library gives a freed block of a picture's size back to the system, and each new picture then costs hundreds of
    page faults, half a millisecond a pair. It keeps blocks up to the size of the largest one that was ever freed
    (mallopt(3), M_MMAP_THRESHOLD); one is freed here that was never touched. Elsewhere this does nothing.
    """
    np.empty(LARGEST, np.uint8)
