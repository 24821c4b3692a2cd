"""The whole chain, and every command as a user runs it."""

import argparse
import io
import json
import os
import shutil
import signal
import subprocess
import sys
import types
from dataclasses import replace

import cv2
import numpy as np
import pytest

from conftest import ROOT
from stereo_lab import cli
from stereo_lab.calibration import StereoCalibration, find_calibration
from stereo_lab.calibration.store import BROUGHT
from stereo_lab.cli import checks, main, terminal
from stereo_lab.common.tables import closing_table
from stereo_lab.errors import CalibrationError
from stereo_lab.localization import Localizer
from stereo_lab.recording import open_recording
from stereo_lab.results import benchmark as measure
from stereo_lab.results import live_cost
from stereo_lab.results.evaluation import clutter_of


def run(*arguments, cwd=ROOT):
    """Run ``stereo-lab`` in a process of its own: (exit code, output, errors)."""
    command = [sys.executable, "-m", "stereo_lab", *map(str, arguments)]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(command, capture_output=True, text=True, cwd=cwd, env=environment)
    assert "Traceback" not in done.stderr
    return done.returncode, done.stdout, done.stderr


def errors_mm(localizer, recording):
    rows = []
    for sample in recording.samples("evaluation"):
        place = localizer.locate(sample.pair.left, sample.pair.right)
        assert place is not None, sample.pair.name
        rows.append(
            [place.x_mm - sample.truth.x_mm, place.y_mm - sample.truth.y_mm, place.depth_mm - sample.truth.depth_mm]
        )
    return np.abs(rows), np.array([s.use for s in recording.samples("evaluation")])


def test_cone_localizer_on_bench(bench, bench_calibration):
    errors, use = errors_mm(Localizer.fit(bench, calibration=bench_calibration), bench)
    volume = errors[use == "volume"]
    assert volume[:, :2].mean(0).max() < 0.6  # 0.42 of it by this bench's ruler alone
    assert volume[:, 2].mean() < 0.8 and np.percentile(volume[:, 2], 95) < 3  # one edge in doubt, of 40 pairs


def test_paper_localizer_holds_in_the_plane(bench, bench_calibration):
    errors, use = errors_mm(Localizer.fit(bench, "paper", bench_calibration), bench)
    assert np.percentile(errors[use == "plane"][:, :2], 95, axis=0).max() < 10
    assert errors[use == "volume"][:, :2].mean() > 20  # and nowhere else: the lesson rests on it


def test_a_calibration_of_other_cameras_is_named(bench, bench_calibration):
    turn = cv2.Rodrigues(np.radians([2.0, 0, 0]))[0]
    other = replace(bench_calibration, rotation=turn @ bench_calibration.rotation)
    with pytest.raises(CalibrationError, match="other cameras"):
        Localizer.fit(bench, calibration=other)


@pytest.mark.slow
def test_cone_localizer_on_second_rig(second_rig):
    localizer = Localizer.fit(second_rig)
    errors, _ = errors_mm(localizer, second_rig)
    depths = np.array([s.truth.depth_mm for s in second_rig.samples("evaluation")])
    limit = (localizer.calibration.depth_per_px(depths) * 0.06).mean()
    assert errors[:, 2].mean() < 2 * limit


def test_detect_writes_json(tmp_path):
    picture = ROOT / "data" / "bench" / "snaps" / "left" / "000.jpg"
    code, out, _ = run("detect", picture, "--json", tmp_path / "d.json")
    (row,) = json.loads((tmp_path / "d.json").read_text())
    truth = json.loads((ROOT / "data/bench/truth.json").read_text())["sets"]["snaps"]["000"]["left"]
    assert code == 0 and "radius" in out
    assert row["detection"]["u"] == pytest.approx(truth[0], abs=1.5)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["bench", "second_rig", "third_rig"])
def test_calibrating_anew_gives_what_the_recording_brings(name, tmp_path):
    """The shipped calibration was made on another computer: parameters and verdict are the same here."""
    shipped = StereoCalibration.load(ROOT / "data" / name / "calibration.json")
    code, out, _ = run("calibrate", name, "--json", tmp_path / "c.json", "--save", tmp_path / "cal.json")
    facts = json.loads((tmp_path / "c.json").read_text())
    assert code == 0 and f"verdict: {shipped.verdict}" in out
    assert facts["pairs"] == shipped.pairs == facts["pairs_used"] + len(facts["dropped"])
    anew = StereoCalibration.load(tmp_path / "cal.json")
    assert (anew.verdict, anew.used, anew.made_from) == (shipped.verdict, shipped.used, shipped.made_from)
    for side in ("left", "right"):
        assert np.allclose(anew.camera(side)[0], shipped.camera(side)[0], atol=0.5)
    assert np.allclose(anew.translation_mm, shipped.translation_mm, atol=0.1)
    assert np.allclose(anew.rotation, shipped.rotation, atol=2e-4)


