"""Pictures from elsewhere: both cameras in one picture, and kinds of files."""

import shutil

import cv2
import numpy as np
import pytest

from stereo_lab import cli
from stereo_lab.errors import RecordingError
from stereo_lab.recording import Board, import_images, import_side_by_side, open_recording, read_image

BOARD = Board(9, 6, 25.0)


@pytest.fixture
def pairs(bench):
    return [(pair.left, pair.right) for pair in bench.pairs("calibration")[:3]]


@pytest.mark.parametrize("suffix", ["png", "bmp", "tiff", "webp"])
def test_two_in_one_picture_are_parted_without_loss(pairs, tmp_path, suffix):
    lossless = [cv2.IMWRITE_WEBP_QUALITY, 101] if suffix == "webp" else []
    for k, pair in enumerate(pairs):
        cv2.imwrite(str(tmp_path / f"both {k} \u00fc.{suffix}"), np.hstack(pair), lossless)
    made = import_side_by_side(str(tmp_path / f"both*.{suffix}"), BOARD, tmp_path / "out")
    assert made.image_size == (640, 480)
    for pair, (left, right) in zip(made.pairs("calibration"), pairs, strict=True):
        assert np.array_equal(pair.left, left) and np.array_equal(pair.right, right)


@pytest.mark.parametrize("suffix", ["bmp", "tiff"])
def test_other_kinds_of_files_are_kept_without_loss(pairs, tmp_path, suffix):
    for k, (left, right) in enumerate(pairs):
        cv2.imwrite(str(tmp_path / f"left{k}.{suffix}"), left)
        cv2.imwrite(str(tmp_path / f"right{k}.{suffix}"), right)
    made = import_images(str(tmp_path / "left*"), str(tmp_path / "right*"), BOARD, tmp_path / "out")
    assert np.array_equal(made.pairs("calibration")[2].right, pairs[2][1])


def test_an_odd_width_and_two_ways_at_once_are_refused(pairs, tmp_path, capsys):
    cv2.imwrite(str(tmp_path / "both.png"), np.hstack(pairs[0])[:, 1:])
    with pytest.raises(RecordingError, match="1279 pixels wide: two halves of one width"):
        import_side_by_side(str(tmp_path / "*.png"), BOARD, tmp_path / "out")
    assert not (tmp_path / "out").exists()
    words = ["--board", "9x6", "--square-mm", "25", "--out", str(tmp_path / "out")]
    assert cli.main(["import", "--side-by-side", "x*", "--left", "y*", *words]) == 2
    assert "not both" in capsys.readouterr().err


def test_lists_without_files_are_refused(tmp_path):
    for make in (lambda out: import_images([], [], BOARD, out), lambda out: import_side_by_side([], BOARD, out)):
        with pytest.raises(RecordingError, match="Expected files, got an empty list"):
            make(tmp_path / "out")


def test_the_command(pairs, tmp_path, capsys):
    for k, pair in enumerate(pairs):
        cv2.imwrite(str(tmp_path / f"{k}.png"), np.hstack(pair))
    words = ["--board", "9x6", "--square-mm", "25", "--out", str(tmp_path / "out")]
    assert cli.main(["import", "--side-by-side", str(tmp_path / "*.png"), *words]) == 0
    assert "3 pairs of 640x480 pixels" in capsys.readouterr().out
    assert read_image(open_recording(tmp_path / "out").pairs("calibration")[0].left_path).shape == (480, 640, 3)


def test_a_folder_of_folders_and_half_a_pair_are_told(bench, tmp_path, capsys):
    for side, count in (("left", 3), ("right", 2)):
        (tmp_path / side).mkdir()
        for path in sorted((bench.path / "calibration" / side).iterdir())[:count]:
            shutil.copy(path, tmp_path / side)
    words = ["--board", "9x6", "--square-mm", "25", "--out", str(tmp_path / "mine")]
    assert cli.main(["import", "--left", str(tmp_path), "--right", str(tmp_path), *words]) == 2
    assert f"{tmp_path} finds no file, but folders: left, right." in capsys.readouterr().err
    halves = ["--left", str(tmp_path / "left"), "--right", str(tmp_path / "right")]
    assert cli.main(["import", *halves, *words]) == 2
    assert "has no other half: 3 left and 2 right pictures were found. Put it back" in capsys.readouterr().err


def test_files_that_a_shell_made_of_a_pattern_and_folders_with_brackets(bench, tmp_path, capsys):
    folder = tmp_path / "[2026] Köln"
    for side in ("left", "right"):
        shutil.copytree(bench.path / "calibration" / side, folder / side, ignore=lambda _, names: sorted(names)[6:])
        (folder / side / "Thumbs.db").write_bytes(b"no picture")
    (folder / "right" / "desktop.ini").write_text("no picture")
    listed = [sorted(str(path) for path in (folder / side).glob("*.jpg")) for side in ("left", "right")]
    ways = (
        listed,
        [[str(folder / side / "*")] for side in ("left", "right")],
        [[str(folder / side)] for side in ("left", "right")],
    )
    for k, (left, right) in enumerate(ways):
        words = ["import", "--left", *left, "--right", *right, "--board", "9x6", "--square-mm", "25"]
        assert cli.main([*words, "--out", str(tmp_path / f"mine{k}")]) == 0
        assert "6 pairs of 640x480" in capsys.readouterr().out
