"""The controllers that the conformance suite runs on, behind one face; each has a clock of its own.

``virtual`` is ``virtual://arm``; ``chip`` the firmware in a simulated ATmega328P, in its own time; ``pty`` the same
behind a pseudo-terminal, by the clock. The last two need gcc, gcc-avr, avr-libc, arduino-core-avr and libsimavr-dev
(Debian's names).
"""

import ctypes
import functools
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import serial
from serial.serialutil import SerialBase

import stereo_lab.arm  # noqa: F401  (makes virtual:// known to pyserial)
from conftest import ROOT, skip_unless_ci
from stereo_lab.arm.virtual import BENCH_ARM, BENCH_MOTORS, CAM_DEG, END_STOPS_DEG, SWITCHES_DEG
from stereo_lab.arm.virtual.controller import BYTES_PER_TICK
from stereo_lab.arm.virtual.plant import Faults, Plant
from stereo_lab.kinematics import GRAVITY_M_S2, NM, inertia_parts_kg_m2, moments_g_mm
from stereo_lab.motion import TICK_S

sys.path.insert(0, str(ROOT / "examples"))
from controller_from_the_page import Controller  # noqa: E402

BACK_ENDS = ("virtual", "page", "chip", "pty")
SKETCH = ROOT / "stereo_lab" / "firmware" / "arm_controller" / "arm_controller.ino"
CHIP = ROOT / "tests" / "chip" / "chip.c"
CORE = Path("/usr/share/arduino/hardware/arduino/avr")
SIMAVR = Path("/usr/include/simavr/sim_avr.h")
BOARD = ["-Os", "-mmcu=atmega328p", "-DF_CPU=16000000UL", "-DARDUINO=10819", "-DARDUINO_AVR_UNO", "-DARDUINO_ARCH_AVR",
         "-ffunction-sections", "-fdata-sections", f"-I{CORE}/cores/arduino", f"-I{CORE}/variants/standard"]  # fmt: skip


def open_back_end(name):
    """A bench: its ``port``, what its arm really does, and faults on demand."""
    return {"virtual": VirtualBench, "page": PageBench, "chip": ChipBench, "pty": PtyBench}[name]()


class VirtualBench:
    """``virtual://arm`` in virtual time."""

    speed_per_volt = [m.speed_per_volt for m in BENCH_MOTORS]

    def __init__(self):
        self.port = serial.serial_for_url("virtual://arm", baudrate=115200)

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


class PagePort(SerialBase):
    """A pyserial port in front of the controller that was written from PROTOCOL.md alone: reading lets its time pass."""

    def open(self):
        self.faults = Faults()
        self.plant = Plant(BENCH_MOTORS, self.faults, BENCH_ARM)
        self.controller, self.ticks, self.room = Controller(self.plant), 0, 0.0
        self.sending, self.arrived = bytearray(), bytearray()
        self.is_open = True

    def close(self):
        self.is_open = False

    def clock(self):
        return self.ticks * TICK_S

    def sleep(self, seconds):
        for _ in range(max(1, round(seconds / TICK_S))):
            self.ticks += 1
            self.controller.tick()
            self.plant.tick()
            self.sending += self.controller.sent()
            self.room = min(self.room + BYTES_PER_TICK, 64.0)  # as many bytes as the line can carry
            sent = self.sending[: int(self.room)]
            self.room -= len(sent)
            self.arrived += sent
            del self.sending[: len(sent)]

    @property
    def in_waiting(self):
        return len(self.arrived)

    def read(self, size=1):
        give_up = None if self._timeout is None else self.clock() + self._timeout
        while len(self.arrived) < size and (give_up is None or self.clock() < give_up):
            self.sleep(TICK_S)
        data = bytes(self.arrived[:size])
        del self.arrived[:size]
        return data

    def write(self, data):
        self.controller.receive(bytes(data))
        return len(data)

    def flush(self):
        pass

    def reset_input_buffer(self):
        self.arrived.clear()

    def reset_output_buffer(self):
        pass

    def _reconfigure_port(self):
        pass

    _update_break_state = _update_rts_state = _update_dtr_state = _reconfigure_port
    cts = dsr = cd = property(lambda self: True)
    ri = property(lambda self: False)


class PageBench:
    """``examples/controller_from_the_page.py`` with the virtual arm's motors, links and switches."""

    speed_per_volt = [m.speed_per_volt for m in BENCH_MOTORS]

    def __init__(self):
        self.port = PagePort("page")

    def restart(self):
        self.port.close()
        self.port.open()

    def link_deg(self, j):
        return self.port.plant.links[j]

    def motor_deg(self, j):
        return self.port.plant.positions[j]

    def fault(self, name, joint):
        setattr(self.port.faults, {"reverse": "reversed", "hold": "stalled"}[name], frozenset({joint}))

    def close(self):
        self.port.close()


HOUSE = tempfile.TemporaryDirectory(prefix="chip")


