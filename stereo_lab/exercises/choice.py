"""An answer that is one of a few words."""

from __future__ import annotations

import re
import reprlib
from dataclasses import dataclass
from typing import Any

from stereo_lab.exercises.reading import (
    ALL_BUT,
    HANGING,
    IN_WORDS,
    NEGATIONS,
    OPEN_WORDS,
    UNSURE,
    before_reason,
    key_words,
    told_beside,
    without_contractions,
    without_contrast,
    without_reason,
)
from stereo_lab.exercises.verdict import NOT_ATTEMPTED, NOT_YET, PASS, Verdict, Wrong

JOINED = re.compile(r"\b(?:and|or)\b")
UNIT = r"(?:[mc]m|m|(?:milli|centi)?met(?:re|er)s?|(?:milli)?seconds?|minutes|hours|pictures|frames)\b"
NUMBER_WORD = re.compile(rf"\b({'|'.join(IN_WORDS)})(?:[\s-]+|\s+an?\s+)(?={UNIT})", re.IGNORECASE)
# "only a ring", "nothing but a ring", "a ring and nothing else" are a ring; "bends it, but only a bit" bends it; "grows and grows" grows
NOTHING_ELSE = re.compile(
    r"^(?:nothing (?:but|other than|else than)|only(?! (?:if|when|while|until|after|for|in|at|near)\b))\s+|,?\s*(?:and|but) nothing (?:else|more)$"
    r"|,?\s*(?:but )?(?:only|just) (?:very )?(?:slightly|an? (?:tiny |little )?(?:bit|little))$",
    re.IGNORECASE,
)
TWICE = re.compile(r"\b(\w+) and \1\b", re.IGNORECASE)
NOT_ONLY = re.compile(r"\bnot (?:only|just|merely) (.+?),?\s(?:but also|but|also)\s", re.IGNORECASE)
# What is taken and what is rejected: "on a stick, not in my fingers", "on a stick, fingers away", "it does not move it, it bends it"
REJECTED = (
    r"(?P<yes>[^,;(]+?)(?:\s*[,;(]|\s+(?=and\s))\s*(?:(?:and|but)\s+)?(?:not|no|never|without)\s+(?P<no>[^,;]+?)\)?",
    r"(?P<yes>[^,;(]+?)\s*[,;(]\s*(?P<no>[^,;]+?)\s+(?:(?:far\s+)?away|off|out of reach)\)?",
    r"(?:it|they)\s+(?:is|are|does|do|will)\s+not\s+(?P<no>[^,;]+?)\s*[,;]\s*(?:but\s+)?(?P<yes>(?:it|they)\s.+)",
)


