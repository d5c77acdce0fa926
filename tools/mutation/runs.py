"""Runs tests: all once, to learn which mutants each reaches, then the mutants."""

import json
import os
import re
import resource
import shutil
import signal
import subprocess
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

from .tree import BUILD, FOLDER

# A mutant may take memory without end, or write so.
MOST_BYTES = 6 << 30
MOST_FILE_BYTES = 4 << 30
# A test with a mutant may take that many times its own processor time, and some seconds. Limits are
# of processor time, as a busy machine must not decide; one that waits for ever ends at LONGEST.
TIMES, SECONDS = 5, 10
LONGEST = 600
# Set when the user interrupts: no further test starts.
ended = threading.Event()


@dataclass
class Test:
    name: str
    command: list
    folder: str
    environment: dict
    seconds: float = 0
    reaches: set = field(default_factory=set)


def tests(left_out):
    listed = json.loads(subprocess.run(["ctest", "--test-dir", BUILD, "--show-only=json-v1"],
                                       check=True, capture_output=True, text=True).stdout)
    found = []
    for test in listed["tests"]:
        properties = {p["name"]: p["value"] for p in test.get("properties", [])}
        if properties.get("DISABLED") or re.search(left_out, test["name"]):
            continue
        variables = dict(v.split("=", 1) for v in properties.get("ENVIRONMENT", []))
        found.append(Test(test["name"], test["command"],
                          properties.get("WORKING_DIRECTORY", str(BUILD)), variables))
    return found


def limit(seconds):
    """Limits the process of a test before it starts."""
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_CPU, (int(seconds) + 1, int(seconds) + 2))
    resource.setrlimit(resource.RLIMIT_DATA, (MOST_BYTES, MOST_BYTES))
    resource.setrlimit(resource.RLIMIT_FSIZE, (MOST_FILE_BYTES, MOST_FILE_BYTES))


def run(test, seconds, **variables):
    """"passed", "failed" or "timed out", and the processor time."""
    scratch = tempfile.mkdtemp(prefix="t4d-mutate-")
    environment = {**os.environ, **test.environment, "TMPDIR": scratch, **variables}
    process = subprocess.Popen(test.command, cwd=test.folder, env=environment,
                               stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                               stderr=subprocess.DEVNULL, start_new_session=True,
                               preexec_fn=lambda: limit(seconds))
    begin = time.monotonic()
    pause = 0.002
    ended_by = 0
    while not ended_by:
        ended_by, status, usage = os.wait4(process.pid, os.WNOHANG)
        if not ended_by and time.monotonic() - begin > LONGEST:
            break
        time.sleep(pause)
        pause = min(2 * pause, 0.05)
    try:
        os.killpg(process.pid, signal.SIGKILL)  # what the test started ends with it
    except ProcessLookupError:
        pass
    if not ended_by:
        _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    shutil.rmtree(scratch, ignore_errors=True)
    used = usage.ru_utime + usage.ru_stime
    if process.returncode == 0:
        return "passed", used
    return "timed out" if not ended_by or used >= seconds else "failed", used


def stamp(test):
    """The times when the programs that a test runs were built."""
    programs = [Path(test.command[0]), *BUILD.glob("t4d*")]
    return [p.stat().st_mtime_ns for p in programs if p.is_file() and os.access(p, os.X_OK)]


def trace(all_tests, jobs, longest, say):
    """Runs each test as it is; returns those that pass, with their times and what they reach. Tests
    whose programs are those of the last time are not run again."""
    folder = FOLDER / "traces"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    kept_file = FOLDER / "traces.json"
    kept = json.loads(kept_file.read_text()) if kept_file.exists() else {}

    def one(job):
        number, test = job
        if ended.is_set():
            return test, "was not run"
        last = kept.get(test.name)
        if last and last["stamp"] == stamp(test) and last["longest"] == longest:
            test.seconds, test.reaches = last["seconds"], set(last["reaches"])
            return test, last["outcome"]
        file = folder / str(number)
        outcome, test.seconds = run(test, longest, T4D_MUTANT_TRACE=str(file))
        if file.exists():
            test.reaches = {int(line) for line in file.read_text().split()}
        kept[test.name] = {"stamp": stamp(test), "longest": longest, "outcome": outcome,
                           "seconds": test.seconds, "reaches": sorted(test.reaches)}
        return test, outcome

    good = []
    pool = ThreadPoolExecutor(jobs)
    try:
        for test, outcome in pool.map(one, enumerate(all_tests)):
            if outcome == "passed":
                good.append(test)
            else:
                say(f"without a mutant {test.name} {outcome}: left out")
    except KeyboardInterrupt:
        ended.set()
        raise
    finally:
        pool.shutdown(cancel_futures=True)
        kept_file.write_text(json.dumps(kept))
    return sorted(good, key=lambda test: test.seconds)


def judge(mutant, all_tests, budget):
    """What becomes of a mutant: as in the report. `all_tests` are in the order of their times; those
    of the mutant's own folder are the first to notice it."""
    own = f"/release/{Path(mutant.file).parts[0]}/"
    reaching = [test for test in all_tests if mutant.number in test.reaches]
    reaching.sort(key=lambda test: own not in test.command[0])
    done, used = 0, 0
    for test in reaching:
        if used > budget or ended.is_set():
            break
        outcome, seconds = run(test, TIMES * test.seconds + SECONDS, T4D_MUTANT=str(mutant.number))
        done += 1
        used += seconds
        if outcome != "passed":
            return {"outcome": "killed", "by": test.name, "how": outcome, "reached by": len(reaching)}
    if not reaching and mutant.constant:
        return {"outcome": "not built", "why": "evaluated by the compiler"}
    return {"outcome": "survived", "reached by": len(reaching), "tests run": done,
            "tests": [test.name for test in reaching[:200]]}
