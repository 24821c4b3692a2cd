"""The tests, the notebooks and the demo's figures on other processors, simulated: their libraries take other code paths.

OPENBLAS_CORETYPE chooses the kernels of numpy's linear algebra, OPENCV_CPU_DISABLE and NPY_DISABLE_CPU_FEATURES
switch instructions off. Every run has a home of its own, and one or two threads.
"""

import json
import os
import platform
import subprocess
import sys

import pytest

from conftest import ROOT, skip_unless_ci

pytestmark = pytest.mark.slow

NEW, MIDDLE, OLD = "AVX512-SKX", "AVX2,FP16,AVX", "SSE4.2,SSE4.1"
# numpy's names of them, of all its versions: those that it does not know it passes over
NUMPY_NEW = "AVX512F AVX512CD AVX512_SKX AVX512_CLX AVX512_CNL AVX512_ICL AVX512_SPR X86_V4"
NUMPY_MIDDLE = "AVX2 FMA3 X86_V3"
COMPUTE_NOTHING = (  # files, pages, other programs and people: alike on every processor
    "accessibility", "class_of_thirty", "classroom", "guide", "handing_in", "handouts", "installed", "instructor", "lab",
    "language", "moving", "privacy", "ready", "school", "seats", "server", "wheels",
)  # fmt: skip
TAKE_LONG = (  # 20 seconds and more each, together eight minutes: asked on the oldest alone, which differs most from a new one
    "arm", "charuco", "conformance", "doctor", "films", "recorder", "replay", "run",
)  # fmt: skip
OLDEST = "2008, one thread"
PROCESSORS = {
    OLDEST: ("Nehalem", f"{NEW},{MIDDLE},{OLD}", f"{NUMPY_NEW} {NUMPY_MIDDLE}", 1),
    "2011, two threads": ("Sandybridge", f"{NEW},AVX2,FP16", f"{NUMPY_NEW} {NUMPY_MIDDLE}", 2),
    "2013, two threads": ("Haswell", NEW, NUMPY_NEW, 2),
    "2017, one thread": ("SkylakeX", "", "", 1),
}


def environment(name, home):
    core, opencv, numpy, threads = PROCESSORS[name]
    return {
        **os.environ,
        "OPENBLAS_CORETYPE": core,
        "OPENCV_CPU_DISABLE": opencv,
        "NPY_DISABLE_CPU_FEATURES": numpy,
        "OPENBLAS_NUM_THREADS": str(threads),
        "OPENCV_FOR_THREADS_NUM": str(threads),
        "STEREO_LAB_HOME": str(home),
        "PYTHONWARNINGS": "ignore",  # numpy says which features this computer lacks anyway
    }


@pytest.fixture(autouse=True)
def x86():
    if platform.machine().lower() not in ("x86_64", "amd64"):
        skip_unless_ci("only an x86-64 processor can pretend to be an older one")


@pytest.fixture(scope="module")
def figures_here(tmp_path_factory):
    return figures(os.environ, tmp_path_factory.mktemp("here"))


def figures(environ, folder):
    command = [
        sys.executable,
        "-m",
        "stereo_lab",
        "demo",
        "bench",
        "--json",
        folder / "d.json",
        "--report",
        folder / "d.html",
    ]
    done = subprocess.run(list(map(str, command)), cwd=ROOT, env=dict(environ), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads((folder / "d.json").read_text())


@pytest.mark.parametrize("name", PROCESSORS)
@pytest.mark.parametrize("what", ["package", "notebooks"])
def test_the_readmes_command(name, what, tmp_path):
    left_out = COMPUTE_NOTHING if name == OLDEST else COMPUTE_NOTHING + TAKE_LONG
    computing = ["tests", "-m", "not slow", *(f"--ignore=tests/test_{file}.py" for file in left_out)]
    tests = computing if what == "package" else ["--nbval", "--nbval-cell-timeout=300", "notebooks"]
    command = [sys.executable, "-m", "pytest", "-q", *tests]
    done = subprocess.run(command, cwd=ROOT, env=environment(name, tmp_path), capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-8000:]


def test_what_is_left_out_is_there():
    assert all((ROOT / "tests" / f"test_{name}.py").is_file() for name in COMPUTE_NOTHING + TAKE_LONG)


@pytest.mark.parametrize("name", PROCESSORS)
def test_figures_of_the_demo(name, figures_here, tmp_path):
    there = figures(environment(name, tmp_path), tmp_path)
    for key in ("detection", "clutter"):
        for method, counts in figures_here[key].items():
            for what, count in counts.items():
                assert abs(there[key][method][what] - count) <= 0.02 * count, (key, method, what)
    for method, kinds in figures_here["evaluation"].items():
        for use in ("volume", "plane"):
            for axis, figure in kinds[use].items():
                if axis != "missed":
                    assert there["evaluation"][method][use][axis]["mean"] == pytest.approx(
                        figure["mean"], rel=0.05, abs=0.05
                    )
    assert there["calibration"] == figures_here["calibration"]
