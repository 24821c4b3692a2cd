"""What every figure draws: its curves, marks, words and bounds, as they are written down."""

import inspect
import itertools

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.colors import to_hex, to_rgb
from matplotlib.text import Text
from mpl_toolkits.mplot3d import proj3d

from stereo_lab import plots
from stereo_lab.position import LineFit
from tests.written import assert_as_written

ARM = np.array([[0.0, 0.0], [200.0, 100.0], [150.0, 260.0]])
PICTURE = np.arange(4 * 6 * 3, dtype=np.uint8).reshape(4, 6, 3)
UP, DOWN = np.array([1.0, 2.0, 4.0, 7.0]), np.array([9.0, 5.0, 2.0, 1.0])
CORNERS = np.array([[u, v] for v in (10.0, 22.0) for u in (5.0, 17.0, 30.0)])
GRID = np.array([[u, v] for v in (5.0, 20.0, 40.0) for u in (5.0, 20.0, 40.0, 60.0)])

CALLS = {
    "show_image": lambda ax: plots.show_image(PICTURE, "A title", ax),
    "side_by_side": lambda ax: plots.side_by_side(PICTURE, PICTURE, [1.0, 2.5], "A title", ax),
    "mark_ball": lambda ax: plots.mark_ball(3.0, 2.0, 1.5, ax),
    "line_fit": lambda ax: plots.line_fit(
        UP, 3 * UP - 1, DOWN[:2], 3 * DOWN[:2], LineFit.fit(UP, 3 * UP - 1), ("u (px)", "x (mm)"), "A title", ax
    ),
    "scatter_errors": lambda ax: plots.scatter_errors(UP, -DOWN, 10.0, "A title", ax),
    "histogram_errors": lambda ax: plots.histogram_errors(np.array([-1.0, 2.0, 2.5, -4.0]), "A title", ax),
    "rig_from_above": lambda ax: plots.rig_from_above(-60.0, 120.0, 1000.0, 450.0, UP, 100 * DOWN, "A title", ax),
    "jump_against_depth": lambda ax: plots.jump_against_depth(UP, DOWN, "A title", ax),
    "grids": lambda ax: plots.grids([CORNERS, CORNERS + 1], [CORNERS + 2, CORNERS + 3], (64, 48), "A title", ax),
    "mark_corners": lambda ax: plots.mark_corners(CORNERS, 3, ax),
    "error_by_pair": lambda ax: plots.error_by_pair(["a", "b", "c"], [1.0, 2.0, 9.0], 2.0, {"c"}, "A title", ax),
    "how_many_pairs": lambda ax: plots.how_many_pairs([3, 5, 8, 12], UP, DOWN, "A title", ax),
    "depth_doubt": lambda ax: plots.depth_doubt(
        GRID, GRID[:, 0] / 10, np.arange(12) % 3, np.array([CORNERS[[0, 2, 5, 3]]]), (64, 48), "A title", ax
    ),
    "mask_view": lambda ax: plots.mask_view(PICTURE[..., 0], "A title", ax),
    "hue_circle": lambda ax: plots.hue_circle("A title", ax),
    "heat": lambda ax: plots.heat(PICTURE[..., 1], (2.0, 1.0), "A title", ax),
    "flow": lambda ax: plots.flow(["one", "two", "three"], "A title", ax),
    "numbers_by_file": lambda ax: plots.numbers_by_file(["a", "b"], [1.0, 9.0], ["b"], "px", "A title", ax),
    "where_boards_were": lambda ax: plots.where_boards_were(np.array([[3.0, 4.0], [30, 20]]), (64, 48), "A title", ax),
    "both_views": lambda ax: plots.both_views(120.0, 600.0, 640.0, [(400.0, 300.0), (1000.0, 900.0)], "A title", ax),
    "value_by_pair": lambda ax: plots.value_by_pair(["a", "b"], [1.0, 9.0], "degrees", "A title", ax),
    "told_and_typed": lambda ax: plots.told_and_typed(["a", "b"], UP[:2], DOWN[:2], "A title", ax),
    "own_errors": lambda ax: plots.own_errors(["1", "2"], UP[:2], -DOWN[:2], "A title", ax),
    "depth_errors": lambda ax: plots.depth_errors([("60 mm", UP, DOWN), ("120 mm", UP, UP)], "A title", ax),
    "rig_drawing": lambda ax: plots.rig_drawing(120.0, 1000.0, 350.0, ("Above", "Side"), ax.figure.subplots(1, 2)),
    "numbered_things": lambda ax: plots.numbered_things(PICTURE, [[3.0, 2.0, 1.5], [5.0, 3.0, 1.0]], "A title", ax),
    "boundaries": lambda ax: plots.boundaries(
        UP,
        DOWN,
        np.array([False, True, True, True, False, True])[: len(UP)],
        {"first": (1, 1, -2.0), "last": (0, 2, 1)},
        ("x", "y"),
        "A title",
        ax,
    ),
    "loss_falls": lambda ax: plots.loss_falls([0.7, 0.3, 0.2], "A title", ax),
    "shares": lambda ax: plots.shares(["a", "b"], [20.0, 90.0], [10.0, 80.0], [40.0, 95.0], "right (%)", "A title", ax),
    "many_draws": lambda ax: plots.many_draws(
        {"from nothing": ([10.0, 20.0], [80.0, 90.0])}, {"the paper's way": (100.0, 14.0)}, "A title", ax
    ),
    "evidence_counts": lambda ax: plots.evidence_counts(["rim", "shade"], [19, -2], "A title", ax),
    "answers_bar": lambda ax: plots.answers_bar(["a", "b"], [20.0, 40.0], [90.0, 95.0], "A title", ax),
    "suspect": lambda ax: plots.suspect(PICTURE, 3.0, 2.0, 1.5, "A title", ax),
    "signs": lambda ax: plots.signs({"rim": 1.5, "shade": -2.0, "seen": 0.0}, "A title", True, ax),
    "reliability": lambda ax: plots.reliability(
        np.array([0.02, np.nan, 0.9]), np.array([0.0, np.nan, 0.8]), np.array([50, 0, 5]), "A title", ax
    ),
    "error_against_depth": lambda ax: plots.error_against_depth(
        [("lines", UP, DOWN), ("rigid", UP, 0.01 * DOWN)], 3.0, "A title", ax
    ),
    "rays_spread": lambda ax: plots.rays_spread([0.1, 0.3], [500.0, 1000.0], 1000.0, "A title", ax),
    "similar_triangles": lambda ax: plots.similar_triangles(120.0, 690.0, 600.0, 40.0, "A title", ax),
    "depth_curves": lambda ax: plots.depth_curves(
        [("Eq. 4", UP, DOWN), ("Eq. 3", UP, UP)], UP, DOWN, DOWN, UP, "A title", ax
    ),
    "error_grid": lambda ax: plots.error_grid(
        np.array([[1.0, np.nan], [30.0, 2.0]]), ["a", "b"], ["c, d", "e"], "A title", ax
    ),
    "depth_terms": lambda ax: plots.depth_terms(UP, [("m/d", DOWN), ("c", UP)], "A title", ax),
    "beams_cross": lambda ax: plots.beams_cross(
        120.0, [("near", [(3, 0), (4, 1), (6, 0), (4, -1)]), ("far", [(6, 0), (8, 2), (15, 0), (8, -2)])], "A title", ax
    ),
    "error_band": lambda ax: plots.error_band(UP, DOWN, UP, 0.1 * UP, "A title", ax),
    "error_of_baseline": lambda ax: plots.error_of_baseline(
        UP, [("at 2 m", DOWN), ("at 1 m", DOWN / 4)], 3.0, "A title", ax
    ),
    "two_links": lambda ax: plots.two_links(ARM, (25.0, 50.0), ("l1", "l2"), "A title", ax),
    "arms": lambda ax: plots.arms([("down", ARM), ("up", ARM[:, ::-1])], [(100.0, 50.0)], "A title", ax),
    "reach": lambda ax: plots.reach(50.0, 450.0, UP, DOWN, np.arange(16).reshape(4, 4) % 3, ARM, "A title", ax),
    "cosine_triangle": lambda ax: plots.cosine_triangle(ARM, ("l1", "l2", "r"), (25.0, 50.0, 30.0), "A title", ax),
    "one_degree": lambda ax: plots.one_degree(ARM, [("θ1", (30.0, 40.0)), ("θ2", (-10.0, 20.0))], "A title", ax),
    "turret": lambda ax: plots.turret((ARM[1], ARM[2]), ARM, ("Above", "Side"), ax.figure.subplots(1, 2)),
    "motor_curves": lambda ax: plots.motor_curves(UP, [("one", DOWN), ("two", UP)], "A title", ax),
    "stops": lambda ax: plots.stops([("one", UP, 10 * UP), ("two", UP, 9 * UP)], 70.0, "A title", ax, 5.0, 2.0),
    "holding": lambda ax: plots.holding(10 * UP, (UP, DOWN), 8.0, "A title", ax),
    "plan": lambda ax: plots.plan(UP, DOWN, UP + 1, DOWN + 1, "A title", ax),
    "stopping_errors": lambda ax: plots.stopping_errors([("one", DOWN), ("two", 0.001 * UP)], "A title", ax),
    "pose_at_ball": lambda ax: plots.pose_at_ball(ARM, (160.0, 290.0), 20.0, (25.0, 50.0), "A title", ax),
    "over_time": lambda ax: plots.over_time([("one", UP, DOWN), ("two", UP, UP)], "gap (mm)", "A title", ax),
    "certainty": lambda ax: plots.certainty(UP, DOWN, 0.1 * UP, UP < 3, "x (mm)", "A title", ax),
    "milliseconds": lambda ax: plots.milliseconds({"cameras": 67.0, "angles": 0.1, "order": 3.0}, "A title", ax),
    "usage": lambda ax: plots.usage(DOWN, 23.4, "CPU", "A title", ax),
    "touches": lambda ax: plots.touches(ARM, ARM + 1, UP, "A title", ax.figure.subplots(1, 2)),
}


