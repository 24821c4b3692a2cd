"""What this program costs its computer."""

from __future__ import annotations

import time
from collections import deque

import psutil

OVER_S = 1.0  # a clock of processors ticks a hundred times a second: shorter looks tell nothing


class Usage:
    """CPU and memory of this program, told anew every second.

    Attributes
    ----------
    cpu_percent : float, of one core, over the last second; 0 before that
    rss_mb : float, memory that lies in the computer's RAM
    """

    def __init__(self) -> None:
        self._process = psutil.Process()
        self._looks = deque([self._look()], maxlen=2)
        self.cpu_percent, self.rss_mb = 0.0, self._process.memory_info().rss / 1e6

    def update(self) -> None:
        """Look again, where a second has passed."""
        if time.monotonic() - self._looks[-1][0] < OVER_S:
            return
        self._looks.append(self._look())
        (then_s, before), (now_s, after) = self._looks
        self.cpu_percent = 100 * (after - before) / (now_s - then_s)
        self.rss_mb = self._process.memory_info().rss / 1e6

    def _look(self):
        times = self._process.cpu_times()
        return time.monotonic(), times.user + times.system
