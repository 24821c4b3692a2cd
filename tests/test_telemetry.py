"""A run told to a network: against a real broker on this computer, which is killed and started again in mid-run."""

import getpass
import json
import shutil
import socket
import subprocess
import sys
import time

import pytest

from conftest import ROOT, skip_unless_ci
from stereo_lab.cli import main
from stereo_lab.common.packages import to_install
from stereo_lab.errors import StereoLabError
from stereo_lab.live import telemetry
from stereo_lab.live.telemetry import KEPT, Bench, Broadcast, Watch, address, bench_name

HEAD = {"source": "virtual:bench", "arm": "virtual://arm", "started": "2026-11-23T10:00:00+0000"}
WAIT_S = 20.0  # for what takes a moment on an idle computer


class Broker:
    """Mosquitto on the loopback."""

    def __init__(self, folder, *settings):
        self.program = shutil.which("mosquitto") or shutil.which("mosquitto", path="/usr/sbin:/usr/local/sbin")
        if self.program is None:
            skip_unless_ci("no mosquitto on this computer")
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = probe.getsockname()[1]
        self.file = folder / "mosquitto.conf"
        lines = [
            f"user {getpass.getuser()}",
            f"listener {self.port} 127.0.0.1",
            *(settings or ["allow_anonymous true"]),
        ]
        self.file.write_text("\n".join(lines) + "\n")
        self.name, self.process = f"127.0.0.1:{self.port}", None

    def start(self):
        self.process = subprocess.Popen(
            [self.program, "-c", self.file], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )

        def answers():
            with socket.socket() as probe:
                return probe.connect_ex(("127.0.0.1", self.port)) == 0

        assert until(answers), "mosquitto does not start"
        return self

    def kill(self):
        if self.process is not None:
            self.process.kill()
            self.process.wait()


def until(what):
    end = time.monotonic() + WAIT_S
    while not (found := what()) and time.monotonic() < end:
        time.sleep(0.02)
    return found


@pytest.fixture
def paho():
    """The package that not everybody has; where no skip is allowed, its absence is a failure of the test itself."""
    if not skip_is_failure():
        pytest.importorskip("paho.mqtt.client")


@pytest.fixture
def broker(paho, tmp_path):
    broker = Broker(tmp_path)
    yield broker.start()
    broker.kill()


def skip_is_failure():
    import os

    return bool(os.environ.get("STEREO_LAB_NO_SKIPS"))


def numbers(watch, bench="b1"):
    return watch.benches.get(bench, Bench()).record.get("number")


def test_what_a_bench_tells_is_seen_elsewhere(broker):
    watch, told = Watch(broker.name), Broadcast(broker.name, "b1", HEAD)
    try:
        assert until(lambda: not watch.trouble and not told.trouble)
        record = {
            "number": 7, "x_mm": 12.6, "y_mm": 250.0, "depth_mm": 1000.2, "rate_hz": 30.1, "cpu_percent": 8.0, "said": "follows",
        }  # fmt: skip

        def heard():
            told.write(record)  # again and again: whoever watches may be there and not listen yet
            return numbers(watch) == 7

        assert until(heard) and until(lambda: watch.benches["b1"].state == "running")
        heading, line = watch.lines()
        assert heading.split()[:3] == ["bench", "state", "ago"]
        assert line.split() == ["b1", "running", "0", "s", "13", "250", "1000", "30", "8%", "follows"]
        told.close()
        assert until(lambda: watch.benches["b1"].state == "ended")
    finally:
        told.close()
        watch.close()


def test_who_comes_later_knows_the_state_too(broker):
    told = Broadcast(broker.name, "b1", HEAD)
    assert until(lambda: not told.trouble)
    told.close()
    watch = Watch(broker.name)
    try:
        assert until(lambda: watch.benches.get("b1", Bench()).state == "ended")
        assert "-" in watch.lines()[1].split()
    finally:
        watch.close()


def test_watching_tells_by_its_exit_code_that_the_broker_is_away(broker, capsys):
    assert main(["watch", broker.name, "--seconds", "3"]) == 0
    broker.kill()
    assert main(["watch", broker.name, "--seconds", "0.3"]) == 1
    assert "Does a broker run there?" in capsys.readouterr().out


def test_a_bench_that_dies_is_called_gone_by_the_broker(broker):
    code = (
        "import os, time\nfrom stereo_lab.live.telemetry import Broadcast\n"
        f"told = Broadcast({broker.name!r}, 'b2', {HEAD!r})\n"
        "while told.trouble:\n    time.sleep(0.02)\n"
        "time.sleep(0.5)\nos._exit(1)\n"
    )
    watch = Watch(broker.name)
    try:
        subprocess.run([sys.executable, "-c", code], cwd=ROOT, timeout=60)
        assert until(lambda: watch.benches.get("b2", Bench()).state == "gone")
    finally:
        watch.close()


def test_a_broker_that_dies_in_mid_run_is_found_again_and_the_newest_records_arrive(broker):
    watch, told = Watch(broker.name), Broadcast(broker.name, "b1", HEAD)
    try:
        assert until(lambda: not watch.trouble and not told.trouble)
        broker.kill()
        assert until(lambda: told.trouble and watch.trouble) and "is away" in told.trouble
        slowest = 0.0
        for k in range(3 * KEPT):
            start = time.perf_counter()
            told.write({"number": k})
            slowest = max(slowest, time.perf_counter() - start)
        assert told.dropped == 2 * KEPT and slowest < 5  # it does not wait for the broker
        heard = []
        take = watch._heard
        watch.client.on_message = lambda *words: (
            heard.append(json.loads(words[2].payload).get("number")),
            take(*words),
        )
        broker.start()
        assert until(lambda: not watch.trouble and not told.trouble)
        told.write({"number": 1000})
        assert until(lambda: numbers(watch) == 1000) and watch.benches["b1"].state == "running"
        kept = [n for n in heard if n is not None and n < 1000]
        assert kept == sorted(kept) and set(kept) <= set(range(2 * KEPT, 3 * KEPT))
    finally:
        told.close()
        watch.close()


