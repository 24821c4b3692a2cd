"""The blank ``____`` that stands where the learner writes."""

from __future__ import annotations

from typing import Any

import numpy as np


class Blank:
    """Stands for an answer that is not written yet. Whatever is done with it, it stays a blank.

    So ``____ - 3`` or ``____[0]`` in a half-written line does not stop the notebook.
    """

    _the_one = None

    def __new__(cls) -> Blank:
        """The one blank there is."""
        cls._the_one = cls._the_one or super().__new__(cls)
        return cls._the_one

    def __repr__(self):
        return "____"

    def __getattr__(self, name):
        if name.startswith("__") or name.startswith("_repr") or name.startswith("_ipython"):
            raise AttributeError(name)
        return self

    def _stay(self, *_, **__):
        return self

    def __iter__(self):
        return iter((self, self))

    __call__ = __getitem__ = __neg__ = __abs__ = __round__ = _stay
    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = _stay
    __truediv__ = __rtruediv__ = __floordiv__ = __rfloordiv__ = __mod__ = __rmod__ = _stay
    __pow__ = __rpow__ = __matmul__ = __rmatmul__ = _stay
    __array_ufunc__ = __array_function__ = _stay  # what numpy does with a blank is left to the blank


____ = Blank()


def is_blank(answer: Any) -> bool:
    """True for a blank, and for a list, tuple, dictionary or array with a blank in it, however deep."""
    waiting, seen = [answer], set()
    while waiting:
        item = waiting.pop()
        if type(item) is Blank:
            return True
        if id(item) not in seen:  # a list may contain itself
            seen.add(id(item))
            waiting.extend(_parts(item))
    return False


def _parts(item):
    """What is in it. The built-in ways are named: an object of the learner's may have its own, which may fail."""
    if isinstance(item, dict):
        return dict.values(item)
    if isinstance(item, list):
        return list.__iter__(item)
    if isinstance(item, tuple):
        return tuple.__iter__(item)
    if isinstance(item, np.ndarray) and item.dtype == object:
        return item.ravel().tolist()
    return ()
