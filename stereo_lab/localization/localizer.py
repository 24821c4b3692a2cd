"""Two ways to a place on the bench, the paper's and ours, behind one face."""

from __future__ import annotations

import reprlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stereo_lab.calibration import StereoCalibration, calibrate_recording
from stereo_lab.common.files import typed
from stereo_lab.detection import BallColor, Detection, check_image
from stereo_lab.errors import StereoLabError
from stereo_lab.localization.doubt import FAR_OFF
from stereo_lab.localization.ours import ConeWay
from stereo_lab.localization.paper import PaperWay
from stereo_lab.recording import Position, Recording, Sample
from stereo_lab.recording.model import must_be_recording

WAYS: dict[str, type[ConeWay] | type[PaperWay]] = {"cone": ConeWay, "paper": PaperWay}
NAMED = 5  # samples in a sentence
MOST_UNLIKE = 0.25  # of the samples: places move by 4 mm at most with so many wrong ones, and by 200 with a few more


@dataclass(frozen=True, eq=False)
class Localizer:
    """Finds the ball in a pair and tells where it is; made by :meth:`fit`.

    Attributes
    ----------
    calibration : StereoCalibration
    way : ConeWay or PaperWay: how the ball is found, and the fitted models that place it
    residuals_mm : ndarray, shape (N, 3)
        x, y, depth of the samples fitted on, model minus ruler; NaN where a model does not use that number of a
        sample: the paper's way takes x and y from the position samples, depth from the depth samples.
    missed : tuple of str, samples in which no ball was found, as "set/name"
    unlike : tuple of str, samples that contradict the others by more than cameras and ruler explain, the worst first;
        none where all are mirrored, or by the paper's way, which knows no standard deviations
    """

    calibration: StereoCalibration
    way: ConeWay | PaperWay
    residuals_mm: np.ndarray
    missed: tuple[str, ...] = ()
    unlike: tuple[str, ...] = ()

    @classmethod
    def fit(
        cls,
        recording: Recording,
        method: str = "cone",
        calibration: StereoCalibration | None = None,
        color: BallColor | str | None = None,
        leave_out: Sequence[Sample] = (),
    ) -> Localizer:
        """Fit on the samples of a recording.

        Parameters
        ----------
        recording : Recording with the sets calibration, position and depth
        method : "cone": every position and depth sample, triangulated, and one rigid fit.
            "paper": Eq. 1 and 2 on the position samples with use "fit", Eq. 4 on the depth
            samples with use "fit", plain Hough.
        calibration : StereoCalibration, optional; else the recording's own
        color : BallColor or the name of one, optional; else the recording's
        leave_out : sequence of Sample, optional; samples that are to judge the fit, and so must not be fitted on

        Returns
        -------
        Localizer

        Raises
        ------
        StereoLabError
            If the ball is not found in enough samples, or what is given is no such thing.
        """
        must_be_recording(recording)
        if method not in WAYS:
            raise StereoLabError(f'There is no method {method!r}. Choose "cone" or "paper".')
        if calibration is None:
            calibration = calibrate_recording(recording)
        elif not isinstance(calibration, StereoCalibration):
            raise StereoLabError(
                "Expected a calibration, as calibrate_stereo or StereoCalibration.load gives it; "
                f"got {reprlib.repr(calibration)}."
            )
        if tuple(calibration.image_size) != tuple(recording.image_size):
            (width, height), (wide, high) = calibration.image_size, recording.image_size
            raise StereoLabError(
                f"This calibration is for pictures of {width}x{height} pixels; those of {recording.title} are {wide}x{high}. Take "
                "the recording's own, or calibrate these cameras at this size."
            )
        kept_back = {sample.pair for sample in _samples_of(leave_out)}
        samples = {
            name: [s for s in recording.samples(name) if s.pair not in kept_back] for name in ("position", "depth")
        }
        return cls(calibration, *WAYS[method].fit(recording, samples, calibration, color or recording.ball.color))

    @property
    def told(self) -> list[str]:
        """What was done beside the recipe, in plain sentences: a colour that marked itself, a board's squares taken for longer."""
        return [sentence for sentence in (self.way.color_told, self.way.squares_told) if sentence]

    @property
    def stand_ins_told(self) -> str:
        """That samples to check on had to be fitted on, which therefore judge nothing; empty where none had to be."""
        names = first_of(self.way.stand_ins)
        said = "The paper's way finds the ball in too few samples to fit on. Samples to check on stand in, and judge nothing"
        return f"{said}: {names}." if names else ""

    @property
    def doubts(self) -> list[str]:
        """What speaks against the samples that this was fitted on, in plain sentences; none where they agree."""
        count, said = len(self.residuals_mm) + len(self.missed), []
        if self.missed:
            said.append(
                f"In {len(self.missed)} of {count} measured pairs the two cameras show no ball in one place, and they are left out of "
                f"the fit: {first_of(self.missed)}."
            )
        if self.stand_ins_told:
            said.append(self.stand_ins_told)
        if self.way.table_told:
            said.append(self.way.table_told)
        if self.unlike:
            said.append(
                f"The measured samples contradict each other, {len(self.unlike)} of {count} by more than {FAR_OFF:.0f} times what cameras "
                f"and ruler leave in doubt: {first_of(self.unlike)}."
            )
        return said

    @property
    def misleads(self) -> bool:
        """Whether places may be far off, and no arm should go there: by the samples' unit, a mirror, or many that contradict each other."""
        return bool(self.way.table_told) or len(self.unlike) > MOST_UNLIKE * len(self.residuals_mm)

    def locate(
        self, left: np.ndarray, right: np.ndarray, near: tuple[Detection, Detection] | None = None
    ) -> Position | None:
        """Where the ball is, or None where no ball is seen by both cameras.

        Parameters
        ----------
        left, right : ndarray, raw pictures, BGR
        near : (Detection, Detection), optional; where to look first

        Returns
        -------
        Position or None
        """
        found = self.detect(left, right, near)
        return None if found is None else self.position(*found)

    def detect(
        self, left: np.ndarray, right: np.ndarray, near: tuple[Detection, Detection] | None = None
    ) -> tuple[Detection, Detection] | None:
        """The same ball in both pictures.

        Parameters
        ----------
        left, right : ndarray, raw pictures, BGR
        near : (Detection, Detection), optional; where to look first (the paper's way always looks everywhere)

        Returns
        -------
        (Detection, Detection) in raw pixels, or None
        """
        self.calibration.check_size(check_image(left))
        self.calibration.check_size(check_image(right))
        if near is not None:
            _must_be_pair(near)
        return self.way.detect(left, right, near)

    def position(self, left: Detection, right: Detection) -> Position | None:
        """Two detections of one ball, in raw pixels, to a place on the bench: Position, or None."""
        _must_be_pair((left, right))
        return self.way.position(left, right)


