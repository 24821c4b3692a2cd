"""Lesson 04: depth from disparity, d = u_left − u_right in rectified pixels."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from stereo_lab.common.files import finite_number
from stereo_lab.common.vectors import as_numbers
from stereo_lab.errors import StereoLabError

STEPS = 60
STRAIGHT = 1000  # d0 farther off than so many times what the samples span: to them the curve is a straight line
NO_CURVE = "No curve a/(d − d0) + c comes near these samples: look at their depths and disparities."


@dataclass(frozen=True)
class IdealDepth:
    """Z = B·f/d (Eq. 3): two equal cameras that look exactly the same way.

    Attributes
    ----------
    baseline_mm, focal_px : float, B and f
    """

    baseline_mm: float
    focal_px: float

    def predict(self, disparity_px: ArrayLike) -> float | np.ndarray:
        """Depth in mm for one disparity or an array; NaN at zero and below, where the two rays meet nowhere."""
        d = as_numbers(disparity_px)
        baseline, focal = finite_number(self.baseline_mm, "baseline_mm"), finite_number(self.focal_px, "focal_px")
        return baseline * focal / np.where(d > 0, d, np.nan)


@dataclass(frozen=True, eq=False)
class PaperDepth:
    """Z = m'''·d⁻¹ − n'''·d + c''' (Eq. 4), fitted on samples; three are solved exactly.

    Attributes
    ----------
    m, n, c : float, in mm·px, mm/px and mm
    residuals_mm : ndarray, shape (N,), model minus sample
    """

    m: float
    n: float
    c: float
    residuals_mm: np.ndarray

    @classmethod
    def fit(cls, disparity_px_N: ArrayLike, depth_mm_N: ArrayLike, not_below_zero: bool = False) -> PaperDepth:
        """Least squares. Without a constraint the signs come out as they come out.

        Parameters
        ----------
        disparity_px_N, depth_mm_N : array_like, shape (N,), three samples or more
        not_below_zero : bool
            The paper states m, n, c > 0: of the fits in which some of the three are held at zero, the best that has none below.
        """
        d, depth = _samples(disparity_px_N, depth_mm_N)
        terms = np.column_stack([1 / d, -d, np.ones_like(d)])
        fits = []
        for held in product((False, True), repeat=3) if not_below_zero else [(False,) * 3]:
            solved = np.zeros(3)
            free = ~np.array(held)
            solved[free] = np.linalg.lstsq(terms[:, free], depth, rcond=None)[0]
            fits.append((np.linalg.norm(terms @ solved - depth), *solved))
        _, m, n, c = min(fit for fit in fits if not not_below_zero or min(fit[1:]) >= 0)
        return cls(float(m), float(n), float(c), terms @ [m, n, c] - depth)

    def predict(self, disparity_px: ArrayLike) -> float | np.ndarray:
        """Depth in mm for one disparity or an array; NaN at zero and below, where Eq. 4 says nothing."""
        d = as_numbers(disparity_px)
        d = np.where(d > 0, d, np.nan)
        return self.m / d - self.n * d + self.c


@dataclass(frozen=True, eq=False)
class OffsetDepth:
    """Z = a/(d − d0) + c: Eq. 3 for cameras that squint a little (d0) and a tape that starts elsewhere (c).

    Attributes
    ----------
    a, d0, c : float, in mm·px, px and mm
    residuals_mm : ndarray, shape (N,), model minus sample
    """

    a: float
    d0: float
    c: float
    residuals_mm: np.ndarray

    @classmethod
    def fit(cls, disparity_px_N: ArrayLike, depth_mm_N: ArrayLike) -> OffsetDepth:
        """Least squares by Gauss-Newton steps from d0 = 0; every error in mm is weighed by d².

        A pixel is worth a/(d − d0)² mm, so the errors count in pixels as long as d0 is small beside d.

        Raises
        ------
        StereoLabError
            If there are fewer than three samples at different depths, a disparity is not above zero, or no such curve
            falls as depth does with disparity and bends as it does.
        """
        d, depth = _samples(disparity_px_N, depth_mm_N)
        a, c = np.linalg.lstsq(np.column_stack([1 / d, np.ones_like(d)]), depth, rcond=None)[0]
        d0 = 0.0
        weight = d**2 / np.median(d**2)  # a pixel is worth Z², so about 1/d², millimetres
        for _ in range(STEPS):
            gap = d - d0
            terms = np.column_stack([1 / gap, a / gap**2, np.ones_like(d)])
            error = depth - (a / gap + c)
            if not (np.isfinite(terms).all() and np.isfinite(error).all()):
                raise StereoLabError(NO_CURVE)
            step = np.linalg.lstsq(terms * weight[:, None], error * weight, rcond=None)[0]
            step *= min(1.0, 0.5 * gap.min() / max(abs(step[1]), 1e-12))  # never past the nearest sample
            a, d0, c = a + step[0], d0 + step[1], c + step[2]
        if a <= 0 or (d - d0).min() > STRAIGHT * np.ptp(d):
            raise StereoLabError(NO_CURVE)
        return cls(float(a), float(d0), float(c), a / (d - d0) + c - depth)

    def predict(self, disparity_px: ArrayLike) -> float | np.ndarray:
        """Depth in mm for one disparity or an array; NaN at d0 and below, where the two rays meet nowhere."""
        gap = as_numbers(disparity_px) - self.d0
        return self.a / np.where(gap > 0, gap, np.nan) + self.c


def _samples(disparity, depth):
    d, depth = as_numbers(disparity).ravel(), as_numbers(depth).ravel()
    if len(d) != len(depth) or len(d) < 3 or len(np.unique(d.round(6))) < 3:
        raise StereoLabError(
            f"Expected three samples or more at different depths; got {len(d)} disparities, {len(np.unique(d.round(6)))} of "
            f"them different, and {len(depth)} depths."
        )
    if not (np.isfinite(d).all() and np.isfinite(depth).all() and (d > 0).all()):
        raise StereoLabError("A disparity is not a number above zero: are left and right swapped?")
    return d, depth
