"""Recordings, and everything that can be wrong with one."""

import json
import shutil
from contextlib import nullcontext

import cv2
import numpy as np
import pytest
from PIL import Image, ImageOps

from stereo_lab.errors import RecordingError, StereoLabError
from stereo_lab.kinematics import ArmWeight
from stereo_lab.recording import Ball, Board, import_images, open_recording, read_image

FACTS = {
    "format": 1,
    "image_size": [64, 48],
    "board": {"columns": 9, "rows": 6, "square_mm": 25.0},
    "ball": {"color": "red", "diameter_mm": 40.0},
}


@pytest.fixture
def small(tmp_path):
    """A tiny camera recording with two pairs and a table."""
    folder = tmp_path / "small"
    rng = np.random.default_rng(0)
    for side in ("left", "right"):
        (folder / "position" / side).mkdir(parents=True)
        for name in ("000", "001"):
            cv2.imwrite(str(folder / "position" / side / f"{name}.jpg"), rng.integers(0, 255, (48, 64, 3), np.uint8))
    (folder / "recording.json").write_text(json.dumps(FACTS))
    (folder / "position" / "measured.csv").write_text("name,x_mm,y_mm,depth_mm,use\n000,1,2,3,fit\n001,4,5,6,check\n")
    return folder


def rewrite(folder, **changes):
    (folder / "recording.json").write_text(json.dumps({**FACTS, **changes}))


def test_samples_are_read(small):
    samples = open_recording(small).samples("position")
    assert [s.use for s in samples] == ["fit", "check"]
    assert samples[0].truth is None
    assert samples[1].measured.depth_mm == 6
    assert samples[0].pair.left.shape == (48, 64, 3)


@pytest.mark.parametrize(
    "table",
    ["name,x_mm,y_mm,depth_mm,use\n000,1,2,3,\n001,4,5,6,\n", "name,x_mm,y_mm,depth_mm\n000,1,2,3\n001,4,5,6\n"],
)
def test_where_no_line_tells_its_use_every_second_one_is_to_check(small, table):
    (small / "position" / "measured.csv").write_text(table)
    recording = open_recording(small)
    assert [s.use for s in recording.samples("position")] == ["fit", "check"]
    assert [s.pair.name for s in recording.judges("plane")] == ["001"]


def test_missing_arm_means_the_shipped_one(small):
    recording = open_recording(small)
    assert recording.arm_is_shipped and recording.arm.l1_mm == 250


def test_an_arms_masses_are_read_and_the_rest_is_a_light_build(small):
    arm = {"l1_mm": 250, "l2_mm": 200, "depth_mm": 1000, "link1_g": 70, "center1_mm": 90, "load_g": 0}
    rewrite(small, arm=arm)
    assert open_recording(small).arm.weight == ArmWeight(link1_g=70, center1_mm=90, load_g=0)
    rewrite(small, arm={**arm, "hand_g": -1})
    with pytest.raises(RecordingError, match="hand_g: expected a number from 0 to 100,000 g, got -1"):
        open_recording(small)


def test_spreadsheet_table_is_read(small):
    (small / "position" / "measured.csv").write_text("\ufeffname;x_mm;y_mm;depth_mm;use\n0;1,5;2;3;fit\n1;4;5;6;\n")
    samples = open_recording(small).samples("position")
    assert samples[0].measured.x_mm == 1.5 and samples[1].pair.name == "001"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("name,x_mm,y_mm,use\n000,1,2,fit\n", "depth_mm"),
        ("name,x_mm,y_mm,depth_mm,use\n000,1,2,3,fit\n001,4,nan,6,check\n", "line 3"),
        ("name,x_mm,y_mm,depth_mm,use\n000,1,two,3,fit\n", "line 2"),
        ("name,x_mm,y_mm,depth_mm,use\n009,1,2,3,fit\n", "009"),
        ("name,x_mm,y_mm,depth_mm,use\n000,1,2,3,fit\n0,4,5,6,check\n", "line 3: picture 000 has a line already"),
    ],
)
def test_broken_tables_are_named(small, text, says):
    (small / "position" / "measured.csv").write_text(text)
    with pytest.raises(StereoLabError, match=says):
        open_recording(small).samples("position")


def test_missing_folder(tmp_path):
    with pytest.raises(RecordingError, match="no folder"):
        open_recording(tmp_path / "nowhere")


