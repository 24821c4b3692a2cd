"""The background: cameras that stand still see the same room behind the ball in every picture, so it is known there.

In a pixel at the rim the light of both is mixed, I = αF + (1 − α)B: F is the ball's light, B the background's, and α the
part of the pixel that the ball covers. Where B is known, the edge of a book behind the ball is not taken for its rim.

Close to its rim a ball shows less of itself: seen at so flat an angle, its surface mirrors what lies behind it, further out
(Fresnel). Taken for background, that ring makes the ball too small, and moves it where its two sides mirror other things.
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
BLUR_PX = 0.7  # standard deviation of an edge in a webcam's picture: lens and pixels; its colour is softer yet
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
GLOSS, GLOSS_SIGMA = 0.5, 0.3  # a smooth ball mirrors by 1, a matt one by 0, any as likely: its rim must tell
# Radii from the ball's middle: of its last pixel each part mirrors at another angle, and so what lies anywhere from here to there
OUT = np.linspace(2, 20, 10)
FAR_OFF = 4.0  # medians: what is explained so badly is no ball, but its stand or a finger
ROUNDS = 4
# Errors of neighbouring pixels go together (colour mosaic, sharpening, JPEG), and no ball's light changes quite evenly:
# measured on rendered balls before books, so many times more than if each erred alone
TOGETHER = 3.0
LEAST_BLOCKS = 8
MOVED_PX, MOVED = 1.0, 0.25  # px and radii: so far from where it was found it is another thing

LIGHT_AND_COLOR = np.concatenate([LUMA, CR, CB])
NO_EDGES = np.zeros(RAYS)
EACH_COLOR = np.eye(3)[:, None, :, None, None]
BEYOND = np.linspace(-6, 6, 241)  # standard deviations of the blur
STEP_PX = (BEYOND[1] - BEYOND[0]) * BLUR_PX
COVERED = np.array([0.5 * math.erfc(x / 2**0.5) for x in BEYOND])
COVERS = -np.gradient(COVERED, STEP_PX)  # so much more of it where the rim lies a pixel further out
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

    Thirteen numbers: the cone's axis a' (see ``fit_cone``), how blue, green and red the ball is in its middle, and how much more
    so to the right and downwards, and how much its rim mirrors. Gauss and Newton's least squares.

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
    known = _known(background, image, cone)
    fitted = None if known is None else _explain(_rim(background, image, cone, *known), cone.axis)
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


def _known(background, image, cone):
    """How much lighter it is behind a ball than it was, of blue, green and red, and the noise, (6,); None where the room looks otherwise."""
    (u, v, r), (height, width) = cone.circle, image.shape[:2]
    if not (0 <= u < width and 0 <= v < height and 0 < r < width):
        return None
    rows, columns, _ = _blocks(cone, r + AROUND_PX, image.shape)
    beyond = _beyond(_rays(rows, columns, cone.look.camera), cone.axis, r).mean(0)
    around, inside = (beyond > FAR_PX) & (beyond < AROUND_PX), (beyond > -RIM_PX) & (beyond < -2 * BLUR_PX)
    if min(map(np.count_nonzero, (around, inside))) < LEAST_BLOCKS:
        return None
    stored = _colors(image, rows, columns)
    seen, behind = LIGHT[stored], LIGHT[_colors(background, rows, columns)]
    gain = np.median((seen[..., around] + 1) / (behind[..., around] + 1), (1, 2))
    differs = _compared(stored - _stored(behind * gain[:, None, None]))
    noise = np.maximum(NORMAL * np.quantile(np.abs(differs[:, around]), QUARTER, axis=1), LEAST_NOISE)
    away = _length(differs / noise[:, None])
    if np.quantile(away[around], AGREE) > SAME or np.median(away[inside]) < CLEAR:
        return None
    return gain, noise


class _Rim(NamedTuple):
    """N blocks of 2 x 2 pixels round a rim; JPEG stores four of light of each, and one of each colour.

    ``r``: of the circle they lie round, px; ``shape``: rows and columns of blocks; ``rays`` through the pixels, shape (3, 4, N);
    ``near`` the rim, (N,), they are compared; ``evenly``: 1, how far to the right and how far down they lie, radii, (3, 4, N).
    Blue, green and red: what is ``stored`` in the picture, and the light of what is ``behind`` and of what is ``mirrored`` if the
    rim is there, (3, 4, N). ``mirrors``: how much of it, at BEYOND, and how that changes. ``noise`` of what is compared, (6, 1).
    """

    r: float
    shape: tuple[int, int]
    rays: np.ndarray
    near: np.ndarray
    evenly: np.ndarray
    stored: np.ndarray
    behind: np.ndarray
    mirrored: np.ndarray
    mirrors: tuple[np.ndarray, np.ndarray]
    noise: np.ndarray


def _rim(background, image, cone, gain, noise):
    """What is seen at the rim of a cone, and what is behind it."""
    u, v, r = cone.circle
    rows, columns, shape = _blocks(cone, r + RIM_PX + 2, image.shape)  # a block more than is compared
    rays = _rays(rows, columns, cone.look.camera)
    near = np.abs(_beyond(rays, cone.axis, r).mean(0)) < RIM_PX
    right, down = (columns - u) / r, (rows - v) / r
    behind, mirrored = LIGHT[_colors(background, rows, columns)], _mirrored(background, u, v, r, right, down)
    light = (told * gain[:, None, None] for told in (behind, mirrored))
    evenly = np.stack([np.ones(rows.shape), right, down])
    stored = _colors(image, rows, columns)
    return _Rim(r, shape, rays, near, evenly, stored, *light, _mirrors(r), (noise / COUNTS)[:, None])


def _mirrored(background, u, v, r, right, down):
    """The light that a rim mirrors, shape (3, 4, N): of the background's, out from (u, v) px over each place, the mean at OUT."""
    width, height = (max(1, round(side / r)) for side in background.shape[1::-1])
    small = LIGHT[cv2.resize(background, (width, height), interpolation=cv2.INTER_AREA)].astype(np.float32)
    turns = 2 * math.pi / RAYS * np.arange(RAYS)
    x, y = (
        np.float32((middle + 0.5) / r - 0.5 + np.outer(OUT, way(turns))) for middle, way in ((u, np.cos), (v, np.sin))
    )
    light = cv2.remap(small, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE).mean(0)
    nearest = np.rint(np.arctan2(down, right) * RAYS / (2 * math.pi)).astype(int) % RAYS
    return light[nearest].transpose(2, 0, 1)


