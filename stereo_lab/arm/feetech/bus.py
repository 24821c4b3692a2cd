"""One wire with servos on it: ask, wait, ask again."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping

import serial

from stereo_lab.arm.feetech import packets
from stereo_lab.arm.feetech.packets import Answer

BAUD_RATE = 1_000_000
ANSWER_S = 0.03  # a servo answers within a millisecond; the computer's side of USB takes its time
TRIES = 3


class Bus:
    """Servos behind an open serial port.

    Parameters
    ----------
    port : serial.SerialBase, at BAUD_RATE, with a short time-out
    clock : function() -> float, seconds
    """

    def __init__(self, port: serial.SerialBase, clock: Callable[[], float] = time.monotonic) -> None:
        self.port, self.clock = port, clock
        self.echo = False  # whether the adapter sends back what it is sent
        self._heard = bytearray()

    def find_echo(self, id: int) -> None:
        """Find out whether the adapter sends back what it is sent: some do, as both ways share one wire."""
        question = packets.read_frame(id, 0, 5)
        self.echo = False
        self._send(question)
        self._listen(ANSWER_S, lambda: False)
        self.echo = bytes(self._heard[: len(question)]) == question

    def ping(self, id: int, tries: int = TRIES) -> Answer | None:
        """Whether a servo of this id is there: its answer, or None."""
        return self._ask(id, packets.frame(id, packets.PING), tries=tries)

    def read(self, id: int, address: int, count: int) -> Answer:
        """Some bytes of a servo's table.

        Raises
        ------
        serial.SerialException
            If it does not answer.
        """
        answer = self._ask(id, packets.read_frame(id, address, count), count)
        if answer is None:
            raise serial.SerialException(f"servo {id} does not answer: is its supply on, and its plug in?")
        return answer

    def write(self, id: int, address: int, data: bytes) -> Answer:
        """Write into a servo's table.

        Raises
        ------
        serial.SerialException
            If it does not answer.
        """
        answer = self._ask(id, packets.write_frame(id, address, data), 0)
        if answer is None:
            raise serial.SerialException(f"servo {id} does not answer: is its supply on, and its plug in?")
        return answer

    def holds(self, id: int, address: int, data: bytes) -> bool:
        """Whether these bytes stand in a servo's table; asked once, and one that does not answer does not hold them."""
        answer = self._ask(id, packets.read_frame(id, address, len(data)), len(data), tries=1)
        return answer is not None and answer.data == data

    def tell(self, address: int, data: Mapping[int, bytes]) -> None:
        """Write into several servos at once; none answers."""
        self._send(packets.sync_write_frame(address, data))

    def _ask(self, id, question, count=None, tries=TRIES):
        for _ in range(tries):
            self._send(question)
            found: list[Answer] = []
            self._listen(ANSWER_S, lambda found=found: self._take(id, len(question), count, found))
            if found:
                return found[0]
        return None

    def _take(self, id, sent, count, found):
        """Whether the answer is there: the right servo's, as long as was asked for, and not our own words."""
        if self.echo and len(self._heard) < sent:
            return False
        heard = self._heard[sent:] if self.echo else self._heard[:]
        while (answer := packets.take_answer(heard)) is not None:
            if answer.id == id and (count is None or len(answer.data) == count):
                found.append(answer)
                return True
        return False

    def _send(self, data):
        if late := self.port.in_waiting:
            self.port.read(late)  # no flush: where the adapter is gone, that raises what is no OSError
        self._heard.clear()
        self.port.write(data)

    def _listen(self, seconds, enough):
        until = self.clock() + seconds
        while not enough() and self.clock() < until:
            self._heard += self.port.read(max(1, self.port.in_waiting))
