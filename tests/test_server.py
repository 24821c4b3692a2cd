"""One server for a class, with the files of docs/server: a real JupyterHub, real Unix users, a learner each."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from conftest import ROOT, skip_unless_ci

SERVER = ROOT / "docs" / "server"


def may_run():
    """Whether this computer can: only root makes users, and they must be able to read the kit."""
    if os.name != "posix" or os.geteuid():
        pytest.skip("only root can make a user for each learner")
    from tests.hub import missing

    if told := missing():
        skip_unless_ci(told)
    import pwd

    nobody = pwd.getpwnam("nobody")
    reads = subprocess.run([ROOT / ".venv/bin/python", "-c", "import stereo_lab.work"], user=nobody.pw_uid, group=nobody.pw_gid, cwd="/", capture_output=True)  # fmt: skip
    if reads.returncode:
        pytest.skip(f"other users cannot read the kit in {ROOT}")


@pytest.fixture(scope="module")
def class_():
    """Three learners who logged in at once, with a kernel each."""
    may_run()
    from tests.hub import Hub, log_in

    folder = Path(f"/tmp/stereo_lab_hub_{os.getpid()}")  # a home must lie where everybody may pass
    folder.mkdir()
    try:
        with Hub(3, folder) as hub:
            learners = log_in(hub)
            for learner in learners:
                learner.open_kernel()
            yield learners
    finally:
        subprocess.run(["rm", "-rf", folder], check=True)


@pytest.mark.slow
def test_they_begin_lesson_02_as_somebody_alone_would(class_):
    from tests.hub import cells

    for learner in class_:
        said = "".join(learner.run(cell)[0] for cell in cells("02", "q3.check"))
        assert "rendered recording" in said and said.count("NOT ATTEMPTED") == 3 and "Error" not in said
        assert "PASS" in learner.run("q1.check(200)")[0]
        assert learner.run("import os; print(os.getcwd(), os.environ['STEREO_LAB_WORK'])")[0].split() == 2 * [
            f"{learner.hub.folder}/{learner.name}/work"
        ]
    for learner in class_:  # each has an own count, in an own folder
        home = learner.hub.folder / learner.name
        assert (home / "work/02_detection.ipynb").owner() == learner.name
        assert "02" in (home / "work/progress.json").read_text()


@pytest.mark.slow
def test_the_kits_commands_are_there(class_):
    said = class_[0].run("!stereo-lab progress")[0]
    assert "lesson 02" in said and "lesson 09" in said
    assert class_[0].ask("api/terminals", method="post", json={}).status_code == 200
    (shell,) = (p for p in server_of(class_[0]).children(recursive=True) if p.name() == "bash")
    assert "-l" not in shell.cmdline() and str(ROOT / ".venv/bin") in shell.environ()["PATH"]


@pytest.mark.skipif(os.name == "nt", reason="a hub runs on Linux")
@pytest.mark.parametrize("seat", [None, 17])
def test_a_learner_starts_with_the_kits_commands_and_with_the_seats_recording(tmp_path, seat):
    if seat is not None:
        (tmp_path / "work" / "seat").mkdir(parents=True)
        (tmp_path / "work" / "seat" / "recording.json").write_text(f'{{"seat": {seat}}}')
    code = "import os, runpy, sys; os.execv = lambda *_: print(os.environ['PATH'], os.environ.get('STEREO_LAB_RECORDING'))\n"
    code += f"runpy.run_path({str(SERVER / 'start_learner.py')!r}, run_name='__main__')"
    environment = {k: v for k, v in os.environ.items() if not k.startswith("STEREO_LAB_")}
    environment |= {"HOME": str(tmp_path), "PYTHONPATH": str(ROOT), "PATH": "/usr/bin"}
    said = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True).stdout.split()
    assert said == [f"{Path(sys.executable).parent}:/usr/bin", str(tmp_path / "work" / "seat") if seat else "None"]


@pytest.mark.slow
def test_a_page_of_the_server_tells_what_its_pictures_are(class_):
    """As the pages that `start` opens do: by the kit's own extension of JupyterLab."""
    page = class_[0].ask("lab").text
    assert "stereo_lab_page" in page and "remoteEntry" in page


