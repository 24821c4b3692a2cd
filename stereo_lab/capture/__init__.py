"""Lesson 08, your own cameras: boards and marks to print, calibrations taken over from elsewhere and given away."""

from stereo_lab.capture.exchange import export_calibration, import_calibration, recording_of
from stereo_lab.capture.found import Camera, find_cameras, which_is_covered
from stereo_lab.capture.sheets import PAPERS_MM, Sheet, board_sheet, mark_sheets

__all__ = [
    "Camera",
    "find_cameras",
    "which_is_covered",
    "PAPERS_MM",
    "Sheet",
    "board_sheet",
    "export_calibration",
    "import_calibration",
    "mark_sheets",
    "recording_of",
]
