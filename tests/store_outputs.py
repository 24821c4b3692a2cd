"""Run notebooks from top to bottom and store their outputs: python tests/store_outputs.py [notebooks/04_depth.ipynb ...]

Whoever changes a lesson, or a number that it prints, runs this and reads the difference before committing it.
"""

import os
import sys
import tempfile
from pathlib import Path

import nbformat
from nbclient import NotebookClient

NOTEBOOKS = Path(__file__).resolve().parent.parent / "notebooks"


def store_outputs(path):
    """Execute one notebook on the shipped bench and write it back, without times or other noise."""
    notebook = nbformat.read(path, 4)
    metadata = notebook.metadata.copy()
    where = {"metadata": {"path": str(path.parent)}}
    quiet = {"record_timing": False, "store_widget_state": False, "coalesce_streams": True}
    NotebookClient(notebook, timeout=240, kernel_name="python3", resources=where, **quiet).execute()
    notebook.metadata = metadata
    for cell in notebook.cells:
        for output in cell.get("outputs", ()):  # a stored panel has no kernel behind it: its name is shown instead
            output.get("data", {}).pop("application/vnd.jupyter.widget-view+json", None)
    nbformat.write(notebook, path)


if __name__ == "__main__":
    for name in ("STEREO_LAB_RECORDING", "MPLBACKEND"):  # another backend shows no figure
        os.environ.pop(name, None)
    with tempfile.TemporaryDirectory() as home:
        os.environ["STEREO_LAB_HOME"] = home
        for name in sys.argv[1:] or sorted(map(str, NOTEBOOKS.glob("*.ipynb"))):
            print(name, flush=True)
            store_outputs(Path(name).resolve())
