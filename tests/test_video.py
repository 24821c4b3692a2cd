"""Videos through cv2.VideoCapture, and a colour that marks itself."""

import json

import cv2
import numpy as np
import pytest

from stereo_lab.cli import main
from stereo_lab.errors import RecordingError
from stereo_lab.recording.video import count_frames, is_video, read_video


@pytest.fixture(scope="module")
def film(bench, tmp_path_factory):
    """The first 20 pairs of the set track, left pictures, as a compressed video."""
    path = tmp_path_factory.mktemp("film") / "track.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 10, tuple(bench.image_size))
    for pair in bench.pairs("track")[:20]:
        writer.write(pair.left)
    writer.release()
    return path


def test_a_video_is_read_frame_by_frame(film):
    assert is_video(film) and not is_video("000.jpg")
    frames = list(read_video(film))
    assert len(frames) == count_frames(film) == 20 and frames[0].shape == (480, 640, 3)


def test_detect_follows_the_ball_through_a_video(film, bench, tmp_path, capsys):
    assert main(["detect", str(film), "--learn", "--json", str(tmp_path / "d.json")]) == 0
    said = capsys.readouterr()
    assert "learned from 6 balls" in said.err and "frame 19: u" in said.out
    rows = json.loads((tmp_path / "d.json").read_text())
    off = []
    for row, pair in zip(rows, bench.pairs("track"), strict=False):
        u, v, _ = bench.true_ball("track", pair.name)["left"]
        off.append(np.hypot(row["detection"]["u"] - u, row["detection"]["v"] - v))
    assert [row["frame"] for row in rows] == list(range(20)) and np.median(off) < 0.3 and max(off) < 3


@pytest.mark.parametrize(("content", "says"), [(b"not a video at all", "no video"), (b"", "no video")])
def test_what_is_no_video_is_refused(tmp_path, content, says):
    path = tmp_path / "film.mp4"
    path.write_bytes(content)
    with pytest.raises(RecordingError, match=says):
        list(read_video(path))
    with pytest.raises(RecordingError, match="Cannot read"):
        count_frames(tmp_path / "nowhere.mp4")
