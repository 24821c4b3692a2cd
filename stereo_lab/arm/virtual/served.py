"""The virtual arm in a process of its own, behind a port of the network: ``socket://127.0.0.1:PORT``."""

from __future__ import annotations

import contextlib
import select
import socket
import subprocess
import sys
from collections.abc import Iterator

import serial

import stereo_lab.arm  # noqa: F401 - makes virtual:// known to pyserial
from stereo_lab.arm.protocol import BAUD_RATE

LOOK_S = 0.002


def serve(listener: socket.socket) -> None:
    """Carry bytes between one client and a virtual arm that follows the clock, until the client goes."""
    line, _ = listener.accept()
    line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    with line, serial.serial_for_url("virtual://arm?realtime=1", BAUD_RATE, timeout=0) as port:
        while True:
            if select.select([line], [], [], LOOK_S)[0]:
                data = line.recv(4096)
                if not data:
                    return
                port.write(data)
            if waiting := port.in_waiting:
                line.sendall(port.read(waiting))


@contextlib.contextmanager
def served_arm() -> Iterator[str]:
    """A virtual arm in a process of its own; gives its address for ``connect``."""
    process = subprocess.Popen([sys.executable, "-m", __name__], stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        yield f"socket://127.0.0.1:{int(process.stdout.readline())}"
    finally:
        process.kill()
        process.communicate()


if __name__ == "__main__":
    with socket.create_server(("127.0.0.1", 0)) as listener:
        print(listener.getsockname()[1], flush=True)
        with contextlib.suppress(ConnectionError):
            serve(listener)
