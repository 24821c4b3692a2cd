"""Where pyserial looks for the scheme ``virtual://``."""

from stereo_lab.arm.virtual import VirtualPort as Serial

__all__ = ["Serial"]