def test_a_broker_that_is_not_there_stops_nothing(tmp_path):
    pytest.importorskip("paho.mqtt.client")
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    told = Broadcast(f"127.0.0.1:{port}", "b1", HEAD)
    for k in range(KEPT + 5):
        told.write({"number": k})
    assert told.dropped == 5 and f"127.0.0.1:{port}" in told.trouble
    told.close()
    told.close()


def test_without_its_package_it_says_how_this_python_gets_it(monkeypatch):
    """Not the kit's own name, which a package index does not know; and by this very Python, not by another one."""
    monkeypatch.setitem(sys.modules, "paho.mqtt.client", None)
    with pytest.raises(StereoLabError) as told:
        Watch("127.0.0.1")
    assert str(told.value) == f"MQTT needs one more package: {to_install('paho-mqtt>=2.1')}"
    assert sys.executable in str(told.value)


def test_a_password_is_asked_for_and_taken_from_the_environment(paho, tmp_path):
    passwords = tmp_path / "passwords"
    maker = shutil.which("mosquitto_passwd")
    if maker is None:
        skip_unless_ci("no mosquitto_passwd on this computer")
    subprocess.run([maker, "-b", "-c", passwords, "teacher", "s3cret"], check=True)
    passwords.chmod(0o644)
    tmp_path.chmod(0o755)
    broker = Broker(tmp_path, "allow_anonymous false", f"password_file {passwords}")
    if broker.program:
        broker.start()
    try:
        stranger = Watch(broker.name, {})
        assert until(lambda: "refuses" in stranger.trouble)
        stranger.close()
        known = Watch(broker.name, {telemetry.USER: "teacher", telemetry.PASSWORD: "s3cret"})
        assert until(lambda: not known.trouble)
        known.close()
    finally:
        broker.kill()


def test_tls_needs_a_certificate_that_fits(paho, tmp_path):
    """A broker with a certificate of its own is believed by who has it, and by nobody else."""
    maker = shutil.which("openssl")
    if maker is None:
        skip_unless_ci("no openssl on this computer")
    key, certificate = tmp_path / "key.pem", tmp_path / "certificate.pem"
    words = f"req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=localhost -addext subjectAltName=IP:127.0.0.1 -keyout {key} -out {certificate}"
    subprocess.run([maker, *words.split()], check=True, capture_output=True)
    key.chmod(0o644)
    broker = Broker(tmp_path, "allow_anonymous true", f"certfile {certificate}", f"keyfile {key}").start()
    try:
        known = Watch(broker.name, {telemetry.TLS: str(certificate)})
        assert until(lambda: not known.trouble)
        known.close()
        stranger = Watch(broker.name, {telemetry.TLS: "1"})
        time.sleep(1.0)
        assert stranger.trouble
        stranger.close()
    finally:
        broker.kill()
    with pytest.raises(StereoLabError, match="a file of certificates"):
        Watch("127.0.0.1", {telemetry.TLS: str(tmp_path / "nothing.pem")})


def test_messages_of_strangers_do_no_harm(broker):
    from paho.mqtt.client import CallbackAPIVersion, Client

    watch, stranger = Watch(broker.name), Client(CallbackAPIVersion.VERSION2)
    stranger.connect("127.0.0.1", broker.port)
    stranger.loop_start()
    try:
        assert until(lambda: not watch.trouble and stranger.is_connected())
        for payload in (b"\xff\xfe", b"[1]", b'"x"', b'{"x_mm": "far", "rate_hz": null, "said": 5}',
                        b"[" * 100_000, b'{"x_mm": 1' + b"0" * 400 + b', "said": "\\u001b[2Jgone"}'):  # fmt: skip
            stranger.publish("stereo_lab/b9/record", payload, qos=1)
        assert until(lambda: "gone" in str(watch.benches.get("b9")))
        assert watch.lines()[1].split()[0] == "b9" and "\x1b" not in watch.lines()[1]
    finally:
        stranger.disconnect()
        stranger.loop_stop()
        watch.close()


@pytest.mark.parametrize(
    ("words", "tls", "found"),
    [
        ("broker", False, ("broker", 1883)), ("broker", True, ("broker", 8883)), ("10.0.0.1:99", False, ("10.0.0.1", 99)),
        ("[::1]:1883", False, ("::1", 1883)),
    ],
)  # fmt: skip
def test_addresses(words, tls, found):
    assert address(words, tls) == found


@pytest.mark.parametrize("words", ["", "a b", "host:", "host:0", "host:70000", "host:x", ":1883"])
def test_what_is_no_address_is_refused(words):
    with pytest.raises(StereoLabError, match="HOST or HOST:PORT"):
        address(words)


def test_names_of_benches():
    assert bench_name("bench-7") == "bench-7" and bench_name()
    for words in ("", "a/b", "+", "#", "x" * 41, "bänk"):
        with pytest.raises(StereoLabError, match="bench's name"):
            bench_name(words)