@dataclass(frozen=True, eq=False)
class Choice:
    """One of a few words.

    Attributes
    ----------
    right : str
    wrong : tuple of Wrong, one for each of the other words
    praise, also : as in :class:`Number`
    same : tuple of (words, other words), other ways to say a thing
    beside : tuple of (words, what to say), for answers that are none of the options and that people give
    not_meant : the same for answers that have the words of an option and mean another thing; these are told first
    """

    right: str
    wrong: tuple[Wrong, ...]
    praise: str
    also: tuple[Any, ...] = ()
    same: tuple[tuple[str, str], ...] = ()
    beside: tuple[tuple[str, str], ...] = ()
    not_meant: tuple[tuple[str, str], ...] = ()

    @property
    def options(self) -> list[str]:
        """All words there are to choose from, sorted."""
        return sorted([self.right, *(w.answer for w in self.wrong)])

    def judge(self, answer: Any) -> Verdict:
        """PASS for the right word, large or small letters; else what is wrong with the other."""
        if isinstance(answer, (list, tuple)) and len(answer) == 1:
            answer = answer[0]
        if isinstance(answer, (int, float)) and not isinstance(answer, bool):
            answer = f"{answer:g}"
        listed = "; ".join(self.options)
        if not issubclass(type(answer), str):
            return Verdict(NOT_YET, f"answer with one of these, in quotes: {listed}.")
        if "____" in answer:
            return Verdict(NOT_ATTEMPTED)
        told = str.strip(answer).lower()
        answer = self._without_rejected(_in_plain_form(str.strip(answer).rstrip(" .!")))
        if message := told_beside(before_reason(answer), self.not_meant):
            return Verdict(NOT_YET, message)
        word = answer.lower()
        meant = self.right if word in self.also else self._meant(answer)
        if self._meant(before_reason(answer)) == self.right:
            meant, answer = self.right, before_reason(answer)
        if meant == self.right:
            if word != self.right and (self._names_another(answer) or self._turns_round(answer)):
                return Verdict(NOT_YET, f"that names two of the answers, or says what it is not. Take one: {listed}.")
            return Verdict(PASS, self.praise)
        if meant is None and not self._lists_several(answer):
            meant = self._meant(without_reason(answer))
        for mistake in self.wrong:
            if meant == mistake.answer:
                return Verdict(NOT_YET, mistake.message)
        if message := told_beside(answer, self.beside):
            return Verdict(NOT_YET, message)
        return Verdict(NOT_YET, f"{self._why_none(word, told)}: {listed}.")

    def _why_none(self, word, told):
        """Why words are none of the options."""
        words = key_words(word)
        if not words or words & UNSURE:
            return "a wrong guess costs nothing. Take one"
        if re.fullmatch(r"[-+]?[\d.,]+", word):
            return "a number is no answer here. Take one, in quotes"
        if "both" in words or sum(key_words(option) <= words for option in self.options) > 1:
            return "these are two of the answers. Take one"
        if re.match(r"(yes|no)\b", word):
            return "this is no question of yes or no. Take one"
        if words & HANGING:
            return "one of these holds in every case. Take one"
        if words & NEGATIONS:
            return f"{reprlib.repr(told)} says what it is not. Say what it is"
        return f"{reprlib.repr(told)} is not among the answers"

    def _without_rejected(self, answer):
        """What is taken of "on a stick, never in my fingers": wrong answers that share no word with the right one are cut off."""
        far_off = {w.answer for w in self.wrong if not key_words(w.answer) & key_words(self.right)}
        for pattern in REJECTED:
            found = re.fullmatch(pattern, answer, re.IGNORECASE)
            if found and self._meant(found["no"]) in far_off:
                return found["yes"]
        return answer

    def _names_another(self, answer):
        """Whether words that mean the right option name a wrong one beside it, or say that it is not the right one."""
        told = self._with_options(answer, [pair for pair in self.same if ".*" not in pair[0]])
        if re.search(rf"\b(?:not|never|no)\s+{re.escape(self.right)}", told):
            return True
        words, its = key_words(told), key_words(self.right)
        others = [key_words(w.answer) for w in self.wrong]
        if any(other - its and other <= words for other in others):
            return True
        parts = [] if JOINED.search(self.right) else JOINED.split(told)
        return len(parts) > 1 and any(self._meant(part) in {w.answer for w in self.wrong} for part in parts)

    def _lists_several(self, answer):
        """Whether plain options stand side by side, with a comma between them."""
        options = [key_words(option) for option in self.options]
        parts = [key_words(part) for part in answer.split(",")]
        return len(set(parts)) > 1 and all(part in options for part in parts)

    def _turns_round(self, answer):
        """Whether a word for the right option, anything else allowed round it, was found beside a "not" that it does not expect."""
        told = self._with_options(answer, [pair for pair in self.same if not key_words(pair[1])])
        if ALL_BUT.search(told):
            return True
        if not key_words(told) & NEGATIONS - key_words(self.right):
            return False
        for words, other in self.same:
            if other == self.right and ".*" in words and re.fullmatch(words, told):
                return not re.search(rf"\b({'|'.join(NEGATIONS)})", re.sub(r"\(\?!.*?\)", "", words))
        return False

    def _with_options(self, answer, same):
        """An answer in small letters, with the options' own words for others."""
        told = without_contrast(str.lower(answer))
        for words, others in same:
            told = re.sub(rf"(?<!\w)(?:{words})(?!\w)", others, told)
        return told

    def _meant(self, answer):
        """The one option that has the same words, or all of the answer's, or whose words the answer has; else None.

        Words that turn a meaning round must stand in the option as well.
        """
        told = self._with_options(answer, self.same)
        words, options = key_words(told), {option: key_words(option) for option in self.options}
        open_words = words & OPEN_WORDS
        for test in (words.__eq__, words.__le__, words.__ge__):
            found = [option for option, its in options.items() if words and its and test(its) and open_words <= its]
            if found:
                return found[0] if len(found) == 1 else None
        return None


def _in_plain_form(answer):
    """An answer with "is not" for "isn't", figures before units, and without words that add nothing to what they stand beside."""
    answer = NUMBER_WORD.sub(lambda found: IN_WORDS[found[1].lower()] + " ", without_contractions(answer))
    return NOTHING_ELSE.sub("", TWICE.sub(r"\1", NOT_ONLY.sub(r"\1 and ", answer)))