def test_broken_json_names_its_line(small):
    (small / "recording.json").write_text('{"format": 1,\n "board": }')
    with pytest.raises(RecordingError, match="line 2"):
        open_recording(small)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"board": {"columns": 9, "rows": 6, "square_mm": "wide"}}, "square_mm"),
        ({"board": {"columns": 9.5, "rows": 6, "square_mm": 25}}, "columns"),
        ({"image_size": [64]}, "image_size"),
        ({"ball": {"color": "pink", "diameter_mm": 40}}, "pink"),
        ({"ball": {"color": "red", "diameter_mm": float("nan")}}, "diameter_mm"),
        ({"board": None}, "board"),
    ],
)
def test_broken_facts_are_named(small, change, says):
    rewrite(small, **change)
    with pytest.raises(RecordingError, match=says):
        open_recording(small)


@pytest.mark.parametrize(
    ("lost", "says"),
    [
        (
            ("ball",),
            r'recording.json: ball is missing, or spelt in another way. Add "ball": {"color": "red", "diameter_mm": 40.0}',
        ),
        (("image_size",), r'recording.json: image_size is missing.* Add "image_size": \[640, 480\], with your own'),
        (("board", "square_mm"), r'recording.json, board: square_mm is missing.* Add "square_mm": 25.0'),
        (("ball", "diameter_mm"), r'recording.json, ball: diameter_mm is missing.* Add "diameter_mm": 40.0'),
        (("arm", "l2_mm"), r'recording.json, arm: l2_mm is missing.* Add "l2_mm": 200'),
    ],
)
def test_what_recording_json_lacks_is_told_with_how_it_is_written(small, lost, says):
    facts = json.loads((small / "recording.json").read_text())
    facts["arm"] = {"l1_mm": 250, "l2_mm": 200, "depth_mm": 1000}
    inner = facts if len(lost) == 1 else facts[lost[0]]
    del inner[lost[-1]]
    (small / "recording.json").write_text(json.dumps(facts))
    with pytest.raises(RecordingError, match=says):
        open_recording(small)


def test_boards_and_balls_are_of_numbers_however_they_were_typed():
    assert repr(Board("9", "6", "25")) == repr(Board(9, 6, 25.0))
    assert repr(Board("8", 6, "25", "charuco", "18", "DICT_4X4_50")) == repr(
        Board(8, 6, 25.0, "charuco", 18.0, "DICT_4X4_50")
    )
    assert repr(Ball("Red ", "40")) == repr(Ball("red", 40.0))


@pytest.mark.parametrize("depth", ["1.024", '"1,024"'])
def test_a_sign_between_the_thousands_is_told(small, depth):
    table = small / "position" / "measured.csv"
    table.write_text(f"name,x_mm,y_mm,depth_mm,use\n000,1,2,823,fit\n001,4,5,{depth},check\n")
    with pytest.raises(RecordingError, match=r"line 3, depth_mm: 1\.024 stands beside 823.*Write 1024"):
        open_recording(small).samples("position")
    table.write_text("name,x_mm,y_mm,depth_mm,use\n000,1,2,823,fit\n001,4,5,823.024,check\n")
    assert len(open_recording(small).samples("position")) == 2


def test_missing_half_is_named(small):
    (small / "position" / "right" / "001.jpg").unlink()
    with pytest.raises(RecordingError, match=r"001\.jpg.*half of the pair"):
        open_recording(small).pairs("position")


def test_cameras_that_name_their_pictures_are_told_and_no_half_is_taken_away(small):
    for picture in (small / "position").glob("*/*.jpg"):
        picture.rename(picture.with_name(f"IMG_{picture.stem}_{picture.parent.name}.jpg"))
    with pytest.raises(RecordingError, match=r"one name.*IMG_000_left\.jpg.*IMG_000_right\.jpg") as caught:
        open_recording(small).pairs("position")
    assert "half" not in str(caught.value)


@pytest.mark.parametrize(("lost", "says"), [(1, "picture 002.jpg: half"), (3, "picture 002.jpg and 2 more: half")])
def test_missing_halves_are_counted(small, lost, says):
    for name in ("002", "003", "004")[:lost]:
        picture = small / "position" / "left" / f"{name}.jpg"
        picture.write_bytes((small / "position" / "left" / "000.jpg").read_bytes())
    with pytest.raises(RecordingError, match=says):
        open_recording(small).pairs("position")


def test_a_set_that_is_not_there_is_named_beside_those_that_are(small):
    with pytest.raises(RecordingError, match=r"snaps.left holds no pictures.*Sets in this recording: position\.$"):
        open_recording(small).pairs("snaps")


def test_two_sizes_in_one_set(small):
    cv2.imwrite(str(small / "position" / "left" / "001.jpg"), np.zeros((40, 64, 3), np.uint8))
    pair = open_recording(small).pairs("position")[1]
    with pytest.raises(RecordingError, match="64x40.*64x48"):
        _ = pair.left


