"""Make the kit's own environment, then run it.

python3 lab.py              opens the course in JupyterLab, in a folder of your own (work)
python3 lab.py --name ada   the same in ada's own folder (work-ada)
python3 lab.py test         runs the tests
python3 lab.py ANYTHING     runs `stereo-lab ANYTHING`
python3 lab.py --offline FOLDER [ANYTHING]   sets up from a folder that `stereo-lab wheels` made, without a network

Standard library only. The environment lies in .venv beside this file and is made from
environment.txt; while that is up to date, nothing is touched.
"""

import hashlib
import json
import os
import platform
import shutil
import signal
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
VENV = os.path.join(HERE, ".venv")
BIN = os.path.join(VENV, "Scripts" if os.name == "nt" else "bin")
PYTHON = os.path.join(BIN, "python.exe" if os.name == "nt" else "python")
STAMP = os.path.join(VENV, "stereo_lab.stamp")
OLDEST = (3, 10)
SPACE_MB = 900
EXTRAS = os.environ.get("STEREO_LAB_EXTRAS", "")  # such as "browser,oracle": what some tests need as well
ME = "py lab.py" if os.name == "nt" else "python3 lab.py"


class SetupError(Exception):
    """Something that the person at the keyboard can put right."""


def say(text):
    sys.stderr.write(str(text) + "\n")


def main(arguments):
    try:
        check_python()
        offline, arguments = parted(arguments)
        if not up_to_date():
            make_environment(offline)
    except SetupError as error:
        say(error)
        return 2
    except KeyboardInterrupt:
        say("\nStopped. Run it again to go on: " + ME)
        return 130
    return run(arguments)


def check_python():
    if sys.version_info[:2] < OLDEST:
        found = ".".join(str(n) for n in sys.version_info[:2])
        raise SetupError(
            "This kit needs Python 3.10 or newer; this is Python " + found + ". "
            "Install a newer one, then run it with that: "
            + ("py -3.12 lab.py" if os.name == "nt" else "python3.12 lab.py")
        )


def parted(arguments):
    """The folder after --offline, or None, and what is left of the arguments."""
    if arguments[:1] != ["--offline"]:
        return None, arguments
    if len(arguments) < 2:
        raise SetupError("After --offline the folder is expected that `stereo-lab wheels` made.")
    folder = os.path.abspath(arguments[1])
    check_wheels(folder)
    return folder, arguments[2:]


def check_wheels(folder):
    """Refuse a folder that was made for other computers, or copied in part."""
    try:
        with open(os.path.join(folder, "wheels.json"), encoding="utf-8") as file:
            made = json.load(file)
        made_for, files = [tuple(pair) for pair in made["made_for"]], dict(made["files"])
    except (OSError, ValueError, KeyError, TypeError):
        raise SetupError("Expected a folder that `stereo-lab wheels` made, got " + folder + ".") from None
    here = (system(), "%d.%d" % sys.version_info[:2])
    if here not in made_for:
        told = ", ".join("Python " + python + " on " + name for name, python in made_for)
        raise SetupError(
            "%s was made for %s; this is Python %s on %s. Where there is a network: %s wheels %s --system %s --python %s"
            % (folder, told, here[1], here[0], ME, folder, here[0], here[1])
        )
    for name, size in sorted(files.items()):
        path = os.path.join(folder, os.path.basename(name))
        if not os.path.isfile(path) or os.path.getsize(path) != size:
            raise SetupError("%s is not there whole: %s is missing or cut off. Copy the folder again." % (folder, name))


def system():
    """What `stereo-lab wheels` calls this system; stereo_lab/seats/wheels.py has the same rule."""
    arm = platform.machine().lower() in ("arm64", "aarch64")
    if sys.platform == "darwin":
        return "macos" if arm else "macos-intel"
    return "windows" if sys.platform == "win32" else "linux-arm" if arm else "linux"


def wanted():
    """What the environment is made from, as one line: a changed line makes it out of date."""
    digest = hashlib.sha256(repr((sys.version_info[:2], HERE, EXTRAS)).encode("utf-8"))
    for name in ("environment.txt", "pyproject.toml"):
        with open(os.path.join(HERE, name), "rb") as file:
            digest.update(file.read().replace(b"\r\n", b"\n"))
    return digest.hexdigest()


