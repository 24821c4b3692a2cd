"""Recordings: a folder of pictures from two cameras, and what was in front of them.

The format is described in ``data/README.md``.
"""

from stereo_lab.recording.importing import import_images, import_side_by_side
from stereo_lab.recording.model import Recording
from stereo_lab.recording.needs import with_sets
from stereo_lab.recording.opening import COLORS, open_recording
from stereo_lab.recording.pictures import read_image
from stereo_lab.recording.places import REPOSITORY
from stereo_lab.recording.sample import USUAL_BALL, Ball, Board, Position, Sample, StereoPair
from stereo_lab.recording.swapping import swap_sides
from stereo_lab.recording.video import is_video

__all__ = [
    "COLORS", "REPOSITORY", "USUAL_BALL", "Ball", "Board", "Position", "Recording", "Sample", "StereoPair", "import_images", "import_side_by_side",
    "is_video",
    "open_recording", "read_image", "swap_sides", "with_sets",
]  # fmt: skip
