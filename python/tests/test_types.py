"""The annotations are true, and fit what the page shows; the stubs are those of the compiled part."""

import doctest
import os
import subprocess
import sys
from pathlib import Path

import t4d

PACKAGE = Path(t4d.__file__).parent
PAGE = Path(__file__).parents[2] / "docs" / "python.md"

CALLS = """
from pathlib import Path

import numpy as np
import t4d
from t4d import verbs

times = np.linspace(0, 1, 3)
frames = np.ones((3, 4, 4, 4), dtype=np.float16)
woven: t4d.Mesh = t4d.weave(frames, times=times, spacing=np.ones(3), origin=np.zeros(3))
woven = t4d.weave(list(frames), times=range(3), spacing=np.float32(1), iso=np.float32(0.5))
V, F = np.zeros((3, 8, 3)), np.zeros((12, 3), dtype=np.uint32)
swept = t4d.sweep(V, F, times=times, prism=np.int64(3))
swept = t4d.sweep(V[0].tolist(), F.tolist(), b"motion.json", rv_min=np.float32(0.9))
swept = t4d.sweep(t4d.TriangleMesh(V[0], F), motion=Path("motion.json"), steps=np.int32(2))
section = swept.slice(time=1)
section = swept.slice(time=np.float32(1))
section = swept.slice(x=np.float64(1))
section = swept.slice(hyperplane=np.arange(5))
section = swept.slice(hyperplane=(0, 0, 0, 1, 0.5))
points, triangles = section
count: int = swept.save(b"x.t4d", compression=np.uint8(3), grid=np.float32(0.1), progress=print)
slab: t4d.Slab = swept.slab(np.int64(0))
body: t4d.Mesh = swept["nut"][np.int64(0)]
pose = t4d.Motion({"segments": [{"duration": np.float32(2)}]}).at(np.float32(1))
found = t4d.collide(swept, woven, clearance=0.2)
verdict: str = found.pairs[0].verdict
deepest: float = verbs.collide("a.t4d", [b"b.t4d"], ignore=["a:b", "a:c"]).pairs[0].depth
verbs.sweep(swept.slice(time=0), V, motion={"segments": []}, steps=np.int64(3), output=t4d.Mesh)
verbs.sweep("cube.obj", prism=3, steps="4", output=Path("a.t4d"))
verbs.measure("a.t4d", body=["nut", b"bolt"], output=[Path("a.csv"), "a.png"])
samples = verbs.join(["1.json", "2.json"]).samples
heights = slab.vertices[:, 2].max() + points[0, 2] + pose[0, 3] + slab.cells[0, 0] + triangles[0, 0]
"""


def found(folder, *arguments):
    """The faults that a part of mypy finds."""
    path = str(PACKAGE.parent)
    run = subprocess.run(
        [sys.executable, "-m", *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": path, "MYPYPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    return run.stdout + run.stderr if run.returncode else ""


def mypy(folder, *arguments):
    return found(folder, "mypy", "--strict", *arguments)


def test_mypy_finds_nothing_in_the_package(tmp_path):
    assert mypy(tmp_path, "-p", "t4d") == ""


def test_mypy_finds_nothing_in_the_page(tmp_path):
    examples = doctest.DocTestParser().get_examples(PAGE.read_text())
    (tmp_path / "page.py").write_text("".join(example.source for example in examples))
    # The page's own functions have no annotations.
    assert mypy(tmp_path, "--allow-untyped-defs", "--allow-untyped-calls", "page.py") == ""


def test_mypy_takes_numbers_and_arrays_of_numpy_and_all_verbs(tmp_path):
    from t4d import verbs

    calls = "".join(
        f"verbs.{verb}({'' if verb in ('formats', 'version') else chr(39) + 'a.t4d' + chr(39)})\n"
        for verb in verbs.__all__
    )
    (tmp_path / "calls.py").write_text(CALLS + calls)
    assert mypy(tmp_path, "calls.py") == ""


def test_mypy_refuses_what_is_refused(tmp_path):
    wrong = [
        "t4d.weave([], times='0, 1')",
        "t4d.weave([], spacing='a')",
        "t4d.read(5)",
        "t4d.read('x.t4d').slice(time='a')",
        "verbs.polish('x.t4d')",
        "verbs.quality('x.t4d', wurst=3)",
        "verbs.sweep('x.obj', backend='mesh')",
        "verbs.quality('x.t4d').cels",
    ]
    (tmp_path / "wrong.py").write_text("import t4d\nfrom t4d import verbs\n" + "\n".join(wrong))
    lines = [line for line in mypy(tmp_path, "wrong.py").splitlines() if "error:" in line]
    assert sorted({int(line.split(":")[1]) for line in lines}) == [3, 4, 5, 6, 7, 8, 9, 10]


def test_stubs_are_those_of_the_compiled_part(tmp_path):
    assert found(tmp_path, "mypy.stubtest", "t4d._t4d") == ""