@pytest.mark.slow
def test_demo_writes_json_and_report(tmp_path):
    code, out, _ = run("demo", "bench", "--json", tmp_path / "demo.json", "--report", tmp_path / "demo.html")
    facts = json.loads((tmp_path / "demo.json").read_text())
    assert code == 0 and "its method here" in out and "rendered recording" in out
    assert facts["detection"]["cone"]["hits"] == facts["detection"]["cone"]["frames"] == 250
    assert facts["detection"]["paper"]["hits"] >= 248
    assert (
        facts["evaluation"]["cone"]["volume"]["depth_mm"]["mean"]
        < facts["evaluation"]["paper"]["volume"]["depth_mm"]["mean"] / 10
    )
    page = (tmp_path / "demo.html").read_text(encoding="utf-8")
    assert page.count("<img ") == 5 and "http" not in page


def test_import_then_calibrate(tmp_path):
    source = ROOT / "data" / "bench" / "calibration"
    code, out, _ = run(
        "import", "--left", source / "left" / "00*.jpg", "--right", source / "right" / "00*.jpg",
        "--board", "9x6", "--square-mm", "25", "--out", tmp_path / "mine",
    )  # fmt: skip
    assert code == 0 and "10 pairs" in out
    code, out, _ = run("calibrate", tmp_path / "mine", "--keep", "--json", tmp_path / "c.json")
    facts = json.loads((tmp_path / "c.json").read_text())
    assert code == 0 and "verdict: " in out and facts["pairs"] == 10
    assert find_calibration(open_recording(tmp_path / "mine"))[1] == BROUGHT


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("calibrate", "nowhere"), "no folder"),
        (("demo", "nowhere"), "no folder"),
        (("detect", "nowhere.jpg"), "Cannot read"),
        (("detect", "README.md"), "no picture that can be read"),
        (("detect", "data/bench/snaps/left/000.jpg", "--color", "pink"), "pink"),
        (("detect", "data/bench/snaps/left/000.jpg", "--color-from", "nowhere.csv"), "nowhere.csv"),
        (
            ("import", "--left", "no*.jpg", "--right", "no*.jpg", "--board", "9x6", "--square-mm", "25", "--out", "x"),
            "No file matches",
        ),
        (("import", "--left", "a", "--right", "b", "--board", "nine", "--square-mm", "25", "--out", "x"), "--board"),
        (
            ("import", "--left", "a", "--right", "b", "--board", "9x6", "--square-mm", "wide", "--out", "x"),
            "--square-mm",
        ),
        (
            ("import", "--left", "data/bench/calibration/left/*.jpg", "--right", "data/bench/calibration/*/*.jpg")
            + ("--board", "9x6", "--square-mm", "25", "--out", "x"),
            "matches both patterns",
        ),
        (
            (
                "import",
                "--left",
                "a.mp4",
                "--right",
                "b.mp4",
                "--board",
                "9x6",
                "--square-mm",
                "25",
                "--every",
                "0",
                "--out",
                "x",
            ),
            "--every: expected a whole number from 1 up",
        ),
        (
            ("import", "--left", "data/bench/calibration/left", "--right", "data/bench/calibration/right")
            + ("--board", "9x6", "--square-mm", "25", "--every", "5", "--out", "x"),
            "--every is for films",
        ),
        (("train", "clutter", "--out", "ball.txt"), ".json"),
        (("render", "nowhere"), "no rig"),
        (("fly",), "invalid choice"),
    ],
)
def test_bad_input_is_one_plain_sentence(arguments, says):
    code, _, errors = run(*arguments)
    assert code == 2 and says in errors


