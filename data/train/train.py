"""Train the judge: python data/train/train.py look FOLDER … and then python data/train/train.py fit.

``things`` looks at data/clutter and data/clutter_test and keeps there what lesson 09 learns from, things_snaps.npz: to be done whenever
evidence is taken in another way, so that nobody who opens the lesson waits for it.

``look`` takes recordings of clutter that are rendered with other seeds (stereo-lab render clutter --seed 101 --out s101; and
matt balls in even light: stereo-lab render data/train/clutter_even.json --seed 301 --out e301) and
folders of real frames with a labels.csv. It writes the evidence of every thing in them, and no picture, to rows/NAME.csv.
``fit`` needs these rows alone and writes stereo_lab/detection/weights.json, by the lines that lesson 09 reads
(stereo_lab/detection/training.py). Nothing in it is left to chance: another processor gives the same numbers within 0.001.
"""

from __future__ import annotations

import argparse
import csv
import io
from pathlib import Path

import numpy as np
import pictures

from stereo_lab.calibration import calibrate_recording
from stereo_lab.common.files import write_whole
from stereo_lab.detection import BallDetector, judge
from stereo_lab.detection.training import weights_of
from stereo_lab.detection.weights import FILE
from stereo_lab.recording import open_recording
from stereo_lab.results import learned

HERE = Path(__file__).parent
ROWS = HERE / "rows"
MOST_THINGS = 8  # of a picture, the most probable by the weights of before
CENTRE, SIZE = 0.5, 0.4  # of the radius: so near is the ball
RIDGE = 10.0
REAL_WEIGHT = 3.0  # real frames are few, and all else is rendered


def look(folder: Path) -> None:
    """Write the evidence of everything in the pictures of a folder."""
    ROWS.mkdir(exist_ok=True)
    seen = list(pictures.real(folder) if (folder / "labels.csv").exists() else pictures.rendered(folder))
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(["picture", "source", "has_ball", "is_ball", *judge.EVIDENCE])
    for number, picture in enumerate(seen):
        has = picture.circle is not None
        for thing, _ in judge.ranking(BallDetector(picture.color).things(picture.image, True))[:MOST_THINGS]:
            is_ball = has and _is_ball(thing.cone, picture.circle)
            evidence = [f"{value:.4g}" for value in thing.evidence]
            table.writerow([number, picture.source, int(has), int(is_ball), *evidence])
        if number % 100 == 0:
            print(f"{folder.name}: {number} of {len(seen)}", flush=True)
    write_whole(ROWS / f"{folder.name}.csv", text.getvalue())


def _is_ball(cone, circle):
    u, v, r = circle
    return np.hypot(cone.u - u, cone.v - v) < CENTRE * r and abs(cone.outline_px - r) < SIZE * r + 1


def read_rows() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Which picture each thing is of, the picture's source, whether the thing is the ball, its evidence."""
    rows = []
    for path in sorted(ROWS.glob("*.csv")):
        with open(path, encoding="utf-8", newline="") as file:
            rows += [{**row, "picture": f"{path.stem} {row['picture']}"} for row in csv.DictReader(file)]
    group = np.unique([row["picture"] for row in rows], return_inverse=True)[1]
    evidence = np.array([[float(row[name]) for name in judge.EVIDENCE] for row in rows])
    is_ball = np.array([row["is_ball"] == "1" for row in rows])
    return group, np.array([row["source"] for row in rows]), is_ball, evidence


def home_of(source: np.ndarray) -> np.ndarray:
    """The recording, or the folder of real frames, that each source is of."""
    return np.array([s.split()[0].split("/")[0] for s in source])


def counted(home: np.ndarray) -> np.ndarray:
    """How much the pictures of each home count."""
    return np.where(np.isin(home, list(pictures.REAL)), REAL_WEIGHT, 1.0)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("step", choices=("look", "fit", "things"))
    parser.add_argument("folders", nargs="*", type=Path, metavar="FOLDER", help="what look looks at")
    options = parser.parse_args()
    if bool(options.folders) != (options.step == "look"):
        parser.error("look takes folders, and nothing else does")
    if options.step == "look":
        for folder in options.folders:
            look(folder)
        return
    if options.step == "things":
        camera = calibrate_recording(open_recording("bench")).camera("left")
        for name in ("clutter", "clutter_test"):
            learned.keep_frames(open_recording(name), "snaps", camera)
        return
    group, source, ball, evidence = read_rows()
    home = home_of(source)
    trained_on = f"{len(np.unique(group))} pictures: {', '.join(sorted(set(home)))}"
    weights = weights_of(group, ball, evidence, judge.EVIDENCE, RIDGE, counted(home), trained_on=trained_on)
    write_whole(FILE, weights.text())
    print(weights.text())


if __name__ == "__main__":
    main()
