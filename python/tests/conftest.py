"""Fixtures: files that the program writes."""

import os
import subprocess
from pathlib import Path

import pytest

BUILD = Path(os.environ.get("T4D_BUILD", Path(__file__).parents[2] / "build" / "release"))


@pytest.fixture(scope="session")
def models(tmp_path_factory):
    """A folder with the fixtures, and cube.t4d, screw.t4d (swept) of them."""
    folder = tmp_path_factory.mktemp("models")
    subprocess.run([BUILD / "t4d-fixtures", folder], check=True, stdout=subprocess.DEVNULL)
    for motion, name in [("paper-translation", "cube"), ("paper-screw", "screw")]:
        subprocess.run(
            [BUILD / "t4d", "sweep", folder / "paper-cube.obj", "--motion",
             folder / f"{motion}.json", "-o", folder / f"{name}.t4d", "-q"],
            check=True,
        )  # fmt: skip
    return folder


@pytest.fixture(scope="session")
def program():
    return BUILD / "t4d"


@pytest.fixture
def cube():
    """A unit cube, its triangles counter-clockwise seen from outside."""
    import numpy as np

    vertices = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    return vertices, np.array(triangles)
