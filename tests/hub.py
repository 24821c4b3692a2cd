"""A real JupyterHub on the loopback with real Unix users, and learners who work in it.

`python -m tests.hub --learners 30 --busy 3` measures a class on this computer: memory, and how long a light cell waits.
"""

from __future__ import annotations

import argparse
import importlib.util
import itertools
import json
import os
import pwd
import shutil
import socket
import statistics
import subprocess
import sys
import tempfile
import threading
import time
import uuid
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import nbformat
import psutil
import requests
import websocket

from conftest import ROOT

SETTINGS = """exec(open({settings!r}).read())
c.JupyterHub.bind_url = "http://127.0.0.1:{port}"
c.JupyterHub.hub_port = {hub_port}
c.ConfigurableHTTPProxy.api_url = "http://127.0.0.1:{api_port}"
c.ConfigurableHTTPProxy.command = {proxy!r}
c.JupyterHub.authenticator_class = "dummy"
c.DummyAuthenticator.password = "a long password for the test"
c.Authenticator.allow_all = True
c.JupyterHub.spawner_class = "jupyterhub.spawner.LocalProcessSpawner"
c.JupyterHub.log_level = "WARN"
"""
LIGHT = "pixel = (30, 40, 200)\nprint('a pixel:', pixel)"  # a cell of the lesson that computes nothing
PASSWORD = "a long password for the test"


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


def proxy_command():
    """configurable-http-proxy: where `.ci/run` has put it, or on the PATH; None where it is not."""
    return shutil.which(
        "configurable-http-proxy", path=f"{ROOT / '.npm/hub/node_modules/.bin'}{os.pathsep}{os.environ['PATH']}"
    )


def without_the_kits(path):
    """A PATH as a hub has it that is not the kit's: without the folder of the kit's Python."""
    return os.pathsep.join(part for part in path.split(os.pathsep) if not (Path(part) / "stereo-lab").exists())


def missing():
    """What this computer needs before it can run a hub, as a sentence; "" where nothing is missing."""
    if os.geteuid():
        return "Expected root: a Unix user is made for each learner, and taken away again. Run it with sudo."
    if importlib.util.find_spec("jupyterhub") is None:
        return "JupyterHub is not installed. In the kit's folder: STEREO_LAB_EXTRAS=server python3 lab.py --help"
    if proxy_command() is None:
        return "configurable-http-proxy is not installed. In the kit's folder: npm install --no-save --prefix .npm/hub configurable-http-proxy"
    return ""


class Hub:
    """JupyterHub with learners who have a Unix user each; everything of it is gone when it is left."""

    def __init__(self, learners, folder):
        self.names = [f"sl{os.getpid() % 10000}n{k}" for k in range(learners)]
        self.folder, self.running = Path(folder), None
        self.address = f"http://127.0.0.1:{(port := free_port())}"
        self.settings = SETTINGS.format(
            settings=str(ROOT / "docs/server/stereo_lab_hub.py"), port=port, hub_port=free_port(), api_port=free_port(), proxy=[proxy_command()]
        )  # fmt: skip

    def __enter__(self):
        try:
            return self.start()
        except BaseException:
            self.__exit__()
            raise

    def start(self):
        self.folder.chmod(0o755)
        for name in self.names:
            subprocess.run(
                ["useradd", "--create-home", "--home-dir", self.folder / name, "--shell", "/bin/bash", name], check=True
            )
        config = self.folder / "hub"
        config.mkdir(mode=0o700)
        (config / "jupyterhub_config.py").write_text(self.settings)
        environment = {**os.environ, "STEREO_LAB_KIT": str(ROOT), "PATH": without_the_kits(os.environ["PATH"])}
        for name in ("STEREO_LAB_HOME", "STEREO_LAB_WORK", "PYTHONPATH"):
            environment.pop(name, None)
        with open(config / "log", "w") as log:
            self.running = subprocess.Popen(
                [sys.executable, "-m", "jupyterhub"], cwd=config, env=environment, stdout=log, stderr=log
            )
        for _ in range(600):
            assert self.running.poll() is None, (config / "log").read_text()
            try:
                requests.get(f"{self.address}/hub/health", timeout=2).raise_for_status()
                return self
            except requests.RequestException:
                time.sleep(0.1)
        raise AssertionError((config / "log").read_text())

    def __exit__(self, *_):
        if self.running:
            self.running.terminate()  # stops every learner's server as well
            self.running.wait(60)
        for name in self.names:
            left = processes_of(name)
            for process in left:
                process.kill()
            psutil.wait_procs(left, 10)
            subprocess.run(["userdel", "--force", "--remove", name], stderr=subprocess.DEVNULL)

    def memory_mb(self):
        """What hub, proxy and all learners take, each page counted once (PSS), MB."""
        mine = psutil.Process(self.running.pid)
        everything = [mine, *mine.children(recursive=True), *(p for name in self.names for p in processes_of(name))]
        return sum(pss_mb(p) for p in {p.pid: p for p in everything}.values())


def processes_of(name):
    uid = pwd.getpwnam(name).pw_uid
    found = []
    for process in psutil.process_iter():
        try:
            if process.uids().real == uid:
                found.append(process)
        except psutil.Error:
            continue
    return found


def pss_mb(process):
    try:
        return process.memory_full_info().pss / 2**20
    except psutil.Error:
        return 0.0


