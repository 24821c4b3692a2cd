"""An opened recording: its sets of pairs and samples. Nothing is read before it is asked for."""

from __future__ import annotations

import re
import reprlib
from dataclasses import dataclass, field, replace
from pathlib import Path

from stereo_lab.common.files import natural_key
from stereo_lab.common.spreadsheets import read_table
from stereo_lab.errors import RecordingError, StereoLabError
from stereo_lab.kinematics import Registration, TwoLinkArm
from stereo_lab.recording.bounds import place_mm, plain_name
from stereo_lab.recording.pictures import PICTURES, without_ending
from stereo_lab.recording.sample import Ball, Board, Position, Sample, StereoPair
from stereo_lab.recording.strays import CALIBRATION, is_bereft, told_of_strays

SHARED_OUT = ("position", "depth")  # sets that are fitted to; every line of their tables may be kept back
PUT_BACK = "Put it back, or take its other half away: that of the same moment, which need not be the last one."
THOUSANDS = re.compile(r"\d{1,3}\.\d{3}")
USES = {**dict.fromkeys(SHARED_OUT, ("fit", "check")), "evaluation": ("plane", "volume")}


def must_be_recording(recording: object) -> None:
    """Refuse the name or the path of a recording, or nothing, where an opened one is asked for.

    Raises
    ------
    StereoLabError
    """
    if isinstance(recording, str | Path | None):
        got = recording if recording is None else str(recording)
        raise StereoLabError(f"Expected a recording, as open_recording gives it; got {got!r}.")


@dataclass(frozen=True)
class Recording:
    """An opened recording; see :func:`open_recording`.

    Attributes
    ----------
    path : Path of its folder
    title : str
    made_by : str, "camera" or "render"
    image_size : (width, height), px
    frame_rate : float, pairs a second
    board : Board
    ball : Ball
    arm : TwoLinkArm
    arm_depth_mm : float, depth of the plane of the arm
    arm_is_shipped : bool, whether the shipped bench's arm stands in for one that is not named
    calibrated_by : str, name of the recording beside it that has the boards; None: its own
    truth : dict, what truth.json says
    seat : int, whose recording it is where each learner has another one; else None
    """

    path: Path
    title: str
    made_by: str
    image_size: tuple[int, int]
    frame_rate: float
    board: Board
    ball: Ball
    arm: TwoLinkArm
    arm_depth_mm: float
    arm_is_shipped: bool = False
    calibrated_by: str | None = None
    truth: dict = field(default_factory=dict, repr=False)
    seat: int | None = None

    @property
    def name(self) -> str:
        """Name of its folder."""
        return self.path.name

    @property
    def rendered(self) -> bool:
        """True where the pictures come from a renderer and not from cameras."""
        return self.made_by == "render"

    @property
    def registration_path(self) -> Path:
        """Where the file lies that says where its arm stands; see :attr:`registration`."""
        return self.path / "registration.json"

    @property
    def registration(self) -> Registration:
        """Where its arm stands before its cameras: as registered, or else as told.

        Raises
        ------
        StereoLabError
            If its file cannot be used.
        """
        if self.registration_path.is_file():
            return Registration.load(self.registration_path)
        return Registration.told(self.arm, self.arm_depth_mm)

    @property
    def sets(self) -> list[str]:
        """Names of the sets of pictures there are."""
        return sorted(p.parent.name for p in self.path.glob("*/left") if p.is_dir())

    def pairs(self, set_name: str) -> tuple[StereoPair, ...]:
        """The pairs of one set, in the order of their names, pictures unread.

        A set without a folder ``right`` was taken with the left camera alone.

        Raises
        ------
        RecordingError
            If the set is missing or empty, its name is a path, or half of a pair is missing.
        """
        folder = self.path / plain_name(set_name, f"{self.path}, set")
        left = pictures_in(folder / "left")
        if not left:
            there = ", ".join(self.sets) or "none"
            raise RecordingError(
                f"{folder / 'left'} holds no pictures (.jpg or .png). Sets in this recording: {there}.{told_of_strays(self.path, folder)}",
                fault="no_pictures",
            )
        right = pictures_in(folder / "right") if (folder / "right").is_dir() else {}
        if (folder / "right").is_dir():
            _check_halves(folder, left, right)
        grey = set_name == "calibration"
        return tuple(StereoPair(n, left[n], right.get(n), self.image_size, grey) for n in left)

    def samples(self, set_name: str) -> tuple[Sample, ...]:
        """The measured pairs of one set: a tuple of :class:`Sample`.

        Where no line of position or depth says what it is for, every second one is kept back to check.

        Raises
        ------
        RecordingError
            If ``measured.csv`` is missing or has a line that cannot be used (the line is named).
        """
        pairs = {pair.name: pair for pair in self.pairs(set_name)}
        table = self.path / set_name / "measured.csv"
        if not table.exists():
            hint = told_of_strays(self.path, table.parent) or " Write one, with the columns name,x_mm,y_mm,depth_mm."
            raise RecordingError(f"{table}, which tells where the ball was, is missing.{hint}")
        rows = read_table(table, ("name", "x_mm", "y_mm", "depth_mm"))
        if not rows:
            raise RecordingError(f"{table} has no rows: one is expected for each picture, name, x, y and depth.")
        _check_thousands(rows)
        samples: list[Sample] = []
        for where, row in rows:
            pair = _find_pair(pairs, row["name"], where)
            if any(pair is sample.pair for sample in samples):
                raise RecordingError(f"{where}: picture {pair.name} has a line already. Take one of the two away.")
            x, y, depth = (place_mm(row[k], f"{where}, {k}") for k in ("x_mm", "y_mm", "depth_mm"))
            ball = self.true_ball(set_name, pair.name)
            truth = None if ball is None else _exact(ball["ball"])
            use = (row.get("use") or "").strip().lower()
            uses = USES.get(set_name, ())
            if uses and use not in ("", *uses):
                raise RecordingError(f"{where}, use: expected {' or '.join(uses)}, or nothing; got {use!r}.")
            samples.append(Sample(pair, Position(x, y, depth), truth, use))
        if set_name in SHARED_OUT and not any(sample.use for sample in samples):
            samples = [replace(sample, use=USES[set_name][k % 2]) for k, sample in enumerate(samples)]
        return tuple(samples)

    def has_samples(self, set_name: str) -> bool:
        """Whether a set has pictures and a table of what was measured."""
        return set_name in self.sets and (self.path / set_name / "measured.csv").is_file()

    @property
    def has_boards(self) -> bool:
        """Whether there are boards to calibrate on, its own or those of the recording that calibrated_by names."""
        return "calibration" in self.sets or bool(self.calibrated_by)

    @property
    def is_calibrated(self) -> bool:
        """Whether a calibration can be had: of its boards, or one that was taken over from elsewhere."""
        brought = self.path / CALIBRATION
        return self.has_boards or brought.is_file() and not is_bereft(brought)

    @property
    def ball_sets(self) -> list[str]:
        """Names of the sets that show the ball, single pictures first."""
        order = ("snaps", "evaluation", "position", "depth", "track")
        names = [name for name in self.sets if name != "calibration"]
        return sorted(names, key=lambda name: order.index(name) if name in order else len(order))

    def judges(self, use: str | None = None) -> tuple[Sample, ...]:
        """The samples that a model is judged by: no model may be fitted on them.

        The evaluation set; where there is none, the check samples: those of position stand for the arm's
        plane, those of depth for the volume.

        Parameters
        ----------
        use : "plane" or "volume", optional; else both

        Returns
        -------
        tuple of Sample, their ``use`` being "plane" or "volume"
        """
        if self.has_samples("evaluation"):
            found = self.samples("evaluation")
        else:
            stand_in = (("depth", "volume"), ("position", "plane"))
            found = tuple(
                replace(sample, use=kind)
                for name, kind in stand_in
                if self.has_samples(name)
                for sample in self.samples(name)
                if sample.use == "check"
            )
        return tuple(s for s in found if use is None or s.use == use)

    def true_ball(self, set_name: str, name: str) -> dict | None:
        """The entry of truth.json for one frame with a ball in it, or None."""
        entry = self.truth.get("sets", {}).get(set_name, {}).get(name)
        return entry if entry and entry.get("ball") is not None else None


