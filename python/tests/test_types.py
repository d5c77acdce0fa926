"""The annotations are true, and the stubs name all that the compiled part has."""

import subprocess
import sys
from pathlib import Path

import t4d
from t4d import _t4d

PACKAGE = Path(t4d.__file__).parent


def test_mypy_finds_nothing(tmp_path):
    run = subprocess.run(
        [sys.executable, "-m", "mypy", "--disallow-untyped-defs", "--cache-dir", tmp_path, "-p", "t4d"],
        cwd=PACKAGE.parent,
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stdout


def test_stubs_are_complete():
    stubs = (PACKAGE / "_t4d.pyi").read_text()
    for name in dir(_t4d):
        if name.startswith("__") or name == "Slabs":
            continue
        assert f"def {name}(" in stubs or f"class {name}:" in stubs or f"{name}:" in stubs, name
        for member in vars(getattr(_t4d, name)) if isinstance(getattr(_t4d, name), type) else ():
            assert member.startswith("__") or f"def {member}(" in stubs, f"{name}.{member}"
