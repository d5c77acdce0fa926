"""Verbs on real workers of Dask: processes that share a folder and nothing else."""

import filecmp
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import t4d
from conftest import BUILD
from t4d import verbs

distributed = pytest.importorskip("distributed")
import t4d.distributed as many  # noqa: E402
from test_parts import frames, woven  # noqa: E402, F401

FAULTY = Path(__file__).with_name("faulty_t4d.py")
COUNTS = (1, 3, 7)


@pytest.fixture(scope="module")
def client(tmp_path_factory):
    """Three workers, each with a folder of its own."""
    with distributed.LocalCluster(
        n_workers=3, threads_per_worker=1, dashboard_address=None,
        local_directory=str(tmp_path_factory.mktemp("workers")),
    ) as cluster, distributed.Client(cluster) as client:  # fmt: skip
        yield client


@pytest.fixture
def faulty(client, tmp_path, monkeypatch):
    """Gives the program of all workers a fault, and takes it back."""
    folder = tmp_path / "fault"
    folder.mkdir()

    def set_everywhere(environment):
        def setting():
            import os

            from t4d import verbs

            os.environ.update(environment)
            verbs.program.cache_clear()

        client.run(setting)

    def fault(kind, word):
        set_everywhere({
            "T4D_PROGRAM": str(FAULTY), "T4D_REAL": str(BUILD / "t4d"), "T4D_FAULT": f"{kind}:{word}:{folder}",
            "T4D_FAILING_DISK": str(BUILD / "libt4d_failing_disk.so"),
        })  # fmt: skip
        return folder / "happened"

    yield fault
    set_everywhere({"T4D_PROGRAM": str(BUILD / "t4d"), "T4D_FAULT": "::"})


def same(a, b):
    return filecmp.cmp(a, b, shallow=False)


@pytest.mark.parametrize("parts", COUNTS)
def test_a_weave_on_workers_is_that_of_one_process(client, frames, woven, tmp_path, parts):  # noqa: F811
    report = many.weave(frames, tmp_path / "movie.t4d", client=client, parts=parts)
    assert same(tmp_path / "movie.t4d", woven)
    assert report.distributed.parts == parts and report.distributed.workers == 3
    assert report.distributed.retries == report.distributed.resumed == 0
    whole = verbs.weave(*frames, output=tmp_path / "whole.t4d")
    for name in ("vertices", "tetrahedra", "frames", "cap_tetrahedra", "bytes", "parts_lost"):
        assert report[name] == whole[name]
    assert sorted(p.name for p in tmp_path.iterdir()) == ["movie.t4d", "whole.t4d"]


def test_reports_on_workers_are_those_of_one_process(client, woven, models, tmp_path):  # noqa: F811
    for mesh in (woven, models / "screw.t4d"):
        for verb, options in (
            ("measure", {"frames": 9}), ("track", {}), ("validate", {"deep": True}), ("quality", {}),
        ):  # fmt: skip
            report = getattr(many, verb)(mesh, client=client, parts=5, **options)
            report.pop("distributed")
            assert report == getattr(verbs, verb)(mesh, **options)
    many.measure(woven, tmp_path / "volumes.json", client=client, parts=2, frames=9)
    assert json.loads((tmp_path / "volumes.json").read_text()) == verbs.measure(woven, frames=9)


def test_frames_on_workers_are_those_of_one_process(client, models, tmp_path):
    many.frames(models / "screw.t4d", tmp_path / "made", client=client, parts=3, n=8, format="vtp")
    verbs.frames(models / "screw.t4d", output=tmp_path / "whole", n=8, format="vtp")
    compared = filecmp.dircmp(tmp_path / "whole", tmp_path / "made")
    assert len(compared.same_files) == 10 and not compared.left_only and not compared.right_only
    assert not filecmp.cmpfiles(tmp_path / "whole", tmp_path / "made", compared.common_files, shallow=False)[1]


def test_sweep_and_compress_on_workers(client, models, tmp_path):
    many.sweep(models / "paper-cube.obj", tmp_path / "cube.t4d", client=client, parts=3,
               motion=models / "paper-translation.json")  # fmt: skip
    assert verbs.diff(tmp_path / "cube.t4d", models / "cube.t4d").level in ("bytes", "mesh")
    many.compress(models / "cube.t4d", tmp_path / "small.t4d", client=client, parts=3)
    assert verbs.diff(tmp_path / "small.t4d", models / "cube.t4d").level in ("bytes", "mesh")