# A program that says when it has begun to look at the boards, and goes on as the command does.
TELLS = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)  # whoever runs the tests in the background has it ignored
from stereo_lab.calibration import search
from stereo_lab.cli import main
look = search.find_corners
search.find_corners = lambda *given: print("looking", flush=True) or look(*given)
sys.exit(main(sys.argv[1:]))
"""


@pytest.mark.skipif(os.name == "nt", reason="Ctrl-C cannot be sent to another process there")
@pytest.mark.parametrize("looks", [1, 20])
def test_ctrl_c_leaves_nothing_half_written(tmp_path, looks):
    command = [sys.executable, "-c", TELLS, "calibrate", "bench", "--json", str(tmp_path / "c.json")]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "STEREO_LAB_HOME": str(tmp_path / "home")}
    running = subprocess.Popen(
        command, cwd=ROOT, env=environment, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    for _ in range(looks):
        assert running.stdout.readline() == "looking\n"
    running.send_signal(signal.SIGINT)
    _, errors = running.communicate()
    assert running.returncode == 130 and "stopped" in errors and "Traceback" not in errors
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []


def test_every_command_has_help_with_an_example():
    for command in ("demo", "calibrate", "detect", "import", "render", "test"):
        code, out, _ = run(command, "--help")
        assert code == 0 and "example:" in out


def _commands(parser):
    """All commands below a parser, and the commands below them, with their names."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name, command in action.choices.items():
                yield name, command
                yield from _commands(command)


def test_every_option_says_what_it_is():
    silent = [
        f"{name} {action.dest}"
        for name, command in _commands(cli._parser())
        for action in command._actions
        if not action.help and not isinstance(action, argparse._SubParsersAction)
    ]
    assert not silent


@pytest.mark.parametrize(("command", "says"), [
    ("board", "(default: 25)"), ("record", "(25, or that of the recording)"), ("detect", "(default: cone)"), ("detect", "middle of the top left pixel"),
])  # fmt: skip
def test_help_tells_what_is_taken_and_what_is_printed(command, says):
    assert says in " ".join(run(command, "--help")[1].split())


@pytest.mark.slow
def test_bench_measures_every_way(bench, bench_calibration, monkeypatch):
    monkeypatch.setattr(measure, "PAIRS", 3)
    monkeypatch.setattr(measure, "POINTS", 20_000)
    monkeypatch.setattr(live_cost, "PAPERS_PAIRS", 40)
    monkeypatch.setattr(live_cost, "SECONDS", 3.0)
    groups = measure.benchmark(bench)
    assert (
        groups["ratios"]["track_vs_sgbm"] > 10
        and groups["ratios"]["track_vs_paper"] > groups["ratios"]["search_vs_paper"] > 1
    )
    assert groups["errors_mm"]["cone, whole pictures"] == groups["locating"][1]["error_mm"]
    assert groups["run"]["pairs"] == 40 and groups["run"]["lost"] == 0 and 8 < groups["run"]["rate_hz"] < 10.5
    assert groups["cpu_percent"] == groups["run"]["cpu_percent"] > 0 and 40 < groups["rss_mb"] < 300
    assert 0 < groups["latency_ms"]["median"] <= groups["latency_ms"]["p95"]
    assert groups["hand_mm"]["ahead"] < groups["hand_mm"]["seen"]
    assert json.loads(json.dumps(groups)) == groups
    paper, whole, near, dense = groups["locating"]
    assert max(whole["error_mm"], near["error_mm"]) < min(3, paper["error_mm"], dense["error_mm"])
    one_by_one, arrays, searched = groups["inverse_kinematics"][:3]
    assert max(one_by_one["error_mm"], arrays["error_mm"]) < 1e-9 and searched["error_mm"] < 0.1
    assert all(library["error_mm"] < 0.1 for library in groups["inverse_kinematics"][3:])  # where it is installed
    assert dense["error_mm"] < 9.5  # 10.7 where the way from the surface to the centre is forgotten
    assert arrays["times"] > 20 > 1 > searched["times"]
    for row in (*groups["locating"], *groups["inverse_kinematics"], *groups["virtual_arm"]):
        assert row["way"] in measure.page(groups) and row["times"] > 0


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_the_progress_line_fills_from_left_to_right(monkeypatch):
    shown = Terminal()
    monkeypatch.setattr(sys, "stderr", shown)
    clock = iter(range(1, 100))
    monkeypatch.setattr(terminal.time, "monotonic", lambda: next(clock))
    with terminal.Progress() as progress:
        for done in (0, 1, 3, 4):
            progress("look", done, 4)
    lines = [f"  [{'#' * n}{'.' * (24 - n)}] {done}/4  look" for n, done in ((0, 0), (6, 1), (18, 3), (24, 4))]
    assert shown.getvalue().split("\r\033[K") == ["", *lines, ""]


def test_the_progress_line_is_drawn_ten_times_a_second_and_at_the_end(monkeypatch):
    shown = Terminal()
    monkeypatch.setattr(sys, "stderr", shown)
    monkeypatch.setattr(terminal.time, "monotonic", lambda: 5.0)
    with terminal.Progress() as progress:
        for done in range(8):
            progress("look", done, 7)
    assert shown.getvalue().count("look") == 2 and "7/7" in shown.getvalue()


