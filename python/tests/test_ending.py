"""Scripts end, with the exit status that is theirs, and leave no file that is half written: also where
threads are at work when Python ends."""

import os
import random
import signal
import subprocess
import sys
import textwrap
import time

import jupyter_client
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

def few():
    for time in range(8):
        yield np.sqrt((x - time / 8) ** 2 + y**2 + z**2) - 1

def ball():
    return t4d.weave(np.stack(list(few())))

def swept(caps="cone"):
    return t4d.sweep(solid, motion=screw, steps=4000, caps=caps)

def woven(source=frames):
    return t4d.weave(source(), times=range(8) if source is few else times)

def start(work):
    threading.Thread(target=work, daemon=True).start()
    time.sleep(wait)

def end(*ignored):
    sys.exit(7)
"""

# The main thread alone: what the script is, and its exit status.
SCRIPTS = {
    "save": ("ball().save('x.t4d')", 0),
    "save while the mesh is alive": ("mesh = ball(); mesh.save('x.t4d')", 0),
    "load": ("mesh = ball().load(); mesh.save('x.t4d')", 0),
    "a generator": ("mesh = woven(few); mesh.save('x.t4d')", 0),
    "an array": ("mesh = t4d.weave(np.stack(list(few()))); mesh.save('x.t4d')", 0),
    "an iso value": ("mesh = t4d.weave(np.stack(list(few())), iso=0.1); mesh.save('x.t4d')", 0),
    "a label": ("mesh = t4d.weave((np.stack(list(few())) < 0).astype('u1'), label=1); mesh.save('x.t4d')", 0),
    "labels": ("mesh = t4d.weave((np.stack(list(few())) < 0).astype('u1') + 1, label=[1, 2]); mesh.save('x.t4d')", 0),
    "all slabs": ("mesh = ball(); print(len(list(mesh.slabs())))", 0),
    "some slabs": ("mesh = ball(); slabs = mesh.slabs(); next(slabs)", 0),
    "slabs that nobody takes": ("mesh = ball(); slabs = mesh.slabs()", 0),
    "collide": ("mesh, other = (t4d.weave(np.stack(list(few()))[:3, ::4, ::4, ::4], origin=(shift, 0, 0)) for shift in (0, 3)); t4d.collide(mesh, other)", 0),
    "measure": ("mesh = ball(); mesh.measure([0, 1]); mesh.slice(time=1)", 0),
    "sweep": ("mesh = t4d.sweep(solid, motion=screw, caps='cone'); mesh.save('x.t4d')", 0),
    "an exception": ("mesh = ball(); mesh.save('x.t4d'); raise ValueError('mine')", 1),
    "an exception in a frame": (
        """
        def failing():
            yield from few()
            raise ValueError("mine")
        mesh = t4d.weave(failing(), times=range(9))
        mesh.save("x.t4d")
        """,
        1,
    ),
    "an exception in progress": (
        """
        def progress(done): raise ValueError("mine")
        mesh = ball()
        mesh.save("x.t4d", progress=progress)
        """,
        1,
    ),
    "exit in progress": (
        """
        mesh = ball()
        mesh.save("x.t4d", progress=lambda done: sys.exit(5))
        """,
        5,
    ),
    "exit in a frame": (
        """
        def leaving():
            yield from few()
            sys.exit(5)
        mesh = t4d.weave(leaving(), times=range(9))
        mesh.save("x.t4d")
        """,
        5,
    ),
    "exit while slabs are taken": ("for slab in ball().slabs(): sys.exit(5)", 5),
    "an exception with slabs in its frames": (
        """
        def deep(slabs):
            next(slabs)
            raise ValueError("mine")
        deep(woven().slabs())
        """,
        1,
    ),
    "a fork": (
        """
        mesh = ball()
        slabs = mesh.slabs()
        next(slabs)
        child = os.fork()
        if child == 0:
            try:
                list(slabs)
            except t4d.Failed:
                sys.exit(0)
            sys.exit(9)
        assert os.waitpid(child, 0)[1] == 0
        mesh.save("x.t4d")
        """,
        0,
    ),
    "a fork that weaves": (
        """
        mesh = ball()
        child = os.fork()
        if child == 0:
            mesh.save("x.t4d")
            sys.exit(0)
        assert os.waitpid(child, 0)[1] == 0
        """,
        0,
    ),
    "processes": (
        """
        def make(i):
            mesh = ball()
            mesh.save(f"{i}.t4d")
            os.remove(f"{i}.t4d")
        if __name__ == "__main__":
            mesh = ball()
            with multiprocessing.get_context("fork").Pool(2) as pool:
                pool.map(make, range(4))
        """,
        0,
    ),
    "a thread that is waited for": ("thread = threading.Thread(target=lambda: ball().save('x.t4d')); thread.start()", 0),
    "a mesh in a cycle": ("class Node: pass\nnode = Node(); node.node, node.mesh = node, ball(); node.mesh.save('x.t4d')", 0),
    "a mesh that the module keeps": ("t4d.kept = ball(); t4d.kept.save('x.t4d'); sys.kept = t4d.kept.slabs(); next(sys.kept)", 0),
    "an exit handler": ("mesh = ball(); atexit.register(lambda: mesh.save('x.t4d'))", 0),
    "a signal": ("mesh = ball(); slabs = mesh.slabs(); next(slabs); os.kill(os.getpid(), signal.SIGINT)", -signal.SIGINT),
}  # fmt: skip


THREADS = {
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
                os.remove("x.ply")
        start(work)
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
            print("worked")
        atexit.unregister(t4d.slabs._end)
        atexit.register(last)
        atexit.register(t4d.slabs._end)
        end()
    """,
    "a process that forks": """
        def work():
            woven().save(f"{os.getpid()}.t4d")
            os.remove(f"{os.getpid()}.t4d")
        start(lambda: swept().save("y.t4d"))
        context = multiprocessing.get_context("fork")
        processes = [context.Process(target=work) for _ in range(2)]
        for process in processes: process.start()
        for process in processes: process.join()
        assert [process.exitcode for process in processes] == [0, 0]
        end()
    """,
}

