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
# A test with a mutant may take that many times its own time, and some seconds.
TIMES, SECONDS = 5, 10
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


def limits():
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_DATA, (MOST_BYTES, MOST_BYTES))
    resource.setrlimit(resource.RLIMIT_FSIZE, (MOST_FILE_BYTES, MOST_FILE_BYTES))


def run(test, seconds, **variables):
    """"passed", "failed" or "timed out"."""
    scratch = tempfile.mkdtemp(prefix="t4d-mutate-")
    environment = {**os.environ, **test.environment, "TMPDIR": scratch, **variables}
    process = subprocess.Popen(test.command, cwd=test.folder, env=environment,
                               stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                               stderr=subprocess.DEVNULL, start_new_session=True, preexec_fn=limits)
    try:
        return "passed" if process.wait(seconds) == 0 else "failed"
    except subprocess.TimeoutExpired:
        return "timed out"
    finally:
        # What the test started ends with it.
        try:
            os.killpg(process.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        process.wait()
        shutil.rmtree(scratch, ignore_errors=True)


def trace(all_tests, jobs, longest, say):
    """Runs each test as it is; returns those that pass, with their times and what they reach."""
    folder = FOLDER / "traces"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)

    def one(job):
        number, test = job
        if ended.is_set():
            return test, "was not run"
        file = folder / str(number)
        begin = time.monotonic()
        outcome = run(test, longest, T4D_MUTANT_TRACE=str(file))
        test.seconds = time.monotonic() - begin
        if file.exists():
            test.reaches = {int(line) for line in file.read_text().split()}
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
    return sorted(good, key=lambda test: test.seconds)


def judge(mutant, all_tests, budget):
    """What becomes of a mutant: as in the report. `all_tests` are in the order of their times."""
    reaching = [test for test in all_tests if mutant.number in test.reaches]
    begin = time.monotonic()
    done = 0
    for test in reaching:
        if time.monotonic() - begin > budget or ended.is_set():
            break
        outcome = run(test, TIMES * test.seconds + SECONDS, T4D_MUTANT=str(mutant.number))
        done += 1
        if outcome != "passed":
            return {"outcome": "killed", "by": test.name, "how": outcome, "reached by": len(reaching)}
    if not reaching and mutant.constant:
        return {"outcome": "not built", "why": "evaluated by the compiler"}
    return {"outcome": "survived", "reached by": len(reaching), "tests run": done,
            "tests": [test.name for test in reaching[:200]]}
