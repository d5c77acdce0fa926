"""Python may end while threads are at work: nothing is left, and the exit status is the program's."""

import os
import random
import subprocess
import sys
import textwrap

import pytest

import t4d

COMMON = """
import atexit, multiprocessing, os, queue, signal, sys, threading, time
import numpy as np
import t4d
from t4d import verbs

side = np.linspace(-2, 2, 40)
x, y, z = np.meshgrid(side, side, side, indexing="ij")
times = np.arange(400.0)
screw = {"segments": [{"duration": 2, "axis_direction": [0, 0, 1], "angle_degrees": 3000}]}
count = 16
turn = np.arange(count) * 2 * np.pi / count
around, along = np.meshgrid(turn, turn, indexing="ij")
torus = np.stack([(3 + np.cos(along)) * np.cos(around), (3 + np.cos(along)) * np.sin(around), np.sin(along)], -1)
at = np.arange(count * count).reshape(count, count)
a, b, c, d = at, np.roll(at, -1, 0), np.roll(at, (-1, -1), (0, 1)), np.roll(at, -1, 1)
quads = [np.stack(corners, -1).reshape(-1, 3) for corners in ([a, b, c], [a, c, d])]
solid = t4d.TriangleMesh(torus.reshape(-1, 3), np.concatenate(quads))
wait = float(sys.argv[1])

def frames():
    for time in times:
        yield np.sqrt((x - time / 400) ** 2 + y**2 + z**2) - 1

def swept(caps="cone"):
    return t4d.sweep(solid, motion=screw, steps=4000, caps=caps)

def woven(source=frames):
    return t4d.weave(source(), times=times)

def start(work):
    threading.Thread(target=work, daemon=True).start()
    time.sleep(wait)

def end(*ignored):
    sys.exit(7)
"""

CASES = {
    "sweep": "start(lambda: swept().save('x.t4d')); end()",
    "weave": "start(lambda: woven().save('x.t4d')); end()",
    "caps": "start(lambda: swept('tetgen').save('x.t4d')); end()",
    "load": "start(lambda: swept().load()); end()",
    "progress": "start(lambda: swept().save('x.t4d', progress=lambda done: time.sleep(0.01))); end()",
    "again and again": """
        def work():
            while True:
                woven().save("x.t4d")
        for _ in range(3):
            start(work)
        end()
    """,
    "slices": """
        mesh = t4d.sweep(solid, motion=screw, steps=5, caps="cone").load()
        def work():
            while True:
                mesh.slice(time=1)
        start(work)
        end()
    """,
    "triangles": """
        def work():
            while True:
                solid.save("x.ply")
                t4d.read_triangles("x.ply")
        start(work)
        atexit.unregister(t4d._t4d.end_work)
        atexit.register(lambda: os.path.exists("x.ply") and os.remove("x.ply"))
        atexit.register(t4d._t4d.end_work)
        end()
    """,
    "slabs": """
        def work():
            for slab in woven().slabs():
                time.sleep(0.001)
        start(work)
        end()
    """,
    "slabs that are kept": "slabs = woven().slabs(); next(slabs); time.sleep(wait); end()",
    "slabs that are kept in a cycle": """
        class Node: pass
        node = Node()
        node.node, node.slabs = node, swept().slabs()
        next(node.slabs)
        end()
    """,
    "a frame that never comes": """
        def waiting():
            yield from list(frames())[:3]
            yield queue.Queue().get()
        start(lambda: woven(waiting).save("x.t4d"))
        end()
    """,
    "a frame that computes": """
        def computing():
            for frame in frames():
                yield frame
                sum(range(10**7))
        start(lambda: woven(computing).save("x.t4d"))
        end()
    """,
    "a verb": """
        solid.save("solid.obj")
        open("screw.json", "w").write('{"segments": [{"duration": 2, "axis_direction": [0, 0, 1], "angle_degrees": 3000}]}')
        start(lambda: verbs.sweep("solid.obj", motion="screw.json", steps=4000, output="x.t4d"))
        os.remove("solid.obj"), os.remove("screw.json")
        end()
    """,
    "an exception": "start(lambda: woven().save('x.t4d')); raise SystemExit(7)",
    "a signal": """
        signal.signal(signal.SIGTERM, end)
        start(lambda: woven().save("y.t4d"))
        threading.Timer(wait, lambda: os.kill(os.getpid(), signal.SIGTERM)).start()
        swept().save("x.t4d")
        time.sleep(60)
    """,
    "work at the end": """
        start(lambda: woven().save("x.t4d"))
        def last():
            assert len(t4d.sweep(solid, motion=screw, steps=3, caps="cone").load().slice(time=1).triangles) > 0
            assert len(list(t4d.weave([x**2 + y**2 + z**2 - 1] * 3).slabs())) > 0
            print("worked")
        atexit.unregister(t4d._t4d.end_work)
        atexit.register(last)
        atexit.register(t4d._t4d.end_work)
        end()
    """,
    "a process that forks": """
        def work():
            start(lambda: woven().save("x.t4d"))
        start(lambda: woven().save("y.t4d"))
        context = multiprocessing.get_context("fork")
        processes = [context.Process(target=work) for _ in range(2)]
        for process in processes: process.start()
        for process in processes: process.join()
        assert [process.exitcode for process in processes] == [0, 0]
        end()
    """,
}


@pytest.mark.parametrize("case", CASES)
def test_nothing_is_left_by_work_that_python_ends(tmp_path, case):
    script = tmp_path / "script.py"
    script.write_text(COMMON + textwrap.dedent(CASES[case]))
    rng = random.Random(case)
    for i in range(int(os.environ.get("T4D_REPEAT", "2"))):
        folder = tmp_path / str(i)
        folder.mkdir()
        wait = rng.choice([0, rng.uniform(0, 0.2), rng.uniform(0, 1)])
        run = subprocess.run(
            [sys.executable, script, str(wait)], cwd=folder, timeout=120,
            stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert (run.returncode, run.stderr) == (7, ""), wait
        assert "worked" in run.stdout or case != "work at the end"
        # Work that was quick enough has written its file.
        complete = {"x.t4d", "y.t4d"}
        assert set(os.listdir(folder)) - complete == set(), wait
        for name in complete & set(os.listdir(folder)):
            t4d.read(folder / name)