@pytest.mark.slow
def test_nobody_gets_at_another_ones_files_from_a_kernel(class_):
    one, other, _ = class_
    theirs = f"{one.hub.folder}/{other.name}"
    for attempt in (
        f"print(open('{theirs}/work/02_detection.ipynb').read()[:9])", f"import os; print(os.listdir('{theirs}'))",
        f"print(open('{theirs}/work/mine.txt', 'w'))", f"import glob, os; print(os.listdir('{theirs}/.kernels'))",
        f"import os, pwd; os.kill({server_of(other).pid}, 15)", f"print(open('/proc/{server_of(other).pid}/environ').read())",
        f"print(open('{one.hub.folder}/hub/jupyterhub.sqlite', 'rb').read(9))",
    ):  # fmt: skip
        said = one.run(attempt)[0]
        assert said.startswith("PermissionError"), (attempt, said)
    for shared in (
        f"{ROOT}/data/bench/recording.json",
        f"{ROOT}/stereo_lab/work.py",
        f"{ROOT}/notebooks/02_detection.ipynb",
    ):
        assert one.run(f"print(len(open('{shared}').read()) > 100)")[0] == "True\n"
        assert one.run(f"open('{shared}', 'a')")[0].startswith("PermissionError")
    assert other.run("print('still there')")[0] == "still there\n"


@pytest.mark.slow
def test_nobody_gets_at_another_ones_files_over_http(class_):
    one, other, _ = class_
    assert one.ask("api/contents/02_detection.ipynb").status_code == 200
    for path in ("api/contents", "api/contents/02_detection.ipynb", "files/02_detection.ipynb", "lab", "api/kernels"):
        assert one.ask(path, whose=other.name).status_code in (302, 403, 404), path
    assert one.ask("api/kernels", whose=other.name, method="post", json={}).status_code == 403
    written = {"type": "file", "format": "text", "content": "mine"}
    assert one.ask("api/contents/mine.txt", whose=other.name, method="put", json=written).status_code == 403
    assert (
        one.ask("api/contents/mine.txt", method="put", json=written).status_code == 201
    )  # the same on one's own is no trouble
    behind = next(c.laddr.port for c in server_of(other).net_connections() if c.status == "LISTEN")  # past the proxy
    said = one.web.get(f"http://127.0.0.1:{behind}/user/{other.name}/api/contents", allow_redirects=False, timeout=30)
    assert said.status_code in (302, 403)
    for path in ("../../" + other.name, "%2e%2e/%2e%2e/" + other.name, "..%2f..%2f" + other.name):
        assert one.ask(f"api/contents/{path}").status_code != 200


@pytest.mark.slow
def test_a_kernel_is_no_port_that_everybody_can_listen_to(class_):
    from tests.hub import processes_of

    for learner in class_:
        folder = learner.hub.folder / learner.name / ".kernels"
        assert (
            folder.stat().st_mode & 0o077 == 0 or learner.hub.folder.joinpath(learner.name).stat().st_mode & 0o077 == 0
        )
        assert (
            len([path for path in folder.iterdir() if path.is_socket()]) >= 5
        )  # shell, iopub, stdin, control, heartbeat
        ports = [c for p in processes_of(learner.name) for c in p.net_connections() if c.status == "LISTEN"]
        assert {c.laddr.ip for c in ports} == {"127.0.0.1"}


def server_of(learner):
    from tests.hub import processes_of

    return next(p for p in processes_of(learner.name) if "jupyterhub.singleuser" in " ".join(p.cmdline()))


@pytest.mark.slow
def test_what_a_learner_takes_is_what_the_page_says(class_):
    """The page's number is that of thirty, who share pages; a kernel with a picture more or less moves it."""
    from tests.hub import processes_of, pss_mb

    told = float(re.search(r"(\d+) MB for each learner", (SERVER / "README.md").read_text(encoding="utf-8")).group(1))
    taken = [sum(map(pss_mb, processes_of(learner.name))) for learner in class_]
    assert all(0.6 * told < mb < 1.5 * told for mb in taken), taken


def test_every_link_of_the_page_leads_somewhere():
    for link in re.findall(r"\]\(([^)#]+)\)", (SERVER / "README.md").read_text(encoding="utf-8")):
        assert link.startswith("http") or (SERVER / link).exists(), link


def test_the_values_for_kubernetes_are_yaml_that_start_what_the_image_has():
    values = yaml.safe_load((SERVER / "values.yaml").read_text(encoding="utf-8"))
    image = (SERVER / "Dockerfile").read_text(encoding="utf-8")
    assert values["singleuser"]["memory"] == {"guarantee": "300M", "limit": "1G"}
    for word in values["singleuser"]["cmd"]:
        assert word.startswith("/srv/stereo_lab/") and "WORKDIR /srv/stereo_lab" in image
        assert word.endswith("/.venv/bin/python") or (ROOT / word.removeprefix("/srv/stereo_lab/")).is_file()
    assert "NOT RUN" in image.upper() and "not run" in (SERVER / "values.yaml").read_text(encoding="utf-8")
