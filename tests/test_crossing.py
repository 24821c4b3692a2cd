"""Corners of a chessboard, placed by a model of the brightness round them."""

import cv2
import numpy as np
import pytest

from stereo_lab.calibration.crossing import place_corners

TIMES = 8  # pictures are drawn so many times as large, then averaged


def board_picture(turn_deg=12.0, square=18.0, blur=0.8, light=0.0, noise=0.0, columns=5, rows=4):
    """A turned chessboard with exact corners: (grey picture, corners of shape (rows, columns, 2))."""
    v, u = (np.mgrid[: 160 * TIMES, : 200 * TIMES] + 0.5) / TIMES - 0.5
    cosine, sine = np.cos(np.radians(turn_deg)), np.sin(np.radians(turn_deg))
    middle = square * np.array([(columns - 1) / 2, (rows - 1) / 2])
    start = np.array([99.25, 79.375]) - [[cosine, -sine], [sine, cosine]] @ middle  # on the fine grid if not turned
    x = (cosine * (u - start[0]) + sine * (v - start[1])) / square
    y = (-sine * (u - start[0]) + cosine * (v - start[1])) / square
    inside = (x > -1) & (x < columns) & (y > -1) & (y < rows)
    dark = ((np.floor(x) + np.floor(y)) % 2 == 0) & inside
    large = np.where(dark, 40.0, 210.0) * (1 + light * (u / 200 - 0.5))
    picture = cv2.GaussianBlur(cv2.resize(large, (200, 160), interpolation=cv2.INTER_AREA), (0, 0), blur)
    picture += np.random.default_rng(0).normal(0, noise, picture.shape) if noise else 0
    j, i = np.meshgrid(np.arange(columns), np.arange(rows))
    corners = start + square * np.stack([cosine * j - sine * i, sine * j + cosine * i], -1)
    return picture.round().clip(0, 255).astype(np.uint8), corners


def off(picture, corners, start_px=0.4):
    """Distances of the placed corners from the true ones, from a start that is a little off; px."""
    start = corners + np.random.default_rng(1).uniform(-start_px, start_px, corners.shape)
    return np.linalg.norm(place_corners(picture, start) - corners.reshape(-1, 2), axis=1)


@pytest.mark.parametrize("turn_deg", [0, 12, 47, 80])
@pytest.mark.parametrize(("square", "blur"), [(9, 0.6), (18, 0.8), (18, 2.0), (24, 1.2)])
def test_corners_of_a_drawn_board(turn_deg, square, blur):
    assert off(*board_picture(turn_deg, square, blur)).max() < 0.03


def test_uneven_light_moves_no_corner():
    """Over a fifth of the picture, brightness changes by as much as a window's light does."""
    assert off(*board_picture(light=0.5)).max() < 0.02


def test_noise_moves_corners_by_little():
    distance = off(*board_picture(noise=3.0))
    assert 0.003 < np.sqrt((distance**2).mean()) < 0.03


def test_a_start_two_pixels_off_is_near_enough():
    assert off(*board_picture(), start_px=2.0).max() < 0.02


def test_a_corner_where_there_is_none_stays():
    picture, corners = board_picture()
    flat = np.full_like(picture, 90)
    assert place_corners(flat, corners) == pytest.approx(corners.reshape(-1, 2))
    hidden = picture.copy()
    u, v = corners[1, 2].astype(int)
    hidden[v - 9 : v + 10, u - 9 : u + 10] = 128  # a thumb
    placed = place_corners(hidden, corners)
    assert np.isfinite(placed).all() and np.linalg.norm(placed - corners.reshape(-1, 2), axis=1).max() < 6


def test_a_picture_smaller_than_a_corner():
    corners = board_picture()[1]
    assert place_corners(np.zeros((5, 5), np.uint8), corners) == pytest.approx(corners.reshape(-1, 2))
