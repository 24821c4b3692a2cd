"""What goes wrong, in plain words: what was expected, what came, what to do next."""


class StereoLabError(Exception):
    """Bad input or a step that cannot go on. The message is written for the person at the keyboard.

    ``fault``: what the doctor calls it, such as "never_tilted", where that is known.
    """

    def __init__(self, says: str = "", fault: str = "") -> None:
        super().__init__(says)
        self.fault = fault


class RecordingError(StereoLabError):
    """A recording, a picture or a table that cannot be used."""


class CalibrationError(StereoLabError):
    """Boards from which no calibration can be made, or a calibration that does not fit."""


class SwappedSidesError(CalibrationError):
    """Pictures of the left camera where the right one's should be, and the other way round."""


class UnreachableTargetError(StereoLabError):
    """A point that the arm cannot reach."""


class ArmError(StereoLabError):
    """An arm that does not answer, refuses, or stopped by itself."""


class RefusedError(ArmError):
    """A command that the arm understood and refused: nothing has moved by it."""
