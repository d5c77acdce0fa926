"""The notebooks run, and show what they show in the pages."""

from pathlib import Path

import nbclient
import nbformat
import pytest

NOTEBOOKS = sorted((Path(__file__).parents[2] / "docs" / "notebooks").glob("*.ipynb"))


def printed(notebook):
    """The text that each cell prints; pictures are left out."""
    return [
        "".join(output["text"] for output in cell.get("outputs", [])
                if output.get("name") == "stdout")
        for cell in notebook.cells
    ]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_the_notebook_runs(path):
    shown = nbformat.read(path, 4)
    run = nbformat.read(path, 4)
    nbclient.NotebookClient(run, timeout=300, kernel_name="python3").execute()
    assert printed(run) == printed(shown)