@functools.lru_cache(maxsize=1)
def build():
    """Compile the sketch as the Arduino IDE does, and the simulated chip; returns the folder."""
    missing = [tool for tool in ("gcc", "avr-gcc", "avr-g++") if shutil.which(tool) is None]
    missing += [str(path) for path in (CORE, SIMAVR) if not path.exists()]
    if missing:
        skip_unless_ci(f"no simulated chip here: {', '.join(missing)} missing")
    folder = Path(HOUSE.name)
    cpp = ["-std=gnu++11", "-fno-exceptions", "-fno-threadsafe-statics"]
    sketch = ["-Wall", "-Wextra", "-Werror", *cpp, "-fpermissive", "-x", "c++", "-include", "Arduino.h"]
    _run("avr-g++", *BOARD, *sketch, "-c", SKETCH, "-o", folder / "sketch.o")
    core = CORE / "cores" / "arduino"
    for source, compiler, flags in (
        ("wiring.c", "avr-gcc", ["-std=gnu11"]), ("hooks.c", "avr-gcc", ["-std=gnu11"]), ("main.cpp", "avr-g++", cpp),
    ):  # fmt: skip
        _run(compiler, *BOARD, *flags, "-w", "-c", core / source, "-o", folder / f"{source}.o")
    objects = [folder / f"{name}.o" for name in ("sketch", "wiring.c", "hooks.c", "main.cpp")]
    _run("avr-gcc", "-Os", "-mmcu=atmega328p", "-Wl,--gc-sections", *objects, "-lm", "-o", folder / "firmware.elf")
    simulator = ["gcc", "-O2", "-I/usr/include/simavr", CHIP, "-lsimavr", "-lutil", "-lm", "-o"]
    _run(*simulator, folder / "chip.so", "-shared", "-fPIC")
    _run(*simulator, folder / "serve", "-DSERVE")
    return folder


def _run(*command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def motor_numbers(j):
    """The motors of the virtual arm's bench, for the simulated chip."""
    m = BENCH_MOTORS[j]
    return [m.speed_per_volt, *m.dead_band_v, m.time_constant_s, m.backlash_deg, m.supply_v, m.counts_per_turn,
            SWITCHES_DEG[j], *END_STOPS_DEG[j], m.torque_per_volt, m.gear_loss,
            min(m.resistance_ohm * m.current_limit_a, 1e9), CAM_DEG]  # fmt: skip


def arm_numbers():
    """What its arm weighs."""
    return [*(GRAVITY_M_S2 * NM * moment for moment in moments_g_mm(BENCH_ARM)), *inertia_parts_kg_m2(BENCH_ARM)]


class ChipPort(SerialBase):
    """A pyserial port in front of the simulated chip: reading lets its time pass."""

    STEP_US = 500

    def open(self):
        self.library = ctypes.CDLL(str(build() / "chip.so"))
        self.library.chip_new.restype = ctypes.c_void_p
        for name in ("chip_seconds", "chip_link", "chip_position"):
            getattr(self.library, name).restype = ctypes.c_double
        self.chip = ctypes.c_void_p(self.library.chip_new(str(build() / "firmware.elf").encode()))
        assert self.chip.value, "the firmware could not be loaded"
        self.restart()
        self.is_open = True

    def restart(self):
        for j in range(2):
            self.library.chip_motor(self.chip, j, (ctypes.c_double * 14)(*motor_numbers(j)))
        self.library.chip_arm(self.chip, (ctypes.c_double * 5)(*arm_numbers()))
        self.library.chip_reset(self.chip)
        self.start = self.library.chip_seconds(self.chip)

    def clock(self):
        return self.library.chip_seconds(self.chip) - self.start

    @property
    def in_waiting(self):
        return self.library.chip_waiting(self.chip)

    def read(self, size=1):
        end = None if self._timeout is None else self.clock() + self._timeout
        while self.in_waiting < size and (end is None or self.clock() < end):
            assert self.library.chip_run_us(self.chip, self.STEP_US) == 0, "the chip crashed"
        data = (ctypes.c_uint8 * size)()
        return bytes(data[: self.library.chip_read(self.chip, data, size)])

    def write(self, data):
        return self.library.chip_write(self.chip, bytes(data), len(data))

    def close(self):
        self.is_open = False

    def _reconfigure_port(self):
        pass

    _update_break_state = _update_rts_state = _update_dtr_state = _reconfigure_port


class ChipBench:
    """The compiled firmware in the simulated chip."""

    speed_per_volt = VirtualBench.speed_per_volt

    def __init__(self):
        build()
        self.port = ChipPort("chip", baudrate=115200)

    def restart(self):
        self.port.restart()

    def link_deg(self, j):
        return self.port.library.chip_link(self.port.chip, j)

    def motor_deg(self, j):
        return self.port.library.chip_position(self.port.chip, j)

    def fault(self, name, joint):
        self.port.library.chip_fault(self.port.chip, name.encode(), joint - 1)

    def close(self):
        self.port.close()


class PtyBench:
    """The same chip as a program of its own, by the clock, behind a pseudo-terminal."""

    speed_per_volt = VirtualBench.speed_per_volt

    def __init__(self):
        numbers = [repr(n) for n in (*motor_numbers(0), *motor_numbers(1), *arm_numbers())]
        self.program = subprocess.Popen(
            [str(build() / "serve"), str(build() / "firmware.elf"), *numbers],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1,
        )  # fmt: skip
        self.name = next(line for line in self.program.stdout if line.startswith("/dev/")).strip()  # simavr talks first
        self.port = serial.Serial(self.name, 115200, timeout=0.02, exclusive=True)

    def _ask(self, order):
        self.program.stdin.write(order + "\n")
        return [float(word) for word in self.program.stdout.readline().split()]

    def restart(self):
        time.sleep(0.05)  # what is on the line has arrived
        self.port.reset_input_buffer()
        self._ask("reset")

    def clock(self):
        """The chip's own time: on a busy computer its program falls behind the clock on the wall."""
        return self._ask("ask")[4]

    def link_deg(self, j):
        return self._ask("ask")[j]

    def motor_deg(self, j):
        return self._ask("ask")[2 + j]

    def fault(self, name, joint):
        self._ask(f"{name} {joint}")

    def close(self):
        self.port.close()
        self.program.stdin.close()
        self.program.wait(5)
        assert os.path.exists(self.name) is False or self.program.returncode == 0
