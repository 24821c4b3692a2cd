"""Every panel without a browser: each control changes the picture, and no value breaks it."""

import itertools
from types import SimpleNamespace

import cv2
import ipywidgets
import numpy as np
import pytest

from stereo_lab import plots, widgets
from stereo_lab.errors import StereoLabError
from stereo_lab.motion import Motor
from stereo_lab.recording.marks import read_marks
from stereo_lab.widgets.lesson07 import _with_words
from stereo_lab.widgets.lesson08 import MARGIN_PX
from stereo_lab.widgets.lesson09 import ZOOM_PX
from stereo_lab.widgets.panel import LETTERS, ORANGE
from tests.written import assert_as_written

DISPARITY = np.array([160.0, 103.0, 73.0, 60.0, 49.0, 42.0])
DEPTH = np.array([520.0, 813.0, 1104.0, 1397.0, 1688.0, 1980.0])


@pytest.fixture(scope="module")
def panels(bench, bench_calibration):
    pair = bench.samples("evaluation")[0].pair
    left, right = pair.left, pair.right
    before = left.copy()
    made = [
        widgets.color_thresholds(left, "red"),
        widgets.hough_parameters(left, "red"),
        widgets.epipolar_line(bench_calibration, left, right),
        widgets.ball_against_disparity(120.0, 690.0, 40.0),
        widgets.depth_samples(DISPARITY, DEPTH),
        widgets.signs_against_squint(120, 690, [520, 1100, 1980]),
        widgets.arm_reaches(bench.arm),
        widgets.stopping(Motor()),
        widgets.registering(bench.arm),
        widgets.rig_planner(40.0),
    ]
    assert np.array_equal(left, before)
    return made


def test_space_is_turned_by_its_sliders():
    things = [
        plots.Thing("line", [[0, 0, 0], [100, 50, 900]], plots.BLUE),
        plots.Thing("", [[5, 5, 5]], plots.BLACK, "o"),
    ]
    panel = widgets.space(things, "A line")
    seen = {bytes(panel.picture.value)}
    for control, value, words in (
        ("turned_deg", 90, "behind the bench"),
        ("turned_deg", 0, "side"),
        ("raised_deg", 90, "above"),
    ):
        panel.control(control).value = value
        seen.add(bytes(panel.picture.value))
        assert words in panel.text.value
    assert len(seen) == 4 and repr(panel) == "panel: space: A line"


def limits(control):
    if isinstance(control, ipywidgets.IntRangeSlider):
        return [(control.min, control.min), (control.max, control.max), (control.min, control.max)]
    if isinstance(control, ipywidgets.IntSlider):
        return [control.min, control.max]
    if isinstance(control, ipywidgets.Checkbox):
        return [False, True]
    return list(control.options)


def test_every_control_changes_the_picture_or_the_text(panels):
    for panel in panels:
        for name, control in panel._controls.items():
            start, shown = control.value, set()
            for value in limits(control):
                control.value = value
                assert bytes(panel.picture.value).startswith(b"\xff\xd8") and panel.text.value
                shown.add((bytes(panel.picture.value), panel.text.value))
            control.value = start
            assert len(shown) > 1, f"{panel}: {name} does nothing"


def thumbnail(panel):
    """The panel's picture, 30 by 15 patches of mean grey."""
    image = cv2.imdecode(np.frombuffer(bytes(panel.picture.value), np.uint8), cv2.IMREAD_GRAYSCALE)
    return f"{image.shape[1]}x{image.shape[0]}: " + " ".join(
        map(str, cv2.resize(image, (30, 15), interpolation=cv2.INTER_AREA).ravel())
    )


def test_panels_show_what_is_written_down(panels):
    for panel in panels:
        lines = [panel.text.value, thumbnail(panel)]
        for name, control in panel._controls.items():
            start = control.value
            for value in limits(control):
                control.value = value
                lines += [f"{name} {value}", panel.text.value, thumbnail(panel)]
            control.value = start
        assert_as_written(f"panels/{panel!r}", lines, {"whole": 3, "absolute": 0.2})


def test_repr_is_fixed(panels):
    names = [repr(panel) for panel in panels]
    panels[0].control("hue_low").value = 50
    assert names == [repr(panel) for panel in panels] and len(set(names)) == len(panels)


def test_red_wraps_round_zero(bench):
    panel = widgets.color_thresholds(bench.samples("evaluation")[0].pair.left, "red")
    assert "wraps" in panel.text.value
    panel.control("hue_low").value, panel.control("hue_high").value = 40, 80
    assert "wraps" not in panel.text.value


