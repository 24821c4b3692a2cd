"""Every ipywidgets panel. Each is a picture with sliders beside it, drawn by OpenCV, and feeds nothing downstream.

A panel answers a slider by drawing its picture anew and writing one line of text. The keyboard works: Tab goes
to a slider, the arrow keys move it.
"""

from __future__ import annotations

from collections.abc import Callable

import cv2
import ipywidgets
import numpy as np
from numpy.typing import ArrayLike

from stereo_lab.calibration import StereoCalibration
from stereo_lab.depth import OffsetDepth, PaperDepth
from stereo_lab.detection import BallColor, check_image
from stereo_lab.errors import StereoLabError
from stereo_lab.kinematics import TwoLinkArm
from stereo_lab.motion import Motor, SlowDownRule, Tuning, calibrate_motor, drive, push_of

# Okabe and Ito, as OpenCV counts: blue, green, red
BLUE, ORANGE, VERMILION, BLACK, WHITE, GREY = (
    (178, 114, 0), (0, 159, 230), (0, 94, 213), (0, 0, 0), (255, 255, 255), (200, 200, 200),
)  # fmt: skip
PANEL_WIDTH = 960  # px, of the picture in a panel
LONG = {"description_width": "170px"}


class Panel(ipywidgets.VBox):
    """A picture, a line of text and controls. ``repr`` never changes, so that a notebook's output does not."""

    def __init__(
        self, name: str, controls: dict[str, ipywidgets.Widget], draw: Callable[..., tuple[np.ndarray, str]]
    ) -> None:
        """``draw(**values)`` gives the picture (BGR) and the text; ``controls`` is a dictionary of widgets."""
        self._name, self._controls, self._draw = name, controls, draw
        self.picture = ipywidgets.Image(format="jpeg", layout=ipywidgets.Layout(max_width="100%"))
        self.text = ipywidgets.Label()
        super().__init__([*controls.values(), self.text, self.picture])
        for control in controls.values():
            control.observe(self._change, "value")
        self._change()

    def __repr__(self):
        return f"panel: {self._name}"

    def control(self, name: str) -> ipywidgets.Widget:
        """One of the panel's controls, by name."""
        return self._controls[name]

    def _change(self, _=None):
        image, text = self._draw(**{name: control.value for name, control in self._controls.items()})
        self.picture.value = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, 88])[1].tobytes()
        self.text.value = text


