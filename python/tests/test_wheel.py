"""The wheel holds the module and the program."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

from conftest import BUILD

def test_the_wheel_works_by_itself(tmp_path):
    folders = ["egg_info", "--egg-base", tmp_path, "build", "--build-base", tmp_path / "build"]
    wheel = ["bdist_wheel", "--bdist-dir", tmp_path / "wheel", "--dist-dir", tmp_path / "dist"]
    subprocess.run(
        [sys.executable, "setup.py", "-q", *folders, *wheel],
        cwd=Path(__file__).parents[1],
        env={**os.environ, "T4D_BUILD": str(BUILD)},
        check=True,
        capture_output=True,
    )
    (wheel,) = (tmp_path / "dist").glob("t4d-*.whl")
    assert "none-any" not in wheel.name
    with zipfile.ZipFile(wheel) as packed:
        assert any(name.endswith(".data/data/share/t4d/paraview/t4d_reader.py") for name in packed.namelist())
    folder = tmp_path / "site"
    zipfile.ZipFile(wheel).extractall(folder)
    (info,) = folder.glob("*.dist-info")
    metadata = (info / "METADATA").read_text()
    assert "\nLicense: Apache-2.0; with TetGen" in metadata
    for name in ("LICENSE", "NOTICE"):
        assert f"\nLicense-File: {name}\n" in metadata
        (packed,) = info.rglob(name)
        assert packed.read_bytes() == (Path(__file__).parents[2] / name).read_bytes()
    (folder / "t4d" / "bin" / "t4d").chmod(0o755)
    env = {name: value for name, value in os.environ.items() if not name.startswith("T4D")}
    script = (
        "import numpy as np, t4d; from t4d import verbs\n"
        "V = np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0], [0, 0, 9]])\n"
        "solid = t4d.TriangleMesh(V, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])\n"
        "motion = t4d.Motion({'segments': [{'duration': 1, 'translation': [1, 0, 0]}]})\n"
        "swept = t4d.sweep(solid, motion=motion)\n"
        "verbs.rasterize(swept, voxel_size=1, n=2, output='frames')\n"  # with OpenVDB
        "print(verbs.program()); print(verbs.version()['version'])"
    )
    run = subprocess.run(
        [sys.executable, "-c", script],
        cwd=tmp_path,
        env={**env, "PYTHONPATH": str(folder)},
        check=True,
        capture_output=True,
        text=True,
    )
    program, version = run.stdout.split()
    assert program == str(folder / "t4d" / "bin" / "t4d")
    assert version.split()[-1] == wheel.name.split("-")[1]
