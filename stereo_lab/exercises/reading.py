"""What a learner's answer says: numbers and words out of whatever was typed."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

import numpy as np

NUMBER = re.compile(r"(?<![\d.θ])(?<!theta)[-+]?\d+(?:\.\d+)?")
PARTS = {"½": ".5", "¼": ".25", "¾": ".75"}
NAMES = ("zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve")
TENS = ("twenty", "thirty", "forty", "fifty", "sixty", "seventy", "eighty", "ninety")
IN_WORDS = {name: str(k) for k, name in enumerate(NAMES)} | {name: str(20 + 10 * k) for k, name in enumerate(TENS)} | {
    "once": "1", "twice": "2", "double": "2", "doubles": "2", "doubled": "2", "half": "0.5",
}  # fmt: skip
# Words that turn round what stands beside them, or leave it open: then only the plain answer counts
OPEN_WORDS = frozenset((
    "not", "no", "nor", "neither", "never", "cannot", "can", "isn", "wasn", "aren", "don", "doesn", "didn", "won",
    "hardly", "barely", "without", "or", "and", "wrong", "false", "useless", "opposite", "instead", "only", "less",
    "more", "smaller", "larger", "bigger", "farther", "further", "under", "over", "above", "below", "almost",
    "half", "filled",
))  # fmt: skip
NEGATIONS = frozenset((
    "not", "no", "nor", "neither", "never", "without", "hardly", "barely", "isn", "wasn", "aren", "doesn", "didn",
    "won",
))  # fmt: skip
ALL_BUT = re.compile(r"\b(anything|everything|anywhere|nothing|all) (but|except)\b")
HANGING = frozenset(["depend", "vary", "vari", "sometim"])
UNSURE = frozenset(["know", "idea", "guess", "unsure", "sure", "maybe"])
NO_NUMBERS = OPEN_WORDS - {"above", "below", "half"} | {
    "hundred", "thousand", "million", "dozen", "small", "anything", "everything", "except",
}  # fmt: skip
NOT_AFTER = "is|was|are|were|do|does|did|has|have|had|could|would|should|must|need"
CODE = re.compile(
    r"\s*[a-z]\d\s*$|\s*[-+]?[\d.]+\s*([*]\s*[a-z_(]|π|pi\b)|\s*[a-z_]\w*(?!\s+[-+]\d)\s*[-+*/]\s*[\w(]|.*[a-z]\w*(\.[a-z_]|\[|\(|_\w)",
    re.IGNORECASE,
)
# Numbers alone with * or / between them, as 4094.4 / 2
TO_WORK_OUT = re.compile(r"(?=.*[\d)]\s*[*/]{1,2}\s*[\d.(])[-+*/().\d\s]+")
# How exact a number is, beside it: "50 ± 1 mm"
ROOM = re.compile(
    r"(?<=\d)([^\d±]*?),?\s*(?:±|\+\s*/?\s*[-–]|\bplus\s*(?:or|/)?\s*minus\b|\bgive or take\b)\s*\d+(?:[.,]\d+)?\s*(?:%|([a-zµμ°]*))"
)
A_RATE = "edges a second"  # what hertz count here
A_LITTLE = r"(?:(?:an?\s+(?:little\s+|tiny\s+)?(?:bit|little)|slightly|just|somewhat)\s+)?"
BOUNDS = (
    (rf"\b{A_LITTLE}(more\s+than|over|above)\s+(?=[-−.\d]|half\s)|,?\s+and\s+(an?\s+)?((little\s+)?bit|little|more)(\s+more)?$", 1),
    (rf"\b({A_LITTLE}(less\s+than|under|below)|almost)\s+(?=[-−.\d]|half\s)", -1),
)  # fmt: skip
RANGE = r"(?:[-–—]|(?:(?:up|down)\s+)?to|till|until)"  # what stands between its two ends
# "one" for a thing and not for a number: "a wider one", "one that is twice as wide"
SOME_ONE = re.compile(r"\b(?:an?|the)\s+[a-z]+\s+one\b|^(?:the\s+)?one\s+(?=(?:that|which|with|twice|double)\b)")
FOLD = re.compile(rf"\b({'|'.join(IN_WORDS)})-?(?=(?:fold|times)\b)", re.IGNORECASE)  # "twofold", "two-times"
# "twenty-four", "24 1/2"
TENS_AND_ONES = re.compile(rf"\b({'|'.join(TENS)})[\s-]({'|'.join(NAMES[1:10])})\b")
FRACTION = re.compile(r"(?<![\d./])(?:(\d+)\s+)?([1-9])\s?/\s?([2-9]|10)(?![\d/])")
A_SECOND = re.compile(r"\s*(/|\b(per|in|within|an?|each|every)\b)\s*(1|one)?\s*(s|sec|seconds?)\b|\bs(\^-1|⁻¹)")
# What a unit measures, and how many of the kit's unit it is
UNITS = {
    **dict.fromkeys(("mm", "millimetre", "millimetres", "millimeter", "millimeters"), ("mm", 1)),
    **dict.fromkeys(("cm", "centimetre", "centimetres", "centimeter", "centimeters"), ("mm", 10)),
    "dm": ("mm", 100), **dict.fromkeys(("m", "metre", "metres", "meter", "meters"), ("mm", 1000)), "km": ("mm", 1e6),
    **dict.fromkeys(("µm", "μm", "um", "micrometre", "micrometres"), ("mm", 0.001)), **dict.fromkeys(("inch", "inches"), ("mm", 25.4)),
    **dict.fromkeys(("px", "pixel", "pixels"), ("px", 1)), **dict.fromkeys(("%", "percent"), ("%", 1)),
    **dict.fromkeys(("ms", "millisecond", "milliseconds"), ("ms", 1)), **dict.fromkeys(("s", "second", "seconds"), ("ms", 1000)),
    **dict.fromkeys(("°", "deg", "degree", "degrees", "grad"), ("degrees", 1)), **dict.fromkeys(("rad", "radian", "radians"), ("degrees", 180 / np.pi)),
    **dict.fromkeys(("turn", "turns", "rev", "revs", "revolution", "revolutions", "rotation", "rotations", "circle", "circles"), ("degrees", 360)),
    **dict.fromkeys(("min", "minute", "minutes"), ("ms", 60_000)),
    **dict.fromkeys(("v", "volt", "volts"), ("V", 1)), "mb": ("MB", 1), "hz": (A_RATE, 1), "khz": (A_RATE, 1000), "kg": ("g", 1000), "g": ("g", 1),
    # and those that nobody needs here, lest a number in one of them be taken for the right one
    "rpm": ("turns a minute", 1), **dict.fromkeys(("wave", "waves"), ("waves", 1)), "nm": ("mm", 1e-6), **dict.fromkeys(("ft", "foot", "feet"), ("mm", 304.8)), **dict.fromkeys(("yd", "yard", "yards"), ("mm", 914.4)),
    **dict.fromkeys(("µs", "μs", "us", "microsecond", "microseconds"), ("ms", 0.001)), **dict.fromkeys(("ns", "nanosecond", "nanoseconds"), ("ms", 1e-6)),
    **dict.fromkeys(("h", "hour", "hours"), ("ms", 3_600_000)), "mrad": ("degrees", 0.18 / np.pi),
    **dict.fromkeys(("arcmin", "arcminutes"), ("degrees", 1 / 60)), **dict.fromkeys(("arcsec", "arcseconds"), ("degrees", 1 / 3600)),
    "gon": ("degrees", 0.9),
}  # fmt: skip
# What is counted, and is no measure
THINGS = re.compile(rf"{NUMBER.pattern}\s*(pairs?|pictures?|frames?|boards?|steps?|edges?)\b")
# What may stand beside the numbers of a board's columns and rows
ACROSS = ("across", "columns", "column", "wide", "horizontal", "horizontally", "left")
DOWN = ("down", "rows", "row", "high", "vertical", "vertically", "top")
IN_A_ROW, IN_A_COLUMN = (
    re.compile(rf"\b(in|per)\s+((an?|the|each|every|one)\s+)?(\w+\s+)?{of}\b") for of in ("row", "column")
)
SMALL_WORDS = frozenset(("a", "an", "the", "it", "its", "in", "on", "of", "is", "to", "ones"))


def numbers_in(text: str, count: int, unit: str = "", labels: tuple[frozenset[str], ...] = ()) -> list[float] | str:
    """The numbers in a text, with their units, in words, with a decimal comma; or a sentence on why there are none.

    Parameters
    ----------
    text : str
    count : int, of numbers that are asked for
    unit : str, that is asked for; another one of the same kind is converted
    labels : for each number the words that may stand beside it, where their order is not to matter
    """
    text = re.sub(r"^\s*(pi|π)(?=\s*rad)", f"{np.pi}", text, flags=re.I)
    text = re.sub(r"^\s*(?:(?:an?|one)\s)?half[\s-](an?\s)?(?=[a-z])", "0.5 ", text, flags=re.I)
    text = TENS_AND_ONES.sub(lambda part: f"{IN_WORDS[part[1].lower()][0]}{IN_WORDS[part[2].lower()]}", text)
    text = FOLD.sub(lambda word: f"{IN_WORDS[word[1].lower()]} ", text)
    if count > 1:
        text = re.sub(r"(?<=\d)\s*\*\s*(?=\d)", " x ", text)  # 9*6
    if CODE.match(text.rpartition("=")[2]) or count == 1 and _is_to_work_out(text, unit):
        return "this is Python in quotes. Take the quotes away, and Python works it out."
    plain = text.lower().replace("−", "-").rpartition("=")[2].strip().rstrip(" .")
    plain = re.sub(r"(?<=\d)\s?([½¼¾])|([½¼¾])", lambda part: PARTS[part[1] or part[2]], plain)  # 24½
    plain = re.sub(r"(?<![\d.])\.(?=\d)", "0.", plain)  # .05
    plain = re.sub(r"(?<=\d)\s*(?:\.{2,}|…)\s*(?=[-\d])", " to ", plain)  # 7...8
    plain = re.sub(r"(?<=\d)\s*in$", " inches", plain)
    plain = re.sub(r"(?<=\d)\s+1\s*/\s*s$", " /s", plain)
    plain = re.sub(r"\s+or (more|so|thereabouts)\b", "", ROOM.sub(_without_room, plain))
    plain = re.sub(r"^(?=\d)(.*\d\D*)\bbelow (zero|0)$", r"-\1", plain)
    if unit == A_RATE:
        plain = A_SECOND.sub(" hz", plain)
    if count == 1:
        plain = re.sub(r"(?<=\d)\s(?=\d{3}(\D|$))", "", plain)  # 2 047
        plain = FRACTION.sub(lambda part: f"{int(part[1] or 0) + int(part[2]) / int(part[3]):g}", plain)
    if unit == "of 255":
        plain = re.sub(r"(out\s+of|of|/)\s*255$", "", plain).strip()
    plain = SOME_ONE.sub("", plain) if count == 1 else plain
    if unit == "times":
        plain = re.sub(r"^(just )?(as large|the same|same|equal|unchanged)( as .*)?$", "1", plain)
    plain = re.sub(r"[a-z]+", lambda word: IN_WORDS.get(word[0], word[0]), plain)
    plain = re.sub(r"(?<=\d)\s+and\s+(?:a|1)\s+0\.5\b", ".5", plain)  # 24 and a half
    plain = re.sub(r"(?<=\d)\s+point\s+(?=\d)", ".", plain)
    plain = re.sub(r"\b(minus|negative)\s+(?=\d)|^[-–]\s*\(?\s*(?=\d)", "-", plain)
    if (NO_NUMBERS if count == 1 else NO_NUMBERS - {"and"}) & set(re.findall(r"[a-z]+", plain)):
        return _no_number(plain, count)
    plain = re.sub(r"(?<=\d),(?=\d{3}\.\d)|(?<=\d)\.(?=\d{3},\d)", "", plain)  # 2,047.2 and 2.047,2
    decimal_commas = re.sub(r"(?<=\d),(?=\d)", ".", plain)
    for parts in (plain, decimal_commas) if decimal_commas.count(".") - plain.count(".") <= count else (plain,):
        found = NUMBER.findall(parts)
        if len(found) == count:
            numbers = [float(number) for number in found]
            return _converted(numbers[0], parts, unit) if count == 1 else _in_order(numbers, parts, labels)
    with_unit = _with_its_unit(plain, unit) if count == 1 and unit.isalpha() else None
    return _no_number(plain, count) if with_unit is None else [with_unit]


def _with_its_unit(text, unit):
    """The one number of several that the unit stands beside, as in "twice as much, 241 mm".

    None where it is the end of a range, as in "0 to 50 mm", or where another measure stands beside it, as in "3 degrees, 8 mm".
    """
    found = re.findall(rf"({NUMBER.pattern})\s*{unit}\b", text)
    if len(found) != 1 or re.search(rf"\d\s*{RANGE}\s*{re.escape(found[0])}\s*{unit}\b", text):
        return None
    right = float(found[0])
    measures = re.findall(rf"({NUMBER.pattern})\s*([a-zµμ]+|[°%])", text)
    beside = [(float(number), UNITS[word]) for number, word in measures if word in UNITS]
    same = all(number == 1 or (kind, number * scale) == (unit, right) for number, (kind, scale) in beside)
    return right if same else None


def _is_to_work_out(text, unit):
    """Whether numbers are yet to be worked out: more than a fraction, as 1/2, and more than a part of 255."""
    text = text.rpartition("=")[2].strip()
    of_255 = unit == "of 255" and text.endswith("255")
    return bool(TO_WORK_OUT.fullmatch(text)) and not FRACTION.fullmatch(text) and not of_255


def _without_room(found):
    """What stands before a ±; the unit behind it is that of both numbers where none stands before."""
    return found[1] if found[1].strip() else f" {found[2] or ''}"


def without_bound(text: str) -> tuple[str, int]:
    """The text without "more than" or "almost", and 1 where it means more than its number, −1 where less, else 0."""
    for words, side in BOUNDS:
        if re.search(words, text.rstrip(" ."), re.IGNORECASE):
            return re.sub(words, " ", text.rstrip(" ."), flags=re.IGNORECASE), side
    return text, 0


def _no_number(text, count):
    """What to say to a text that does not tell what is asked for."""
    found = NUMBER.findall(text)
    if count == 1 and len(set(found)) > 1 and not re.search("hundred|thousand|million", text):
        return f"expected a number, and in this text there are {len(found)}. Write the one that is asked for."
    asked, them = ("a number", "the number") if count == 1 else (f"{count} numbers", "them")
    return f"expected {asked}, this is a text. Write {them} alone, in figures."


def _converted(number, text, unit):
    """The one number in the unit that is asked for; where none is, whatever was written beside it does not matter."""
    if not unit:
        return [number]
    told = re.sub(r"\s*/\s*", " per ", re.sub(r"[()\[\]]", "", NUMBER.sub("", text))).strip()
    if " per " in told or " per " in unit:
        above, _, below = ([UNITS.get(word, (word, 1)) for word in part.split()] for part in told.partition(" per "))
        other_rate = " per " in told and [name for name, _ in (*above, ("per", 1), *below)] != unit.split()
        a_speed = UNITS.get(told.rpartition(" ")[2], ("",))[0] == "ms" and " per " in told
        another = other_rate if " per " in unit or unit == A_RATE else a_speed
        if told in UNITS:  # "1.4 mm" may leave "per px" away; "1.4 px" is another thing
            another = UNITS[told] != UNITS[unit.partition(" ")[0]]
        scale = above[0][1] / below[0][1] if " per " in told and " per " in unit and not another else 1
        return f"{unit} is asked for, this is {told}." if another else [number * scale]
    things = THINGS.search(text)
    if things and not (unit == A_RATE and things[1].startswith("edge")):
        return f"{unit} is asked for, this is {things[1]}."
    if "²" in told or "square" in told:
        return f"{unit} is asked for, this is {told}."
    known = [UNITS[word] for word in re.findall(r"[a-zµμ]+|[°%]", told) if word in UNITS]
    if unit == A_RATE and any(kind != unit for kind, _ in known):
        return f"{unit} is asked for, this is {told.replace('hz', 'a second')}."
    measures, scale = next((u for u in known if u[0] == unit), known[0] if known else (unit, 1))
    if measures == unit:
        turned = unit == "degrees" and re.search(r"(?<![a-z-])(clockwise|cw)\b", told)  # plus is counter-clockwise
        return [-number * scale if turned else number * scale]
    return (
        f"{unit} is asked for, this is {told}."
        if unit in dict(UNITS.values())
        else f"a bare number is asked for, without {told}."
    )


def _in_order(numbers, text, labels):
    """Numbers with labels beside them in the order of the labels."""
    text = IN_A_COLUMN.sub("down", IN_A_ROW.sub("across", text))
    beside = re.split(NUMBER, text)
    for sides in (beside[1:], beside[:-1]):  # the words after each number, or before it
        said = [frozenset(re.findall(r"[a-z]+", side)) for side in sides]
        places = [next((k for k, words in enumerate(said) if words & label), None) for label in labels]
        if labels and None not in places and len(set(places)) == len(places):
            return [numbers[k] for k in places]
    # "6 rows of 9", "6 rows, 9 in each": the second number is how many are in a row
    named = [k for k, label in enumerate(labels) if label & frozenset(re.findall(r"[a-z]+", beside[1]))]
    in_each = re.search(r"\b(of|with)\s*$", beside[1]) or re.search(r"\beach\b", beside[-1])
    if in_each and len(numbers) == 2 and len(named) == 1:
        return numbers if named == [0] else numbers[::-1]
    return numbers


def without_contractions(text: str) -> str:
    """The text with "is not" for "isn't", and so on; the apostrophe may be missing."""
    text = re.sub(r"\bcan['’]?t\b", "can not", re.sub(r"\bwon['’]t\b", "will not", text, flags=re.I), flags=re.I)
    return re.sub(rf"\b({NOT_AFTER})n['’]?t\b", r"\1 not", text, flags=re.I)


def key_words(text: str) -> frozenset[str]:
    """The words of a short answer that matter: small letters, no quotes, full stops and small words, no s or ing at the end."""
    words = frozenset(re.findall(r"[^\W_]+", text.lower())) - SMALL_WORDS
    return frozenset(re.sub(r"(?<=\w{3})(ing|es|s)$", "", word) for word in words)


def without_contrast(text: str) -> str:
    """What is meant by "right, not left" and by "not left, but right"."""
    found = re.fullmatch(
        r"\s*not\s+(?P<no>[^,;]*)([,;]|\s+but\s)\s*(but\s+)?(?P<yes>(?!\s*then\b).*)", text, re.IGNORECASE
    )
    found = found or re.fullmatch(
        r"(?P<yes>[^,;]*)[,;]\s*((and|but)\s+)?((it|they)\s+)?((is|are|was|were|does|do|did)\s+)?not\s+(?P<no>.*)",
        text,
        re.IGNORECASE,
    )
    return found["yes"] if found else text


def without_reason(text: str) -> str:
    """What is said before a reason for it, or before a comma."""
    return re.split(r"\W+(?:because|since|as|so|for|due)\W|[,;:(]", text, maxsplit=1, flags=re.IGNORECASE)[0]


def before_reason(text: str) -> str:
    """What is said before words, or an equation in brackets, that begin a reason or what was not taken, and that begin nothing else."""
    begins = r"\s(?:because|since|so that|instead of|rather than|to keep|to protect)\s|,\s*as\s(?!\w+ as\b|before\b)|\s\((?=.*=)"
    return re.split(begins, text, maxsplit=1, flags=re.IGNORECASE)[0].rstrip(" ,;")


def told_beside(answer: str, beside: Sequence[tuple[str, str]]) -> str:
    """What to say to words that people give and that are no answer here; "" to all others.

    ``beside``: (pattern of the words, what to say); large letters, blanks and what stands round the words do not count.
    """
    words = " ".join(str(answer).lower().strip().strip(" .!?'\"").split())
    return next((message for pattern, message in beside if re.fullmatch(pattern, words)), "")


def as_numbers(answer: Any) -> np.ndarray:
    """The answer as an array of floats.

    Raises
    ------
    TypeError
        For True and False, which Python counts as 1 and 0, and for complex numbers.
    """
    parts = answer if isinstance(answer, np.ndarray) else np.asarray(answer, object).ravel()
    if parts.dtype.kind in "bc" or (
        parts.dtype == object and any(isinstance(part, (bool, np.bool_, complex)) for part in parts.ravel())
    ):
        raise TypeError("no plain number")
    return np.asarray(answer, float)
