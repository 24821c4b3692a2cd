"""Lesson 07: pictures as they come: from a recording, from two cameras, or drawn."""

from stereo_lab.live.bench import DrawnCameras, VirtualBench
from stereo_lab.live.cameras import CameraSource
from stereo_lab.live.sources import Frame, RecordingSource, Source, open_source

__all__ = ["CameraSource", "DrawnCameras", "Frame", "RecordingSource", "Source", "VirtualBench", "open_source"]
