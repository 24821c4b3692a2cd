"""Makes pyserial know feetech:// ports."""

from stereo_lab.arm.feetech.port import FeetechPort as Serial  # noqa: F401
