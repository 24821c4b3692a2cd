"""The class table as a page: who is where, how many fell for what, and what they wrote."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from pathlib import Path

from stereo_lab.classroom.marks import IN_WORDS, Mark, Row, Tally
from stereo_lab.common.files import write_whole

SIGNS = {"passed": "&#10003;", "not yet": "&#9675;", "not attempted": "&ndash;"}
STYLE = """
body { font: 16px/1.45 system-ui, sans-serif; color: #1a1a1a; margin: 2rem auto; max-width: 75rem; padding: 0 1rem }
table { border-collapse: collapse; margin: 1rem 0 } caption { text-align: left; padding: .3rem 0 }
th, td { border: 1px solid #767676; padding: .3rem .5rem; vertical-align: top; text-align: left }
th { background: #eeeeee } th[scope=row] { min-width: 3rem; max-width: 16rem } th.who[scope=row] { min-width: 8rem }
.wide { overflow-x: auto } th[scope=row], h4, blockquote { overflow-wrap: anywhere }
td small, .notes { color: #444444 } td small, .notes, li { overflow-wrap: anywhere }
.passed { background: #d7ecf7 } .not-yet { background: #fde8c8 }
ul { margin: 0; padding-left: 1.2rem }
blockquote { margin: .5rem 0; padding: .2rem 1rem; border-left: 4px solid #767676; white-space: pre-wrap }
"""


def write_page(path: Path, rows: Sequence[Row], tallies: dict[str, list[Tally]], said: Sequence[str]) -> None:
    """Write the page.

    Parameters
    ----------
    path : Path
    rows : sequence of Row
    tallies : dict, for each lesson its questions
    said : sequence of str, how the class was graded

    Raises
    ------
    StereoLabError
        If it cannot be written.
    """
    parts = ["<!DOCTYPE html>", '<html lang="en"><head><meta charset="utf-8"><title>The class</title>']
    parts += [f"<style>{STYLE}</style></head><body><main><h1>The class</h1>"]
    parts += [f"<p>{escape(sentence)}</p>" for sentence in said]
    for lesson, counts in tallies.items():
        mine = [row for row in rows if row.lesson == lesson]
        parts += [f"<h2>Lesson {escape(lesson)}</h2>", _questions(counts), _class(mine, counts), *_written(mine)]
    odd = [row for row in rows if row.lesson not in tallies]
    if odd:
        parts += ["<h2>Not run</h2><ul>", *(f"<li>{_who(row)}: {_notes(row)}</li>" for row in odd), "</ul>"]
    write_whole(path, "\n".join([*parts, "</main></body></html>\n"]))


def _questions(counts):
    """For each question how many passed, and what the others fell for."""
    lines = []
    for count in counts:
        fell = "".join(f"<li>{n} of {count.learners}: {_theirs(why)}</li>" for why, n in count.fell_for)
        lines.append(
            f'<tr><th scope="row">{count.name}</th><td>{escape(count.asks)}</td><td>{count.passed}</td>'
            f"<td>{count.not_yet}</td><td>{count.not_attempted}</td><td><ul>{fell}</ul></td></tr>"
        )
    heads = "".join(
        f'<th scope="col">{h}</th>' for h in ("No.", "Question", "passed", "not yet", "not attempted", "What was said")
    )
    return _table("How many fell for what", heads, lines)


def _class(rows, counts):
    """A line for each learner."""
    heads = "".join(f'<th scope="col">{h}</th>' for h in ("Learner", "passed", *(c.name for c in counts), "Notes"))
    lines = [
        f'<tr><th scope="row" class="who">{_who(row)}</th><td>{row.passed} of {len(row.marks)}</td>'
        + "".join(map(_mark, row.marks))
        + f"<td>{_notes(row)}</td></tr>"
        for row in rows
    ]
    return _table(f"{len(rows)} learners", heads, lines)


def _table(caption, heads, lines):
    """A table in a box of its own: where it is too wide, the box is moved along, by keys as well, and not the page."""
    return (
        f'<div class="wide" role="region" aria-label="{caption}" tabindex="0"><table><caption>{caption}</caption>'
        f"<thead><tr>{heads}</tr></thead><tbody>{''.join(lines)}</tbody></table></div>"
    )


def _mark(mark: Mark) -> str:
    words = IN_WORDS[mark.counts]
    more = [escape(mark.help), f"teacher: {_theirs(mark.teacher)}" if mark.teacher else ""]
    more += [_theirs(mark.why)] if words != "passed" and mark.why else []
    told = "".join(f"<br><small>{part}</small>" for part in more if part)
    return f'<td class="{words.replace(" ", "-")}">{SIGNS[words]}&nbsp;{words}{told}</td>'


def _written(rows):
    """What learners wrote between the cells, unmarked."""
    texts = [
        f"<h4>{_who(row)}</h4>" + "".join(f"<blockquote>{_theirs(t)}</blockquote>" for t in row.written)
        for row in rows
        if row.written
    ]
    return ["<h3>What they wrote (not marked)</h3>", *texts] if texts else []


def _who(row):
    return _theirs(row.learner)


def _theirs(text):
    """What somebody else wrote: its letters may run from right to left, and the kit's words beside it do not."""
    return f"<bdi>{escape(text)}</bdi>"


def _notes(row):
    return f'<span class="notes">{"; ".join(map(_theirs, row.notes))}</span>'
