"""Work and progress to another computer as one file: nothing lost there, nothing let out of the folder."""

import json
import os
import stat
import zipfile
from pathlib import Path
from types import SimpleNamespace

import pytest

from conftest import ROOT
from stereo_lab.cli import main
from stereo_lab.errors import StereoLabError
from stereo_lab.seats import moving
from stereo_lab.seats.moving import pack, unpack
from stereo_lab.work import MARK, lay_out

NAMES = sorted(path.name for path in (ROOT / "notebooks").glob("*.ipynb"))


@pytest.fixture
def school(tmp_path):
    """A work folder in which lesson 00 was begun, with an answer, progress and a recording of one's own."""
    folder = tmp_path / "school"
    lay_out(ROOT / "notebooks", folder)
    write(folder / NAMES[0], read(folder / NAMES[0]).replace("____  ", '"at school"  '))
    write(folder / "answers" / "question_05_3.py", "answer = 3\n")
    write(folder / "progress.json", json.dumps({"00": [1, 2], "05": [3]}))
    write(folder / "data" / "méine" / "recording.json", "{}")
    write(folder / ".ipynb_checkpoints" / NAMES[0], "old")
    return folder


def read(path):
    return path.read_text(encoding="utf-8")


def write(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def everything(folder):
    return {p.relative_to(folder).as_posix(): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def test_a_folder_comes_back_as_it_was(school, tmp_path):
    count, left_out = pack(school, tmp_path / "stick" / "ada.zip")
    done = unpack(tmp_path / "stick" / "ada.zip", tmp_path / "home")
    wanted = {name: content for name, content in everything(school).items() if ".ipynb_checkpoints" not in name}
    got = everything(tmp_path / "home")
    assert (
        left_out == []
        and done.kept == done.left == []
        and count == len(done.brought) == len(wanted) - 1 == len(got) - 1
    )
    assert {n: c for n, c in got.items() if n != MARK} == {n: c for n, c in wanted.items() if n != MARK}
    assert json.loads(got[MARK]) == json.loads(wanted[MARK])
    assert lay_out(ROOT / "notebooks", tmp_path / "home") == ([], [])  # and the kit takes it for one of its own


def test_what_lies_there_is_kept(school, tmp_path):
    home = tmp_path / "home"
    lay_out(ROOT / "notebooks", home)
    write(home / NAMES[0], read(home / NAMES[0]).replace("____  ", '"at home"  '))
    write(home / NAMES[3], read(home / NAMES[3]).replace("____  ", '"at home"  '))
    write(home / "answers" / "question_05_3.py", "answer = 4\n")
    write(home / "progress.json", json.dumps({"00": [2, 5], "03": [1], "04": "broken"}))
    before = everything(home)
    pack(school, tmp_path / "ada.zip")
    done = unpack(tmp_path / "ada.zip", home)
    after = everything(home)
    assert after[NAMES[0]] == everything(school)[NAMES[0]] and after["answers/question_05_3.py"] == b"answer = 3\n"
    assert [name for name, _ in done.kept] == [NAMES[0], "answers/question_05_3.py"]
    for name, kept in done.kept:
        assert after[(os.path.dirname(name) + "/" + kept).lstrip("/")] == before[name]
    assert done.left == [NAMES[3]] and after[NAMES[3]] == before[NAMES[3]]
    assert json.loads(after["progress.json"]) == {"00": [1, 2, 5], "03": [1], "05": [3]}
    lost = [name for name, content in before.items() if content not in after.values()]
    assert set(lost) <= {"progress.json", MARK}
    again = unpack(tmp_path / "ada.zip", home)
    assert again.brought == again.kept == [] and everything(home) == after


def test_the_recording_of_another_seat_stays_whole(school, tmp_path):
    home = tmp_path / "home"
    lay_out(ROOT / "notebooks", home)
    for folder, seat, pictures in ((school, 17, "ab"), (home, 3, "abc")):
        write(folder / "seat" / "recording.json", json.dumps({"seat": seat}))
        for name in pictures:
            write(folder / "seat" / "calibration" / "left" / f"{name}.jpg", f"{name} of {seat}")
    before = everything(home / "seat")
    pack(school, tmp_path / "ada.zip")
    done = unpack(tmp_path / "ada.zip", home)
    assert [name for name, _ in done.kept] == ["seat"] and everything(home / done.kept[0][1]) == before
    assert everything(home / "seat") == everything(school / "seat")
    assert unpack(tmp_path / "ada.zip", home).kept == []


def test_a_pack_brings_no_other_code_name_and_forgets_no_help(school, tmp_path, monkeypatch, capsys):
    home = tmp_path / "home"
    lay_out(ROOT / "notebooks", home)
    for folder, name, taken in (
        (school, "calm-owl-128", {"00": {"1": {"hint": 2}, "2": {"solution": 1}}, "03": 7}),
        (home, "brave-fox-77", {"00": {"1": {"hint": 1, "solution": 1}}, "05": {"3": {"hint": 3}}}),
    ):
        write(folder / "code_name.json", json.dumps({"code_name": name}))
        write(folder / "help.json", json.dumps(taken))
    pack(school, tmp_path / "ada.zip")
    monkeypatch.setenv("STEREO_LAB_WORK", str(home))
    assert main(["unpack", str(tmp_path / "ada.zip")]) == 0
    said = capsys.readouterr().out
    assert "stays brave-fox-77; that of the pack is calm-owl-128" in said and "json was different" not in said
    assert json.loads(read(home / "code_name.json")) == {"code_name": "brave-fox-77"}
    assert json.loads(read(home / "help.json")) == {
        "00": {"1": {"hint": 2, "solution": 1}, "2": {"solution": 1}}, "05": {"3": {"hint": 3}},
    }  # fmt: skip
    assert unpack(tmp_path / "ada.zip", tmp_path / "new").code_names == []  # where there is none it comes along
    assert read(tmp_path / "new" / "code_name.json") == read(school / "code_name.json")


def test_an_untouched_copy_makes_room(school, tmp_path):
    lay_out(ROOT / "notebooks", tmp_path / "home")
    pack(school, tmp_path / "ada.zip")
    done = unpack(tmp_path / "ada.zip", tmp_path / "home")
    assert NAMES[0] in done.brought and done.kept == done.left == []
    assert read(tmp_path / "home" / NAMES[0]) == read(school / NAMES[0])


def made(path, *entries, mark='{"format": 1, "copies": {}}'):
    """A pack with made-up names."""
    with zipfile.ZipFile(path, "w") as file:
        if mark is not None:
            file.writestr(MARK, mark)
        for name in entries:
            file.writestr(name, "climbed")
    return path


def link(name, to):
    about = zipfile.ZipInfo(name)
    about.external_attr = (stat.S_IFLNK | 0o777) << 16
    return about, to


@pytest.mark.parametrize(
    "name",
    ["../climbed", "a/../../climbed", "/tmp/climbed", "..", "a\\..\\..\\climbed", "C:climbed", "C:/climbed", "//server/climbed",
     "notes.txt:stream"],
)  # fmt: skip
def test_a_name_that_climbs_is_refused(tmp_path, name):
    packed = made(tmp_path / "bad.zip", "fine.txt", name)
    with pytest.raises(StereoLabError, match="leads out of the folder"):
        unpack(packed, tmp_path / "home")
    assert not (tmp_path / "home").exists() and not list(tmp_path.rglob("*climbed*"))


def test_a_link_is_refused(tmp_path):
    with zipfile.ZipFile(tmp_path / "bad.zip", "w") as file:
        file.writestr(MARK, '{"format": 1, "copies": {}}')
        file.writestr(*link("out", "/etc/passwd"))
    with pytest.raises(StereoLabError, match="leads out of the folder"):
        unpack(tmp_path / "bad.zip", tmp_path / "home")


@pytest.mark.skipif(os.name == "nt", reason="links need leave there")
def test_a_link_that_lies_there_leads_nobody_out(tmp_path):
    (tmp_path / "home").mkdir()
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "home" / "sub").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(StereoLabError, match="leads out of the folder"):
        unpack(made(tmp_path / "bad.zip", "sub/climbed"), tmp_path / "home")
    assert list((tmp_path / "elsewhere").iterdir()) == []


def test_what_is_no_pack(school, tmp_path):
    write(tmp_path / "text.zip", "no zip")
    with pytest.raises(StereoLabError, match="Expected a file that pack wrote"):
        unpack(tmp_path / "text.zip", tmp_path / "home")
    with pytest.raises(StereoLabError, match="not made by"):
        unpack(made(tmp_path / "other.zip", "a.txt", mark=None), tmp_path / "home")
    with pytest.raises(StereoLabError, match="a newer kit made it"):
        unpack(made(tmp_path / "newer.zip", mark='{"format": 2}'), tmp_path / "home")
    with pytest.raises(StereoLabError, match='expected "format"'):
        unpack(made(tmp_path / "list.zip", mark="[1]"), tmp_path / "home")
    with pytest.raises(StereoLabError, match="same name"):
        unpack(made(tmp_path / "twice.zip", "a.txt", "A.txt"), tmp_path / "home")
    with pytest.raises(StereoLabError, match="Cannot read"):
        unpack(tmp_path / "none.zip", tmp_path / "home")
    assert not (tmp_path / "home").exists()


def test_a_damaged_pack_changes_nothing(school, tmp_path):
    pack(school, tmp_path / "ada.zip")
    content = bytearray((tmp_path / "ada.zip").read_bytes())
    refused = 0
    for place in range(100, len(content) - 100, len(content) // 40):
        (tmp_path / "bad.zip").write_bytes(content[:place] + bytes([content[place] ^ 0xFF]) + content[place + 1 :])
        try:
            unpack(tmp_path / "bad.zip", tmp_path / "home")
        except StereoLabError:
            refused += 1
            assert not (tmp_path / "home").exists()
        else:  # what was hit is a time, say: then all files are whole
            assert everything(tmp_path / "home")["answers/question_05_3.py"] == b"answer = 3\n"
            moving.shutil.rmtree(tmp_path / "home")
    assert refused > 30
    (tmp_path / "bad.zip").write_bytes(content[: len(content) // 2])
    with pytest.raises(StereoLabError, match="Expected a file that pack wrote"):
        unpack(tmp_path / "bad.zip", tmp_path / "home")


def test_more_than_there_is_room_for(tmp_path, monkeypatch):
    packed = made(tmp_path / "ada.zip", "a.txt")
    monkeypatch.setattr(moving.shutil, "disk_usage", lambda _: SimpleNamespace(free=1000))
    with pytest.raises(StereoLabError, match="Free some space"):
        unpack(packed, tmp_path / "home")
    monkeypatch.setattr(moving, "LARGEST", 10)
    with pytest.raises(StereoLabError, match="at most"):
        unpack(packed, tmp_path / "home")
    monkeypatch.setattr(moving, "MOST", 1)
    with pytest.raises(StereoLabError, match="1 files at most, got 2"):
        unpack(packed, tmp_path / "home")


@pytest.mark.skipif(os.name == "nt", reason="such names and links are not made there")
def test_what_another_system_would_not_take_is_told(school, tmp_path):
    write(school / "what?.txt", "x")
    (school / "link").symlink_to("/etc/passwd")
    for name in ("aux.csv", "con/y.txt", "COM1.ipynb", "notes.", "run ", "a\tb.txt"):
        write(school / name, "x")
    write(school / "console.txt", "x")
    _, left_out = pack(school, tmp_path / "ada.zip")
    assert left_out == ["COM1.ipynb", "a\tb.txt", "aux.csv", "con/y.txt", "link", "notes.", "run ", "what?.txt"]
    unpack(tmp_path / "ada.zip", tmp_path / "home")


@pytest.mark.skipif(os.name == "nt", reason="such names are not made there")
def test_what_is_packed_is_taken_in_again(school, tmp_path, monkeypatch):
    for name in ("Notes.md", "notes.md"):
        write(school / name, name)
    with open(os.fsencode(school) + b"/caf\xe9.txt", "w", encoding="ascii") as file:
        file.write("x")
    os.utime(school / "Notes.md", (5_000_000_000, 5_000_000_000))  # in 2128
    monkeypatch.chdir(school)
    write(school / "older.zip", "older")
    count, left_out = pack(school, Path("ada.zip"))
    assert "notes.md" in left_out and any("caf" in name for name in left_out)
    unpack(school / "ada.zip", tmp_path / "home")
    assert len(everything(tmp_path / "home")) == count + 1  # and the mark
    assert not {"ada.zip", "ada.zip.part"} & set(everything(tmp_path / "home"))
    (school / "ada.zip").unlink()
    monkeypatch.setattr(moving, "LARGEST", 10)
    with pytest.raises(StereoLabError, match="0 MB at most"):
        pack(school, tmp_path / "large.zip")
    assert not list(tmp_path.glob("large*"))


def test_a_mark_that_is_a_bomb_is_not_read(tmp_path):
    with zipfile.ZipFile(tmp_path / "bomb.zip", "w", zipfile.ZIP_DEFLATED) as file:
        file.writestr(moving.MARK, b" " * (moving.LARGEST_MARK + 1) + b'{"format": 1}')
    with pytest.raises(StereoLabError, match="format"):
        unpack(tmp_path / "bomb.zip", tmp_path / "home")


def test_nothing_is_written_over_by_packing(school, tmp_path):
    write(tmp_path / "ada.zip", "older")
    with pytest.raises(StereoLabError, match="already there"):
        pack(school, tmp_path / "ada.zip")
    assert read(tmp_path / "ada.zip") == "older"
    with pytest.raises(StereoLabError, match="There is no work in"):
        pack(tmp_path / "nobody", tmp_path / "nobody.zip")
    write(tmp_path / "file", "")
    with pytest.raises(StereoLabError, match="Cannot write"):
        pack(school, tmp_path / "file" / "ada.zip")
    assert not list(tmp_path.rglob("*.part"))


def test_a_pack_inside_the_folder_holds_no_pack(school):
    pack(school, school / "ada.zip")
    assert "ada.zip" not in zipfile.ZipFile(school / "ada.zip").namelist()


def test_by_command(school, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("STEREO_LAB_WORK", str(school))
    assert main(["pack"]) == 0
    (packed,) = tmp_path.glob("school_20*.zip")
    assert f"unpack {packed.name}" in capsys.readouterr().out
    monkeypatch.setenv("STEREO_LAB_WORK", str(tmp_path / "home"))
    write(tmp_path / "home" / NAMES[0], "mine")
    assert main(["unpack", packed.name]) == 0
    said = capsys.readouterr().out
    assert "new folder" not in said and f"{NAMES[0]} was different here; what you had is now {NAMES[0][:-6]}_20" in said
    assert main(["progress", "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["lessons"]["05"]["passed"] == [3]
    monkeypatch.setenv("STEREO_LAB_WORK", str(tmp_path / "work-evaa"))
    assert main(["unpack", packed.name]) == 0 and "work-evaa is a new folder" in capsys.readouterr().out