def describe(ax):
    """All that is drawn on an axis, as plain numbers and words."""
    told = [f"title {ax.get_title()!r} x {ax.get_xlabel()!r} y {ax.get_ylabel()!r}"]
    told.append(f"scales {ax.get_xscale()} {ax.get_yscale()} aspect {ax.get_aspect()} axis {ax.axison}")
    for name, fixed, limits in (
        ("x", not ax.get_autoscalex_on(), ax.get_xlim()), ("y", not ax.get_autoscaley_on(), ax.get_ylim()),
    ):  # fmt: skip
        told.append(
            f"{name} from {numbers(limits)}" if fixed else f"{name} runs {'up' if limits[0] < limits[1] else 'down'}"
        )
    for line in ax.lines:
        look = f"{to_hex(line.get_color())} {line.get_linestyle()} {line.get_marker()} {line.get_linewidth():g} {line.get_markersize():g}"
        label = "" if line.get_label().startswith("_") else repr(line.get_label())
        told.append(f"line {look} {label} {numbers(line.get_xdata())} | {numbers(line.get_ydata())}")
    for patch in ax.patches:
        box = numbers(patch.get_path().transformed(patch.get_patch_transform()).get_extents().bounds)
        told.append(
            f"{type(patch).__name__} {to_hex(patch.get_facecolor())} {patch.get_hatch() or ''} {patch.get_fill()} {box}"
        )
    for text in ax.texts:
        place, shift = getattr(text, "xy", text.get_position()), text.get_position()
        look = f"{to_hex(text.get_color())} {text.get_ha()} {text.get_va()}"
        told.append(f"text {text.get_text()!r} at {numbers(place)} moved {numbers(shift)} {look}")
    for image in ax.images:
        told.append(
            f"image {numbers(image.get_array().astype(float).ravel()[:24])} extent {numbers(image.get_extent())}"
        )
    for heap in ax.collections:
        box = numbers(heap.get_datalim(ax.transData).bounds)
        told.append(
            f"{type(heap).__name__} {box} {numbers(np.ravel(heap.get_array())[:16]) if heap.get_array() is not None else ''}"
        )
    legend = ax.get_legend()
    told.append("legend " + repr([t.get_text() for t in legend.get_texts()] if legend else None))
    for name, axis in (("x", ax.xaxis), ("y", ax.yaxis)):
        if isinstance(axis.get_major_locator(), matplotlib.ticker.FixedLocator):
            told.append(f"{name} ticks {numbers(axis.get_ticklocs())} {[t.get_text() for t in axis.get_ticklabels()]}")
    return told


