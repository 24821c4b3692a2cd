"""Lesson 07: pictures as they come, from a recording, from two cameras, or drawn; and a ball followed in them."""

from stereo_lab.live.bench import DrawnCameras, VirtualBench
from stereo_lab.live.cameras import CameraSource
from stereo_lab.live.sources import Frame, RecordingSource, Source, open_source
from stereo_lab.live.tracker import Track, Tracker

__all__ = [
    "CameraSource",
    "DrawnCameras",
    "Frame",
    "RecordingSource",
    "Source",
    "Track",
    "Tracker",
    "VirtualBench",
    "open_source",
]
