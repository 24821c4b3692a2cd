"""Light to pixels: path tracing straight through a distorted lens, then the webcam's sensor.

Each light sample starts at a point of the *distorted* sensor, so no picture is ever resampled
and the projection formula gives the exact place of everything in it.
"""

from __future__ import annotations

import os

import cv2
import llvm
import numpy as np

llvm.point_to_llvm(os.environ)  # Mitsuba looks for it while it is imported

import drjit as dr  # noqa: E402
import mitsuba as mi  # noqa: E402

llvm.start(dr, mi)

WAVEFRONT = 6_000_000  # paths traced at once: what fits into a small machine's memory
INVERSION_STEPS = 9


def trace(scene, camera, box, samples, seed):
    """Trace one box of the frame.

    Parameters
    ----------
    scene : mitsuba.Scene
    camera : rig.Camera
    box : (x0, y0, width, height) in pixels
    samples : int, light paths per pixel (about)
    seed : int

    Returns
    -------
    ndarray, shape (height, width, 3), linear RGB radiance
    """
    width, height = box[2:]
    strata = 8 if width * height * 64 < WAVEFRONT else 4  # two kernels, each compiled once
    paths = strata * strata
    passes = max(1, round(samples / paths))
    integrator = mi.load_dict({"type": "path", "max_depth": 5, "rr_depth": 8})
    total = np.zeros((height, width, 3))
    for k in range(passes):
        sampler = mi.load_dict({"type": "multijitter", "sample_count": paths})
        sampler.set_samples_per_wavefront(paths)
        sampler.seed(seed * 1009 + k, width * height * paths)
        ray = _rays(camera, box, sampler, strata)
        light, _, _ = integrator.sample(scene, sampler, ray)
        dr.eval(light)  # once for all three channels: left lazy, each would trace every ray again
        sums = [dr.block_sum(channel, paths) for channel in (light.x, light.y, light.z)]
        total += np.stack([np.array(s).reshape(height, width) for s in sums], -1) / paths
    return total / passes


def _rays(camera, box, sampler, strata):
    """Rays through a thin lens for every sample of the box."""
    x0, y0, width, height = box
    index = dr.arange(mi.UInt32, width * height * strata * strata)
    across = dr.opaque(mi.UInt32, strata)
    pixel, stratum = index // (across * across), index % (across * across)
    row_length = dr.opaque(mi.UInt32, width)
    u = mi.Float(pixel % row_length) + dr.opaque(mi.Float, float(x0))
    v = mi.Float(pixel // row_length) + dr.opaque(mi.Float, float(y0))
    u += (mi.Float(stratum % across) + sampler.next_1d()) / opaque(strata) - 0.5
    v += (mi.Float(stratum // across) + sampler.next_1d()) / opaque(strata) - 0.5
    blur = mi.warp.square_to_std_normal(sampler.next_2d()) * opaque(camera.sensor.psf_px)
    x, y = _undistort(camera, u + blur.x, v + blur.y)
    lens = mi.warp.square_to_uniform_disk_concentric(sampler.next_2d()) * opaque(camera.aperture_mm / 2)
    focus = opaque(camera.focus_mm)
    direction = dr.normalize(mi.Vector3f(x * focus - lens.x, y * focus - lens.y, focus))
    to_bench = camera.rotation.T
    rows = [mi.Vector3f(*[opaque(value) for value in row]) for row in to_bench]
    turn = lambda p: mi.Vector3f(*[dr.dot(row, p) for row in rows])  # noqa: E731
    centre = mi.Point3f(*[opaque(value) for value in camera.position_mm])
    origin = centre + turn(mi.Vector3f(lens.x, lens.y, 0))
    return mi.RayDifferential3f(mi.Ray3f(origin, turn(direction)))


def opaque(value):
    """A constant that the compiled kernel reads as data, so that it is compiled once."""
    return dr.opaque(mi.Float, float(value))


def _undistort(camera, u, v):
    """Exact inverse of Brown-Conrady by fixed-point iteration, raw pixels to (x/z, y/z)."""
    k1, k2, p1, p2, k3 = (opaque(c) for c in camera.distortion)
    matrix = camera.matrix
    xd = (u - opaque(matrix[0, 2])) / opaque(matrix[0, 0])
    yd = (v - opaque(matrix[1, 2])) / opaque(matrix[1, 1])
    x, y = mi.Float(xd), mi.Float(yd)
    for _ in range(INVERSION_STEPS):
        r2 = x * x + y * y
        radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
        dx = 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
        dy = p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
        x, y = (xd - dx) / radial, (yd - dy) / radial
    return x, y


def expose(radiance, sensor, rng, gain=1.0):
    """Linear RGB radiance (H, W, 3) to the bytes of the JPEG that this webcam would send."""
    balance = np.array(sensor.white_balance)
    electrons = radiance * gain * sensor.exposure * _vignette(radiance.shape, sensor) / balance
    raw = _read_out(_mosaic(electrons), sensor, rng)
    rgb = cv2.cvtColor(raw, cv2.COLOR_BayerBG2RGB_EA).astype(float) / 4095 * balance
    screen = _gamma(np.clip(rgb, 0, 1))
    screen += sensor.sharpen * (screen - cv2.GaussianBlur(screen, (0, 0), 1.0))
    bgr = np.clip(np.round(screen[..., ::-1] * 255), 0, 255).astype(np.uint8)
    ok, jpeg = cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, sensor.jpeg_quality])
    assert ok
    return jpeg.tobytes()


def _vignette(shape, sensor):
    height, width = shape[:2]
    v, u = np.mgrid[:height, :width]
    r2 = ((u - width / 2) ** 2 + (v - height / 2) ** 2) / (0.625 * width) ** 2
    return (1 / (1 + sensor.vignetting * r2) ** 2)[..., None]


def _mosaic(rgb):
    """Keep one colour a pixel: red and green in even rows, green and blue in odd ones."""
    mosaic = rgb[..., 1].copy()
    mosaic[0::2, 0::2] = rgb[0::2, 0::2, 0]
    mosaic[1::2, 1::2] = rgb[1::2, 1::2, 2]
    return mosaic


def _read_out(mosaic, sensor, rng):
    full = sensor.full_well_electrons
    electrons = rng.poisson(np.clip(mosaic, 0, 1.3) * full)
    electrons = electrons + rng.normal(0, sensor.read_noise_electrons, mosaic.shape)
    return np.round(np.clip(electrons / full, 0, 1) * 4095).astype(np.uint16)


def _gamma(linear):
    """The sRGB curve."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
