"""``virtual://arm``: an arm without hardware, behind a serial port of pyserial."""

from stereo_lab.arm.virtual.plant import BENCH_MOTORS, END_STOPS_DEG, SWITCHES_DEG
from stereo_lab.arm.virtual.port import VirtualPort

__all__ = ["BENCH_MOTORS", "END_STOPS_DEG", "SWITCHES_DEG", "VirtualPort"]