def test_a_file_in_parts_is_the_same_mesh_here_and_in_a_store(client, frames, woven, tmp_path, monkeypatch):  # noqa: F811
    monkeypatch.chdir(tmp_path)
    report = many.weave(frames, tmp_path / "movie.t4dm", client=client, parts=3)
    assert report.vertices == verbs.weave(*frames, output=tmp_path / "whole.t4d").vertices
    (tmp_path / "whole.t4d").unlink()
    assert verbs.diff(tmp_path / "movie.t4dm", woven).level == "mesh"
    names = [f"part-{number}-of-3.t4d" for number in (1, 2, 3)]
    assert sorted(p.name for p in (tmp_path / "movie.t4dm.parts").iterdir()) == names
    # What fsspec knows as an object store: here a folder, by its URL.
    many.weave(frames, f"file://{tmp_path}/store/other.t4dm", client=client, parts=3)
    assert sorted(p.name for p in (tmp_path / "store" / "other.t4dm.parts").iterdir()) == names
    assert verbs.diff(tmp_path / "store" / "other.t4dm", woven).level == "mesh"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["movie.t4dm", "movie.t4dm.parts", "store"]


def test_a_task_without_enough_memory_says_so(woven):
    with pytest.raises(t4d.VerbError, match="memory"):
        verbs.run_words(["validate", str(woven), "--threads=1"], memory=1 << 20)


@pytest.mark.parametrize("limit", (4, 8))
def test_a_worker_with_too_little_memory_ends_the_run_with_one_sentence(frames, woven, tmp_path, limit):  # noqa: F811
    dask = pytest.importorskip("dask")
    memory = {f"distributed.worker.memory.{name}": False for name in ("target", "spill", "pause", "terminate")}
    output = tmp_path / "movie.t4d"
    with dask.config.set(memory), distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, memory_limit=limit * 1_000_000, dashboard_address=None,
        local_directory=str(tmp_path / "workers"),
    ) as cluster, distributed.Client(cluster) as client:  # fmt: skip
        with pytest.raises(many.DistributedError, match=f"a task has {limit} MB of this worker: workers with more"):
            many.weave(frames, output, client=client, parts=4)
    assert not output.exists()
    many.weave(frames, output, local=2, resume=True)
    assert same(output, woven)


def test_a_killed_worker_changes_nothing(client, faulty, frames, woven, tmp_path):  # noqa: F811
    happened = faulty("kill", "--part=2/4")
    report = many.weave(frames, tmp_path / "movie.t4d", client=client, parts=4)
    assert happened.exists() and report.distributed.retries >= 1
    assert same(tmp_path / "movie.t4d", woven)
    client.wait_for_workers(3, timeout=60)


def test_a_full_disk_of_one_worker_changes_nothing(client, faulty, frames, woven, tmp_path):  # noqa: F811
    happened = faulty("full", "--part=2/4")
    report = many.weave(frames, tmp_path / "movie.t4d", client=client, parts=4)
    assert happened.exists() and report.distributed.retries == 1
    assert same(tmp_path / "movie.t4d", woven)


def test_a_slow_worker_changes_nothing(client, faulty, frames, woven, tmp_path):  # noqa: F811
    happened = faulty("slow", "--part=2/8")
    report = many.weave(frames, tmp_path / "movie.t4d", client=client, parts=8)
    assert happened.exists() and report.distributed.retries == 0
    assert same(tmp_path / "movie.t4d", woven)