def up_to_date():
    try:
        with open(STAMP, encoding="utf-8") as file:
            return file.read() == wanted() and os.path.exists(PYTHON)
    except OSError:
        return False


def make_environment(offline=None):
    """Make .venv anew, from a folder where one is named. The stamp is written last, so a half-made environment is made again."""
    say("Setting up the kit (once; about a minute, 600 MB) ...")
    try:
        free_mb = shutil.disk_usage(HERE).free // 2**20
        if free_mb < SPACE_MB:
            raise SetupError(
                "The disk has %d MB left; the kit needs %d MB. Free some space, then: %s" % (free_mb, SPACE_MB, ME)
            )
        if os.path.isdir(VENV):
            shutil.rmtree(VENV)
        uv = shutil.which("uv")
        if uv:
            step([uv, "venv", "--quiet", "--python", sys.executable, VENV], "make .venv")
            install = [uv, "pip", "install", "--quiet", "--python", PYTHON]
        else:
            import venv

            venv.EnvBuilder(with_pip=True).create(VENV)
            install = [PYTHON, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
        if offline:
            install += ["--no-index", "--find-links", offline]
        step(install + ["-r", os.path.join(HERE, "environment.txt")], "install the packages")
        step(install + ["--no-deps", "--no-build-isolation", "-e", HERE], "install the kit")
        if EXTRAS:
            extras = HERE + "[" + EXTRAS + "]"
            step(install + ["--no-build-isolation", "-e", extras], "install the extras " + EXTRAS)
        quiet()
        with open(STAMP, "w", encoding="utf-8") as file:
            file.write(wanted())
    except OSError as error:
        raise SetupError(
            "Cannot make %s: %s. Check the folder's permissions and the disk, then: %s"
            % (VENV, error.strerror or error, ME)
        ) from None
    except subprocess.CalledProcessError as error:
        raise SetupError(
            "Cannot make %s: %s. On Debian and Ubuntu: sudo apt install python3-venv. Then: %s" % (VENV, error, ME)
        ) from None


def quiet():
    """JupyterLab asks everybody whether to fetch news: here it does not, and fetches none."""
    folder = os.path.join(VENV, "share", "jupyter", "lab", "settings")
    os.makedirs(folder, exist_ok=True)
    answers = {"@jupyterlab/apputils-extension:notification": {"fetchNews": "false", "checkForUpdates": False}}
    with open(os.path.join(folder, "overrides.json"), "w", encoding="utf-8") as file:
        json.dump(answers, file)


def step(command, what):
    """Run one command of the set-up; a failure becomes one sentence with the last lines of its output."""
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, cwd=HERE)
    if done.returncode == 0:
        return
    output = done.stdout.decode("utf-8", "replace")
    last = "\n    ".join(output.strip().splitlines()[-4:])
    low = output.lower()
    if "no space left" in low:
        why = "the disk is full"
    elif "no matching distribution" in low or "no solution found" in low:
        why = "a package was not found: is this computer online, and this Python not newer than the kit knows?"
    elif any(sign in low for sign in ("connection", "resolve", "network", "timed out", "dns", "unreachable")):
        why = "the packages could not be fetched: is this computer online, and may it download?"
    else:
        why = "a step failed"
    raise SetupError("Could not %s: %s\n    %s\nThen run it again: %s" % (what, why, last, ME))


def run(arguments):
    """Run `stereo-lab`, or open the course. Returns its exit code."""
    opens = arguments[:1] in ([], ["--name"])
    command = [PYTHON, "-m", "stereo_lab"] + (["start"] if opens else []) + arguments
    # The environment's own tools come first on the path, as in an activated environment.
    environment = dict(os.environ, PATH=BIN + os.pathsep + os.environ.get("PATH", ""), VIRTUAL_ENV=VENV)
    environment["STEREO_LAB_COMMAND"] = ME
    # The kit's matrices are small: several threads would spend their time waiting for each other.
    environment.setdefault("OPENBLAS_NUM_THREADS", "1")
    child = subprocess.Popen(command, env=environment)
    # Whoever ends this ends what it runs: that may hold an arm, or be JupyterLab.
    signal.signal(signal.SIGTERM, lambda *_: child.terminate())
    while True:
        try:
            return child.wait()
        except KeyboardInterrupt:
            continue  # it got the same Ctrl-C, and ends in its own way


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
