"""Lesson 07: pictures as they come, from a recording, from two cameras, or drawn; and a ball followed in them."""

from stereo_lab.live.bench import DrawnCameras, VirtualBench, round_trip
from stereo_lab.live.cameras import CameraSource
from stereo_lab.live.film import poses_film, reach_film, run_film
from stereo_lab.live.follower import Follower, Step, hand_to_ball
from stereo_lab.live.run import Moment, run
from stereo_lab.live.sources import Frame, RecordingSource, StereoSource, look, open_source, stage_of
from stereo_lab.live.touching import touch_in_turn
from stereo_lab.live.tracker import Track, Tracker

__all__ = [
    "CameraSource",
    "DrawnCameras",
    "Follower",
    "Frame",
    "Moment",
    "RecordingSource",
    "Step",
    "StereoSource",
    "Track",
    "Tracker",
    "VirtualBench",
    "hand_to_ball",
    "look",
    "open_source",
    "poses_film",
    "reach_film",
    "round_trip",
    "run",
    "run_film",
    "stage_of",
    "touch_in_turn",
]
