"""What JupyterHub starts for each learner, as that learner: their work folder is laid out, then their server takes over.

It runs with the learner's own rights: nothing is written into a home by anybody else.
"""

import os
import sys
from pathlib import Path

os.umask(0o077)  # what a learner writes, nobody else reads; the kit takes it over when it is imported

from stereo_lab.errors import StereoLabError  # noqa: E402
from stereo_lab.recording.places import PACKAGE, course  # noqa: E402
from stereo_lab.work import SEAT, lay_out, seat_of  # noqa: E402

PAGE = PACKAGE / "widgets" / "page"  # tells screen readers what pictures and sliders are
# what a teacher may have installed beside the kit, and help for those who write programs: 36 MB in each server
LEFT_OUT = [
    f"nbgrader.server_extensions.{part}"
    for part in ("formgrader", "validate_assignment", "assignment_list", "course_list")
]
LEFT_OUT += ["notebook", "jupyter_lsp"]
# jsonschema looks for this package, and does without: 15 MB in each server. JupyterHub's own log brings the hub's pages along: 8 MB
SERVER = """import sys, jupyter_server.log
sys.modules["rfc3987_syntax"] = None
sys.modules["jupyterhub.log"] = jupyter_server.log
from jupyterhub.singleuser import main
sys.exit(main())"""


def main():
    """Make ~/work where it is missing, close it to all others, and become the learner's server."""
    home = Path.home()
    if home.stat().st_uid == os.getuid():  # a volume's root may be another's
        home.chmod(0o700)
    folder = home / "work"
    folder.mkdir(exist_ok=True)
    try:
        lay_out(course() / "notebooks", folder)
    except StereoLabError as error:  # on a full disk a learner must get in, to make room
        print(error, file=sys.stderr)
    os.chdir(folder)
    os.environ["STEREO_LAB_WORK"] = str(folder)
    if seat_of(folder) is not None:  # its numbers stand in the lessons
        os.environ.setdefault("STEREO_LAB_RECORDING", str(folder / SEAT))
    # `stereo-lab` in a terminal, or behind ! in a cell
    os.environ["PATH"] = f"{Path(sys.executable).parent}{os.pathsep}{os.environ.get('PATH', os.defpath)}"
    os.environ["JUPYTER_RUNTIME_DIR"] = str(home / ".kernels")  # a socket's path may have 107 bytes
    options = [
        f"--ServerApp.root_dir={folder}",
        f"--ServerApp.jpserver_extensions={dict.fromkeys(LEFT_OUT, False)}",
        "--ServerApp.terminado_settings={'shell_command': ['bash']}",  # a login shell would begin with another PATH
        "--KernelManager.transport=ipc",  # files of the learner's, and no ports that all of the computer can listen to
        f"--LabApp.extra_labextensions_path={PAGE}",
        "--LabApp.news_url=None",
        "--LabApp.check_for_updates_class=jupyterlab.NeverCheckForUpdate",
    ]
    os.execv(sys.executable, [sys.executable, "-c", SERVER, *sys.argv[1:], *options])


if __name__ == "__main__":
    main()