def run(folder, script, wait=0.0):
    folder.mkdir()
    # Ten seconds are the promise; a busy machine has more.
    return subprocess.run(
        # Python 3.12 and later warn of a fork beside threads.
        [sys.executable, "-W", "ignore::DeprecationWarning", script, str(wait)], cwd=folder, timeout=60,
        stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False,
    )  # fmt: skip


def is_whole(folder):
    """Whether all files are, with their final names."""
    for name in os.listdir(folder):
        assert name in ("x.t4d", "y.t4d", "x.ply")
        (t4d.read_triangles if name == "x.ply" else t4d.read)(folder / name)
    return True


@pytest.mark.parametrize("name", SCRIPTS)
def test_a_script_ends(tmp_path, name):
    text, code = SCRIPTS[name]
    script = tmp_path / "script.py"
    script.write_text(COMMON + textwrap.dedent(text))
    ended = run(tmp_path / "run", script)
    assert ended.returncode == code, ended.stderr
    assert ended.stderr == "" or code in (1, -signal.SIGINT)
    assert ("mine" in ended.stderr) == (code == 1)
    assert is_whole(tmp_path / "run")
    written = os.path.exists(tmp_path / "run" / "x.t4d")
    assert written == ("x.t4d" in text and "progress" not in name and "frame" not in name)


def test_a_notebook_is_started_again_while_it_weaves(tmp_path):
    manager, client = jupyter_client.manager.start_new_kernel(kernel_name="python3", cwd=str(tmp_path))
    try:
        program = COMMON.replace("float(sys.argv[1])", "0") + "mesh = woven(); mesh.slabs()"
        for work in ("kept = woven().slabs(); next(kept)", "start(lambda: woven().save('x.t4d'))"):
            assert client.execute_interactive(program, timeout=60)["content"]["status"] == "ok"
            assert client.execute_interactive(work, timeout=60)["content"]["status"] == "ok"
            begin = time.monotonic()
            manager.restart_kernel()
            client.wait_for_ready(timeout=60)
            assert time.monotonic() - begin < 60
        assert is_whole(tmp_path)
    finally:
        client.stop_channels()
        manager.shutdown_kernel()


@pytest.mark.parametrize("case", THREADS)
def test_nothing_is_left_by_work_that_python_ends(tmp_path, case):
    script = tmp_path / "script.py"
    script.write_text(COMMON + textwrap.dedent(THREADS[case]))
    rng = random.Random(case)
    for i in range(int(os.environ.get("T4D_REPEAT", "2"))):
        wait = rng.choice([0, rng.uniform(0, 0.2), rng.uniform(0, 1)])
        ended = run(tmp_path / str(i), script, wait)
        assert (ended.returncode, ended.stderr) == (7, ""), wait
        assert "worked" in ended.stdout or case != "work at the end"
        assert is_whole(tmp_path / str(i)), wait
