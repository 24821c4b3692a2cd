"""A short film of the whole cell: two drawn cameras, a ball that moves, an arm that follows it.

    .venv/bin/python examples/film_of_the_cell.py docs/follow.webp

The README opens with it. What is written under the pictures is what the localizer finds in them.
"""

import sys

import cv2
import numpy as np

from stereo_lab.arm import connect
from stereo_lab.live import Follower, VirtualBench, run
from stereo_lab.localization import Localizer
from stereo_lab.recording import open_recording

BLUE, BLACK, WHITE = (178, 114, 0), (0, 0, 0), (255, 255, 255)
PLACES_MM = np.array([(230, 190), (-60, 320), (-250, 160), (60, 250), (230, 190)], float)
MOVE_S, REST_S = 1.0, 0.9
STEP_S = 0.1  # so long each picture is shown, or a little longer
WIDE, HIGH, FOOT = 400, 300, 44  # px, of each picture as it is shown, and of the line under them


def path(depth_mm):
    """The ball goes from place to place, softly, and rests at each; a function of the time."""

    def ball(time_s):
        leg, left_s = divmod(time_s, MOVE_S + REST_S)
        start, goal = PLACES_MM[int(leg) % 4], PLACES_MM[int(leg) % 4 + 1]
        part = min(1.0, max(0.0, (left_s - REST_S) / MOVE_S))
        x, y = start + (3 * part**2 - 2 * part**3) * (goal - start)
        return x, y, depth_mm

    return ball


def shown(moment):
    """Both pictures, the ball marked, its place below."""
    view = np.full((HIGH + FOOT, 2 * WIDE + 4, 3), 255, np.uint8)
    for k, picture in enumerate((moment.frame.left, moment.frame.right)):
        picture = picture.copy()
        ball = moment.track.detections[k] if moment.track is not None and moment.track.detections else None
        if ball is not None:
            cv2.circle(picture, (round(ball.u), round(ball.v)), round(ball.radius_px) + 4, BLUE, 3, cv2.LINE_AA)
        picture = cv2.resize(picture, (WIDE, HIGH), interpolation=cv2.INTER_AREA)
        view[:HIGH, k * (WIDE + 4) : k * (WIDE + 4) + WIDE] = picture
    if moment.track is not None:
        p = moment.track.position
        words = f"ball: x {p.x_mm:5.0f}   y {p.y_mm:5.0f}   depth {p.depth_mm:5.0f} mm      arm: {moment.said}"
        cv2.putText(view, words, (10, HIGH + 29), cv2.FONT_HERSHEY_SIMPLEX, 0.6, BLACK, 1, cv2.LINE_AA)
    return view


def film(name="bench"):
    """The pictures of one round, after the arm has come from home, and how long each is shown, ms."""
    recording = open_recording(name)
    localizer, seconds = Localizer.fit(recording), 4 * (MOVE_S + REST_S)
    with connect("virtual://arm") as arm:
        arm.set_limits(recording.arm.limits_deg)
        arm.home()
        port = arm.port  # the simulated arm has a time of its own, which the bench keeps; noise makes films large
        with VirtualBench(recording, port, clock=port.clock, sleep=port.sleep, noise=0.0) as source:
            source.path = path(recording.arm_depth_mm)
            times_s, pictures = [], []
            for moment in run(source, localizer, Follower(arm, recording), seconds=2 * seconds):
                if moment.frame.time_s >= (times_s[-1] + STEP_S - 1e-6 if times_s else seconds):
                    times_s.append(moment.frame.time_s)
                    pictures.append(shown(moment))
    return pictures, [round(1000 * s) for s in np.diff([*times_s, 2 * seconds])]


def write(pictures, shown_ms, file):
    """As an animated picture that goes round and round."""
    animation = cv2.Animation()
    animation.frames, animation.durations = pictures, shown_ms
    if not cv2.imwriteanimation(file, animation, [cv2.IMWRITE_WEBP_QUALITY, 75]):
        sys.exit(f"Cannot write {file}.")


if __name__ == "__main__":
    write(*film(), sys.argv[1] if len(sys.argv) > 1 else "follow.webp")