def numbers(values):
    return " ".join(f"{v:.4g}" for v in np.asarray(values, float).ravel() + 0.0)


def drawn(name):
    fig, axes = plots.figure()
    try:
        CALLS[name](axes[0, 0])
        return [words for ax in fig.axes for words in describe(ax)]
    finally:
        plt.close(fig)


@pytest.mark.parametrize("name", CALLS)
def test_a_figure_draws_what_is_written_down(name):
    assert_as_written(f"plots/{name}", drawn(name))


@pytest.mark.parametrize("theta1", [-60.0, 25.0, 90.0, 120.0])
@pytest.mark.parametrize("theta2", [-80.0, -35.0, 30.0, 70.0])
def test_no_word_of_an_arm_hides_another_one(theta1, theta2):
    """Whatever angles are tried out; and an angle below zero is drawn as wide as one above."""
    turned = np.radians([theta1, theta1 + theta2])
    points = np.cumsum([(0, 0), *np.column_stack([np.cos(turned), np.sin(turned)]) * [[250], [200]]], axis=0)
    fig, axes = plots.figure(height=4.8)
    ax = plots.two_links(points, (theta1, theta2), ("l1 = 250 mm", "l2 = 200 mm"), "A title", axes[0, 0])
    fig.canvas.draw()
    boxes = {text.get_text(): text.get_window_extent() for text in ax.texts}
    assert len(boxes) == 7
    hidden = [(a, b) for a, b in itertools.combinations(boxes, 2) if boxes[a].overlaps(boxes[b])]
    assert not hidden
    assert [arc.theta2 - arc.theta1 for arc in ax.patches] == pytest.approx([abs(theta1), abs(theta2)])
    plt.close(fig)


