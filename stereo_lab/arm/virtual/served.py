"""The virtual arm in a process of its own, behind a port that any program can open."""

from __future__ import annotations

import contextlib
import os
import select
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator

import serial

import stereo_lab.arm  # noqa: F401 - makes virtual:// known to pyserial
from stereo_lab.arm.protocol import BAUD_RATE

LOOK_S = 0.002


def _serve(line: int | socket.socket, take: Callable[[int], bytes], give: Callable[[bytes], object]) -> None:
    """Carry bytes between a client and a virtual arm that follows the clock, until the client goes."""
    with serial.serial_for_url("virtual://arm?realtime=1", BAUD_RATE, timeout=0) as port:
        while True:
            if select.select([line], [], [], LOOK_S)[0]:
                data = take(4096)
                if not data:
                    return
                port.write(data)
            if waiting := port.in_waiting:
                give(port.read(waiting))


def _main() -> None:
    if hasattr(os, "openpty"):  # a terminal: what a serial port looks like to a program
        line, client = os.openpty()
        import tty

        tty.setraw(client)
        print(os.ttyname(client), flush=True)
        _serve(line, lambda most: os.read(line, most), lambda data: os.write(line, data))
        return
    with socket.create_server(("127.0.0.1", 0)) as listener:
        print(f"socket://127.0.0.1:{listener.getsockname()[1]}", flush=True)
        network, _ = listener.accept()
        network.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        _serve(network, network.recv, network.sendall)


@contextlib.contextmanager
def served_arm() -> Iterator[str]:
    """A virtual arm in a process of its own; gives its port for ``connect``."""
    process = subprocess.Popen([sys.executable, "-m", __name__], stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        yield process.stdout.readline().strip()
    finally:
        process.kill()
        process.communicate()


if __name__ == "__main__":
    with contextlib.suppress(OSError):  # the client is gone
        _main()