def color_thresholds(image: np.ndarray, color: str) -> Panel:
    """Bounds on hue, lightness and saturation, and the mask that they make.

    Parameters
    ----------
    image : ndarray, BGR
    color : str, a named colour: where the sliders start

    Returns
    -------
    Panel; where the lower hue is above the upper one, the range wraps round 0
    """
    small = _fit(check_image(image), PANEL_WIDTH // 2)
    hls = cv2.cvtColor(small, cv2.COLOR_BGR2HLS)
    ranges = BallColor.named(color).ranges
    (low, high) = (ranges[0][0], ranges[-1][1])

    def draw(hue_low, hue_high, lightness, saturation):
        spans = [(hue_low, hue_high)] if hue_low <= hue_high else [(hue_low, 179), (0, hue_high)]
        mask = np.zeros(hls.shape[:2], np.uint8)
        for a, b in spans:
            lower, upper = (a, lightness[0], saturation[0]), (b, lightness[1], saturation[1])
            mask |= cv2.inRange(hls, np.array(lower), np.array(upper))
        share = 100 * np.count_nonzero(mask) / mask.size
        wraps = ", the hue wraps round 0" if len(spans) == 2 else ""
        return np.hstack([small, cv2.cvtColor(mask, cv2.COLOR_GRAY2BGR)]), f"{share:.1f} % of the pixels kept{wraps}"

    return Panel(
        "colour thresholds",
        {
            "hue_low": _slider("lower hue H", low[0], 0, 179),
            "hue_high": _slider("upper hue H", high[0], 0, 179),
            "lightness": _range("lightness L", (low[1], high[1]), 0, 255),
            "saturation": _range("saturation S", (low[2], high[2]), 0, 255),
        },
        draw,
    )


def hough_parameters(image: np.ndarray, color: str) -> Panel:
    """Blur, votes needed and radii of ``cv2.HoughCircles``, and the circles that it finds in the mask."""
    small = _fit(check_image(image), PANEL_WIDTH * 2 // 3)
    mask = BallColor.named(color).mask(small)

    def draw(blur, votes, radii):
        blurred = cv2.GaussianBlur(mask, (2 * blur + 1, 2 * blur + 1), 0)
        found = cv2.HoughCircles(
            blurred, cv2.HOUGH_GRADIENT, 1, 12, param1=200, param2=votes, minRadius=radii[0], maxRadius=max(radii)
        )
        circles = [] if found is None else found.reshape(-1, found.shape[-1])[:20, :3]
        view = cv2.addWeighted(small, 0.7, cv2.cvtColor(blurred, cv2.COLOR_GRAY2BGR), 0.3, 0)
        for k, (u, v, radius) in enumerate(circles):
            cv2.circle(view, (round(u), round(v)), round(radius), (BLUE, ORANGE)[k > 0], 2, cv2.LINE_AA)
            cv2.drawMarker(view, (round(u), round(v)), (BLUE, ORANGE)[k > 0], cv2.MARKER_CROSS, 14, 2)
        return view, f"{len(circles)} circles; the blue one has the most votes" if len(circles) else "no circle"

    return Panel(
        "Hough parameters",
        {
            "blur": _slider("blur, half width (px)", 4, 0, 15),
            "votes": _slider("votes needed", 10, 1, 60),
            "radii": _range("radii (px)", (4, min(96, small.shape[0] // 3)), 1, small.shape[0] // 3),
        },
        draw,
    )


def epipolar_line(calibration: StereoCalibration, left: np.ndarray, right: np.ndarray) -> Panel:
    """One row drawn through both pictures, raw or rectified.

    Parameters
    ----------
    calibration : StereoCalibration
    left, right : ndarray, raw pictures, BGR
    """
    pairs = {
        kind: np.hstack([_fit(image, PANEL_WIDTH // 2) for image in images])
        for kind, images in (("raw", (left, right)), ("rectified", calibration.rectify(left, right)))
    }
    height = pairs["raw"].shape[0]
    scale = left.shape[0] / height

    def draw(row, kind):
        view, y = pairs[kind].copy(), round(row / 100 * (height - 1))
        cv2.line(view, (0, y), (view.shape[1], y), ORANGE, 2, cv2.LINE_AA)
        half = view.shape[1] // 2
        cv2.line(view, (half, 0), (half, height), WHITE, 2)
        return view, f"row {y * scale:.0f} px in both {kind} pictures"

    kind = ipywidgets.ToggleButtons(
        options=["rectified", "raw"], description="pictures", style={"button_width": "110px"}
    )
    return Panel("epipolar line", {"row": _slider("row (% from the top)", 40, 0, 100), "kind": kind}, draw)


def ball_against_disparity(baseline_mm: float, focal_px: float, diameter_mm: float) -> Panel:
    """A ball before two cameras, from above: move it, and see its two pictures part."""
    for name, value in (("baseline_mm", baseline_mm), ("focal_px", focal_px), ("diameter_mm", diameter_mm)):
        if not (np.isfinite(value) and value > 0):
            raise StereoLabError(f"Expected {name} to be above zero; got {value}.")

    def draw(depth_mm):
        disparity = baseline_mm * focal_px / depth_mm
        view = np.full((340, PANEL_WIDTH, 3), 255, np.uint8)
        across = 0.3 * 340 / max(baseline_mm, 1) * min(1.0, baseline_mm / 60)  # px per mm, upwards

        def place(depth, x):
            return round(70 + depth * 800 / 2600), round(170 - (x - baseline_mm / 2) * across)

        ball = place(depth_mm, baseline_mm / 2)
        for x, color, name in ((0.0, BLUE, "left"), (baseline_mm, VERMILION, "right")):
            x = baseline_mm - x
            camera = place(0, x)
            cv2.line(view, camera, ball, color, 2, cv2.LINE_AA)
            cv2.circle(view, camera, 9, color, -1, cv2.LINE_AA)
            cv2.putText(
                view, name, (camera[0] - 60, camera[1] + 6), cv2.FONT_HERSHEY_SIMPLEX, 0.55, BLACK, 1, cv2.LINE_AA
            )
        cv2.circle(view, ball, max(5, round(diameter_mm / 2 * 800 / 2600)), ORANGE, -1, cv2.LINE_AA)
        _bar(view, disparity, baseline_mm * focal_px / 400)
        return (
            view,
            f"depth {depth_mm} mm, disparity {disparity:.1f} px; depth times disparity {depth_mm * disparity:.0f}",
        )

    return Panel("ball against disparity", {"depth_mm": _slider("depth (mm)", 1000, 400, 2500, 10)}, draw)


def depth_samples(disparity_px_N: ArrayLike, depth_mm_N: ArrayLike) -> Panel:
    """Choose the samples of the depth fit and watch the curves of Eq. 4 and of a/(d − d0) + c."""
    d, depth = np.asarray(disparity_px_N, float), np.asarray(depth_mm_N, float)
    if d.shape != depth.shape or d.ndim != 1 or len(d) < 3:
        raise StereoLabError(f"Expected as many disparities as depths, three or more; got {d.shape} and {depth.shape}.")
    first = {0, len(d) // 2, len(d) - 1}
    controls = {
        f"sample_{k}": ipywidgets.Checkbox(k in first, description=f"{depth[k]:.0f} mm at {d[k]:.1f} px", indent=False)
        for k in range(len(d))
    }

    def draw(**values):
        chosen = np.array(list(values.values()))
        view, to_px = _axes(d, depth)
        for k in range(len(d)):
            center = to_px(d[k], depth[k])
            cv2.circle(view, center, 8, BLACK, -1 if chosen[k] else 2, cv2.LINE_AA)
        if chosen.sum() < 3:
            return view, "Eq. 4 has three unknown numbers: choose three samples or more."
        span, said = np.linspace(0.9 * d.min(), 1.1 * d.max(), 120), []
        for model, color, name in ((PaperDepth, BLUE, "Eq. 4"), (OffsetDepth, VERMILION, "a/(d-d0)+c")):
            fit = model.fit(d[chosen], depth[chosen])
            line = np.array([to_px(a, b) for a, b in zip(span, fit.predict(span), strict=True)])
            dashed = line.reshape(-1, 2, 2) if model is OffsetDepth else np.stack([line[:-1], line[1:]], 1)
            cv2.polylines(view, list(np.clip(dashed, -5000, 5000)), False, color, 2, cv2.LINE_AA)
            rest = np.abs(fit.predict(d[~chosen]) - depth[~chosen])
            said.append(f"{name}: {rest.mean():.0f} mm off" if len(rest) else f"{name}: nothing left to check")
        return view, "On the samples not chosen, " + "; ".join(said) + ". Solid blue: Eq. 4; dashed red: a/(d-d0)+c."

    return Panel("depth samples", controls, draw)


def arm_reaches(arm: TwoLinkArm) -> Panel:
    """A target moved by sliders, and the arm that follows it.

    Parameters
    ----------
    arm : TwoLinkArm
    """
    far = arm.reach_mm[1]
    scale = 190 / far

    def to_px(x, y):
        return round(PANEL_WIDTH / 2 + x * scale), round(210 - y * scale)

    def draw(x_mm, y_mm, elbow):
        view = np.full((420, PANEL_WIDTH, 3), 255, np.uint8)
        for radius in arm.reach_mm:
            cv2.circle(view, to_px(0, 0), round(radius * scale), GREY, 2, cv2.LINE_AA)
        cv2.circle(view, to_px(x_mm, y_mm), 10, ORANGE, -1, cv2.LINE_AA)
        try:
            pose = arm.inverse(x_mm, y_mm, elbow)
        except StereoLabError as error:
            return view, str(error)
        joint = arm.l1_mm * np.cos(np.radians(pose.theta1_deg)), arm.l1_mm * np.sin(np.radians(pose.theta1_deg))
        points = [to_px(0, 0), to_px(*joint), to_px(x_mm, y_mm)]
        for start, end, color in zip(points[:-1], points[1:], (BLUE, VERMILION), strict=True):
            cv2.line(view, start, end, color, 6, cv2.LINE_AA)
        for point in points[:2]:
            cv2.circle(view, point, 8, BLACK, -1, cv2.LINE_AA)
        beyond = "" if arm.within_limits(pose) else ": beyond a limit of this arm"
        return view, f"shoulder {pose.theta1_deg:.1f}, elbow {pose.theta2_deg:.1f} degrees{beyond}"

    whole = int(far * 1.1)
    elbow = ipywidgets.ToggleButtons(options=["down", "up"], description="elbow", style={"button_width": "110px"})
    return Panel(
        "arm follows a target",
        {
            "x_mm": _slider("x (mm)", 0.6 * far, -whole, whole, 5),
            "y_mm": _slider("y (mm)", 0.3 * far, -whole, whole, 5),
            "elbow": elbow,
        },
        draw,
    )


def stopping(motor: Motor, goal_deg: float = 90.0) -> Panel:
    """One motor driven by the slow-down rule: the slow zone and the speed by sliders.

    Parameters
    ----------
    motor : stereo_lab.motion.motors.Motor
    """
    tuning = Tuning.of(calibrate_motor(push_of(motor), motor.supply_v), motor.counts_per_turn)

    def to_px(seconds, angle):
        return round(70 + seconds / 1.6 * 860), round(380 - angle / (1.25 * goal_deg) * 350)

    def draw(zone_deg, cruise_deg_s):
        view = np.full((420, PANEL_WIDTH, 3), 255, np.uint8)
        run = drive(motor, SlowDownRule(tuning, 0.0, goal_deg, zone_deg, cruise_deg_s))
        if zone_deg:
            cv2.rectangle(view, to_px(0, goal_deg), to_px(1.6, goal_deg - zone_deg), (205, 235, 250), -1)
        cv2.line(view, to_px(0, goal_deg), to_px(1.6, goal_deg), BLACK, 1, cv2.LINE_AA)
        line = np.array([to_px(t, p) for t, p in zip(run.time_s, run.position_deg, strict=True)])
        cv2.polylines(view, [np.clip(line, -5000, 5000)], False, BLUE, 3, cv2.LINE_AA)
        for k in range(0, 17, 4):
            cv2.putText(
                view,
                f"{k / 10:.1f}",
                (to_px(k / 10, 0)[0] - 12, 402),
                cv2.FONT_HERSHEY_SIMPLEX,
                0.5,
                BLACK,
                1,
                cv2.LINE_AA,
            )
        cv2.putText(view, "time (s)", (450, 417), cv2.FONT_HERSHEY_SIMPLEX, 0.5, BLACK, 1, cv2.LINE_AA)
        cv2.putText(
            view,
            f"goal {goal_deg:.0f} deg",
            (74, to_px(0, goal_deg)[1] - 8),
            cv2.FONT_HERSHEY_SIMPLEX,
            0.55,
            BLACK,
            1,
            cv2.LINE_AA,
        )
        return view, f"stops {run.rest_deg - goal_deg:+.1f} degrees from the goal, after {run.arrived_s:.2f} s"

    return Panel(
        "stopping a motor",
        {
            "zone_deg": _slider("slow zone (degrees)", 5, 0, 40),
            "cruise_deg_s": _slider("speed (degrees/s)", 180, 30, 400, 10),
        },
        draw,
    )


def _slider(description, value, low, high, step=1):
    return ipywidgets.IntSlider(
        int(value), low, high, step, description=description, style=LONG, layout=ipywidgets.Layout(width="560px")
    )


def _range(description, value, low, high):
    return ipywidgets.IntRangeSlider(
        value=[int(v) for v in value], min=low, max=high, description=description, style=LONG,
        layout=ipywidgets.Layout(width="560px"),
    )  # fmt: skip


def _fit(image, width):
    """The picture made at most ``width`` wide."""
    scale = min(1.0, width / image.shape[1])
    return image if scale == 1 else cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)


def _bar(view, disparity, largest):
    """The disparity as a bar at the bottom."""
    length = round(700 * disparity / largest)
    cv2.rectangle(view, (200, 305), (900, 325), GREY, 1)
    cv2.rectangle(view, (200, 305), (200 + length, 325), ORANGE, -1)
    cv2.putText(view, "disparity", (90, 321), cv2.FONT_HERSHEY_SIMPLEX, 0.6, BLACK, 1, cv2.LINE_AA)


def _axes(d, depth):
    """An empty chart with ticks, and the function from (disparity, depth) to its pixels."""
    view = np.full((420, PANEL_WIDTH, 3), 255, np.uint8)
    low, high, top = 0.85 * d.min(), 1.12 * d.max(), 1.15 * depth.max()

    def to_px(x, y):
        return round(90 + (x - low) / (high - low) * 830), round(370 - float(y) / top * 340)

    for x in np.linspace(low, high, 6):
        cv2.putText(view, f"{x:.0f}", (to_px(x, 0)[0] - 14, 392), cv2.FONT_HERSHEY_SIMPLEX, 0.5, BLACK, 1, cv2.LINE_AA)
    for y in np.linspace(0, top, 5):
        cv2.line(view, to_px(low, y), to_px(high, y), GREY, 1)
        cv2.putText(view, f"{y:.0f}", (36, to_px(low, y)[1] + 5), cv2.FONT_HERSHEY_SIMPLEX, 0.5, BLACK, 1, cv2.LINE_AA)
    cv2.putText(view, "disparity (px)", (440, 413), cv2.FONT_HERSHEY_SIMPLEX, 0.55, BLACK, 1, cv2.LINE_AA)
    cv2.putText(view, "depth (mm)", (96, 14), cv2.FONT_HERSHEY_SIMPLEX, 0.55, BLACK, 1, cv2.LINE_AA)
    return view, to_px
