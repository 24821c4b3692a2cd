"""The controllers that the conformance suite runs on, behind one face."""

import serial

import stereo_lab.arm  # noqa: F401  (makes virtual:// known to pyserial)

BACK_ENDS = ("virtual",)


def open_back_end(name):
    """A bench: its ``port``, what its arm really does, and faults on demand."""
    return {"virtual": VirtualBench}[name]()


class VirtualBench:
    """``virtual://arm`` in virtual time."""

    def __init__(self):
        self.port = serial.serial_for_url("virtual://arm", baudrate=115200)
        self.speed_per_volt = [m.speed_per_volt for m in self.port.motors]

    def restart(self):
        self.port.close()
        self.port.open()

    def link_deg(self, j):
        return self.port.link_deg[j]

    def motor_deg(self, j):
        return self.port.motor_deg[j]

    def fault(self, name, joint):
        setattr(self.port.faults, {"reverse": "reversed", "hold": "stalled"}[name], frozenset({joint}))

    def close(self):
        self.port.close()