def contrast_with_white(color):
    """By WCAG 2.2, from 1 to 21."""
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in to_rgb(color)]
    return 1.05 / (np.dot((0.2126, 0.7152, 0.0722), linear) + 0.05)


OVER_PICTURES = {"mark_corners", "depth_doubt"}  # drawn over a photograph, or a field of colours


@pytest.mark.parametrize("name", sorted(set(CALLS) - OVER_PICTURES))
def test_lines_and_words_stand_out_from_white(name):
    """3 to 1 for lines and bold words, 4.5 to 1 for others; a mark is seen by its edge."""
    fig, axes = plots.figure()
    CALLS[name](axes[0, 0])
    for ax in fig.axes:
        if ax.images or ax.name == "3d":
            continue
        for line in ax.lines:
            if line.get_linestyle() not in ("None", "", " "):
                assert contrast_with_white(line.get_color()) >= 3, line
            elif line.get_marker() not in ("None", None, ""):
                assert contrast_with_white(line.get_markeredgecolor()) >= 3, line
        for words in ax.texts:
            assert contrast_with_white(words.get_color()) >= (3 if words.get_weight() == "bold" else 4.5), words
    plt.close(fig)


def test_every_figure_is_written_down():
    figures = {n for n, f in inspect.getmembers(plots, inspect.isfunction) if "ax" in inspect.signature(f).parameters}
    figures |= {
        n for n, f in inspect.getmembers(plots, inspect.isfunction) if "axes" in inspect.signature(f).parameters
    }
    assert figures - {"space"} == set(CALLS)  # the one in space has tests of its own below


