"""The background: cameras that stand still see the same room behind the ball in every picture, so it is known there.

In a pixel at the rim the light of both is mixed, I = αF + (1 − α)B: F is the ball's light, B the background's, and α the
part of the pixel that the ball covers. Where B is known, the edge of a book behind the ball is not taken for its rim.

Close to its rim a ball shows less of itself: seen at so flat an angle, its surface mirrors the room (Fresnel). Taken for the
background, that ring would make the ball too small, and move it where things of other light lie behind its two sides.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import cv2
import numpy as np

from stereo_lab.detection import Detection
from stereo_lab.detection.cone import scatter_px, tukey
from stereo_lab.detection.outline import CB, CR, GAMMA, LIGHT, LUMA, RAYS, unit_rays
from stereo_lab.recording import Sample

LEAST, MOST = 5, 9  # pictures; with more little is gained
# So many of them with the ball within two diameters of one place on the bench: in the median of five it is then not seen
AT_ONE_PLACE, PLACE = 2, 2.0
BLUR_PX = 0.8  # standard deviation of an edge in a webcam's picture: lens, pixels, colour mosaic
RIM_PX = 4.0  # so far to both sides of the rim pixels are compared; over so few the ball's light changes evenly
# Between these nothing of the ball is seen: what differs there is noise, or another thing
FAR_PX, AROUND_PX = 3.0, 12.0
QUARTER, NORMAL = 0.25, 3.14  # noise's standard deviation, by its smallest quarter: more may be another thing
LEAST_NOISE = np.array([0.5, 0.5, 0.5, 0.5, 0.3, 0.3])  # whole numbers are stored
# In so much of what is around it differs by no more than so many standard deviations, as before, and the ball itself by more than
# twice as many. Else something moved since, a camera or a book, and the background tells nothing
AGREE, SAME, CLEAR = 0.75, 2.5, 5.5
# A shadow or a highlight on the ball, of which the fit knows nothing, changes light more than colour
COUNTS = np.array([1, 1, 1, 1, 2, 2])
GLOSS = 0.5  # a smooth ball mirrors by 1, a matt one by 0, and nobody tells which it is: half way neither is far off
FAR_OFF = 4.0  # medians: what is explained so badly is no ball, but its stand or a finger
ROUNDS = 4
# Errors of neighbouring pixels go together (colour mosaic, sharpening, JPEG), and no ball's light changes quite evenly:
# measured on rendered balls before books, so many times more than if each erred alone
TOGETHER = 4.0
LEAST_BLOCKS = 8
MOVED_PX, MOVED = 1.0, 0.25  # px and radii: so far from where it was found it is another thing

LIGHT_AND_COLOR = np.concatenate([LUMA, CR, CB])
NO_EDGES = np.zeros(RAYS)
EACH_COLOR = np.eye(3)[:, None, :, None, None]
BEYOND = np.linspace(-6, 6, 241)  # standard deviations of the blur
STEP_PX = (BEYOND[1] - BEYOND[0]) * BLUR_PX
COVERED = np.array([0.5 * math.erfc(x / 2**0.5) for x in BEYOND])
BLUR = np.exp(-np.square(BEYOND) / 2) / np.exp(-np.square(BEYOND) / 2).sum()


def backgrounds_of(samples: Sequence[Sample], diameter_mm: float) -> tuple[np.ndarray, ...]:
    """The background of the left and of the right camera, by samples with the ball at other and other places; none by too few.

    Parameters
    ----------
    samples : sequence of Sample
    diameter_mm : float, of the ball

    Returns
    -------
    (left, right), ndarrays of shape (H, W, 3), uint8; or ()
    """
    apart: list[Sample] = []
    for sample in samples:
        here = sample.measured
        near = [
            math.hypot(s.measured.x_mm - here.x_mm, s.measured.y_mm - here.y_mm) < PLACE * diameter_mm for s in apart
        ]
        if sum(near) < AT_ONE_PLACE:
            apart.append(sample)
    if len(apart) < LEAST:
        return ()
    chosen = [apart[k] for k in np.linspace(0, len(apart) - 1, min(MOST, len(apart))).round().astype(int)]
    return tuple(median_picture([getattr(s.pair, side) for s in chosen]) for side in ("left", "right"))


def median_picture(pictures: Sequence[np.ndarray]) -> np.ndarray:
    """What one camera sees where no ball is: pixel by pixel the median of pictures with the ball at other and other places.

    Parameters
    ----------
    pictures : sequence of ndarray, shape (H, W, 3), BGR, uint8, all of one camera that stands still

    Returns
    -------
    ndarray, shape (H, W, 3), uint8
    """
    return np.rint(np.median(pictures, axis=0)).astype(np.uint8)


def fit_on_background(background: np.ndarray, image: np.ndarray, ball: Detection) -> Detection | None:
    """A ball by the cone that explains best how its picture differs from the background; None where that tells nothing.

    Twelve numbers: the cone's axis a' (see ``fit_cone``), and how blue, green and red the ball is in its middle, and how much more
    so to the right and downwards. Gauss and Newton's least squares.

    Parameters
    ----------
    background, image : ndarray, shape (H, W, 3), BGR, of one camera
    ball : Detection in the picture, right to about a pixel

    Returns
    -------
    Detection or None: where the room looks otherwise than it did, or the ball looks like it, is smeared, or has its centre
    outside the picture
    """
    cone = ball.cone
    if cone is None or cone.smeared or image.shape != background.shape:
        return None
    rim = _rim(background, image, cone)
    fitted = None if rim is None else _explain(rim, cone.axis)
    if fitted is None:
        return None
    axis, information = fitted
    focal, tan2 = float(cone.look.camera[0][0, 0]), float(axis @ axis - 1)
    (u, v), radius = cone.look.pixel(axis), focal * tan2**0.5
    if not math.hypot(u - cone.u, v - cone.v) + abs(radius - cone.radius_px) < MOVED_PX + MOVED * cone.radius_px:
        return None
    scatter = scatter_px(axis, information, focal, tan2, cone.look.r)
    cone = cone._replace(
        u=u, v=v, radius_px=radius, outline_px=radius / cone.radius_px * cone.outline_px, weights=NO_EDGES
    )
    cone = cone._replace(axis=axis, information=information, scatter_px=scatter)
    sigma, sigma_radius = cone.sigmas_px
    return replace(ball, u=u, v=v, radius_px=radius, sigma_px=sigma, sigma_radius_px=sigma_radius, cone=cone)


class _Rim(NamedTuple):
    """N blocks of 2 x 2 pixels near the rim; JPEG stores four of light of each, and one of each colour.

    ``r``: of the circle they lie round, px; ``rays`` through the pixels, shape (3, 4, N); ``evenly``: 1, how far to the right
    and how far down they lie, radii, (3, 4, N). Blue, green and red: what is ``stored`` in the picture, and the light of what is
    ``behind``, (3, 4, N). ``mirrors``: what part of its light a ball so large mirrors at BEYOND. ``noise`` of what is compared, (6, 1).
    """

    r: float
    rays: np.ndarray
    evenly: np.ndarray
    stored: np.ndarray
    behind: np.ndarray
    mirrors: np.ndarray
    noise: np.ndarray


def _rim(background, image, cone):
    """What is seen at the rim of a cone, and what is behind it; None where the room looks otherwise."""
    (u, v, r), (height, width) = cone.circle, image.shape[:2]
    if not (0 <= u < width and 0 <= v < height and 0 < r < width):
        return None
    reach = r + AROUND_PX
    rows, columns = _blocks(u - reach, v - reach, min(width, u + reach), min(height, v + reach))
    rays = _rays(rows, columns, cone.look.camera)
    beyond = _beyond(rays, cone.axis, r).mean(0)
    around, near = (beyond > FAR_PX) & (beyond < AROUND_PX), np.abs(beyond) < RIM_PX
    inside = near & (beyond < -2 * BLUR_PX)
    if min(map(np.count_nonzero, (around, inside))) < LEAST_BLOCKS:
        return None
    stored = image[rows, columns].transpose(2, 0, 1)
    seen, behind = LIGHT[stored], LIGHT[background[rows, columns].transpose(2, 0, 1)]
    gain = np.median((seen[..., around] + 1) / (behind[..., around] + 1), (1, 2))  # more or less light than it was
    behind = behind * gain[:, None, None]
    differs = _compared(stored - _stored(behind))
    noise = np.maximum(NORMAL * np.quantile(np.abs(differs[:, around]), QUARTER, axis=1), LEAST_NOISE)[:, None]
    away = _length(differs / noise)
    if np.quantile(away[around], AGREE) > SAME or np.median(away[inside]) < CLEAR:
        return None
    evenly = np.stack([np.ones(rows.shape), (columns - u) / r, (rows - v) / r])
    seen = (told[..., near] for told in (rays, evenly, stored, behind))
    return _Rim(r, *seen, _mirrors(r), noise / COUNTS[:, None])


def _mirrors(r):
    """What part of its light a ball of this radius, px, mirrors at BEYOND, blurred.

    After C. Schlick, *An Inexpensive BRDF Model for Physically-based Rendering* (1994), eq. 15; what is mirrored in the middle
    as well counts as the ball's own.
    """
    out = 1 + BEYOND * BLUR_PX / r  # radii from the middle
    steep = np.sqrt(np.clip(1 - out * out, 0, 1))  # cosine of the angle at which the surface is seen
    return GLOSS * np.convolve(np.where(out < 1, (1 - steep) ** 5, 0.0), BLUR, "same")


def _explain(rim, axis):
    """The axis a' and its information, shape (3, 3); None where nothing can be told."""
    inside = _beyond(rim.rays, axis, rim.r) < -2 * BLUR_PX
    own = np.linalg.lstsq(rim.evenly[:, inside].T, LIGHT[rim.stored[:, inside]].T, rcond=None)[0].T
    for _ in range(ROUNDS):
        missing, slopes = _missing(rim, axis, own)
        away = _length(missing)
        middle = np.median(away)
        counted = (slopes * tukey(away, FAR_OFF * middle)).reshape(len(slopes), -1)
        sums, toward = counted @ slopes.reshape(len(slopes), -1).T, counted @ missing.ravel()
        told, step = cv2.solve(sums, toward[:, None], flags=cv2.DECOMP_CHOLESKY)
        axis, own = axis + step[:3, 0], own + step[3:].reshape(3, 3)
        if not (told and axis @ axis > 1 + 1e-8):
            return None
    shared = sums[:3, 3:]  # what tells of the ball's light as well
    information = sums[:3, :3] - shared @ np.linalg.solve(sums[3:, 3:], shared.T)
    return axis, information / (TOGETHER * middle) ** 2


