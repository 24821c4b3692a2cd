"""What is said to an answer, and what is known of the wrong ones."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

PASS, NOT_YET, NOT_ATTEMPTED = "PASS", "NOT YET", "NOT ATTEMPTED"


@dataclass(frozen=True)
class Verdict:
    """What is said to an answer.

    Attributes
    ----------
    status : PASS, NOT_YET or NOT_ATTEMPTED
    text : str, a sentence
    """

    status: str
    text: str = ""

    def __str__(self):
        said = f"{self.status} - {self.text}" if self.text else self.status
        return said.encode("utf-8", "backslashreplace").decode("utf-8")  # an answer may hold what cannot be printed


@dataclass(frozen=True, eq=False)
class Wrong:
    """A mistake that people make.

    Attributes
    ----------
    answer : an answer that shows it, of the same kind as the right one
    message : str, what to say to it
    exact : bool, for a number that comes near to the right one by chance: it is this mistake where it is just this number
    """

    answer: Any
    message: str
    exact: bool = False
