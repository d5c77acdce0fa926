"""Verbs on many workers, with Dask (the package ``distributed``).

>>> import t4d.distributed
>>> t4d.distributed.weave("movie.zarr", "movie.t4d", label=2, client=client)
>>> report = t4d.distributed.measure("movie.t4d", frames=10_000, client=client)

A verb is divided into parts of time (``--part K/N``), each a task of Dask that runs the verb in its
worker; the parts are joined, and the result is that of one process. Workers read inputs and write
outputs by path, so they need the same folders; ``client`` is that of a scheduler, and without one
a worker for each core is started on this machine.

Parts are kept beside the output, in ``OUTPUT.parts``, until they are joined. What goes wrong on a
worker is left to Dask: it gives the part to another one. If the run ends early, ``resume=True``
takes up the parts that are finished and fit: those made of the same inputs, with the same options,
by the same version.
"""

from __future__ import annotations

import argparse
import contextlib
import functools
import hashlib
import json
import logging
import math
import os
import posixpath
import queue
import shutil
import signal
import socket
import sys
import threading
import time
import uuid
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, Optional, Sequence, Tuple

import t4d
from t4d import commands
from t4d.errors import Error, VerbError
from t4d.served import package, readable

__all__ = [
    "DistributedError",
    "collide",
    "compress",
    "frames",
    "measure",
    "quality",
    "rasterize",
    "simplify",
    "sweep",
    "track",
    "validate",
    "voxelize",
    "weave",
]

MESHES = ("weave", "sweep", "compress", "simplify")
FOLDERS = ("frames", "voxelize", "rasterize")
REPORTS = ("measure", "track", "validate", "quality", "collide")

_SECONDS = 20.0  # that a part is meant to take
_GONE_SECONDS = 10.0  # without the scheduler before the run ends
_RETRIES = 3  # of a part that failed for no fault of its input


class DistributedError(Error, RuntimeError):
    """A run on many workers did not end; the finished parts are kept."""


# ---- in the workers -------------------------------------------------------------------------


def _digest(path: Path) -> str:
    """SHA-256 of a file, or of the names and contents of the files in a folder."""
    sha = hashlib.sha256()
    for file in [path] if path.is_file() else sorted(path.rglob("*")):
        if not file.is_file():
            continue
        if file != path:
            sha.update(file.relative_to(path).as_posix().encode() + b"\0")
        with file.open("rb") as bytes_:
            while piece := bytes_.read(1 << 20):
                sha.update(piece)
    return sha.hexdigest()


def _link(file: Path, other: Path) -> None:
    """A second name for a file, or a copy where there are no links."""
    try:
        os.link(file, other)
    except FileExistsError:
        raise
    except OSError:
        shutil.copy2(file, other)


def _bytes(path: Path) -> int:
    return sum(file.stat().st_size for file in ([path] if path.is_file() else path.rglob("*")) if file.is_file())


def _write(path: Path, value: Any) -> None:
    """A JSON file, complete or not at all."""
    part = path.with_name(f".{path.name}.{uuid.uuid4().hex[:8]}")
    part.write_text(json.dumps(value) + "\n", encoding="utf-8")
    part.replace(path)


@functools.lru_cache(maxsize=1)
def _version() -> Tuple[str, str]:
    """The versions of the module and of the program."""
    return t4d.__version__, commands.run("version")["version"]