@pytest.mark.parametrize(
    ("kind", "said"),
    (("full", "No space left on device"), ("kill", "workers died while they made it, 4 times")),
)
def test_what_no_worker_can_make_ends_the_run_and_a_second_takes_it_up(
    frames, woven, tmp_path, monkeypatch, kind, said  # noqa: F811
):  # fmt: skip
    (tmp_path / "fault").mkdir()
    output = tmp_path / "movie.t4d"
    with monkeypatch.context() as faulty:
        for name, value in (
            ("PROGRAM", FAULTY), ("REAL", BUILD / "t4d"), ("FAILING_DISK", BUILD / "libt4d_failing_disk.so"),
            ("FAULT", f"{kind}-always:--part=6/8:{tmp_path / 'fault'}"),
        ):  # fmt: skip
            faulty.setenv(f"T4D_{name}", str(value))
        with pytest.raises(many.DistributedError) as error:
            many.weave(frames, output, local=2, parts=8)
    assert str(error.value).startswith("part 6 of 8: ") and said in str(error.value)
    assert "--resume goes on with them" in str(error.value) and not output.exists()
    report = many.weave(frames, output, local=2, resume=True)
    assert report.distributed.resumed > 0 and same(output, woven)
    assert not Path(f"{output}.parts").exists()


def test_parts_are_taken_up_if_what_they_were_made_of_is_the_same(frames, tmp_path):  # noqa: F811
    """Files are given by name, between commas, in folders, by another file, and by URL."""
    own = tmp_path / "in"
    own.mkdir()
    for name in ("a.npy", "b.npy", "c.pvd"):
        (own / name).write_text(name)
    output = own / "movie.t4d"
    for words, changed in (
        (["in/a.npy"], True), (["--velocity-file=x,in/a.npy"], True), (["in"], True), (["in/c.pvd"], True),
        ([f"file://{own}/a.npy"], True), ([f"file://{own}"], True), (["in/b.npy"], False),
    ):  # fmt: skip
        before = many._inputs(words, str(tmp_path), output)
        (own / "movie.t4d.parts").mkdir(exist_ok=True)
        (own / "movie.t4d.parts/part-1-of-2.t4d").write_text("x")
        if not words[0].startswith("file:"):
            assert many._inputs(words, str(tmp_path), output) == before
        with (own / "a.npy").open("a") as file:
            file.write("more")
        assert (many._inputs(words, str(tmp_path), output) != before) == changed, words


def test_a_part_damaged_before_joining_is_made_again(client, faulty, frames, woven, tmp_path):  # noqa: F811
    happened = faulty("damage", f"--output={tmp_path / 'movie.t4d'}")
    report = many.weave(frames, tmp_path / "movie.t4d", client=client, parts=4)
    assert happened.exists() and report.distributed.parts == 4
    assert same(tmp_path / "movie.t4d", woven)


def test_a_frame_that_fails_is_named_with_its_part(client, frames, tmp_path):  # noqa: F811
    own = [tmp_path / name.name for name in frames]
    for name, copy in zip(frames, own):
        copy.write_bytes(name.read_bytes())
    samples = np.load(own[8])
    samples[3, 4, 5] = np.nan
    np.save(own[8], samples)
    output = tmp_path / "movie.t4d"
    with pytest.raises(many.DistributedError) as error:
        many.weave(own, output, client=client, parts=4)
    assert "part 4 of 4: " in str(error.value) and "f8.npy" in str(error.value)
    assert "parts are finished in" in str(error.value) and not output.exists()
    with pytest.raises(many.DistributedError, match="has parts of an earlier run"):
        many.weave(own, output, client=client, parts=4)
    # Parts of other inputs are not taken up.
    np.save(own[8], np.load(frames[8]))
    report = many.weave(own, output, client=client, resume=True)
    assert report.distributed.parts == 4 and report.distributed.resumed == 0
    assert not Path(f"{output}.parts").exists()


def test_inputs_that_fsspec_finds_are_woven(client, frames, woven, tmp_path):  # noqa: F811
    np.save(tmp_path / "f.npy", np.stack([np.load(name) for name in frames]))
    verbs.weave(tmp_path / "f.npy", output=tmp_path / "whole.t4d")
    many.weave(f"file://{tmp_path}/f.npy", tmp_path / "movie.t4d", client=client, parts=3)
    assert same(tmp_path / "movie.t4d", tmp_path / "whole.t4d")


