"""Lesson 06: the arm, whatever is behind the port.

from stereo_lab.arm import JointAngles, connect
with connect("virtual://arm") as arm:    # or COM3, /dev/ttyUSB0, socket://…
    arm.home()
    arm.move_to(JointAngles(30, 45))
"""

from stereo_lab.arm.arm import Arm, connect
from stereo_lab.arm.line import ports
from stereo_lab.kinematics import JointAngles, TwoLinkArm

__all__ = ["Arm", "JointAngles", "TwoLinkArm", "connect", "ports"]
