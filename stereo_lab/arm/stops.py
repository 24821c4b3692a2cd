"""Who stopped the arm, and who knows of it: a stop by one thread must not be undone by another that never heard of it."""

from __future__ import annotations

import threading


class Stops:
    """Stops that this program asked for, numbered from 1.

    Attributes
    ----------
    count : int, how many there were
    undone : int, how many of them a switching-on has undone since
    """

    def __init__(self):
        self.count, self.undone = 0, 0
        self._known = threading.local()  # count: the last stop that this thread asked for or was told of

    def ask(self) -> None:
        """Count a stop that the calling thread asks for."""
        self.count += 1
        self.tell()

    def tell(self) -> None:
        """Note that the calling thread knows of all stops so far."""
        self._known.count = self.count

    @property
    def hold(self) -> bool:
        """Whether the last stop is not undone yet."""
        return self.undone < self.count

    @property
    def are_news(self) -> bool:
        """Whether this thread does not know yet of a stop that holds."""
        return self.hold and getattr(self._known, "count", 0) < self.count