@pytest.mark.parametrize("name", CALLS)
def test_figures_take_the_current_axis_and_give_it_back(name):
    given = CALLS[name]
    fig, axes = plots.figure()
    try:
        plt.sca(axes[0, 0])
        back = given(axes[0, 0])
        assert back is axes[0, 0] or set(back) <= set(fig.axes)
    finally:
        plt.close(fig)


def test_a_figure_becomes_a_png_and_is_closed():
    fig, axes = plots.figure(2, 3, height=4.0, width=9.0)
    assert axes.shape == (2, 3) and fig.get_size_inches().tolist() == [9.0, 4.0]
    assert plots.png(fig).startswith(b"\x89PNG") and not plt.fignum_exists(fig.number)


THINGS = [
    plots.camera_at("left", [10, 20, 30], np.eye(3), (0.5, 0.4), 100),
    plots.Thing("", [[0, 0, 0], [900, 200, 2000]], plots.GREEN, "--"),
    plots.Thing("ball", [[300, -100, 1500]], plots.ORANGE, "o"),
]


def test_a_camera_shows_what_it_sees():
    """The base of the pyramid: straight ahead by its length, and half the view to each side."""
    points = np.array(THINGS[0].points_mm)
    base = points[(points != [10, 20, 30]).any(1)]
    assert {tuple(p) for p in base} == {(10.0 + i * 50, 20.0 + j * 40, 130.0) for i in (-1, 1) for j in (-1, 1)}
    turned = np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]], float)  # looks to the right
    assert np.allclose(
        np.mean(np.unique(plots.camera_at("", [0, 0, 0], turned, (1, 1), 9).points_mm, axis=0), 0), [7.2, 0, 0]
    )


@pytest.mark.parametrize(("turned", "raised"), [(-90, 0), (-60, 20), (120, 70)])
def test_in_space_all_is_seen_and_to_one_scale(turned, raised):
    fig = plt.figure()
    ax = plots.space(THINGS, "A title", fig.add_subplot(projection="3d"), turned, raised)
    fig.canvas.draw()
    low, high = np.transpose([ax.get_xlim(), ax.get_ylim(), ax.get_zlim()])
    for thing in THINGS:
        x, y, depth = np.transpose(np.asarray(thing.points_mm, float))
        inside = np.column_stack([x, depth, y])
        assert (inside >= low).all() and (inside <= high).all()
    assert np.allclose(np.divide(ax.get_box_aspect(), high - low), ax.get_box_aspect()[0] / (high - low)[0])
    assert (ax.azim, ax.elev) == (turned, raised) and ax.get_title() == "A title"
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["left", "ball"]
    plt.close(fig)


def test_from_behind_the_cameras_right_is_right_and_up_is_up():
    fig = plt.figure()
    ax = plots.space(THINGS, "", fig.add_subplot(projection="3d"), -90, 0)
    fig.canvas.draw()
    to_picture = lambda x, y, depth: np.array(proj3d.proj_transform(x, depth, y, ax.get_proj())[:2])
    assert (to_picture(100, 0, 1000) - to_picture(0, 0, 1000))[0] > 0
    assert (to_picture(0, 100, 1000) - to_picture(0, 0, 1000))[1] > 0
    plt.close(fig)


IN_STYLE = [name for name in CALLS if getattr(plots, name).__module__.rpartition(".")[2] in ("lesson01", "lesson08")]


@pytest.mark.parametrize("name", sorted({*IN_STYLE} - {"rig_drawing"}))  # above, that one makes axes of its own
def test_text_that_comes_after_the_axes_is_as_large_as_theirs(name):
    figure, axes = plots.figure()
    CALLS[name](axes[0, 0])
    figure.draw_without_rendering()
    small = [text.get_text() for text in figure.findobj(Text) if text.get_text() and text.get_fontsize() < 11]
    plt.close(figure)
    assert not small
