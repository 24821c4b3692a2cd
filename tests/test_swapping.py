"""Cameras named the wrong way round: told, and put right on request."""

import json
import os
import shutil

import pytest

from stereo_lab.calibration import calibrate_anew
from stereo_lab.cli import main
from stereo_lab.errors import RecordingError, SwappedSidesError
from stereo_lab.recording import open_recording, swap_sides


@pytest.fixture
def swapped(bench, tmp_path):
    """Eight pairs of the bench's boards in a camera recording whose folders are exchanged, and a set of one camera."""
    folder = tmp_path / "mine"
    for side, other in (("left", "right"), ("right", "left")):
        (folder / "calibration" / side).mkdir(parents=True)
        for pair in bench.pairs("calibration")[:8]:
            source = getattr(pair, f"{other}_path")
            shutil.copy(source, folder / "calibration" / side / source.name)
    (folder / "snaps" / "left").mkdir(parents=True)
    shutil.copy(bench.pairs("snaps")[0].left_path, folder / "snaps" / "left")
    text = (bench.path / "recording.json").read_text(encoding="utf-8").replace('"render"', '"camera"')
    (folder / "recording.json").write_text(text, encoding="utf-8")
    return folder


def test_the_swap_is_offered_and_done(swapped, capsys):
    with pytest.raises(SwappedSidesError, match="mirror images.* calibrate .*mine --swap"):
        calibrate_anew(open_recording(swapped))
    first = (swapped / "calibration" / "left" / "000.jpg").read_bytes()
    assert main(["calibrate", str(swapped), "--swap"]) in (0, 1)
    said = capsys.readouterr()
    assert "verdict:" in said.out and "stay as they are: snaps" in said.err
    assert (swapped / "calibration" / "right" / "000.jpg").read_bytes() == first
    assert sorted(p.name for p in (swapped / "calibration").iterdir()) == ["left", "right"]
    assert sorted(p.name for p in (swapped / "snaps").iterdir()) == ["left"]


@pytest.mark.parametrize("end", [KeyboardInterrupt, PermissionError(13, "No")])
def test_a_swap_that_is_broken_off_is_taken_back(swapped, monkeypatch, end):
    before = {path.relative_to(swapped): path.read_bytes() for path in swapped.rglob("*.jpg")}
    renames, rename = iter([False, False, True]), os.rename

    def broken_off(*names):
        if next(renames, False):
            raise end
        rename(*names)

    monkeypatch.setattr(os, "rename", broken_off)
    with pytest.raises((KeyboardInterrupt, RecordingError)):
        swap_sides(open_recording(swapped))
    assert {path.relative_to(swapped): path.read_bytes() for path in swapped.rglob("*.jpg")} == before


def test_cameras_that_stand_rightly_stay_as_they_are(swapped, capsys):
    assert main(["calibrate", str(swapped), "--swap"]) in (0, 1)
    first = (swapped / "calibration" / "left" / "000.jpg").read_bytes()
    assert main(["calibrate", str(swapped), "--swap"]) == 2
    assert "stood as they should: nothing was renamed" in capsys.readouterr().err
    assert (swapped / "calibration" / "left" / "000.jpg").read_bytes() == first


def test_where_nothing_comes_of_it_the_folders_are_as_they_were(swapped, monkeypatch):
    first = (swapped / "calibration" / "left" / "000.jpg").read_bytes()
    monkeypatch.setattr("stereo_lab.calibration.calibrate_anew", lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
    assert main(["calibrate", str(swapped), "--swap"]) == 130
    assert (swapped / "calibration" / "left" / "000.jpg").read_bytes() == first


def test_boards_and_balls_of_two_recordings_are_swapped_together(swapped, capsys):
    balls = swapped.parent / "balls"
    shutil.copytree(swapped, balls, ignore=shutil.ignore_patterns("calibration"))
    shutil.copytree(balls / "snaps" / "left", balls / "snaps" / "right")
    (balls / "snaps" / "right" / "000.jpg").write_bytes(b"right")
    facts = json.loads((balls / "recording.json").read_text(encoding="utf-8"))
    (balls / "recording.json").write_text(json.dumps({**facts, "calibrated_by": "mine"}), encoding="utf-8")
    first = (swapped / "calibration" / "left" / "000.jpg").read_bytes()
    main(["calibrate", str(balls), "--swap"])
    assert (swapped / "calibration" / "right" / "000.jpg").read_bytes() == first
    assert (balls / "snaps" / "left" / "000.jpg").read_bytes() == b"right"
    said = capsys.readouterr().err
    assert str(balls) in said and str(swapped) in said


def test_a_folder_that_cannot_be_renamed_leaves_all_as_it_was(swapped, monkeypatch):
    first = (swapped / "calibration" / "left" / "000.jpg").read_bytes()
    rename, calls = os.rename, []

    def once_too_often(old, new):
        calls.append(old)
        if len(calls) == 3:
            raise PermissionError(13, "Permission denied")
        rename(old, new)

    monkeypatch.setattr(os, "rename", once_too_often)
    with pytest.raises(RecordingError, match="cannot be renamed: Permission denied"):
        swap_sides(open_recording(swapped))
    assert (swapped / "calibration" / "left" / "000.jpg").read_bytes() == first
    assert sorted(p.name for p in (swapped / "calibration").iterdir()) == ["left", "right"]


def test_a_rendered_recording_keeps_its_sides(bench):
    with pytest.raises(RecordingError, match="truth"):
        swap_sides(bench)
