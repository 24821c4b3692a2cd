"""What pyproject.toml cannot say: a wheel takes the lessons and the recordings along, as ``stereo_lab/course``."""

import shutil
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

HERE = Path(__file__).resolve().parent


def course():
    """The files that go along, relative to the repository: lessons, teacher's pages, recordings, exact versions."""
    lessons = [
        path
        for path in HERE.glob("notebooks/**/*")
        if not any(part.startswith(".") for part in path.relative_to(HERE).parts)
    ]
    recordings = [path for told in HERE.glob("data/*/recording.json") for path in told.parent.rglob("*")]
    rows = HERE.glob("data/train/rows/*.csv")  # lesson 09 learns from them
    files = [*lessons, *recordings, *rows, HERE / "data" / "README.md", HERE / "environment.txt"]
    return sorted(path.relative_to(HERE) for path in files if path.is_file())


class WithCourse(build_py):
    """Copies the course beside the modules; an editable install finds it where it is."""

    def run(self):
        built = Path(self.build_lib) / "stereo_lab"
        if not self.editable_mode:
            shutil.rmtree(built, ignore_errors=True)  # what an older build left is in no wheel
        super().run()
        if self.editable_mode:
            return
        for name in course():
            target = built / "course" / name
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(HERE / name, target)


setup(cmdclass={"build_py": WithCourse})
