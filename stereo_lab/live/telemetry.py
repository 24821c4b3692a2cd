"""A run told to a network by MQTT, and all benches of a class seen from one place.

``stereo_lab/<bench>/record`` carries the records of a run, flat JSON; ``stereo_lab/<bench>/status`` is retained, so that who
comes later knows it too, and the broker itself says "gone" where a bench falls silent (its last will).
"""

from __future__ import annotations

import json
import os
import re
import socket
import threading
import time
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from stereo_lab.common.packages import to_install
from stereo_lab.errors import StereoLabError
from stereo_lab.live.log import record_of

PORT, TLS_PORT, TOPIC = 1883, 8883, "stereo_lab"
KEPT = 100  # records that wait while the broker is away; after that the oldest is dropped
KEEP_ALIVE_S = 5  # a broker calls a bench gone after one and a half times that
AGAIN_S = (1, 8)  # a broker that is away is tried again after so long, at first and at most
CONNECT_S = 2.0  # so long a broker may take to answer; the end of a run waits for it
FAREWELL_S = 1.0  # so long the end of a run waits to be told
BENCH = re.compile(r"[\w-]{1,40}", re.ASCII)
USER, PASSWORD, TLS = "STEREO_LAB_MQTT_USER", "STEREO_LAB_MQTT_PASSWORD", "STEREO_LAB_MQTT_TLS"


def address(words: str, tls: bool = False) -> tuple[str, int]:
    """A broker's host and port from ``HOST`` or ``HOST:PORT``.

    Raises
    ------
    StereoLabError
        If the words are neither.
    """
    match = re.fullmatch(r"(\[[0-9a-fA-F:]+\]|[^\s:]+)(?::(\d{1,5}))?", words)
    port = int(match[2] or (TLS_PORT if tls else PORT)) if match else 0
    if not match or not 0 < port < 65536:
        raise StereoLabError(f"Expected a broker as HOST or HOST:PORT, such as 192.168.1.10:1883; got {words!r}.")
    return match[1].strip("[]"), port


def bench_name(words: str | None = None) -> str:
    """What a bench is called: so, or by its computer's name.

    Raises
    ------
    StereoLabError
        If a name has other characters than letters, digits, - and _.
    """
    if words is None:
        return re.sub(r"[^A-Za-z0-9_-]", "-", socket.gethostname())[:40] or "bench"
    if not BENCH.fullmatch(words):
        raise StereoLabError(f"Expected a bench's name of 1 to 40 letters, digits, - and _; got {words!r}.")
    return words


class _Link:
    """A client of a broker that connects by itself, again and again."""

    def __init__(self, broker: str, settings: Mapping[str, str] = os.environ) -> None:
        tls = settings.get(TLS, "")
        self.host, self.port = address(broker, bool(tls))
        try:
            from paho.mqtt.client import CallbackAPIVersion, Client
        except ImportError:
            raise StereoLabError(f"MQTT needs one more package: {to_install('paho-mqtt>=2.1')}") from None
        self.client = Client(CallbackAPIVersion.VERSION2)
        self.trouble = (
            f"{self.host}:{self.port} has not answered yet. Does a broker run there? It is tried again and again"
        )
        self.client.reconnect_delay_set(*AGAIN_S)
        if settings.get(USER):
            self.client.username_pw_set(settings[USER], settings.get(PASSWORD))
        if tls:
            try:
                self.client.tls_set(ca_certs=None if tls == "1" else tls)
            except (OSError, ValueError) as error:
                raise StereoLabError(f"{TLS}={tls}: expected 1, or a file of certificates ({error}).") from None
        self.client.on_connect, self.client.on_disconnect = self._connected, self._disconnected

    def start(self) -> None:
        self.client.connect_timeout = CONNECT_S
        self.client.connect_async(self.host, self.port, KEEP_ALIVE_S)
        self.client.loop_start()

    def on_connected(self) -> None:
        """What is said first whenever a connection stands."""

    def _connected(self, _client, _data, _flags, reason, _properties):
        self.trouble = f"{self.host}:{self.port} refuses: {reason}" if reason.is_failure else ""
        if not reason.is_failure:
            self.on_connected()

    def _disconnected(self, _client, _data, _flags, _reason, _properties):
        self.trouble = self.trouble or f"{self.host}:{self.port} is away"

    def close(self) -> None:
        self.client.disconnect()
        self.client.loop_stop()


