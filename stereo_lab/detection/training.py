"""The learning itself: from rows of evidence, and which of them is the ball, to weights.

In each picture one of the things is the ball, or none is: a conditional logit with "none" among the choices. The shipped weights
and those of one's own ball are made by the same lines; ``data/train`` calls them, and :mod:`stereo_lab.detection.own`.
"""

from __future__ import annotations

import numpy as np

from stereo_lab.detection.weights import MOST, Weights

ROUNDS, ENOUGH = 40, 1e-7  # of Newton's method
HELD = 0.01  # the constant to zero: where all is told apart it would grow without end
LONGEST = 4.0  # step of a weight: far from the end the curvature tells too little of the way
SURE, HALVINGS = 30.0, 12  # sums beyond it are certain; so often a step is halved at most
LEAST_SPREAD = 1e-3  # evidence that is always the same tells nothing, and must not be divided by zero


def terms(evidence: np.ndarray, mean: np.ndarray, spread: np.ndarray) -> np.ndarray:
    """A one, each piece of evidence, and the product of each two. Shape (N, 1 + n + n (n + 1) / 2)."""
    z = np.clip((evidence - mean) / spread, -MOST, MOST)
    one, other = np.triu_indices(z.shape[1])
    return np.column_stack([np.ones(len(z)), z, z[:, one] * z[:, other]])


def fit(
    group: np.ndarray, ball: np.ndarray, x: np.ndarray, weight: np.ndarray, held: np.ndarray, start: np.ndarray
) -> np.ndarray:
    """The weights under which what is known to be the ball is most probable, and no farther from the start than that pays.

    By Newton's method: the slope of the likelihood and its curvature tell the next step. A step that leads down is halved.

    Parameters
    ----------
    group : ndarray, shape (N,), the number of the picture of each thing, 0, 1, …
    ball : ndarray, shape (N,), 1 for a thing that is the ball, else 0
    x : ndarray, shape (N, m), from :func:`terms`
    weight : ndarray, shape (N,), how much its picture counts
    held, start : ndarray, shape (m,), each weight is held to its start by so much
    """
    count, beta = group.max() + 1, start.astype(float)
    wanted = ball / np.maximum(1, np.bincount(group, ball, count))[group]  # one ball may be told by more than one thing
    gain = _gain(group, wanted, x, weight, held, start)
    height = gain(beta)
    for _ in range(ROUNDS):
        odds = np.exp(np.clip(x @ beta, -SURE, SURE))
        p = odds / (1 + np.bincount(group, odds, count))[group]  # the 1 is "none"
        slope = x.T @ ((wanted - p) * weight) - held * (beta - start)
        together = np.zeros((count, x.shape[1]))
        np.add.at(together, group, x * (p * np.sqrt(weight))[:, None])
        curvature = (x * (p * weight)[:, None]).T @ x - together.T @ together + np.diag(held + 1e-9)
        step = np.linalg.solve(curvature, slope)
        step *= min(1, LONGEST / np.abs(step).max())
        beta, height, moved = _upward(gain, beta, step, height)
        if moved < ENOUGH:
            break
    return beta


def _gain(group, wanted, x, weight, held, start):
    """How probable weights make what is known, as a logarithm, less what it costs to be far from the start."""
    count = group.max() + 1
    its_weight = np.zeros(count)
    its_weight[group] = weight

    def gain(beta):
        s = np.clip(x @ beta, -SURE, SURE)
        none = np.log1p(np.bincount(group, np.exp(s), count))
        return (weight * wanted) @ s - its_weight @ none - held @ (beta - start) ** 2 / 2

    return gain


def _upward(gain, beta, step, height):
    """As much of a step as leads up: the new weights, their gain, and how far the farthest of them moved."""
    for part in 0.5 ** np.arange(HALVINGS):
        new = gain(beta + part * step)
        if new > height:
            return beta + part * step, new, np.abs(part * step).max()
    return beta, height, 0.0


def weights_of(
    group: np.ndarray, ball: np.ndarray, evidence: np.ndarray, names: tuple[str, ...], ridge: float,
    weight: np.ndarray | None = None, start: Weights | None = None, trained_on: str = "",
) -> Weights:  # fmt: skip
    """Weights learned from rows of evidence: from nothing, or, with a ``start``, from what was learned before.

    Parameters
    ----------
    group, ball, weight : as for :func:`fit`
    evidence : ndarray, shape (N, n), and the ``names`` of its columns
    ridge : float, how strongly the weights are held to the start
    start : Weights, optional; else all are zero, and the constant is nearly free
    trained_on : str
    """
    mean, spread = evidence.mean(0), np.maximum(evidence.std(0), LEAST_SPREAD)
    if start is not None:
        mean, spread = start.mean, start.spread
    x = terms(evidence, mean, spread)
    held = np.full(x.shape[1], ridge)
    held[0] = HELD if start is None else ridge
    first = np.zeros(x.shape[1]) if start is None else flat(start)
    beta = fit(group, ball, x, np.ones(len(x)) if weight is None else weight, held, first)
    n = len(names)
    together = np.zeros((n, n))
    together[np.triu_indices(n)] = beta[n + 1 :]
    return Weights(names, mean, spread, beta[1 : n + 1], (together + together.T) / 2, float(beta[0]), trained_on)


def flat(weights: Weights) -> np.ndarray:
    """The numbers of a table in the order of :func:`terms`."""
    one, other = np.triu_indices(len(weights.names))
    twice = np.where(one == other, 1, 2)
    return np.concatenate([[weights.constant], weights.weight, twice * weights.together[one, other]])