def test_truncated_jpeg(small):
    path = small / "position" / "left" / "000.jpg"
    path.write_bytes(path.read_bytes()[:-200])
    with pytest.raises(RecordingError, match="cut short"):
        read_image(path)


@pytest.mark.parametrize(
    ("content", "says"), [(b"", "broken"), (b"not a picture", "no picture"), (b"\xff\xd8", "broken")]
)
def test_unreadable_picture(tmp_path, content, says):
    path = tmp_path / "x.jpg"
    path.write_bytes(content)
    with pytest.raises(RecordingError, match=says):
        read_image(path)


def test_a_picture_that_opencv_gives_up_on(small, monkeypatch):
    def refuse(*_):
        raise cv2.error("no memory")

    monkeypatch.setattr(cv2, "imdecode", refuse)
    with pytest.raises(RecordingError, match=r"000\.jpg"):
        _ = open_recording(small).pairs("position")[0].left


def test_grey_and_deep_pictures(tmp_path):
    grey, deep = tmp_path / "grey.png", tmp_path / "deep.png"
    cv2.imwrite(str(grey), np.zeros((8, 8), np.uint8))
    cv2.imwrite(str(deep), np.zeros((8, 8, 3), np.uint16))
    with pytest.raises(RecordingError, match="grey"):
        read_image(grey)
    assert read_image(grey, grey_allowed=True).shape == (8, 8, 3)
    with pytest.raises(RecordingError, match="16 bits"):
        read_image(deep)


@pytest.mark.parametrize(("tint", "grey"), [(0, True), (2, True), (40, False)])
def test_a_grey_picture_of_three_channels_is_a_grey_one(bench, tmp_path, tint, grey):
    shades = cv2.cvtColor(cv2.cvtColor(bench.pairs("snaps")[0].left, cv2.COLOR_BGR2GRAY), cv2.COLOR_GRAY2BGR)
    file = tmp_path / "night.png"
    cv2.imwrite(str(file), cv2.add(shades, (tint, 0, 0, 0)))
    assert read_image(file, grey_allowed=True).shape == shades.shape
    with pytest.raises(RecordingError, match="grey") if grey else nullcontext():
        read_image(file)


def test_a_dark_picture_is_no_grey_one(tmp_path):
    cv2.imwrite(str(tmp_path / "dark.png"), np.full((8, 8, 3), 20, np.uint8))
    assert read_image(tmp_path / "dark.png").shape == (8, 8, 3)


@pytest.mark.parametrize("number", range(1, 9))
def test_a_picture_stands_upright_as_its_exif_says(number, tmp_path):
    """Pillow's own turning is the judge."""
    shown = np.random.default_rng(number).integers(0, 255, (24, 40, 3), np.uint8)
    exif = Image.Exif()
    exif[0x0112] = number
    Image.fromarray(shown).save(tmp_path / "held.png", exif=exif)
    upright = np.asarray(ImageOps.exif_transpose(Image.open(tmp_path / "held.png")))
    assert np.array_equal(read_image(tmp_path / "held.png")[..., ::-1], upright)


def test_a_picture_made_for_printing_is_read(tmp_path):
    """Four inks in place of three colours."""
    shown = np.full((24, 40, 3), (200, 120, 40), np.uint8)
    Image.fromarray(shown).convert("CMYK").save(tmp_path / "inks.jpg", quality=95)
    assert np.abs(read_image(tmp_path / "inks.jpg")[..., ::-1].astype(int) - shown).max() <= 4


def test_a_phone_s_own_format_is_named(tmp_path):
    phone = tmp_path / "IMG_0001.HEIC"
    phone.write_bytes(b"\0\0\0\x18ftypheic" + bytes(200))
    with pytest.raises(RecordingError, match="is a HEIC picture.*JPEG"):
        read_image(phone)


def test_import_pairs_by_number(small, tmp_path):
    shots = tmp_path / "shots"
    shots.mkdir()
    for n in (2, 10):
        shutil.copy(small / "position" / "left" / "000.jpg", shots / f"left{n}.jpg")
        shutil.copy(small / "position" / "right" / "000.jpg", shots / f"right{n}.jpg")
    recording = import_images(str(shots / "left*"), str(shots / "right*"), Board(9, 6, 25.0), tmp_path / "out")
    assert len(recording.pairs("calibration")) == 2
    (shots / "right10.jpg").unlink()
    with pytest.raises(RecordingError, match="other half"):
        import_images(str(shots / "left*"), str(shots / "right*"), Board(9, 6, 25.0), tmp_path / "out2")
    assert not (tmp_path / "out2").exists()


def test_import_refuses_a_folder_in_use(small):
    with pytest.raises(RecordingError, match="there already"):
        import_images(str(small / "position/left/*"), str(small / "position/right/*"), Board(9, 6, 25.0), small)