def test_fewer_than_three_samples_is_a_sentence():
    panel = widgets.depth_samples(DISPARITY, DEPTH)
    assert [panel.control(f"sample_{k}").value for k in range(4)] == [True, True, True, False]
    for k in range(4):
        panel.control(f"sample_{k}").value = False
    assert "choose three" in panel.text.value


def test_samples_that_no_curve_comes_near_are_drawn_all_the_same():
    """The second rig's, where the paper's way takes a poster for the ball: every choice of three gives a picture of its own."""
    panel = widgets.depth_samples([129, 70, 467, 91, 56, 46], [520, 984, 1680, 752, 1216, 1449])
    assert bytes(panel.picture.value).startswith(b"\xff\xd8")
    assert "Eq. 4: " in panel.text.value and "a/(d-d0)+c: no such curve" in panel.text.value
    drawn = set()
    for three in itertools.combinations(range(6), 3):
        for k in range(6):
            panel.control(f"sample_{k}").value = k in three
        drawn.add(bytes(panel.picture.value))
    assert len(drawn) == 20


def test_bad_arguments_are_named():
    with pytest.raises(StereoLabError, match="baseline_mm"):
        widgets.ball_against_disparity(-1.0, 690.0, 40.0)
    with pytest.raises(StereoLabError, match="as many"):
        widgets.depth_samples(DISPARITY, DEPTH[:3])
    with pytest.raises(StereoLabError, match="colour picture"):
        widgets.color_thresholds(np.zeros((4, 4)), "red")


def test_a_target_out_of_reach_is_a_sentence(bench):
    panel = widgets.arm_reaches(bench.arm)
    assert "shoulder" in panel.text.value
    panel.control("x_mm").value = panel.control("x_mm").max
    assert "out of reach" in panel.text.value


def test_a_wider_zone_stops_nearer_to_the_goal():
    panel = widgets.stopping(Motor())
    stops = []
    for zone in (0, 5, 25):
        panel.control("zone_deg").value = zone
        stops.append(abs(float(panel.text.value.split()[1])))
    assert stops[0] > stops[1] > stops[2]


def test_a_registration_finds_what_is_set_and_worse_cameras_find_it_worse(bench):
    panel = widgets.registering(bench.arm)
    panel.control("zero1_deg").value, panel.control("link2_mm").value, panel.control("off_mm").value = 3, -4, 0
    assert "zero 1 +3.0 ± 0.0 degrees, link 2 196.0 ±" in panel.text.value
    off = []
    for error in (1, 5):
        panel.control("off_mm").value = error
        off.append(float(panel.text.value.split("told to be, ")[1].split()[0]))
    assert 0 < off[0] < 2 < off[1]


def test_a_zero_has_no_minus_and_a_product_its_unit(bench):
    panel = widgets.registering(bench.arm)
    panel.control("zero1_deg").value, panel.control("off_mm").value = 0, 0
    for link2_mm in (-2, 2):
        panel.control("link2_mm").value = link2_mm
        for count in range(panel.control("count").min, panel.control("count").max + 1):
            panel.control("count").value = count
            assert "zero 1 +0.0 " in panel.text.value
    assert widgets.ball_against_disparity(120.0, 690.0, 40.0).text.value.endswith("disparity 82800 mm px")


def test_the_planner_says_what_lesson_04_says():
    """Twice the baseline halves the error and takes a strip away; a wider lens sees more and knows less."""
    panel = widgets.rig_planner(40.0)

    def told():
        words = panel.text.value.replace("±", " ").split()
        return float(words[4]), float(words[words.index("see") + 1])

    panel.control("noise").value, panel.control("depth_mm").value = 100, 2000
    (error, both), panel.control("baseline_mm").value = told(), 240
    assert told() == (pytest.approx(error / 2, rel=0.02), both - 120)
    panel.control("angle_deg").value = 90
    assert told()[0] > error / 2 and told()[1] == pytest.approx(2 * 2000 - 240)