def _exact(place):
    x, y, depth = map(float, place)
    return Position(x, y, depth)


def pictures_in(folder: Path) -> dict[str, Path]:
    """Pictures of a folder by name without ending, in natural order."""
    if not folder.is_dir():
        return {}
    files = [p for p in folder.iterdir() if p.suffix.lower() in PICTURES and not p.name.startswith(".")]
    found: dict[str, Path] = {}
    for file in sorted(files, key=natural_key):
        if file.stem in found:
            raise RecordingError(
                f"{folder} holds {found[file.stem].name} and {file.name}: two pictures of one name. Keep one.",
                fault="name_twice",
            )
        found[file.stem] = file
    return found


def _check_thousands(rows):
    """Refuse depths of which some are written 1.024 and all others as whole numbers: a spreadsheet parted the thousands."""
    depths = [(where, (row["depth_mm"] or "").strip()) for where, row in rows]
    parted = [(where, depth) for where, depth in depths if THOUSANDS.fullmatch(depth)]
    whole = [depth for _, depth in depths if depth.isdecimal()]
    if parted and len(parted) + len(whole) == len(depths) and whole:
        (where, depth), least = parted[0], min(map(int, whole))
        if max(float(depth) for _, depth in parted) < least / 10:
            raise RecordingError(
                f"{where}, depth_mm: {depth} stands beside {least}. A point between the thousands? "
                f"Write {depth.replace('.', '')}, and so in all lines."
            )


def _check_halves(folder, left, right):
    if len(left) == len(right) > 0 and not left.keys() & right.keys():
        one, other = (next(iter(side.values())).name for side in (left, right))
        raise RecordingError(
            f"{folder}: the two pictures of one moment are expected to have one name, in left and in right. "
            f"None has; left begins with {one}, right with {other}. Give both the same name.",
            fault="names_differ",
        )
    told = []
    for side, have, other in (("left", left, right), ("right", right, left)):
        lost = [other[name].name for name in other if name not in have]
        if lost:
            more = f" and {len(lost) - 1} more" if len(lost) > 1 else ""
            told.append(f"{folder / side} has no picture {lost[0]}{more}")
    if told:
        raise RecordingError(f"{', and '.join(told)}: half of the pair is missing. {PUT_BACK}", fault="half_missing")


def _find_pair(pairs, name, where):
    """A pair by its name; a spreadsheet that turned 003 into 3 is understood."""
    name = without_ending((name or "").strip())
    if name in pairs:
        return pairs[name]
    alike = [
        p for p in pairs.values() if name.isdecimal() and p.name.isdecimal() and p.name.lstrip("0") == name.lstrip("0")
    ]
    if len(alike) == 1:
        return alike[0]
    raise RecordingError(f"{where}: there is no picture named {reprlib.repr(name)} in this set.")
