"""One ball in one picture, by either way."""

from __future__ import annotations

import numpy as np

from stereo_lab.detection import cone
from stereo_lab.detection.color import BallColor
from stereo_lab.detection.model import Camera, Detection, check_image
from stereo_lab.detection.paper import detect_paper
from stereo_lab.errors import StereoLabError

SAME_SIZE = 0.25  # a ball's radius may change by this part from one frame to the next


class BallDetector:
    """Finds one ball in a picture.

    Parameters
    ----------
    color : BallColor, or the name of one
    method : "paper" or "cone"
    camera : (matrix 3x3, distortion), optional
        Intrinsics of the camera that took the pictures, for an exact cone; without them an ellipse
        is fitted.
    """

    def __init__(self, color: BallColor | str, method: str = "cone", camera: Camera | None = None) -> None:
        if method not in ("paper", "cone"):
            raise StereoLabError(f'There is no method {method!r}. Choose "paper" or "cone".')
        self.color = BallColor.named(color) if isinstance(color, str) else color
        self.method = method
        self.camera = camera

    def detect(self, image: np.ndarray, near: Detection | None = None) -> Detection | None:
        """The ball, or None where there is none.

        Parameters
        ----------
        image : ndarray, shape (height, width, 3), BGR, uint8
        near : Detection, optional; where to look first (the ball in the frame before)

        Returns
        -------
        Detection or None
        """
        image = check_image(image)
        if self.method == "paper":
            return detect_paper(image, self.color)
        if near is not None:
            found = self._look_near(image, near)
            if found is not None:
                return found
        return _best(self.candidates(image))

    def candidates(self, image: np.ndarray, most: int = 4) -> list[Detection]:
        """What may be the ball, best first (cone method); a score below ``cone.BALL`` is not enough alone."""
        rounds = cone.find_balls(check_image(image), self.color, self.camera)
        return [Detection(*r.center, r.radius_px, r.score) for r in rounds[:most]]

    def _look_near(self, image, near):
        """Look in a window round the ball's last place; less evidence is enough there for one of the same size."""
        height, width = image.shape[:2]
        reach = int(4 * near.radius_px + 12)
        x0, y0 = max(0, int(near.u) - reach), max(0, int(near.v) - reach)
        window = image[y0 : min(height, int(near.v) + reach), x0 : min(width, int(near.u) + reach)]
        if min(window.shape[:2], default=0) < 8:
            return None
        rounds = cone.find_balls(window, self.color, self.camera, offset=(x0, y0), enough=cone.WEAK)
        same = [r for r in rounds if abs(r.radius_px - near.radius_px) < SAME_SIZE * near.radius_px + 1]
        return Detection(*same[0].center, same[0].radius_px, same[0].score) if same else None


def _best(candidates):
    return next((c for c in candidates if c.score >= cone.BALL), None)