@pytest.fixture
def words_of(monkeypatch):
    """A function that lets a panel draw, and gives the picture and the boxes of the words in it, which must be apart."""
    put, boxes = cv2.putText, []

    def spy(view, words, place, font, size, color, thickness, line):
        wide, high = cv2.getTextSize(words, font, size, thickness)[0]
        boxes.append((words, place[0], place[1] - high, place[0] + wide, place[1]))
        assert size >= LETTERS
        return put(view, words, place, font, size, color, thickness, line)

    def words_of(panel, *values):
        boxes.clear()
        image = panel._draw(*values, **({} if values else {k: c.value for k, c in panel._controls.items()}))[0]
        for a, b in itertools.combinations(boxes, 2):
            assert a[3] < b[1] or b[3] < a[1] or a[4] < b[2] or b[4] < a[2], (panel, values, a, b)
        assert all(0 <= x0 < x1 <= image.shape[1] and 0 <= y0 < y1 <= image.shape[0] for _, x0, y0, x1, y1 in boxes)
        return image, boxes

    monkeypatch.setattr(cv2, "putText", spy)
    return words_of


def test_words_in_pictures_are_large_and_apart(panels, words_of):
    drawn = {repr(panel) for panel in panels if words_of(panel)[1]}
    assert len(drawn) >= 6, drawn


@pytest.mark.parametrize("width", [768, 1280, 2560])
def test_words_of_the_live_cell_are_as_large_at_any_width(words_of, width):
    """A page shows a wide picture smaller, and the words in it."""
    words = ["100 pairs a second, 100 % CPU, 1000 MB", "ball x -282  y -270  depth 1000 mm", "arm -123, -123 degrees"]
    panel = SimpleNamespace(_draw=lambda: (_with_words(np.zeros((480, width, 3), np.uint8), words),), _controls={})
    boxes = words_of(panel)[1]
    assert all((y1 - y0) / width > 0.012 for _, _, y0, _, y1 in boxes) and len(boxes) == 3


def test_the_planners_words_lie_on_nothing_and_its_bar_ends_at_the_cameras(words_of):
    """At all ends of its sliders: words in the picture and apart, and no depth of less than zero."""
    panel = widgets.rig_planner(40.0)
    for values in itertools.product((30, 120, 500), (300, 1000, 3000), (30, 50, 100), (320, 1920), (1, 100)):
        image, boxes = words_of(panel, *values)
        axis = [(x0 + x1) / 2 for words, x0, _, x1, _ in boxes if words.isdigit()]
        assert len(axis) >= 2 and min(np.diff(axis)) >= 50, (values, axis)
        orange = np.flatnonzero((image == ORANGE).all(2).any(0))
        assert orange.min() >= MARGIN_PX - 8, values


def test_a_ball_is_marked_by_clicks_keys_and_buttons(tmp_path):
    """Two clicks are a mark, sliders change it, a button says none; what is saved is what was marked."""
    shots = {"a": np.full((100, 200, 3), 90, np.uint8), "b": np.zeros((100, 200, 3), np.uint8)}
    panel = widgets.mark_balls(shots, tmp_path / "marks.csv")
    wide = 200 + ZOOM_PX
    empty = panel.view()

    def click(u, v):
        panel.clicked.value = f"{(u + 0.5) / wide} {(v + 0.5) / 100} {u}"

    click(60, 40)
    assert "rim" in panel.text.value and not panel.marks
    click(60, 52)
    assert np.allclose(panel.marks["a"], (60, 40, 12)) and (panel.view() != empty).any()
    panel.sliders["radius"].value += 3
    assert np.allclose(panel.marks["a"], (60, 40, 15))
    click(300, 40)
    assert "outside" in panel.text.value
    panel.clicked.value = "no place"
    panel.buttons["next"].click()
    panel.buttons["no ball"].click()
    assert panel.marks["b"] is None and "1 with the ball, 1 without" in panel.text.value
    panel.buttons["save"].click()
    assert read_marks(tmp_path / "marks.csv") == {"a": (60, 40, 15), "b": None} and "is written" in panel.text.value
    again = widgets.mark_balls({"b": shots["b"]}, tmp_path / "marks.csv")  # the cell run again, with fewer pictures
    again.mark((60.25, 40.75, 12.5))
    again.sliders["radius"].value += 3
    again.buttons["save"].click()
    assert read_marks(tmp_path / "marks.csv") == {"a": (60, 40, 15), "b": (60.25, 40.75, again.sliders["radius"].value)}
    with pytest.raises(StereoLabError, match="purple"):
        widgets.mark_balls(shots, tmp_path / "marks.csv", "purple")
    panel.buttons["clear"].click()
    assert list(panel.marks) == ["a"] and repr(panel) == "panel: mark the ball"
    assert "image/jpeg" in panel._repr_mimebundle_()
    with pytest.raises(StereoLabError, match="no pictures to mark"):
        widgets.mark_balls({})


