"""Lesson 08, your own cameras: boards and marks to print."""

from stereo_lab.capture.sheets import PAPERS_MM, Sheet, board_sheet, mark_sheets

__all__ = ["PAPERS_MM", "Sheet", "board_sheet", "mark_sheets"]
