#!/usr/bin/env python3
"""What docs/scale.md says of this machine: costs of the steps, and of Dask.

usage: many_machines.py [FOLDER]   with t4d and the module t4d of a build in PATH and PYTHONPATH
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import distributed
import numpy as np
import t4d.distributed as many
from distributed.protocol import serialize
from t4d import verbs


FRAMES, SIZE = 33, 256


def timed(function, *arguments, **options):
    begin = time.monotonic()
    result = function(*arguments, **options)
    return time.monotonic() - begin, result


def frames_of(folder, count, size):
    """Frames of many balls, as distances."""
    random = np.random.default_rng(1)
    balls = random.uniform(0, size, (8, 3))
    ways = random.uniform(-0.6, 0.6, (8, 3))
    grid = np.stack(np.meshgrid(*3 * [np.arange(size, dtype=np.float32)], indexing="ij"))
    names = []
    for i in range(count):
        centres = balls + ways * i
        distance = np.min([np.sqrt(((grid - c.reshape(3, 1, 1, 1)) ** 2).sum(0)) for c in centres], 0)
        names.append(folder / f"f{i:03}.npy")
        np.save(names[-1], (distance - size / 9).astype(np.float32))
    return names


def cluster(workers, folder):
    return distributed.LocalCluster(
        n_workers=workers, threads_per_worker=1, dashboard_address=None, local_directory=str(folder)
    )


def scheduler_bytes(dask_scheduler):
    import psutil

    return psutil.Process().memory_info().rss


def main(folder):
    found = {"cores": len(os.sched_getaffinity(0)), "load": os.getloadavg()[0]}
    frames = frames_of(folder, FRAMES, SIZE)
    one = folder / "one.t4d"
    quiet = {"frame_time": 1, "threads": 1}
    seconds, report = timed(verbs.weave, *frames, output=one, **quiet)
    found["weave"] = {"seconds": seconds, "frames": FRAMES, "samples": FRAMES * SIZE**3, "bytes_read": FRAMES * 4 * SIZE**3,
                      "cells": report.tetrahedra, "bytes": report.bytes}  # fmt: skip
    # The same parts in sequence, and on one, two, four and eight workers with one thread each.
    parts = 4
    begin = time.monotonic()
    made = []
    for k in range(1, parts + 1):
        made.append(folder / f"part{k}.t4d")
        verbs.weave(*frames, part=f"{k}/{parts}", output=made[-1], **quiet)
    found["sequence"] = time.monotonic() - begin
    seconds, report = timed(verbs.join, *made, output=folder / "joined.t4d")
    found["join"] = {"seconds": seconds, "bytes": report.bytes, "slabs": report.slabs}
    found["read"] = timed(subprocess.run, ["cat", *map(str, made)], stdout=subprocess.DEVNULL)[0]
    found["workers"] = {}
    for workers in (1, 2, 4, 8):
        with cluster(workers, folder / f"w{workers}") as own, distributed.Client(own) as client:
            seconds, report = timed(
                many.weave, frames, folder / f"of{workers}.t4d", client=client, parts=parts, **quiet
            )
            found["workers"][workers] = seconds
            assert (folder / f"of{workers}.t4d").read_bytes() == one.read_bytes()
    # A thousand small parts on four workers, and a tenth of them one after another.
    small = folder / "small.t4d"
    (folder / "few").mkdir()
    verbs.weave(*frames_of(folder / "few", 3, 20), output=small, frame_time=1)
    begin = time.monotonic()
    for k in range(1, 101):
        verbs.measure(small, frames=1000, part=f"{k}/1000", threads=1)
    alone = (time.monotonic() - begin) / 100
    with cluster(4, folder / "many") as own, distributed.Client(own) as client:
        before = client.run_on_scheduler(scheduler_bytes)
        seconds, _ = timed(many.measure, small, client=client, parts=1000, frames=1000, threads=1)
        after = client.run_on_scheduler(scheduler_bytes)
    job = {"run": "t4d-00000000", "verb": "measure", "words": [str(small), "--frames=1000", "--threads=1"],
           "cwd": os.getcwd(), "tasks_on": {"127.0.0.1": 4}, "version": many._version(), "parts": 1000,
           "fingerprint": "0" * 64, "folder": ""}  # fmt: skip
    task = sum(len(frame) for frame in serialize((many._make, (job, 500)))[1])
    answer = len(json.dumps(verbs.measure(small, frames=1000, part="500/1000")))
    found["small"] = {"seconds_a_part": seconds / 1000, "alone": alone, "task_bytes": task, "answer_bytes": answer,
                      "scheduler_bytes": [before, after]}  # fmt: skip
    # Tasks that do nothing: what the engine can do.
    with cluster(4, folder / "empty") as own, distributed.Client(own) as client:
        client.gather(client.map(abs, range(100), pure=False))
        seconds, _ = timed(lambda: client.gather(client.map(abs, range(2000), pure=False)))
        found["empty_tasks_a_second"] = 2000 / seconds
    print(json.dumps(found, indent=2))


if __name__ == "__main__":
    if len(sys.argv) > 1:
        main(Path(sys.argv[1]))
    else:
        with tempfile.TemporaryDirectory() as temporary:
            main(Path(temporary))
