"""Lesson 06: the arm, whatever is behind the port.

from stereo_lab.arm import connect
with connect("virtual://arm") as arm:    # or COM3, /dev/ttyUSB0, socket://…
    arm.home()
    arm.move_to(JointAngles(30, 45))
"""

from stereo_lab.arm.arm import Arm, connect
from stereo_lab.arm.line import ports

__all__ = ["Arm", "connect", "ports"]