def _missing(rim, axis, own):
    """What such a ball does not explain, shape (6, N), and how it changes with the twelve numbers, (12, 6, N).

    ``own``: how blue, green and red it is in its middle, and how much more so a radius to the right and down, shape (3, 3).
    """
    off = _beyond(rim.rays, axis, rim.r)
    covered, covers = _at(off, COVERED)
    mirrored, mirrors = _at(off, rim.mirrors)
    ball, room = np.tensordot(own, rim.evenly, 1), rim.behind.mean((1, 2), keepdims=True)
    mixed = (covered - mirrored) * ball + mirrored * room + (1 - covered) * rim.behind
    stored = _stored(mixed)
    steep = stored / (GAMMA * np.maximum(mixed, 1))  # change of what is stored by light
    moves = steep * ((covers - mirrors) * ball + mirrors * room - covers * rim.behind)
    by_axis = rim.rays[:, None] * (rim.r / (axis @ axis - 1) / (1 + off / rim.r)) * moves
    own_part = (steep * (covered - mirrored))[:, None, None]
    by_light = (EACH_COLOR * rim.evenly[:, None] * own_part).reshape(-1, *mixed.shape)
    slopes = _compared(np.concatenate([by_axis, by_light])) / rim.noise
    return _compared(rim.stored - stored) / rim.noise, slopes