class Broadcast(_Link):
    """Tells a run to a broker. Nothing waits for it: while it is away the newest records are kept, and sent later.

    Parameters
    ----------
    broker : str, HOST or HOST:PORT
    bench : str, its name
    head : dict, the header of the run
    settings : mapping, where user, password and TLS stand; the environment, if left out

    Attributes
    ----------
    trouble : str, why nothing arrives; empty where it does
    dropped : int, records that were never sent

    Raises
    ------
    StereoLabError
        If the broker's name cannot be understood, or paho-mqtt is missing.
    """

    def __init__(self, broker: str, bench: str, head: dict[str, Any], settings: Mapping[str, str] = os.environ) -> None:
        super().__init__(broker, settings)
        self.bench, self.head, self.dropped = bench_name(bench), head, 0
        self._waiting: deque[str] = deque()
        self._news, self._closed = threading.Condition(), False
        self.client.will_set(self._topic("status"), _status("gone", head), qos=1, retain=True)
        self.start()
        self._thread = threading.Thread(target=self._send, name="telemetry", daemon=True)
        self._thread.start()

    def _topic(self, what):
        return f"{TOPIC}/{self.bench}/{what}"

    def on_connected(self) -> None:
        """Say that the bench is there; the last will may have said otherwise."""
        self.client.publish(self._topic("status"), _status("running", self.head), qos=1, retain=True)

    @property
    def untold(self) -> int:
        """Records that were never sent, or still wait."""
        return self.dropped + len(self._waiting)

    def write(self, record: dict[str, Any]) -> None:
        """One more record to send."""
        with self._news:
            self._waiting.append(json.dumps(record))
            if len(self._waiting) > KEPT:  # paho's own queue would refuse the newest
                self._waiting.popleft()
                self.dropped += 1
            self._news.notify()

    def _send(self):
        while True:
            with self._news:
                self._news.wait_for(lambda: self._closed or (self._waiting and self.client.is_connected()), 0.2)
                if self._closed:
                    return
                batch = list(self._waiting) if self.client.is_connected() else []
                if batch:
                    self._waiting.clear()
            for text in batch:
                self.client.publish(self._topic("record"), text)

    def close(self) -> None:
        """Say that the run has ended, and go; a broker that is away is not waited for."""
        with self._news:
            if self._closed:
                return
            self._closed = True
            self._news.notify()
        self._thread.join(FAREWELL_S)
        if self.client.is_connected():
            while self._waiting:
                self.client.publish(self._topic("record"), self._waiting.popleft())
            told = self.client.publish(self._topic("status"), _status("ended", self.head), qos=1, retain=True)
            until = time.monotonic() + FAREWELL_S
            while not told.is_published() and self.client.is_connected() and time.monotonic() < until:
                time.sleep(0.01)
        super().close()


def _status(state, head):
    return json.dumps({"state": state, **{name: head[name] for name in ("source", "arm", "started") if name in head}})


@dataclass
class Bench:
    """What is known of one bench.

    Attributes
    ----------
    state : str, running, ended or gone; empty where none was told
    record : dict, its newest one
    heard_s : float, when that came, by ``time.monotonic``
    """

    state: str = ""
    record: dict[str, Any] = field(default_factory=dict)
    heard_s: float = float("-inf")


class Watch(_Link):
    """Listens to all benches of a broker.

    Attributes
    ----------
    benches : dict, name -> Bench
    """

    def __init__(self, broker: str, settings: Mapping[str, str] = os.environ) -> None:
        super().__init__(broker, settings)
        self.benches: dict[str, Bench] = {}
        self.client.on_message = self._heard
        self.start()

    def on_connected(self) -> None:
        """Listen to every bench."""
        self.client.subscribe([(f"{TOPIC}/+/{what}", 1) for what in ("record", "status")])

    def _heard(self, _client, _data, message):
        _, name, what = message.topic.split("/")
        told = record_of(message.payload)
        if told is None or not BENCH.fullmatch(name):  # anybody may write to an open broker
            return
        bench = self.benches.setdefault(name, Bench())
        if what == "status":
            bench.state = str(told.get("state", ""))
        else:
            bench.record, bench.heard_s = told, time.monotonic()

    def lines(self, now_s: float | None = None) -> list[str]:
        """A heading, and a line a bench in the order of their names.

        Parameters
        ----------
        now_s : float, by ``time.monotonic``
        """
        now_s = time.monotonic() if now_s is None else now_s
        rows = [
            f"{'bench':16s} {'state':8s} {'ago':>5s} {'x':>7s} {'y':>7s} {'depth':>7s} {'rate':>5s} {'CPU':>5s}  says"
        ]
        for name in sorted(self.benches):
            bench, r = self.benches[name], self.benches[name].record
            ago = now_s - bench.heard_s
            numbers = " ".join(_number(r.get(key), 7) for key in ("x_mm", "y_mm", "depth_mm"))
            rows.append(
                f"{name[:16]:16s} {_legible(bench.state)[:8]:8s} {f'{ago:.0f} s' if ago < 1e4 else '-':>5s} {numbers} "
                f"{_number(r.get('rate_hz'), 5)} {_number(r.get('cpu_percent'), 4)}%  {_legible(r.get('said', ''))}"
            )
        return rows


def _legible(words):
    """The first words of a message, without what a terminal would obey."""
    return "".join(letter for letter in str(words)[:40] if letter.isprintable())


def _number(value, wide):
    try:
        return f"{value:{wide}.0f}" if isinstance(value, int | float) else f"{'-':>{wide}s}"
    except OverflowError:  # a whole number larger than any float
        return f"{'-':>{wide}s}"
