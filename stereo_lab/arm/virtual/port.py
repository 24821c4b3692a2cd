"""``virtual://arm``: an arm without hardware, behind a serial port of pyserial.

Its controller answers the same bytes as the firmware; its motors are those of ``stereo_lab.motion``. Time passes
while the host reads, so a move of a second is over in milliseconds; ``?realtime=1`` follows the clock.
"""

from __future__ import annotations

import threading
import time
from dataclasses import replace
from urllib.parse import parse_qsl, urlsplit

import numpy as np
from serial.serialutil import PortNotOpenError, SerialBase, SerialException

from stereo_lab.arm import protocol as wire
from stereo_lab.arm.virtual.controller import BYTES_PER_TICK, Controller
from stereo_lab.arm.virtual.plant import BENCH_ARM, BENCH_MOTORS, EQUAL_MOTORS, Faults, Plant
from stereo_lab.motion import TICK_S, Motor

OPTIONS = "realtime, seed, motors, load_g, noise, silent, unplugged, reset, stall, runaway"


class VirtualPort(SerialBase):
    """A pyserial port with a simulated arm behind it.

    Attributes
    ----------
    faults : Faults
    is_open : bool
    """

    is_open: bool

    def open(self) -> None:
        """Power the arm up.

        Raises
        ------
        SerialException
            For a name that is not ``virtual://arm`` with options that are known.
        """
        if self._port is None:
            raise SerialException("Port must be configured before it can be used.")
        if self.is_open:
            raise SerialException("Port is already open.")
        options = self._options()
        self._lock = threading.RLock()
        self._rng = np.random.default_rng(options["seed"])
        self.faults = Faults(noise=options["noise"], stalled=options["stall"], reversed=options["runaway"])
        self._plant = Plant(_motors(options), self.faults, _arm(options))
        self._controller = Controller(self._plant)
        self._events = {name: options[name] for name in ("silent", "unplugged", "reset") if options[name] is not None}
        self._realtime, self._start = options["realtime"], time.monotonic()
        self._ticks, self._budget, self._out = 0, 0.0, bytearray()
        self.is_open = True

    def _options(self):
        parts = urlsplit(self._port)
        given = dict(parse_qsl(parts.query, keep_blank_values=True))
        if parts.netloc != "arm" or parts.path not in ("", "/"):
            raise SerialException(f"expected virtual://arm, got {self._port}")
        options = {"realtime": False, "seed": 0, "motors": None, "load_g": None, "noise": 0.0, "silent": None, "unplugged": None,
                   "reset": None, "stall": frozenset(), "runaway": frozenset()}  # fmt: skip
        for name, word in given.items():
            if name not in options:
                raise SerialException(f"virtual://arm has no option {name!r}; it has {OPTIONS}")
            read, should_be = READ[name]
            try:
                options[name] = read(word)
            except (KeyError, ValueError):
                raise SerialException(f"virtual://arm: {name} should be {should_be}; got {name}={word}") from None
        if options["motors"] is None:
            options["motors"] = "random" if "seed" in given else "bench"
        return options

    def close(self) -> None:
        """Switch the arm off."""
        self.is_open = False

    def clock(self) -> float:
        """Seconds on the arm's clock since it was opened; with ``?realtime=1`` the computer's, also while nobody asks."""
        return time.monotonic() - self._start if self._realtime else self._ticks * TICK_S

    def sleep(self, seconds: float) -> None:
        """Let time pass on the arm's clock, which goes on where its cable is pulled as well."""
        with self._lock:
            if not self.is_open:
                raise PortNotOpenError()
            self._run(round(seconds / TICK_S))

    def _catch_up(self):
        """With ``?realtime=1``: let the time pass that has passed."""
        if self._realtime:
            self._run(int((time.monotonic() - self._start) / TICK_S) - self._ticks)

    def _run(self, ticks, until_bytes=None):
        """Let ticks pass, or fewer if so many bytes have arrived before."""
        end = self._ticks + ticks
        while self._ticks < end and (until_bytes is None or len(self._out) < until_bytes):
            if self._idle():
                self._skip(end)
            else:
                self._tick()
        for name in [n for n, at in self._events.items() if self._ticks * TICK_S >= at]:
            del self._events[name]
            self.reset() if name == "reset" else setattr(self.faults, name, True)

    def _idle(self):
        c = self._controller
        return self._plant.still and not c.busy and c.settled and not c.line.tx and not c.report_ms

    def _skip(self, end):
        """Nothing moves: jump to the end."""
        for joint in self._controller.joints:
            joint.still_ticks, joint.speed_deg_s = joint.still_ticks + end - self._ticks, 0.0
        self._controller.time_ticks += end - self._ticks
        self._ticks = end

    def _tick(self):
        self._ticks += 1
        self._controller.tick()
        self._plant.tick()
        if self._controller.line.tx:
            self._budget = min(self._budget + BYTES_PER_TICK, 64.0)
            sent = bytes(self._controller.line.tx[: int(self._budget)])
            del self._controller.line.tx[: len(sent)]
            self._budget -= len(sent)
            self._out += b"" if self.faults.silent else self._on_the_wire(sent)

    def _on_the_wire(self, data):
        """Bytes as they arrive on the other side."""
        if self._baudrate != wire.BAUD_RATE:
            return bytes(self._rng.integers(128, 256, len(data), dtype=np.uint8))
        if self.faults.noise <= 0 or not data:
            return data
        hit = self._rng.random(len(data)) < self.faults.noise
        flips = np.where(hit, 1 << self._rng.integers(0, 8, len(data)), 0).astype(np.uint8)
        return (np.frombuffer(data, np.uint8) ^ flips).tobytes()

    @property
    def in_waiting(self) -> int:
        """How many bytes can be read at once."""
        with self._lock:
            self._check()
            self._catch_up()
            return len(self._out)

    def read(self, size: int = 1) -> bytes:
        """Up to ``size`` bytes; waits for them no longer than the time-out, on the arm's clock."""
        deadline = None if self._timeout is None else self.clock() + (self._timeout and max(self._timeout, TICK_S))
        while True:
            with self._lock:
                self._check()
                self._catch_up()
                if len(self._out) >= size or (deadline is not None and self.clock() >= deadline - 1e-9):
                    data = bytes(self._out[:size])
                    del self._out[:size]
                    return data
                if not self._realtime:
                    left = 10 * TICK_S if deadline is None else deadline - self.clock()
                    self._run(max(1, round(left / TICK_S)), until_bytes=size)
                    continue
            time.sleep(TICK_S)

    def write(self, data: bytes) -> int:
        """Bytes to the arm."""
        with self._lock:
            self._check()
            self._catch_up()
            self._controller.line.feed(self._on_the_wire(bytes(data)))
            return len(data)

    def flush(self) -> None:
        """Nothing waits on the way out: what is written has arrived."""
        self._check()

    def reset_input_buffer(self) -> None:
        """Throw away what has arrived and is not read yet."""
        with self._lock:
            self._check()
            self._out.clear()

    def reset_output_buffer(self) -> None:
        """Nothing waits on the way out, so nothing is thrown away."""
        self._check()

    def _check(self):
        if not self.is_open:
            raise PortNotOpenError()
        if self.faults.unplugged:
            raise SerialException("the device is gone: virtual://arm was unplugged")

    @property
    def follows_the_clock(self) -> bool:
        """Whether its time is the computer's; else it passes while the host waits."""
        return self._realtime

    @property
    def link_deg(self) -> tuple[float, float]:
        """Where the links really are: what no encoder sees."""
        return self._plant.links[0], self._plant.links[1]

    @property
    def motor_deg(self) -> tuple[float, float]:
        """Where the motors really are; the links lag by their backlash."""
        return self._plant.positions[0], self._plant.positions[1]

    @property
    def motors(self) -> tuple[Motor, Motor]:
        """The two motors: what calibration has to find out."""
        return self._plant.motors

    @property
    def weight_v(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """What weighing has to find out: g1 and g2 of both joints, volts."""
        (first, second), (one, other) = self._plant.weights, (m.torque_per_volt for m in self.motors)
        return (first / one, second / one), (0.0, second / other)

    @property
    def at_rest(self) -> bool:
        """Whether both motors stand still, and will."""
        return self._plant.still

    def reset(self) -> None:
        """Restart the controller, as a dip of its supply does; the motors stop."""
        self._plant.speeds = [0.0, 0.0]
        self._controller.restart()

    def _reconfigure_port(self):
        pass

    _update_break_state = _update_rts_state = _update_dtr_state = _reconfigure_port
    cts = dsr = cd = property(lambda self: True)
    ri = property(lambda self: False)


def _motors(options):
    if options["motors"] == "bench":
        return BENCH_MOTORS
    if options["motors"] == "equal":
        return EQUAL_MOTORS
    rng = np.random.default_rng(options["seed"])
    return tuple(Motor.random(rng) for _ in range(2))


def _arm(options):
    if options["load_g"] is None:
        return BENCH_ARM
    return replace(BENCH_ARM, weight=replace(BENCH_ARM.weight, load_g=options["load_g"]))


def _seed(word):
    if int(word) < 0:
        raise ValueError(word)
    return int(word)


def _grams(word):
    if not 0 <= float(word) <= 1000:
        raise ValueError(word)
    return float(word)


def _motor_name(word):
    return {"bench": "bench", "equal": "equal", "random": "random"}[word]


def _part(word):
    if not 0 <= float(word) < 1:
        raise ValueError(word)
    return float(word)


def _seconds(word):
    if not 0 <= float(word) < 1e6:
        raise ValueError(word)
    return float(word)


def _joints(word):
    return frozenset({"1": 1, "2": 2}[part] for part in word.split(","))


SECONDS, JOINTS = (_seconds, "a number of seconds, from 0 to below 1000000"), (_joints, "1, 2, or both as 1,2")
READ = {  # what reads an option, and what it should be
    "realtime": (lambda word: {"0": False, "1": True}[word], "0 or 1"), "seed": (_seed, "a whole number from 0 on"),
    "motors": (_motor_name, "bench, equal or random"), "load_g": (_grams, "a number of grams, from 0 to 1000"),
    "noise": (_part, "a part of the bytes, from 0 to below 1"),
    "silent": SECONDS, "unplugged": SECONDS, "reset": SECONDS, "stall": JOINTS, "runaway": JOINTS,
}  # fmt: skip
