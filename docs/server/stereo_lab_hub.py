"""JupyterHub's settings for the course: README.md beside this file says where it goes."""

import os

KIT = os.environ.get("STEREO_LAB_KIT", "/srv/stereo_lab")  # the kit, installed once; learners read it

c = get_config()  # noqa: F821 - JupyterHub gives it to the files that it reads
c.Spawner.cmd = [f"{KIT}/.venv/bin/python", f"{KIT}/docs/server/start_learner.py"]
c.Spawner.default_url = "/lab/tree/00_start_here.ipynb"
c.Spawner.environment = {
    "OPENBLAS_NUM_THREADS": "1",  # thirty learners share the cores; more threads would only wait for each other
    "MALLOC_ARENA_MAX": "1",  # freed memory goes back to the system at once
    "MALLOC_TRIM_THRESHOLD_": "65536",
    "MALLOC_MMAP_THRESHOLD_": "65536",
}
c.Spawner.mem_limit = "1G"  # held by spawners that can (The Littlest JupyterHub's can), so that one learner stops alone
c.Spawner.start_timeout = 120  # seconds: thirty log in within a minute, on two cores
c.Spawner.http_timeout = 120
