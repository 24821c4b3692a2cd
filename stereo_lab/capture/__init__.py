"""Lesson 08, your own cameras: boards to print, a recorder, and calibrations taken over from elsewhere and given away."""

from stereo_lab.capture.coverage import Bar, Coverage
from stereo_lab.capture.exchange import export_calibration, import_calibration, recording_of
from stereo_lab.capture.films import import_films
from stereo_lab.capture.folder import Folder
from stereo_lab.capture.found import Camera, find_cameras, which_is_covered
from stereo_lab.capture.glance import Glance, glance, sides_without, told_without
from stereo_lab.capture.recorder import Recorder, State
from stereo_lab.capture.session import Replay, Session
from stereo_lab.capture.sheets import PAPERS_MM, Sheet, board_sheet, mark_sheets

__all__ = [
    "PAPERS_MM",
    "Bar",
    "Camera",
    "Coverage",
    "Folder",
    "Glance",
    "Recorder",
    "Replay",
    "Session",
    "Sheet",
    "State",
    "board_sheet",
    "export_calibration",
    "find_cameras",
    "glance",
    "import_calibration",
    "import_films",
    "mark_sheets",
    "recording_of",
    "sides_without",
    "told_without",
    "which_is_covered",
]
