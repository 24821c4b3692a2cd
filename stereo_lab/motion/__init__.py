"""Lesson 06: motors, how to measure them, and ways to stop them where they should."""

from stereo_lab.motion.measuring import (
    DirectionFit,
    MotorCalibration,
    WeightFit,
    calibrate_motor,
    lowest_voltage,
    push_of,
)
from stereo_lab.motion.motors import Motor, advance, drag_link, encoder_count, polled_counts
from stereo_lab.motion.rules import (
    MOST_LOAD_V,
    REST_TICKS,
    TICK_S,
    Profile,
    Run,
    SlowDownRule,
    Tuning,
    drive,
    slow_down_volts,
    slow_zone_deg,
    tracking_volts,
    trapezoid_s,
    trapezoid_step,
)  # fmt: skip

__all__ = [
    "MOST_LOAD_V", "WeightFit", "lowest_voltage",
    "REST_TICKS", "TICK_S", "DirectionFit", "Motor", "MotorCalibration", "Profile", "Run", "SlowDownRule", "Tuning",
    "advance", "calibrate_motor", "drag_link", "drive", "encoder_count", "polled_counts", "push_of",
    "slow_down_volts", "slow_zone_deg", "tracking_volts", "trapezoid_s", "trapezoid_step",
]  # fmt: skip
