"""Lesson 08: what is wrong with a recording, in plain words, and what it costs in millimetres.

The doctor looks at the boards, at how the pairs go together, at what the calibration knows, at the ball, and at the ruler's
numbers. Each mistake that people make is undone in turn; the one whose undoing makes everything agree is named. Then it looks again,
until nothing is left. ``examine`` is the recipe.
"""

from stereo_lab.doctor.examine import check_recording
from stereo_lab.doctor.findings import Checkup, Evidence, Finding
from stereo_lab.doctor.patients import Healthy, admit, healthy
from stereo_lab.doctor.spoiling import FAULTS, spoil

__all__ = ["FAULTS", "Checkup", "Evidence", "Finding", "Healthy", "admit", "check_recording", "healthy", "spoil"]