class Learner:
    """One who is logged in through a browser's ways: cookies, the login form, the learner's server, a kernel."""

    def __init__(self, hub, name):
        self.hub, self.name, self.at_work = hub, name, threading.Lock()
        self.web = requests.Session()
        self.web.get(f"{hub.address}/hub/login")
        form = {"username": name, "password": PASSWORD, "_xsrf": self.web.cookies.get("_xsrf", path="/hub/")}
        said = self.web.post(f"{hub.address}/hub/login", data=form)
        said.raise_for_status()
        self.until_my_server_answers()

    def until_my_server_answers(self):
        for _ in range(600):
            said = self.web.get(f"{self.hub.address}/user/{self.name}/api/status", timeout=60)
            if said.status_code == 200:
                return
            self.web.get(f"{self.hub.address}/hub/spawn/{self.name}", timeout=60)
            time.sleep(0.2)
        raise AssertionError(f"{self.name}'s server does not answer: {said.status_code} {said.url}")

    def ask(self, path, whose=None, method="get", **more):
        """What a server says to a request with this learner's cookies."""
        address = f"{self.hub.address}/user/{whose or self.name}/{path}"
        xsrf = next((c.value for c in self.web.cookies if c.name == "_xsrf" and c.path == f"/user/{self.name}/"), "")
        return self.web.request(
            method, address, headers={"X-XSRFToken": xsrf}, allow_redirects=False, timeout=60, **more
        )

    def open_kernel(self):
        """Start a kernel as an open notebook does."""
        said = self.ask("api/kernels", method="post", json={"name": "python3", "path": "02_detection.ipynb"})
        assert said.status_code == 201, said.text
        self.kernel = said.json()["id"]
        cookies = "; ".join(f"{c.name}={c.value}" for c in self.web.cookies)
        address = f"ws{self.hub.address[4:]}/user/{self.name}/api/kernels/{self.kernel}/channels"
        self.line = websocket.create_connection(address, cookie=cookies, timeout=600, origin=self.hub.address)

    def run(self, code):
        """Run a cell; gives what it printed, and how long that took, s."""
        start, me, printed = time.perf_counter(), uuid.uuid4().hex, []
        header = {
            "msg_id": me,
            "msg_type": "execute_request",
            "username": self.name,
            "session": me,
            "version": "5.3",
            "date": "",
        }
        content = {
            "code": code,
            "silent": False,
            "store_history": True,
            "user_expressions": {},
            "allow_stdin": False,
            "stop_on_error": True,
        }
        self.line.send(
            json.dumps({"header": header, "parent_header": {}, "metadata": {}, "content": content, "channel": "shell"})
        )
        while True:
            said = self.line.recv()
            if isinstance(said, bytes):  # a widget's picture
                continue
            said = json.loads(said)
            if said["parent_header"].get("msg_id") != me:
                continue
            if said["msg_type"] == "stream":
                printed.append(said["content"]["text"])
            if said["msg_type"] == "error":
                printed.append(f"{said['content']['ename']}: {said['content']['evalue']}")
            if said["msg_type"] == "status" and said["content"]["execution_state"] == "idle":
                return "".join(printed), time.perf_counter() - start


def cells(lesson, last):
    """The code cells of a lesson up to the one that has `last` in it."""
    (path,) = (ROOT / "notebooks").glob(f"{lesson}_*.ipynb")
    code = [cell.source for cell in nbformat.read(path, 4).cells if cell.cell_type == "code"]
    return code[: next(k for k, source in enumerate(code) if last in source) + 1]


def log_in(hub):
    """All learners at once."""
    with ThreadPoolExecutor(len(hub.names)) as pool:
        return list(pool.map(lambda name: Learner(hub, name), hub.names))


def measure(learners, busy, whole, folder):
    """A class in lesson 02: all have begun it; `busy` at a time work through its first sitting, the others run a light cell in turn."""
    work = cells("02", "closing_table" if whole else "truth[0] is None")
    begun = cells("02", "q2.check")
    with Hub(learners, folder) as hub:
        start = time.perf_counter()
        class_ = log_in(hub)
        logged_in_s = time.perf_counter() - start
        with ThreadPoolExecutor(learners) as pool:
            list(pool.map(Learner.open_kernel, class_))
        with ThreadPoolExecutor(busy) as pool:
            list(pool.map(lambda learner: [learner.run(cell) for cell in begun], class_))
        begun_mb, each_mb = hub.memory_mb(), statistics.mean(sum(map(pss_mb, processes_of(name))) for name in hub.names)
        others, waits, used_mb = itertools.cycle(class_), [], []

        def works(learner):
            with learner.at_work:
                said = "".join(learner.run(cell)[0] for cell in work)
            return "Error" not in said and "frames: paper's method" in said

        with ThreadPoolExecutor(busy) as pool:
            turns = [pool.submit(works, learner) for learner in class_]
            while not all(turn.done() for turn in turns):
                learner = next(others)
                if learner.at_work.acquire(blocking=False):
                    waits.append(learner.run(LIGHT)[1])
                    learner.at_work.release()
                used_mb.append(hub.memory_mb())
                time.sleep(1)
        return {
            "learners": learners, "busy at a time": busy, "all logged in after, s": round(logged_in_s, 1),
            "came to the end": sum(turn.result() for turn in turns),
            "memory, all have begun, MB": round(begun_mb), "  for each learner, MB": round(each_mb),
            "peak memory, MB": round(max(used_mb)), "light cells": len(waits),
            "their median wait, s": round(statistics.median(waits), 2), "longest, s": round(max(waits), 2),
        }  # fmt: skip


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--learners", type=int, default=30)
    parser.add_argument("--busy", type=int, default=3)
    parser.add_argument("--whole", action="store_true", help="the whole lesson, and not its first sitting alone")
    options = parser.parse_args()
    if told := missing():
        sys.exit(told)
    with tempfile.TemporaryDirectory() as folder:
        for what, value in measure(options.learners, options.busy, options.whole, folder).items():
            print(f"{what:32s} {value}")