def _share_of_worker(job: Dict[str, Any]) -> Tuple[int, int]:
    """Threads and bytes for one task of this worker; 0 bytes for no limit."""
    get_worker = package("distributed").get_worker

    worker = get_worker()
    tasks = worker.state.nthreads
    on_host = max(tasks, job["tasks_on"].get(worker.ip, 0))
    limit = worker.memory_manager.memory_limit
    return max(1, len(os.sched_getaffinity(0)) // on_host), int(limit or 0) // tasks


def _event(job: Dict[str, Any], number: int) -> None:
    """Tells the scheduler that a part is begun: more often than there are parts are retries."""
    get_worker = package("distributed").get_worker

    get_worker().log_event(job["run"], {"part": number})


def _part_name(job: Dict[str, Any], number: int) -> str:
    width = len(str(job["parts"]))
    return f"part-{number:0{width}}-of-{job['parts']}"


def _place(job: Dict[str, Any], number: int) -> Path:
    ending = ".t4d" if job["verb"] in MESHES else ""
    return Path(job["folder"]) / (_part_name(job, number) + ending)


def _manifest(place: Path) -> Path:
    """The manifest of a part by itself."""
    return place.with_suffix(".t4dm")


def _note(job: Dict[str, Any], number: int) -> Path:
    return Path(job["folder"]) / (_part_name(job, number) + ".json")


def _call(job: Dict[str, Any], words: Sequence[str]) -> Any:
    """The report of a verb. It has this task's share of the worker's memory."""
    threads, memory = _share_of_worker(job)
    cwd = job["cwd"]
    if not os.path.isdir(cwd):
        raise VerbError(
            f"the folder {cwd} is not there on {socket.gethostname()}: workers need the same folders "
            "as the client", job["verb"], 1,
        )  # fmt: skip
    get_worker = package("distributed").get_worker

    words = [readable(word, Path(get_worker().local_directory) / "t4d-inputs") for word in words]
    if not any(word.startswith("--threads") for word in words):
        words.append(f"--threads={threads}")
    try:
        return commands.run_words([job["verb"], *words], cwd=cwd, memory=memory)
    except VerbError as error:
        # The stacks of threads are memory, too.
        short = any(sign in str(error) for sign in ("memory", "Resource temporarily unavailable"))
        if memory and (short or error.exit_code < 0):
            raise VerbError(
                f"{error} (a task has {memory / 1e6:.0f} MB of this worker: workers with more memory "
                "or fewer threads give it more)", job["verb"], error.exit_code,
            ) from None  # fmt: skip
        raise


def _is_done(job: Dict[str, Any], number: int) -> Optional[Dict[str, Any]]:
    """What is noted of a finished part, if that is there, whole, and of this run."""
    try:
        note = json.loads(_note(job, number).read_text(encoding="utf-8"))
        if note["fingerprint"] != job["fingerprint"]:
            return None
        if job["verb"] not in REPORTS and _digest(_place(job, number)) != note["sha256"]:
            return None
        if job["verb"] in MESHES and not _manifest(_place(job, number)).exists():
            return None
        return dict(note)
    except (OSError, ValueError, KeyError):
        return None


def _make(job: Dict[str, Any], number: int) -> Dict[str, Any]:
    """Makes a part, and notes that it is done. What the input is to blame for is returned: another
    worker would find the same."""
    if _version() != tuple(job["version"]):
        raise DistributedError(_wrong_version(socket.gethostname(), _version(), job["version"]))
    _event(job, number)
    place = _place(job, number)
    words = [*job["words"], f"--part={number}/{job['parts']}"]
    if job["verb"] in FOLDERS:
        shutil.rmtree(place, ignore_errors=True)
    if job["verb"] not in REPORTS:
        words.append(f"--output={place}")
    begin = time.monotonic()
    try:
        report = _call(job, words)
    except VerbError as error:
        if error.exit_code in (2, 4):
            return {"number": number, "wrong": str(error)}
        raise
    note = {"number": number, "fingerprint": job["fingerprint"], "report": report,
            "seconds": time.monotonic() - begin}  # fmt: skip
    if job["verb"] in MESHES:
        # All its bytes are checked here, so that joining reads its index alone.
        commands.run_words(["join", str(place), "--manifest", f"--output={_manifest(place)}"])
        (about,) = json.loads(_manifest(place).read_text(encoding="utf-8"))["parts"]
        note.update((name, about[name]) for name in ("begin", "end", "slabs", "bytes", "sha256"))
    elif job["verb"] in FOLDERS:
        note.update(sha256=_digest(place), bytes=_bytes(place))
    if job["folder"]:
        _write(_note(job, number), note)
        return {"number": number}
    return note


def _damaged(job: Dict[str, Any], number: int) -> Optional[int]:
    return None if _is_done(job, number) else number


def _most_parts(job: Dict[str, Any]) -> int:
    if "most_parts" not in commands.options_of(job["verb"]):
        return 10**9
    words = [*job["words"], "--most-parts"]
    if job["verb"] not in REPORTS:
        words.append("--output=" + ("most" if job["verb"] in FOLDERS else "most.t4d"))
    return int(_call(job, words)["parts"])


def _seconds_of_one(job: Dict[str, Any], most: int) -> float:
    """The seconds that the smallest part in the middle takes."""
    with _scratch(job) as folder:
        words = [*job["words"], f"--part={(most + 1) // 2}/{most}"]
        if job["verb"] not in REPORTS:
            words.append(f"--output={folder / ('part' if job['verb'] in FOLDERS else 'part.t4d')}")
        begin = time.monotonic()
        _call(job, words)
        return time.monotonic() - begin


@contextlib.contextmanager
def _scratch(job: Dict[str, Any]) -> Iterator[Path]:
    get_worker = package("distributed").get_worker

    folder = Path(get_worker().local_directory) / f"t4d-{uuid.uuid4().hex[:8]}"
    folder.mkdir()
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _join_meshes(job: Dict[str, Any], output: str) -> Any:
    """Copies all parts into one file or, if its name is that of a .t4dm, writes a manifest of them, from
    the manifests that their workers have made."""
    own = [str(_manifest(_place(job, number))) for number in range(1, job["parts"] + 1)]
    how = ["--manifest"] if _is_manifest(output) else []
    return commands.run_words(["join", *own, *how, f"--output={output}"])


def _is_manifest(output: Any) -> bool:
    return str(output).endswith(".t4dm")


def _is_url(output: Any) -> bool:
    return "://" in str(output)


def _upload(job: Dict[str, Any], number: int, url: str) -> None:
    """Puts a finished part, or as number 0 the manifest, into the folder of an object store."""
    fsspec = package("fsspec")

    files, folder = fsspec.core.url_to_fs(url)
    if number == 0:
        own = Path(job["folder"]).with_suffix("")
        files.put_file(str(own), f"{folder}/{own.name}")
    else:
        own = _place(job, number)
        files.makedirs(f"{folder}/{own.parent.name}", exist_ok=True)
        files.put_file(str(own), f"{folder}/{own.parent.name}/{own.name}")


# ---- in the client --------------------------------------------------------------------------


def _wrong_version(where: str, found: Sequence[str], own: Sequence[str]) -> str:
    return (
        f"the worker {where} has t4d {found[0]} (program {found[1]}), and this is t4d {own[0]} "
        f"(program {own[1]}): install the same version for all"
    )


# Files that name others, which lie beside them as a rule.
_NAMING = {".pvd", ".nhdr", ".hdr", ".gltf", ".t4dm", ".urdf", ".usda", ".json"}


def _state_of(path: Path, without: str) -> Any:
    """What changes when a file, or one in a folder, is changed: size and time. Names that begin with
    `without` are those of the output and its parts."""
    if path.suffix.lower() in _NAMING and path.is_file():
        path = path.parent
    if path.is_dir():
        sha = hashlib.sha256()
        for folder, folders, files in os.walk(path):
            folders[:] = sorted(n for n in folders if not os.path.join(folder, n).startswith(without))
            for name in sorted(files):
                file = os.path.join(folder, name)
                if not file.startswith(without):
                    status = os.stat(file)
                    sha.update(f"{file} {status.st_size} {status.st_mtime_ns}\n".encode())
        return sha.hexdigest()
    status = path.stat()
    return [status.st_size, status.st_mtime_ns]


def _state_of_url(url: str) -> Any:
    """What changes when a file, or one in a folder, of an object store is changed, as far as it tells."""
    files, path = package("fsspec").core.url_to_fs(url)
    if files.isfile(path):
        return files.ukey(path)
    found = files.find(path, detail=True)
    keys = ("size", "ETag", "mtime", "LastModified")
    about = {name: [value.get(key) for key in keys] for name, value in found.items()}
    return hashlib.sha256(json.dumps(about, sort_keys=True, default=str).encode()).hexdigest()


def _inputs(words: Sequence[str], cwd: str, output: Optional[Path]) -> Dict[str, Any]:
    """The states of the files that words, or words between commas, name."""
    states: Dict[str, Any] = {}
    without = str(output) if output else "\0"
    for word in words:
        value = word.split("=", 1)[1] if word.startswith("-") and "=" in word else word
        for name in {value, *value.split(",")}:
            if _is_url(name):
                with contextlib.suppress(Exception):  # of any package for a kind of URL
                    states[name] = _state_of_url(name)
                continue
            with contextlib.suppress(OSError, ValueError):
                states[name] = _state_of(Path(cwd) / name, without)
    return states


class _Run:
    """One verb on the workers of a client."""

    def __init__(
        self, client: Any, verb: str, words: Sequence[str], output: Optional[str],
        parts: Optional[int], resume: bool, seconds: float, say: Callable[[str], None],
    ) -> None:  # fmt: skip
        self.client = client
        self.url = output if output and _is_url(output) else None
        if self.url:
            output = posixpath.basename(self.url)
        self.output = Path(os.path.abspath(output)) if output else None
        self.resume = resume
        self.seconds = seconds
        self.say = say
        self.wanted = parts
        self.resumed = 0
        self.begun = time.monotonic()
        self.job: Dict[str, Any] = {
            "run": f"t4d-{uuid.uuid4().hex[:8]}", "verb": verb, "words": list(words), "cwd": os.getcwd(),
            "tasks_on": {}, "version": _version(), "parts": 0, "fingerprint": "",
            "folder": f"{self.output}.parts" if self.output else "",
        }  # fmt: skip

    # -- what is to be done

    def _key(self, what: Any) -> str:
        return f"{self.job['verb']}-{self.job['run'][4:]}-{what}"

    def _submit(self, function: Callable[..., Any], *arguments: Any, what: Any, retries: int = 0) -> Any:
        return self.client.submit(
            function, self.job, *arguments, key=self._key(what), retries=retries, pure=False
        )

    def _ask(self, function: Callable[..., Any], *arguments: Any, what: str) -> Any:
        """The result of one task."""
        future = self._submit(function, *arguments, what=what)
        for _ in self._completed([future]):
            pass
        return future.result()

    def _check_workers(self) -> None:
        if not self.client.scheduler_info()["workers"]:
            with contextlib.suppress(Exception):
                self.client.wait_for_workers(1, timeout=30)
        try:
            found = self.client.run(_version)
        except (ImportError, AttributeError, FileNotFoundError) as error:
            raise DistributedError(f"a worker cannot use t4d: {error}") from None
        if not found:
            raise DistributedError("no worker is connected to the scheduler")
        for worker, version in found.items():
            if tuple(version) != tuple(self.job["version"]):
                raise DistributedError(_wrong_version(worker, version, self.job["version"]))

    def _count_tasks(self) -> None:
        """How many tasks run at a time on each host, whose cores they share."""
        tasks_on: Dict[str, int] = {}
        for worker in self.client.scheduler_info()["workers"].values():
            tasks_on[worker["host"]] = tasks_on.get(worker["host"], 0) + int(worker["nthreads"])
        self.job["tasks_on"] = tasks_on

    def _choose_parts(self) -> None:
        folder = Path(self.job["folder"]) if self.job["folder"] else None
        if folder and folder.exists():
            if not self.resume:
                raise DistributedError(
                    "has parts of an earlier run: take them up (--resume), or remove the folder", str(folder)
                )
            with contextlib.suppress(OSError, ValueError, KeyError):
                earlier = json.loads((folder / "run.json").read_text(encoding="utf-8"))
                self.wanted = self.wanted or int(earlier["parts"])
        most = self._ask(_most_parts, what="plan")
        threads = sum(self.client.nthreads().values()) or 1
        if self.wanted is not None:
            if self.wanted > most:
                raise DistributedError(f"{self.wanted} parts are asked for, and there can be {most} at most")
            self.job["parts"] = self.wanted
        elif self.job["verb"] in ("sweep", "simplify") or most <= threads:
            # Their bytes depend on the number of parts, so that must not depend on time.
            self.job["parts"] = min(most, 2 * threads)
        else:
            one = self._ask(_seconds_of_one, most, what="probe")
            self.job["parts"] = min(most, max(threads, math.ceil(most * one / self.seconds)))
        about = {key: self.job[key] for key in ("version", "verb", "words", "parts")}
        about["inputs"] = _inputs(self.job["words"], self.job["cwd"], self.output)
        text = json.dumps(about, sort_keys=True)
        self.job["fingerprint"] = hashlib.sha256(text.encode()).hexdigest()
        if folder:
            folder.mkdir(exist_ok=True)
            _write(folder / "run.json", {**about, "fingerprint": self.job["fingerprint"]})

    # -- doing it

    def _completed(self, futures: Sequence[Any]) -> Iterator[Any]:
        """Futures as they end; fails if the scheduler goes away."""
        ended: "queue.SimpleQueue[Any]" = queue.SimpleQueue()
        for future in futures:
            future.add_done_callback(ended.put)
        left = len(futures)
        seen = time.monotonic()
        while left > 0:
            future = None
            with contextlib.suppress(queue.Empty):
                future = ended.get(timeout=1)
            if future is not None and future.status in ("finished", "error"):
                left -= 1
                yield future
            elif self.client.status == "running":
                seen = time.monotonic()
                if future is not None:
                    raise DistributedError("the scheduler lost the work, or somebody cancelled it")
            elif self.client.status == "closed" or time.monotonic() - seen > _GONE_SECONDS:
                raise DistributedError("the scheduler went away")

    def _make(self, numbers: Sequence[int]) -> List[Dict[str, Any]]:
        futures = [self._submit(_make, number, what=f"{number}/{self.job['parts']}-{uuid.uuid4().hex[:4]}",
                                retries=_RETRIES) for number in numbers]  # fmt: skip
        order = {future.key: number for future, number in zip(futures, numbers)}
        made: List[Dict[str, Any]] = []
        try:
            for future in self._completed(futures):
                number = order[future.key]
                of = f"part {number} of {self.job['parts']}"
                if future.status == "error":
                    raise DistributedError(f"{of}: {_text(future.exception())}")
                result = future.result()
                if "wrong" in result:
                    raise DistributedError(f"{of}: {result['wrong']}")
                made.append(result)
                self.say(f"{self.job['verb']}: {len(made)} of {len(numbers)} parts")
        except BaseException:
            with contextlib.suppress(Exception):
                self.client.cancel(futures, force=True)
            raise
        return made

    def _missing(self) -> List[int]:
        """The parts that are not finished; those of an earlier run are looked at by the workers."""
        numbers = list(range(1, self.job["parts"] + 1))
        if not (self.resume and self.job["folder"]):
            return numbers
        futures = [self._submit(_damaged, number, what=f"check {number}") for number in numbers]
        missing = [future.result() for future in self._completed(futures)]
        found = sorted(number for number in missing if number is not None)
        self.resumed = len(numbers) - len(found)
        return found

    def _notes(self) -> List[Dict[str, Any]]:
        numbers = range(1, self.job["parts"] + 1)
        return [json.loads(_note(self.job, number).read_text(encoding="utf-8")) for number in numbers]

    def _join(self, notes: List[Dict[str, Any]]) -> Any:
        report = _joined_report(self.job, notes)
        if self.job["verb"] in MESHES:
            assert self.output
            joined = self._ask(_join_meshes, str(self.output), what=f"join {uuid.uuid4().hex[:4]}")
            if report is None:
                return joined
            report["bytes"] = joined["bytes"]
            if self.url:
                self._put_all(posixpath.dirname(self.url))
        elif self.job["verb"] in FOLDERS:
            assert self.output
            self._gather(report)
        elif self.output:
            _write_report(self.output, report)
        return report

    def _all(self, function: Callable[..., Any], *arguments: Any, what: str) -> None:
        """Does something with each part."""
        numbers = range(1, self.job["parts"] + 1)
        futures = [self._submit(function, number, *arguments, what=f"{what} {number}", retries=_RETRIES)
                   for number in numbers]  # fmt: skip
        for future in self._completed(futures):
            future.result()

    def _put_all(self, folder: str) -> None:
        """Into an object store: the parts, then the manifest, so that it names what is there."""
        self._all(_upload, folder, what="put")
        self._ask(_upload, 0, folder, what="put manifest")
        assert self.output
        self.output.unlink()

    def _gather(self, report: Any) -> None:
        """Puts the files of all parts into one folder, which gets its name last."""
        assert self.output
        whole = Path(self.job["folder"]) / "whole"
        whole.mkdir(exist_ok=True)
        lists: List[str] = []
        for number in range(1, self.job["parts"] + 1):
            for file in sorted(_place(self.job, number).iterdir()):
                kept = whole / file.name
                with contextlib.suppress(FileExistsError):
                    _link(file, kept)
                if ".part-" in file.name:
                    lists.append(str(kept))
        if lists and self.job["parts"] > 1:
            commands.run_words(["join", *lists, f"--output={whole / 'manifest.json'}"])
            for name in lists:
                os.unlink(name)
        if "manifest" in report:
            report["manifest"] = str(self.output / "manifest.json")
        with contextlib.suppress(OSError):
            self.output.rmdir()
        whole.replace(self.output)

    def run(self) -> commands.Report:
        try:
            self._check_workers()
            self._count_tasks()
            self._choose_parts()
            made = self._make(self._missing())
            if not self.job["folder"]:
                notes = sorted(made, key=lambda note: int(note["number"]))
                report = self._join(notes)
            else:
                try:
                    report = self._join(self._notes())
                except (VerbError, OSError, ValueError, KeyError):
                    # A part was damaged after it had been made: it is made again.
                    self.resume = True
                    again = self._missing()
                    if not again:
                        raise
                    self.say(f"{len(again)} of {self.job['parts']} parts were damaged, and are made again")
                    self._make(again)
                    report = self._join(self._notes())
            result = commands.Report(report)
            result["distributed"] = commands.Report(self._about())
            if self.output and _is_manifest(self.output) and not self.url:
                for file in [*Path(self.job["folder"]).iterdir()]:
                    if file.suffix != ".t4d":
                        file.unlink()
            elif self.job["folder"]:
                shutil.rmtree(self.job["folder"], ignore_errors=True)
            return result
        except (VerbError, DistributedError, OSError) as error:
            raise DistributedError(f"{_text(error)}{self._kept()}", getattr(error, "where", "")) from None

    def _about(self) -> Dict[str, Any]:
        begun = 0
        with contextlib.suppress(Exception):
            begun = len(self.client.get_events(self.job["run"]))
        return {
            "parts": self.job["parts"], "workers": len(self.client.scheduler_info()["workers"]),
            "retries": max(0, begun - (self.job["parts"] - self.resumed)), "resumed": self.resumed,
            "seconds": time.monotonic() - self.begun,
        }  # fmt: skip

    def _kept(self) -> str:
        folder = Path(self.job["folder"]) if self.job["folder"] else None
        if not folder or not folder.exists():
            return ""
        done = len(list(folder.glob("part-*-of-*.json")))
        if done == 0:
            with contextlib.suppress(OSError):
                (folder / "run.json").unlink()
                folder.rmdir()
            return ""
        known = f"{done} of {self.job['parts']}" if self.job["parts"] else f"{done}"
        return f"; {known} parts are finished in {folder}: --resume goes on with them"


def _text(error: Optional[BaseException]) -> str:
    if error is None:
        return ""
    if type(error).__name__ == "KilledWorker":
        return f"workers died while they made it, {_RETRIES + 1} times: {error}"
    return getattr(error, "message", "") or str(error) or type(error).__name__


def _joined_report(job: Dict[str, Any], notes: List[Dict[str, Any]]) -> Any:
    """The report on the whole; None for verbs of which only the files are joined."""
    if job["verb"] in ("sweep", "simplify"):
        return None
    own = Path(job["folder"]) / "reports" if job["folder"] else None
    import tempfile

    with tempfile.TemporaryDirectory(prefix="t4d-") as name:
        folder = own or Path(name)
        folder.mkdir(exist_ok=True)
        files = []
        for note in notes:
            files.append(str(folder / f"{note['number']}.json"))
            Path(files[-1]).write_text(json.dumps(note["report"]), encoding="utf-8")
        printed = commands.run_words(["join", *files], text=True)
        if own:
            shutil.rmtree(own, ignore_errors=True)
    return json.loads(printed, object_hook=commands.Report)


def _write_report(path: Path, report: Any) -> None:
    part = path.with_name(f".{path.name}.{uuid.uuid4().hex[:8]}")
    part.write_text(json.dumps(report, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
    part.replace(path)


@contextlib.contextmanager
def _workers(client: Any, local: Optional[int]) -> Iterator[Any]:
    """The client, or one with `local` workers on this machine."""
    if client is not None:
        yield client
        return
    dask = package("distributed")
    count = local or len(os.sched_getaffinity(0))
    with _interrupted_alone():
        cluster = dask.LocalCluster(
            n_workers=count, threads_per_worker=1, processes=True, dashboard_address=None,
            silence_logs=logging.CRITICAL,  # what fails is said here
        )  # fmt: skip
    with cluster, dask.Client(cluster) as own:
        yield own


@contextlib.contextmanager
def _interrupted_alone() -> Iterator[None]:
    """Processes that are started meanwhile ignore the terminal's Ctrl-C: this one ends them."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _check_output(verb: str, output: Optional[str]) -> None:
    if verb in REPORTS:
        if output and not output.endswith(".json"):
            raise DistributedError("reports are written as .json", output)
        return
    if not output:
        raise DistributedError(f"{verb} needs an output")
    if _is_url(output):
        if not _is_manifest(output):
            raise DistributedError("to an object store, a file in parts is written: name it .t4dm", output)
        return
    if verb in FOLDERS:
        if "%" in os.path.basename(output):
            raise DistributedError("name a folder for the frames, not a pattern of files", output)
        if os.path.exists(output) and (not os.path.isdir(output) or os.listdir(output)):
            raise DistributedError("is there already; name another folder", output)
    folder = os.path.dirname(os.path.abspath(output))
    if not os.path.isdir(folder):
        raise DistributedError("there is no such folder", folder)


def run(
    verb: str, words: Sequence[str], output: Optional[str] = None, *, client: Any = None,
    local: Optional[int] = None, parts: Optional[int] = None, resume: bool = False,
    seconds: float = _SECONDS, say: Callable[[str], None] = lambda text: None,
) -> Any:  # fmt: skip
    """A verb with the words of its command line, but for ``-o``, ``--json`` and ``--part``."""
    if verb not in MESHES + FOLDERS + REPORTS:
        known = ", ".join((*MESHES, *FOLDERS, *REPORTS))
        raise DistributedError(f"'{verb}' cannot be divided among workers; these can: {known}")
    if parts is not None and parts < 1:
        raise DistributedError(f"{parts} parts are asked for; at least 1 is possible")
    _check_output(verb, output)
    with _workers(client, local) as own:
        return _Run(own, verb, words, output, parts, resume, seconds, say).run()


def _function(verb: str) -> Callable[..., Any]:
    def function(
        files: Any, output: Any = None, *, client: Any = None, local: Optional[int] = None,
        parts: Optional[int] = None, resume: bool = False, seconds: float = _SECONDS, **options: Any,
    ) -> Any:  # fmt: skip
        names = [files] if isinstance(files, (str, bytes, os.PathLike)) else list(files)
        words = [*(os.fsdecode(name) for name in names), *commands.words_of(verb, options)]
        return run(
            verb, words, os.fsdecode(output) if output is not None else None, client=client, local=local,
            parts=parts, resume=resume, seconds=seconds,
        )  # fmt: skip

    function.__name__ = function.__qualname__ = verb
    function.__module__ = __name__
    what = (
        "Makes ``output``, a .t4d" if verb in MESHES
        else "Makes the folder ``output``" if verb in FOLDERS
        else "Makes a report, and writes it to ``output`` (.json) if that is given"
    )  # fmt: skip
    function.__doc__ = f"""``verbs.{verb}`` on many workers. {what}. ``options`` are those of the verb.

    ``client`` is a ``distributed.Client``; without one, ``local`` workers run on this machine (default: one
    for each core). ``parts`` is the number of parts (default: such that each takes ``seconds``); ``resume``
    takes up what an earlier run has finished. The report has ``distributed``: parts, workers, retries,
    resumed and seconds."""
    return function


weave = _function("weave")
sweep = _function("sweep")
compress = _function("compress")
simplify = _function("simplify")
frames = _function("frames")
voxelize = _function("voxelize")
rasterize = _function("rasterize")
measure = _function("measure")
track = _function("track")
validate = _function("validate")
quality = _function("quality")
collide = _function("collide")


# ---- the program t4d-distributed -------------------------------------------------------------


def _arguments() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="t4d-distributed", allow_abbrev=False,
        description="Run a verb of t4d on the workers of a Dask scheduler, or on several of this machine.",
        epilog="All other words are those of the verb: t4d VERB --help. Example: "
               "t4d-distributed weave frames/ -o movie.t4d --scheduler tcp://head:8786 --parts 400",
    )  # fmt: skip
    parser.add_argument("verb", metavar="VERB", help=", ".join((*MESHES, *FOLDERS, *REPORTS)))
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument("--scheduler", metavar="ADDRESS", help="address of a Dask scheduler: tcp://HOST:PORT")
    where.add_argument("--local", metavar="N", type=int, help="start N workers on this machine")
    parser.add_argument("--parts", metavar="N", type=int, help="number of parts (default: by --seconds)")
    parser.add_argument(
        "--seconds", metavar="S", type=float, default=_SECONDS,
        help=f"seconds that a part is meant to take (default: {_SECONDS:g})",
    )  # fmt: skip
    parser.add_argument("--resume", action="store_true", help="take up the finished parts of an earlier run")
    parser.add_argument("-o", "--output", metavar="FILE", help="output of the verb; of a report, .json")
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--version", action="version", version=f"t4d {t4d.__version__}")
    return parser


def _client(address: str) -> Any:
    try:
        return package("distributed").Client(address, timeout=5)
    except (OSError, ValueError, TimeoutError) as error:
        raise DistributedError(f"no scheduler answers at {address}: {error}") from None


def main(arguments: Optional[Sequence[str]] = None) -> int:
    options, words = _arguments().parse_known_args(arguments)
    try:
        package("distributed")
    except ImportError:
        print("t4d-distributed: needs Dask: install python3-distributed, or pip install distributed",
              file=sys.stderr)  # fmt: skip
        return 1
    for name in ("distributed", "distributed.client"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    terminal = sys.stderr.isatty()

    def say(text: str) -> None:
        if terminal:
            print(f"\r{text}\033[K", end="", file=sys.stderr, flush=True)

    client = None
    try:
        if options.local is not None and options.local < 1:
            raise DistributedError("--local: at least one worker is needed")
        client = _client(options.scheduler) if options.scheduler else None
        report = run(
            options.verb, words, options.output, client=client, local=options.local, parts=options.parts,
            resume=options.resume, seconds=options.seconds, say=say,
        )  # fmt: skip
    except (DistributedError, FileNotFoundError) as error:
        say("")
        print(f"t4d-distributed: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        say("")
        print("t4d-distributed: interrupted; --resume goes on with the finished parts", file=sys.stderr)
        return 130
    finally:
        if client is not None:
            _close(client)
    say("")
    about = report.pop("distributed")
    if options.json:
        print(json.dumps({**about, "report": report}, indent=2))
    else:
        print(
            f"{options.output or options.verb}: {_counted(about.parts, 'part')} on {_counted(about.workers, 'worker')} in "
            f"{about.seconds:.1f} s; {about.retries} retries, {about.resumed} taken up"
        )
        if options.verb in REPORTS and not options.output:
            print(json.dumps(report, indent=2))
    return 0


def _counted(count: int, what: str) -> str:
    return f"{count} {what}" if count == 1 else f"{count} {what}s"


def _close(client: Any) -> None:
    """A client whose scheduler has gone takes long to close."""
    closing = threading.Thread(target=lambda: client.close(timeout=2), daemon=True)
    closing.start()
    closing.join(5)


if __name__ == "__main__":
    # Workers know the functions by the name of this module.
    from t4d.distributed import main as main_of_module

    sys.exit(main_of_module())