def test_what_cannot_be_done_is_said_before_work_begins(client, frames, woven, tmp_path, monkeypatch):  # noqa: F811
    def said(*arguments, **options):
        with pytest.raises(many.DistributedError) as error:
            many.run(*arguments, client=client, **options)
        assert not list(tmp_path.iterdir())
        return str(error.value)

    output = str(tmp_path / "x.t4d")
    names = list(map(str, frames))
    assert "9 parts are asked for, and there can be 8 at most" in said("weave", names, output, parts=9)
    assert "'mill' cannot be divided among workers; these can: weave" in said("mill", [], output)
    assert "there is no such folder" in said("weave", names, str(tmp_path / "no" / "x.t4d"))
    assert "reports are written as .json" in said("measure", [str(woven)], output)
    assert "weave needs an output" in said("weave", names)
    assert "no-such.npy" in said("weave", ["no-such.npy"], output, parts=2)
    own = many._version()
    monkeypatch.setattr(many, "_version", lambda: ("0.9", "0.9"))
    try:
        said_of = said("weave", names, output, parts=2)
    except AttributeError:
        raise
    assert f"has t4d {own[0]} (program {own[1]}), and this is t4d 0.9 (program 0.9)" in said_of


def command(*words):
    return [f"{os.environ['T4D_BUILD']}/t4d-distributed", *map(str, words)]


@pytest.mark.skipif(not os.environ.get("T4D_ALL"), reason="tools/test --all runs it")
def test_a_killed_scheduler_ends_the_run_and_a_second_takes_it_up(frames, woven, tmp_path):  # noqa: F811
    where = tmp_path / "scheduler.json"
    fault = tmp_path / "fault"
    fault.mkdir()
    environment = dict(
        os.environ, T4D_PROGRAM=str(FAULTY), T4D_REAL=str(BUILD / "t4d"), T4D_FAULT=f"stall:--part=7/8:{fault}",
        T4D_FAILING_DISK="",
    )  # fmt: skip
    output = tmp_path / "movie.t4d"
    started = []

    def start(module, *words):
        started.append(subprocess.Popen(
            [sys.executable, "-m", module, *words], env=environment, stderr=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL, start_new_session=True,
        ))  # fmt: skip
        return started[-1]

    try:
        scheduler = start("distributed.cli.dask_scheduler", "--port", "0", "--no-dashboard",
                          "--scheduler-file", str(where))  # fmt: skip
        start("distributed.cli.dask_worker", "--scheduler-file", str(where), "--nthreads", "1", "--no-dashboard",
              "--local-directory", str(tmp_path / "worker"))  # fmt: skip
        deadline = time.monotonic() + 60
        while not where.exists() and time.monotonic() < deadline:
            time.sleep(0.1)
        address = json.loads(where.read_text())["address"]
        run = subprocess.Popen(
            command("weave", *frames, "-o", output, "--scheduler", address, "--parts", 8, "--json"),
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
        while not (fault / "happened").exists() and time.monotonic() < deadline:
            time.sleep(0.1)
        os.kill(scheduler.pid, signal.SIGKILL)
        said = run.communicate(timeout=90)
        assert run.returncode == 1 and said[0] == ""
        assert "the scheduler went away" in said[1] or "lost the work" in said[1]
        assert "--resume goes on with them" in said[1] and said[1].count("\n") == 1
        assert not output.exists()
    finally:
        for process in started:
            os.killpg(process.pid, signal.SIGKILL) if process.poll() is None else None
            process.wait()
    again = subprocess.run(
        command("weave", *frames, "-o", output, "--local", 2, "--resume", "--json"),
        capture_output=True, text=True, timeout=120, check=True,
    )  # fmt: skip
    report = json.loads(again.stdout)
    assert list(report) == ["parts", "workers", "retries", "resumed", "seconds", "report"]
    assert report["parts"] == 8 and report["workers"] == 2 and report["resumed"] >= 5
    assert same(output, woven) and not Path(f"{output}.parts").exists()


def test_the_program_says_what_is_wrong(tmp_path):
    for words, said in (
        (["weave", "x.npy", "-o", "x.t4d"], "one of the arguments --scheduler --local is required"),
        (["mill", "--local", "1"], "cannot be divided among workers"),
        (["weave", "x.npy", "-o", tmp_path / "x.t4d", "--scheduler", "tcp://127.0.0.1:1"],
         "no scheduler answers at tcp://127.0.0.1:1"),
    ):  # fmt: skip
        done = subprocess.run(command(*words), capture_output=True, text=True, check=False)
        assert done.returncode != 0 and said in done.stderr and "Traceback" not in done.stderr