def _mirrors(r):
    """What part of its light a smooth ball of this radius, px, mirrors at BEYOND, blurred; and as COVERS, how that changes.

    After C. Schlick, *An Inexpensive BRDF Model for Physically-based Rendering* (1994), eq. 15; what is mirrored in the middle
    as well counts as the ball's own.
    """
    out = 1 + BEYOND * BLUR_PX / r  # radii from the middle
    steep = np.sqrt(np.clip(1 - out * out, 0, 1))  # cosine of the angle at which the surface is seen
    mirrors = np.convolve(np.where(out < 1, (1 - steep) ** 5, 0.0), BLUR, "same")
    return mirrors, -np.gradient(mirrors, STEP_PX)


def _explain(rim, axis):
    """The axis a' and its information, shape (3, 3); None where nothing can be told."""
    inside = rim.near & (_beyond(rim.rays, axis, rim.r).mean(0) < -2 * BLUR_PX)
    evenly, light = (told[..., inside].reshape(3, -1) for told in (rim.evenly, LIGHT[rim.stored]))
    own, gloss = np.linalg.lstsq(evenly.T, light.T, rcond=None)[0].T, GLOSS
    for _ in range(ROUNDS):
        missing, slopes = _missing(rim, axis, own, gloss)
        away = _length(missing)
        middle = np.median(away)
        counted = (slopes * tukey(away, FAR_OFF * middle)).reshape(len(slopes), -1)
        sums, toward = counted @ slopes.reshape(len(slopes), -1).T, counted @ missing.ravel()
        strict = (TOGETHER * middle / GLOSS_SIGMA) ** 2
        sums[-1, -1] += strict
        toward[-1] += strict * (GLOSS - gloss)
        told, step = cv2.solve(sums, toward[:, None], flags=cv2.DECOMP_CHOLESKY)
        step = step[:, 0]
        axis, own, gloss = axis + step[:3], own + step[3:-1].reshape(3, 3), gloss + step[-1]
        if not (told and axis @ axis > 1 + 1e-8):
            return None
    shared = sums[:3, 3:]  # what tells of the ball's light as well
    information = sums[:3, :3] - shared @ np.linalg.solve(sums[3:, 3:], shared.T)
    return axis, information / (TOGETHER * middle) ** 2


