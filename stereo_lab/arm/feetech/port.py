"""``feetech://PORT``: bus servos behind a serial port of pyserial, that speaks PROTOCOL.md on the host's side.

feetech:///dev/ttyACM0      feetech://COM5      feetech://COM5?ids=1,2
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from urllib.parse import parse_qsl

import serial
from serial.serialutil import PortNotOpenError, SerialBase, SerialException

from stereo_lab.arm.feetech.bus import BAUD_RATE, Bus
from stereo_lab.arm.feetech.servos import ServoController

LOOK_S = 0.02  # how often the servos are asked how they are


def open_bus(name: str) -> serial.SerialBase:
    """The port of the adapter."""
    return serial.serial_for_url(name, baudrate=BAUD_RATE, timeout=0.002, write_timeout=1, exclusive=True)


class FeetechPort(SerialBase):
    """A pyserial port with two bus servos behind it.

    A thread asks the servos how they are and is their watchdog: it switches them off when the host is silent in mid-move. It
    lives in this program; when the program is gone, the servos hold on.
    """

    clock: Callable[[], float] = staticmethod(time.monotonic)
    is_open: bool

    def open(self) -> None:
        """Open the adapter and ask for both servos.

        Raises
        ------
        SerialException
            If the port or a servo is not there.
        """
        if self.is_open:
            raise SerialException("Port is already open.")
        name, ids = _read_url(self._port)
        inner = open_bus(name)
        try:
            self._controller = ServoController(Bus(inner, self.clock), ids, self.clock)
        except BaseException:
            inner.close()
            raise
        self._inner, self._lock = inner, threading.RLock()
        self._lost: Exception | None = None
        self.is_open = True
        self._looking = threading.Thread(target=self._look_on, daemon=True)
        self._looking.start()

    def close(self) -> None:
        """Switch the servos off, and close the port."""
        if not self.is_open:
            return
        self.is_open = False
        self._looking.join(timeout=1)
        with self._lock:
            self._let_go()
            self._inner.close()

    def _look_on(self):
        while self.is_open and self._lost is None:
            time.sleep(LOOK_S)
            try:
                with self._lock:
                    if self.is_open:
                        self._controller.look()
            except (SerialException, OSError) as error:
                self._lose(error)

    def _lose(self, error):
        """One that does not answer is lost, and with it the arm: the other one must not go on alone."""
        with self._lock:
            try:
                self._let_go()
            finally:
                self._lost = error

    def _let_go(self):
        """Switch off whichever servo still hears."""
        try:
            self._controller.let_go()
        except (SerialException, OSError):
            pass  # the adapter itself is gone

    def _check(self):
        if not self.is_open:
            raise PortNotOpenError()
        if self._lost is not None:
            raise SerialException(str(self._lost))

    @property
    def in_waiting(self) -> int:
        """How many bytes can be read at once."""
        self._check()
        return len(self._controller.line.tx)

    def read(self, size: int = 1) -> bytes:
        """Up to ``size`` bytes; waits for them no longer than the time-out."""
        until = None if self._timeout is None else time.monotonic() + self._timeout
        while True:
            self._check()
            with self._lock:
                tx = self._controller.line.tx
                if len(tx) >= size or (until is not None and time.monotonic() >= until):
                    data = bytes(tx[:size])
                    del tx[:size]
                    return data
            time.sleep(0.001)

    def write(self, data: bytes) -> int:
        """Bytes from the host."""
        self._check()
        try:
            with self._lock:
                self._controller.line.feed(bytes(data))
        except (SerialException, OSError) as error:
            self._lose(error)
            raise SerialException(str(error)) from None
        return len(data)

    def flush(self) -> None:
        """Nothing waits on the way out."""
        self._check()

    def reset_input_buffer(self) -> None:
        """Throw away what has arrived and is not read yet."""
        self._check()
        with self._lock:
            self._controller.line.tx.clear()

    def reset_output_buffer(self) -> None:
        """Nothing waits on the way out."""
        self._check()

    @property
    def servos(self) -> tuple[dict[str, float], ...]:
        """What both servos tell of themselves: load (share of the largest), voltage, temperature."""
        self._check()
        return tuple(
            {"load": j.load, "volts": j.volts, "celsius": j.celsius, "error": j.error} for j in self._controller.joints
        )

    def _reconfigure_port(self):
        pass

    _update_break_state = _update_rts_state = _update_dtr_state = _reconfigure_port
    cts = dsr = cd = property(lambda self: True)
    ri = property(lambda self: False)


def _read_url(url):
    name, _, options = (url or "").removeprefix("feetech://").partition("?")
    given = dict(parse_qsl(options, keep_blank_values=True))
    words = given.pop("ids", "1,2").split(",")
    if given or not name or len(words) != 2 or not all(word.isdecimal() and int(word) <= 253 for word in words):
        raise SerialException(f"expected feetech://PORT or feetech://PORT?ids=1,2, got {url}")
    return name, (int(words[0]), int(words[1]))
