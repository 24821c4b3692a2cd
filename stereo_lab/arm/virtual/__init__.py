"""``virtual://arm``: an arm without hardware, behind a serial port of pyserial."""

from stereo_lab.arm.virtual.plant import BENCH_ARM, BENCH_MOTORS, CAM_DEG, END_STOPS_DEG, SWITCHES_DEG
from stereo_lab.arm.virtual.port import VirtualPort

__all__ = ["BENCH_ARM", "BENCH_MOTORS", "CAM_DEG", "END_STOPS_DEG", "SWITCHES_DEG", "VirtualPort"]