def _missing(rim, axis, own, gloss):
    """What such a ball does not explain, shape (6, near), and how it changes with the thirteen numbers, (13, 6, near).

    ``own``: how blue, green and red it is in its middle, and how much more so a radius to the right and down, shape (3, 3).
    """
    off = _beyond(rim.rays, axis, rim.r)
    covered, covers, shines, shine = (
        np.interp(off / BLUR_PX, BEYOND, told) for told in (COVERED, COVERS, *rim.mirrors)
    )
    ball = np.tensordot(own, rim.evenly, 1)
    itself, gained = covered - gloss * shines, covers - gloss * shine
    mixed = itself * ball + gloss * shines * rim.mirrored + (1 - covered) * rim.behind
    stored = _stored(mixed)
    steep = stored / (GAMMA * np.maximum(mixed, 1))  # change of what is stored by light
    moves = steep * (gained * ball + gloss * shine * rim.mirrored - covers * rim.behind)
    by_axis = rim.rays[:, None] * (rim.r / (axis @ axis - 1) / (1 + off / rim.r)) * moves
    by_light = (EACH_COLOR * rim.evenly[:, None] * (steep * itself)[:, None, None]).reshape(-1, *mixed.shape)
    by_gloss = steep * shines * (rim.mirrored - ball)
    slopes = _soft(_compared(np.concatenate([by_axis, by_light, by_gloss[None]])), rim.shape) / rim.noise
    missing = (_compared(rim.stored) - _soft(_compared(stored), rim.shape)) / rim.noise
    return missing[..., rim.near], slopes[..., rim.near]


def _soft(compared, shape):
    """The same with colours as soft as JPEG draws them: of a block's own three quarters each way, of its neighbours' an eighth."""
    colors = np.pad(compared[..., 4:, :].reshape(-1, *shape), ((0, 0), (1, 1), (1, 1)), "edge")
    down = (colors[:, :-2] + 6 * colors[:, 1:-1] + colors[:, 2:]) / 8
    soft = (down[..., :-2] + 6 * down[..., 1:-1] + down[..., 2:]) / 8
    return np.concatenate([compared[..., :4, :], soft.reshape(compared[..., 4:, :].shape)], -2)


def _blocks(cone, reach, shape):
    """Rows and columns of all blocks of 2 x 2 pixels so near a cone's middle, (4, N), and how many there are down and across.

    JPEG counts blocks from the corner of the picture.
    """
    down, across = (
        np.arange(max(0, int(middle - reach)) // 2 * 2, int(min(side, middle + reach)) - 1, 2)
        for middle, side in ((cone.v, shape[0]), (cone.u, shape[1]))
    )
    rows, columns = (blocks.ravel() for blocks in np.meshgrid(down, across, indexing="ij"))
    return np.array([[0], [0], [1], [1]]) + rows, np.array([[0], [1], [0], [1]]) + columns, (len(down), len(across))


def _colors(image, rows, columns):
    """Blue, green and red there, shape (3, 4, N)."""
    return image[rows, columns].transpose(2, 0, 1)


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