def _at(off, told):
    """What is told at BEYOND, so far beyond the rim, px; and how much more of it where the rim lies a pixel further out."""
    return np.interp(off / BLUR_PX, BEYOND, told), np.interp(off / BLUR_PX, BEYOND, -np.gradient(told, STEP_PX))


def _blocks(left, top, right, bottom):
    """Rows and columns of all blocks of 2 x 2 pixels within, shape (4, N); JPEG counts them from the picture's corner."""
    down, across = (np.arange(max(0, int(a)) // 2 * 2, int(b) - 1, 2) for a, b in ((top, bottom), (left, right)))
    rows, columns = np.meshgrid(down, across, indexing="ij")
    return np.array([[0], [0], [1], [1]]) + rows.ravel(), np.array([[0], [1], [0], [1]]) + columns.ravel()


def _rays(rows, columns, camera):
    """Unit vectors from the camera through pixels, shape (3, 4, N)."""
    pixels = np.stack([columns.ravel(), rows.ravel()], 1).astype(float)
    return unit_rays(pixels, camera).T.reshape(3, *rows.shape)


def _beyond(rays, axis, r):
    """How far beyond a cone rays lie, px."""
    gap = (1 - np.tensordot(axis, rays, 1)) / (axis @ axis - 1)  # of a small cone (d² − 1) / 2, d radii from its axis
    return r * (np.sqrt(np.maximum(1 + 2 * gap, 0)) - 1)


def _stored(light):
    """What a picture stores of light: the other way round than LIGHT."""
    return 255 * (np.maximum(light, 0) / 255) ** (1 / GAMMA)


def _compared(bgr):
    """Of N blocks, shape (…, 3, 4, N): four of light and the mean of each of two colours, shape (…, 6, N)."""
    told = (LIGHT_AND_COLOR @ bgr.reshape(*bgr.shape[:-2], -1)).reshape(bgr.shape)
    return np.concatenate([told[..., 0, :, :], told[..., 1:, :, :].sum(-2) / 4], -2)


def _length(of_blocks):
    """How much each block differs, over all that is compared, shape (N,)."""
    return np.sqrt(np.square(of_blocks).mean(0))
