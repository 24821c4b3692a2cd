"""The table that closes a lesson: paper | its method here | ours."""

from __future__ import annotations

from collections.abc import Sequence


def closing_table(rows: Sequence[Sequence[str]]) -> None:
    """Print rows (what, paper, its method here, ours) in aligned columns; an empty text is a dash.

    Parameters
    ----------
    rows : sequence of four texts each
    """
    table = [("", "paper", "its method here", "ours"), *rows]
    cells = [[str(cell) if cell != "" else "-" for cell in row] for row in table]
    cells[0][0] = ""
    widths = [max(len(row[k]) for row in cells) for k in range(4)]
    for k, row in enumerate(cells):
        print(
            "  ".join(
                [row[0].ljust(widths[0]), *(c.rjust(w) for c, w in zip(row[1:], widths[1:], strict=True))]
            ).rstrip()
        )
        if k == 0:
            print("-" * (sum(widths) + 6))
