"""Train the judge: python data/train/train.py look FOLDER … and then python data/train/train.py fit.

``look`` takes recordings of clutter that are rendered with other seeds (stereo-lab render clutter --seed 101 --out …) and
folders of real frames with a labels.csv. It writes the evidence of every thing in them, and no picture, to rows/NAME.csv.
``fit`` needs these rows alone and writes stereo_lab/detection/weights.json.
"""

from __future__ import annotations

import csv
import json
import sys
from pathlib import Path

import numpy as np
import pictures

from stereo_lab.common.files import write_whole
from stereo_lab.detection import BallDetector, judge

HERE = Path(__file__).parent
ROWS, WEIGHTS = HERE / "rows", Path(judge.__file__).parent / "weights.json"
MOST_THINGS = 8  # of a picture, the most probable by the weights of before
CENTRE, SIZE = 0.5, 0.4  # of the radius: so near is the ball
RIDGE = 10.0
REAL_WEIGHT = 3.0  # real frames are few, and all else is rendered
ROUNDS, ENOUGH = 40, 1e-7  # of Newton's method


def look(folder: Path) -> None:
    """Write the evidence of everything in the pictures of a folder."""
    ROWS.mkdir(exist_ok=True)
    seen = list(pictures.real(folder) if (folder / "labels.csv").exists() else pictures.rendered(folder))
    with open(ROWS / f"{folder.name}.csv", "w", newline="", encoding="utf-8") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["picture", "source", "has_ball", "is_ball", *judge.EVIDENCE])
        for number, picture in enumerate(seen):
            has = picture.circle is not None
            for thing, _ in judge.ranking(BallDetector(picture.color).things(picture.image, True))[:MOST_THINGS]:
                is_ball = has and _is_ball(thing.cone, picture.circle)
                evidence = [f"{value:.4g}" for value in thing.evidence]
                table.writerow([number, picture.source, int(has), int(is_ball), *evidence])
            if number % 100 == 0:
                print(f"{folder.name}: {number} of {len(seen)}", flush=True)


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


def design(evidence: np.ndarray, mean: np.ndarray, spread: np.ndarray) -> np.ndarray:
    """A constant, each piece of evidence, and the product of each two."""
    z = np.clip((evidence - mean) / spread, -judge.MOST, judge.MOST)
    one, other = np.triu_indices(z.shape[1])
    return np.column_stack([np.ones(len(z)), z, z[:, one] * z[:, other]])


def fit(group: np.ndarray, ball: np.ndarray, x: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """The conditional logit: in each picture one of the things is the ball, or, where none of them is it, none is.

    By Newton's method: the slope of the likelihood and its curvature tell the next step.
    """
    count = group.max() + 1
    wanted = ball / np.maximum(1, np.bincount(group, ball, count))[group]  # one ball may be told by more than one thing
    held_back = RIDGE * (np.arange(x.shape[1]) > 0)
    beta = np.zeros(x.shape[1])
    for _ in range(ROUNDS):
        odds = np.exp(np.clip(x @ beta, -30, 30))
        p = odds / (1 + np.bincount(group, odds, count))[group]
        gradient = x.T @ ((wanted - p) * weight) - held_back * beta
        together = np.zeros((count, x.shape[1]))
        np.add.at(together, group, x * (p * np.sqrt(weight))[:, None])
        hessian = (x * (p * weight)[:, None]).T @ x - together.T @ together + np.diag(held_back + 1e-9)
        step = np.linalg.solve(hessian, gradient)
        beta += step
        if np.abs(step).max() < ENOUGH:
            break
    return beta


def weights_text(mean: np.ndarray, spread: np.ndarray, beta: np.ndarray, trained_on: str) -> str:
    """The table that the judge reads: of each piece of evidence its mean, spread and weight, and those with each other."""
    names = list(judge.EVIDENCE)
    together = np.zeros((len(names), len(names)))
    together[np.triu_indices(len(names))] = beta[len(names) + 1 :]
    table = np.column_stack([mean, spread, beta[1 : len(names) + 1], (together + together.T) / 2])
    lines = [f"  {json.dumps(n)}: {[round(float(v), 4) for v in row]}" for n, row in zip(names, table, strict=True)]
    head = json.dumps({"trained_on": trained_on, "constant": round(float(beta[0]), 4)})[:-1]
    return head + ',\n "evidence": {\n' + ",\n".join(lines) + "\n }}\n"


def main() -> None:
    if sys.argv[1] == "look":
        for folder in sys.argv[2:]:
            look(Path(folder))
        return
    group, source, ball, evidence = read_rows()
    home = np.array([s.split()[0].split("/")[0] for s in source])
    mean, spread = evidence.mean(0), evidence.std(0)
    weight = np.where(np.isin(home, list(pictures.REAL)), REAL_WEIGHT, 1.0)
    beta = fit(group, ball, design(evidence, mean, spread), weight)
    trained_on = f"{len(np.unique(group))} pictures: {', '.join(sorted(set(home)))}"
    write_whole(WEIGHTS, weights_text(mean, spread, beta, trained_on))
    print(WEIGHTS.read_text(encoding="utf-8"))


if __name__ == "__main__":
    main()
