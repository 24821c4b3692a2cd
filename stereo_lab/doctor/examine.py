"""Look a recording through: what is wrong, how it was seen, what it costs in millimetres, and what to do."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from stereo_lab.calibration import board_shown, counts_squares, find_calibration, find_corners, only_the_markers
from stereo_lab.calibration.store import JUDGED_AT_MM, boards_of, distance_mm
from stereo_lab.common.files import typed
from stereo_lab.common.threads import one_thread
from stereo_lab.doctor.advice import ADVICE
from stereo_lab.doctor.cameras import Cameras, check_cameras
from stereo_lab.doctor.findings import NOTE, STOPS, Checkup, Finding, in_order, listed, severity_of
from stereo_lab.doctor.known import doubt_mm, noise_mm
from stereo_lab.doctor.measured import check_balls
from stereo_lab.doctor.pictures import Looked, copies_told, look_at
from stereo_lab.doctor.scales import arm_told, plane_told
from stereo_lab.doctor.sets import broken, look_at_sets, unread, unreadable
from stereo_lab.errors import StereoLabError
from stereo_lab.recording import Recording, read_image
from stereo_lab.recording.bounds import CHARUCO
from stereo_lab.recording.strays import strays

SHOWN = 3  # pairs in which the board is looked for first
FEWEST = 4  # boards from which anything can be told
BURNT, DARK, BLOCKS = 0.5, 30.0, 2.0  # part of the white squares, of 255, times: see pictures.Look
SPOILT_PART = 0.3  # of the pictures
LIGHT = {"over_exposed", "under_exposed", "compressed"}  # they cost what the corners' noise costs
LACKS = {"blur", "too_few_pairs", "never_tilted", "one_place", "board_far"}  # of boards: more of them help

Progress = Callable[[str, int, int], object]


def check_recording(recording: Recording, progress: Progress | None = None) -> Checkup:
    """Look a recording through.

    Parameters
    ----------
    recording : Recording
    progress : callable (what is done, done, total), optional

    Returns
    -------
    Checkup
        What a recording does not have is no fault: without boards, or without measured balls, that part is passed over.
    """
    say = progress or (lambda *_: None)
    findings = [Finding("misnamed", says, ADVICE["misnamed"], severity=STOPS) for says in strays(recording.path)]
    depth = _judged_at(recording, findings)
    cameras = _look_at_boards(recording, depth, findings, say)
    findings += cameras.findings
    calibration = cameras.states[0] if cameras.states else None
    clean = None if calibration is None else _clean(calibration, findings)
    if cameras.size is not None and any(finding.name == "image_size" for finding in findings):
        recording = replace(recording, image_size=cameras.size)  # told once
    if any(finding.name == "quarter_turned" for finding in findings):
        findings = [finding for finding in findings if finding.name != "image_size"]  # that of pictures turned back
    findings += look_at_sets(recording, findings, say)
    if calibration is not None:
        findings = _other_size_than_boards(findings, calibration.image_size)
    known = {finding.name for finding in findings}
    findings += [f for f in copies_told(recording) if f.name not in known] + arm_told(recording)
    if calibration is not None:
        findings = [replace(f, does_mm=cameras.noise_mm) if f.name in LIGHT else f for f in findings]
        findings = _look_at_balls(recording, cameras, clean, findings, say)
        clean = None if any(finding.name == "square_unit" for finding in findings) else clean
    findings = [replace(f, advice=f.advice.replace(" REC ", f" {typed(recording.path)} ")) for f in findings]
    least = clean
    if calibration is not None and clean is not None and not np.isfinite(clean):
        # cameras taken over from elsewhere: nobody tells how exact they are
        least = noise_mm(calibration, depth)
    findings = [_weighed(finding, least, depth) for finding in findings]
    if all(finding.severity == NOTE for finding in findings):  # else the table is wrong, and not the plane
        findings += plane_told(recording)
    return Checkup(in_order(findings), clean, depth)


def _weighed(finding, clean, depth):
    """With its severity, where its millimetres tell it; those beyond the distance itself tell nothing."""
    if finding.does_mm is None or finding.severity != NOTE:
        return finding
    if finding.does_mm > depth:
        return replace(finding, does_mm=None, severity=STOPS)
    return replace(finding, severity=severity_of(finding.does_mm, clean))


def _clean(calibration, findings):
    """The error of a clean recording: of this one, without what its boards lack."""
    lacks = max((finding.does_mm or 0 for finding in findings if finding.name in LACKS), default=0.0)
    return float(np.hypot(doubt_mm(calibration) - lacks, noise_mm(calibration)))


def _judged_at(recording, findings):
    """The distance for which all is told; a table that cannot be read is put down."""
    try:
        return distance_mm(recording)
    except StereoLabError as error:
        findings.append(unreadable(error))
        return JUDGED_AT_MM


def _look_at_boards(recording, depth, findings, say):
    """The cameras by the boards; by a calibration from elsewhere where there are no boards."""
    own = boards_of(recording)
    if "calibration" not in own.sets:
        try:
            return Cameras([], (find_calibration(recording)[0],))
        except StereoLabError as error:
            return Cameras([Finding("no_boards", str(error), ADVICE["no_boards"], severity=STOPS)])
    pairs = _whole_pairs(own, findings)
    if not pairs:
        return Cameras([])
    own = _right_board(own, pairs, findings)
    looked = look_at(pairs, own.board, lambda *n: say("look at the boards", *n))
    findings += _sizes(looked, own, len(pairs)) + _light(looked) + _turned_board(looked, own)
    if any(finding.name == "picture_sizes" for finding in findings) and looked.boards.both.sum() < FEWEST:
        return Cameras([])
    with one_thread():
        told = check_cameras(looked.boards, [pair.name for pair in pairs], looked.looks, depth)
    return replace(told, size=looked.size)


def _whole_pairs(own, findings):
    """All pairs whose pictures are there and whole; what is not is put down."""
    try:
        pairs = own.pairs("calibration")
    except StereoLabError as error:
        findings.append(unreadable(error))
        return ()
    if pairs[0].right_path is None:
        says = "The boards were taken with the left camera alone."
        findings.append(Finding("half_missing", says, ADVICE["no_boards"], severity=STOPS))
        return ()
    spoilt = {pair.name: why for pair in pairs if (why := unread(replace(pair, image_size=None))) is not None}
    findings += broken("calibration", spoilt)
    return tuple(pair for pair in pairs if pair.name not in spoilt)


def _other_size_than_boards(findings, size):
    """Balls of another size than the boards put down once: no image_size fits both."""
    apart = [f for f in findings if f.name == "picture_sizes" and not f.files[0].startswith("calibration/")]
    if not apart:
        return findings
    sets = dict.fromkeys(f.files[0].split("/")[0] for f in apart)
    files = tuple(name for f in apart for name in f.files)
    says = (
        f"{len(files)} pairs of the {listed('set', list(sets))} have pictures of another size than those of the boards, "
        f"{size[0]}x{size[1]} pixels: what the boards tell of the cameras holds for one size alone."
    )
    rest = [f for f in findings if f not in apart and f.name != "image_size"]
    return [*rest, Finding("picture_sizes", says, ADVICE["picture_sizes"], files, severity=STOPS)]


def _sizes(looked, own, count):
    """Pictures of different sizes."""
    others, (width, height) = looked.other_sizes, looked.size
    findings = []
    if others:
        (name, side), (wide, high) = next(iter(others.items()))
        sides = {side for _, side in others}
        whose = f"the {side} camera's" if len(sides) == 1 and len(others) >= count / 2 else f"{len(others)}"
        says = f"{whose} pictures are of another size: calibration/{name}, {side}, has {wide}x{high} pixels, most have {width}x{height}."
        files = tuple(f"calibration/{name} {side}" for name, side in others)
        findings.append(
            Finding("picture_sizes", says[0].upper() + says[1:], ADVICE["picture_sizes"], files, severity=STOPS)
        )
    if tuple(own.image_size) != (width, height):
        says = f"The pictures have {width}x{height} pixels, and recording.json says {own.image_size[0]}x{own.image_size[1]}."
        findings.append(Finding("image_size", says, ADVICE["image_size"], severity=STOPS))
    return findings


def _light(looked: Looked) -> list[Finding]:
    """Pictures that are too bright, too dark, or squeezed."""
    checks = (
        ("over_exposed", lambda look: look.burnt > BURNT, "White squares are as bright as a picture can be in {} of {} pictures."),
        ("under_exposed", lambda look: look.contrast < DARK, "White and black squares differ by less than an eighth in {} of {} pictures."),
        ("compressed", lambda look: look.blocks > BLOCKS, "Blocks of 8 pixels show in {} of {} pictures: they are strongly compressed."),
    )  # fmt: skip
    findings = []
    for name, spoilt, says in checks:
        files = [f"calibration/{pair} {side}" for (pair, side), look in looked.looks.items() if spoilt(look)]
        if len(files) > SPOILT_PART * len(looked.looks):
            text = says.format(len(files), len(looked.looks))
            findings.append(Finding(name, text, ADVICE[name], tuple(files), 0.0))
    return findings


def _right_board(own, pairs, findings):
    """The recording with the board that its pictures show, where it is not the one that it tells of."""
    some = pairs[:: max(1, len(pairs) // SHOWN)][:SHOWN]
    images = (
        read_image(path, grey_allowed=True) for pair in some for path in (pair.left_path, pair.right_path) if path
    )
    if any(find_corners(image, own.board) is not None for image in images):
        return own
    shown = board_shown(some, own.board)
    if shown is None:
        return own
    name, says = "board_size", f"recording.json tells of a {own.board}; the pictures show a {shown}."
    if only_the_markers(own.board, shown):
        name = "dictionary"
    elif own.board.kind == shown.kind and counts_squares(own.board, shown):
        name, says = "squares_counted", f"{says} Squares were counted, not the corners between them."
    findings.append(Finding(name, says, ADVICE[name], severity=STOPS))
    return replace(own, board=shown)


def _turned_board(looked: Looked, own: Recording) -> list[Finding]:
    """Columns that run down most pictures, as nobody holds a board whose rows are the shorter way."""
    across, down = own.board.grid
    if across >= down or own.board.kind == CHARUCO or not looked.boards.both.any():
        return []
    left = looked.boards.left[looked.boards.both].reshape(-1, down, across, 2)
    column = left[:, -1, 0] - left[:, 0, 0]
    upright = np.abs(column[:, 0]) > np.abs(column[:, 1])
    if upright.mean() < 0.8:
        return []
    says = f"The board is held with its {down} corners across and its {across} down, and recording.json says it the other way round."
    return [Finding("rows_columns_swapped", says, ADVICE["rows_columns_swapped"], (), 0.0)]


def _look_at_balls(recording, cameras, clean, findings, say):
    """All findings, with those of the measured balls."""
    copies = {file for f in findings if f.name == "same_pictures" for file in f.files}
    try:
        told = check_balls(recording, cameras, clean, lambda *n: say("look at the balls", *n), copies)
    except StereoLabError as error:
        why = unreadable(error)
        told = any(f.says.startswith(why.says) or f.name == error.fault for f in findings)
        return findings if told else [*findings, why]
    if told.mirror:
        what = "mirror images" if told.mirror == "both_mirrored" else "upside down"
        says = f"Left and right seem swapped, and the measured places tell why: both cameras' pictures are {what}."
        findings = [f for f in findings if f.name != "sides_swapped"]
        findings.append(Finding(told.mirror, says, ADVICE[told.mirror], severity=STOPS))
    of_boards = any(file.startswith("calibration/") for f in told.findings for file in f.files)
    if of_boards or any(f.name == "sides_swapped" for f in told.findings):
        findings = [f for f in findings if f.name != "sides_swapped"]  # not in all sets
    if any(f.name in ("square_unit", "square_scale") for f in told.findings):
        findings = [f for f in findings if f.name != "square_unit"]  # the balls tell it more exactly
    findings = [*findings, *told.findings]
    if any(f.name == "square_unit" for f in findings):
        return [f for f in findings if f.name not in LACKS | {"board_bent"}]  # judged in millimetres that are none
    return findings