def test_no_progress_line_in_a_file(monkeypatch):
    shown = io.StringIO()
    monkeypatch.setattr(sys, "stderr", shown)
    with terminal.Progress() as progress:
        progress("look", 7, 7)
    assert shown.getvalue() == ""


def test_a_closing_table_has_aligned_columns(capsys):
    closing_table([("depth (mm)", 8, "16.9", ""), ("snaps", "99.2 %", "", "100 %")])
    assert capsys.readouterr().out.splitlines() == [
        "             paper  its method here   ours",
        "------------------------------------------",
        "depth (mm)       8             16.9      -",
        "snaps       99.2 %                -  100 %",
    ]
    with pytest.raises(ValueError):
        closing_table([("depth (mm)", 8, "16.9", "0.8", "one too many")])


def test_clutter_of_the_same_cameras_is_found_and_no_other(bench):
    assert clutter_of(bench).name == "clutter"
    for name in ("aaa", "second_rig", "zzz"):
        assert clutter_of(replace(bench, path=bench.path.with_name(name))) is None


def test_render_writes_beside_the_other_recordings(monkeypatch, capsys, tmp_path):
    """With a stand-in for the renderer, which is an extra."""
    calls = []
    stand_in = types.ModuleType("record")
    stand_in.record = lambda name, out, seed, sets, report: calls.append((name, out, seed, sets, report(1, 2, "x")))
    monkeypatch.setitem(sys.modules, "record", stand_in)
    monkeypatch.setattr(sys, "path", list(sys.path))
    assert main(["render", "bench"]) == 0
    assert main(["render", "bench", "--out", str(tmp_path), "--seed", "7", "--sets", "snaps,depth"]) == 0
    assert calls == [
        ("bench", ROOT / "data" / "bench", None, None, None),
        ("bench", tmp_path, 7, ["snaps", "depth"], None),
    ]
    assert f"{tmp_path} is complete (a rendered recording)" in capsys.readouterr().out


@pytest.mark.parametrize(("package", "notebooks", "code"), [(0, 0, 0), (1, 0, 1), (0, 1, 1), (0, -9, -9), (-2, 0, -2)])
def test_a_test_run_fails_with_either_half(monkeypatch, package, notebooks, code):
    """And where a signal ended one: such a code is below zero."""

    def half(*command, **_):
        done = types.SimpleNamespace(wait=lambda: None, kill=lambda: None)
        done.returncode = notebooks if "--nbval" in command[0] else package
        return done

    monkeypatch.setattr(checks.subprocess, "Popen", half)
    monkeypatch.setattr(checks.subprocess, "run", half)
    assert checks.run_test(types.SimpleNamespace(all=False)) == code


def test_the_virtual_arms_pace_is_its_clock_by_ours(monkeypatch):
    arm_clock, our_clock = iter((10.0, 13.0)), iter((5.0, 7.0))
    monkeypatch.setattr(measure.time, "perf_counter", lambda: next(our_clock))
    arm = types.SimpleNamespace(line=types.SimpleNamespace(clock=lambda: next(arm_clock)))
    assert measure._pace(arm, lambda: None) == 1.5


def test_the_calibrations_report_says_what_it_is_worth_and_where_it_comes_from(tmp_path):
    code, out, _ = run("calibrate", "bench", "--report", tmp_path / "c.html")
    page = (tmp_path / "c.html").read_text(encoding="utf-8")
    assert code == 0 and "a rendered recording: made by a renderer, not by cameras" in page
    assert "verdict: good" in page and "The next boards help most here" in page and "data:image/png;base64," in page


def test_what_is_missing_for_a_place_is_said(bench, tmp_path, capsys):
    mine = tmp_path / "mine"
    for name in ("calibration", "depth", "position", "evaluation"):
        shutil.copytree(bench.path / name, mine / name)
    for name in ("recording.json", "calibration.json"):
        shutil.copy(bench.path / name, mine)
    table = mine / "position" / "measured.csv"
    table.write_text(table.read_text(encoding="utf-8").splitlines()[0] + "\n", encoding="utf-8")
    assert main(["demo", str(mine)]) == 2 and "has no rows" in capsys.readouterr().err
    table.unlink()
    assert main(["demo", str(mine)]) == 0 and "position/measured.csv is missing" in capsys.readouterr().out
    shutil.copy(bench.path / "position" / "measured.csv", table)
    (table.parent / "left").rename(table.parent / "lefts")  # they are there, and not read: that is to be mended
    assert main(["demo", str(mine)]) == 1 and "here: position/left is missing. The folder" in capsys.readouterr().out
