"""Feetech's own SDK, in an environment of its own, against the kit's frames: what both send, and what both read."""

import json
import random
import subprocess
import sys
import venv

import pytest

from conftest import skip_unless_ci
from stereo_lab.arm.feetech import packets

pytestmark = pytest.mark.slow
SDK = "feetech-servo-sdk==1.0.0"  # scservo_sdk, as its maker publishes it
SCRIPT = '''
import json, sys
from scservo_sdk import GroupSyncWrite, PacketHandler

class Port:
    """In place of a serial port: keeps what is written, gives what it is told to."""
    is_using, ser = False, None
    def __init__(self, heard=b""): self.sent, self.heard = b"", bytearray(heard)
    def clearPort(self): pass
    def writePort(self, packet): self.sent += bytes(packet); return len(packet)
    def readPort(self, length):
        data = bytes(self.heard[:length]); del self.heard[:length]; return list(data)
    def setPacketTimeout(self, length): pass
    def isPacketTimeout(self): return True

handler, answers = PacketHandler(0), []
for kind, *rest in json.load(sys.stdin):
    port = Port(bytes.fromhex(rest[0]) if kind == "answer" else b"")
    if kind == "read": handler.readTx(port, *rest)
    elif kind == "write": handler.writeTxOnly(port, *rest)
    elif kind == "sync write":
        group = GroupSyncWrite(port, handler, rest[1], rest[2])
        for id, data in rest[0]: group.addParam(id, data)
        group.txPacket()
    elif kind == "answer":
        packet, result = handler.rxPacket(port)
        answers.append([result, *( [packet[2], packet[4], packet[5:-1]] if result == 0 else [] )]); continue
    answers.append(port.sent.hex())
print(json.dumps(answers))
'''


@pytest.fixture(scope="module")
def sdk(tmp_path_factory):
    """A function that runs orders through the SDK; it may not share an environment with another servo SDK."""
    folder = tmp_path_factory.mktemp("sdk")
    venv.create(folder, with_pip=True)
    python = folder / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")
    install = subprocess.run([python, "-m", "pip", "install", "-q", SDK], capture_output=True, text=True)
    if install.returncode:
        skip_unless_ci(f"{SDK} cannot be installed here: {install.stderr[-200:]}")

    def run(orders):
        done = subprocess.run([python, "-c", SCRIPT], input=json.dumps(orders), capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return run


def test_frames_are_those_of_the_makers_sdk(sdk):
    rng = random.Random(0)
    orders, ours = [], []
    while len(orders) < 200:
        id, address, count = rng.randrange(1, 30), rng.randrange(0, 70), rng.randrange(1, 12)
        data = [rng.randrange(0, 255) for _ in range(count)]
        kind = ("read", "write", "sync write")[len(orders) % 3]
        ids = rng.sample(range(1, 30), 2)
        try:
            if kind == "read":
                order, frame = [id, address, count], packets.read_frame(id, address, count)
            elif kind == "write":
                order, frame = [id, address, count, data], packets.write_frame(id, address, bytes(data))
            else:
                order = [[[one, data] for one in ids], address, count]
                frame = packets.sync_write_frame(address, {one: bytes(data) for one in ids})
        except ValueError:  # two FF in a row, which the kit refuses to send
            continue
        orders.append([kind, *order])
        ours.append(frame.hex())
    assert sdk(orders) == ours


def test_answers_are_read_as_the_makers_sdk_reads_them(sdk):
    rng = random.Random(1)
    frames = []
    for _ in range(100):
        body = bytes([rng.randrange(1, 30), (count := rng.randrange(0, 12)) + 2, rng.choice((0, 1, 4, 32, 37))])
        body += bytes(rng.randrange(0, 255) for _ in range(count))
        frames.append(packets.HEADER + body + bytes([packets.checksum(body)]))
    told = sdk([["answer", frame.hex()] for frame in frames])
    for frame, (result, *rest) in zip(frames, told, strict=True):
        answer = packets.take_answer(bytearray(frame))
        assert result == 0 and rest == [answer.id, answer.error, list(answer.data)]
    broken = [frame[:-1] + bytes([frame[-1] ^ 1]) for frame in frames]
    assert all(result != 0 for result, *_ in sdk([["answer", frame.hex()] for frame in broken]))
    assert all(packets.take_answer(bytearray(frame)) is None for frame in broken)
