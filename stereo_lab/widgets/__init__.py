"""Every ipywidgets panel, and clips. A panel is a picture with sliders beside it, drawn by OpenCV (`space` by matplotlib), and feeds nothing downstream.

A panel answers a slider by drawing its picture anew and writing one line of text. The keyboard works: Tab goes
to a slider, the arrow keys move it.
"""

from stereo_lab.widgets.clip import Clip
from stereo_lab.widgets.lesson01 import epipolar_line
from stereo_lab.widgets.lesson02 import color_thresholds, hough_parameters
from stereo_lab.widgets.lesson04 import ball_against_disparity, depth_samples, signs_against_squint
from stereo_lab.widgets.lesson05 import arm_reaches
from stereo_lab.widgets.lesson06 import registering, stopping
from stereo_lab.widgets.lesson07 import LiveCell, live_cell
from stereo_lab.widgets.lesson08 import RecorderPanel, recorder_panel, recorder_view, rig_planner
from stereo_lab.widgets.lesson09 import MarkPanel, mark_balls
from stereo_lab.widgets.panel import Panel
from stereo_lab.widgets.space import space

__all__ = [
    "Clip", "LiveCell", "MarkPanel", "Panel", "RecorderPanel", "arm_reaches", "ball_against_disparity", "color_thresholds", "depth_samples", 
    "epipolar_line", "hough_parameters", "live_cell", "mark_balls", "recorder_panel", "recorder_view", "registering", "rig_planner", "signs_against_squint", "space",
    "stopping",
]  # fmt: skip
