"""Lesson 07: all of it together. Two pictures in, a place on the bench out."""

from stereo_lab.localization.localizer import Localizer, disparities
from stereo_lab.localization.matching import find_pair

__all__ = ["Localizer", "disparities", "find_pair"]