def click(panel, u, v):
    """As the page does it: the place of a click in parts of the picture and what stands beside it."""
    height, width = panel.view().shape[:2]
    panel.clicked.value = f"{(u + 0.5) / width} {(v + 0.5) / height} {u}"


def test_two_panels_on_one_table_keep_each_others_marks(tmp_path):
    """Two learners, or the cell in two tabs: each writes what it changed, and nothing else."""
    shots, table = {name: np.zeros((100, 200, 3), np.uint8) for name in "abcd"}, tmp_path / "marks.csv"
    first = widgets.mark_balls(shots, table)
    first.marks = dict.fromkeys("ab", (50.0, 50.0, 9.0))
    first.save()
    one, other = (widgets.mark_balls(shots, table) for _ in range(2))
    one.clear()  # a
    one.go(2)
    one.mark((60.0, 40.0, 12.0))  # c
    one.save()
    other.go(1)
    other.mark(None)  # b
    other.save()
    assert read_marks(table) == other.marks == {"b": None, "c": (60.0, 40.0, 12.0)}
    one.save()
    assert read_marks(table) == one.marks == other.marks
    table.unlink()
    one.save()
    assert read_marks(table) == one.marks  # all that this panel knows
    table.write_text("picture,u\n")
    one.save()
    assert "is written" not in one.text.value and table.read_text() == "picture,u\n"


def test_sliders_begin_in_the_middle_of_a_picture_that_is_not_marked(tmp_path):
    """A key that is pressed there marks no ball at the place of the last one."""
    shots = {name: np.zeros((100, 200, 3), np.uint8) for name in "abc"}
    panel = widgets.mark_balls(shots, tmp_path / "marks.csv")
    panel.mark((30.0, 20.0, 8.0))
    panel.go(1)
    assert [slider.value for slider in panel.sliders.values()] == [100, 50, 12] and list(panel.marks) == ["a"]
    panel.sliders["u"].value += 1
    assert panel.marks["b"] == (101, 50, 12)
    panel.go(1)
    click(panel, 70, 60)
    assert [slider.value for slider in panel.sliders.values()] == [70, 60, 12]
    panel.go(1)
    assert [slider.value for slider in panel.sliders.values()] == [30, 20, 8]


def test_a_mark_that_no_ball_has_is_refused(tmp_path):
    """A rim that is too near or too far; and each picture has bounds of its own."""
    shots = {"a": np.zeros((100, 200, 3), np.uint8), "b": np.zeros((480, 640, 3), np.uint8)}
    panel = widgets.mark_balls(shots, tmp_path / "marks.csv")
    click(panel, 60, 40)
    click(panel, 61, 40)
    assert "centre again" in panel.text.value and not panel.marks
    click(panel, 150, 40)
    assert "90 px from its centre" in panel.text.value and "50 px at most" in panel.text.value and not panel.marks
    click(panel, 60, 41)
    click(panel, 60, 51)
    assert panel.marks["a"] == pytest.approx((60, 41, 10))
    for step, most in ((1, [639, 479, 240]), (1, [199, 99, 50])):
        panel.go(step)
        assert [slider.max for slider in panel.sliders.values()] == most
    assert (
        panel.sliders["radius"].min == 1 and panel.marks["a"] == pytest.approx((60, 41, 10)) and len(panel.marks) == 1
    )


def test_what_is_proposed_is_counted(bench, tmp_path):
    """Marks of one's own are not among it; a ball and none are told apart."""
    shots = {p.name: p.left for p in bench.pairs("snaps")[:3]}
    shots["none"] = np.full_like(next(iter(shots.values())), 255)
    panel = widgets.mark_balls(shots, tmp_path / "marks.csv")
    panel.mark(own := (5.0, 5.0, 4.0))
    panel.propose()
    assert "Proposed: 2 with a ball (an orange circle), 1 without." in panel.text.value
    assert panel.marks[panel.name] == own and panel.marks["none"] is None
    panel.propose()
    assert "Nothing is proposed" in panel.text.value


def test_marks_are_proposed_and_a_folder_is_no_table(bench, tmp_path):
    shots = {p.name: p.left for p in bench.pairs("snaps")[:3]}
    panel = widgets.mark_balls(shots, tmp_path, "red")
    panel.buttons["propose"].click()
    truth = [bench.true_ball("snaps", name)["left"] for name in shots]
    assert np.allclose(list(panel.marks.values()), truth, atol=3)
    panel.buttons["save"].click()
    assert "Name a plain file" in panel.text.value