def _samples_of(leave_out):
    """The samples to leave out; what holds none is refused: names, or a single one."""
    try:
        chosen = list(leave_out)
    except TypeError:
        chosen = [None]
    if not all(isinstance(sample, Sample) for sample in chosen):
        raise StereoLabError(
            "leave_out: expected a list of samples, as recording.samples or recording.judges gives them; "
            f"got {reprlib.repr(leave_out)}."
        )
    return chosen


def _must_be_pair(pair):
    """Refuse what is no pair of detections, such as a point."""
    if not (isinstance(pair, Sequence) and len(pair) == 2 and all(isinstance(ball, Detection) for ball in pair)):
        raise StereoLabError(
            f"Expected two detections, of the left and of the right picture, as detect gives them; got {reprlib.repr(pair)}."
        )


def must_lead_an_arm(localizer: object) -> None:
    """Refuse to send an arm by a fit whose places may be far off.

    Raises
    ------
    StereoLabError
        If it misleads.
    """
    if getattr(localizer, "misleads", False):
        raise StereoLabError(
            "The arm would be sent to wrong places, and does not move. Mend the measured samples first: stereo-lab check "
            "says what is wrong with them."
        )


def first_of(names: Sequence[str]) -> str:
    """The first of some names, for a sentence."""
    return ", ".join(names[:NAMED]) + (" and others" if len(names) > NAMED else "")


def where_to_look(recording: Recording) -> str:
    """What says more where there are doubts, as a sentence."""
    return f"What is wrong there, and what to do: stereo-lab check {typed(recording.path)}"


def disparities(localizer: Localizer, samples: Sequence[Sample]) -> tuple[np.ndarray, list[Sample]]:
    """Disparity d = u_left − u_right, in rectified px, of the ball in each sample where it is found.

    Parameters
    ----------
    localizer : Localizer
    samples : sequence of Sample

    Returns
    -------
    disparity_px_N : ndarray, shape (N,)
    found : list of the N samples
    """
    values, found = [], []
    for sample in samples:
        pair = localizer.detect(sample.pair.left, sample.pair.right)
        if pair is not None:
            left, right = localizer.calibration.rectify_centers(*pair)
            values.append(left[0] - right[0])
            found.append(sample)
    return np.array(values), found
