#!/usr/bin/env python3
"""Runs any reader of .t4d files against the corpus, without t4d:

    t4d-conformance --reader './my-reader' [--junit FILE] [--badge FILE]

The reader serves, as the appendix "A reader under test" of the specification of .t4d defines: it takes requests
such as `describe FILE` from standard input and answers each with a line `accept JSON` or `refuse WHY`. Exits with 0
if every case passed, 1 if one failed, 2 for wrong usage. One file, Python 3.9 or later, no other library; public domain
(CC0 1.0).
"""
import argparse
import contextlib
import json
import os
import re
import select
import shlex
import subprocess
import sys
import tempfile
import time
from collections import namedtuple
from concurrent.futures import ThreadPoolExecutor
from fnmatch import fnmatch
from html import escape
from pathlib import Path

TEXTS = ("name", "domain", "version", "features")  # and checksums: all else that is a string is a number
MOST_BYTES = 16 << 20  # of an answer
# The result says what the reader must do: "valid" accept, "invalid" refuse, "either".
Trial = namedtuple("Trial", "request result answer damage", defaults=(None, None))


def number(text):
    if not re.fullmatch("[-+.0-9A-Za-z]+", text if isinstance(text, str) else ""):
        raise ValueError
    return float.fromhex(text) if "x" in text.lower() else float(text)


def is_same(expected, actual, within, key):
    if not isinstance(expected, str) or key in TEXTS or key.endswith("checksum"):
        return actual == expected
    try:
        return abs(number(actual) - number(expected)) <= number(within or "0")
    except (ValueError, OverflowError):
        return False


def differences(expected, actual, within=None, key="", place="the answer"):
    """The places where the answer differs. `within` has tolerances, as in NAME.json."""
    if isinstance(expected, dict) and isinstance(actual, dict):
        for name, value in expected.items():
            inner = within
            if isinstance(within, dict):
                inner = within.get("length" if name in ("min", "max") else name)
            yield from differences(value, actual.get(name, b"missing"), inner, name, f"{place}.{name}")
    elif isinstance(expected, list) and isinstance(actual, list) and len(actual) == len(expected) and key not in TEXTS:
        for i, (right, given) in enumerate(zip(expected, actual)):
            inner = within[i] if isinstance(within, list) else within
            yield from differences(right, given, inner, "", f"{place}[{i}]")
    elif not is_same(expected, actual, within, key):
        yield f"{place} is {str(actual)[:80]}, not {str(expected)[:80]}"


def fault(trial, verdict, text):
    """What is wrong with the reader's answer, or None."""
    if verdict == "refuse":
        return f"refused a valid file: {text[:200]}" if trial.result == "valid" else None
    if trial.result == "invalid":
        return "accepted, but must be refused"
    try:
        return next(differences(trial.answer["answer"], json.loads(text), trial.answer["within"]), None)
    except ValueError as error:
        return f"accepted, and the answer is no JSON: {error}"


def noise(place):
    """The byte of pseudo-random garbage at this place (splitmix64)."""
    z = place + 0x9E3779B97F4A7C15 & 2**64 - 1
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9 & 2**64 - 1
    z = (z ^ z >> 27) * 0x94D049BB133111EB & 2**64 - 1
    return (z ^ z >> 31) & 0xFF


def damaged(data, damage):
    data = bytearray(data)
    if "flip" in damage:
        byte, bit = damage["flip"]
        data[byte] ^= 1 << bit
    for begin, size in damage.get("overwrite", []):
        ones = damage["with"] == "ones"
        data[begin:begin + size] = b"\xff" * size if ones else bytes(map(noise, range(begin, begin + size)))
    return bytes(data[:damage.get("cut")])


def cases(corpus, without=()):
    """(id, path, trials) of every case: valid files, the simplest first, then the others, then damaged ones."""
    def load(name):
        return json.loads((corpus / name).read_text(encoding="utf-8"))

    slices = {}  # answers by request, of each file that the reader knows
    files = load("manifest.json")["files"]
    files.sort(key=lambda each: (len(each["features"]), each["bytes"]) if each["result"] == "valid" else (1 << 60,))
    for each in files:
        name, result = each["file"], each["result"]
        trials = dict.fromkeys(["describe", *(f"slice {at}" for at in each.get("refused_slices", []))])
        if each["expected"]:
            known = load(each["expected"])
            slices[name] = {f"slice {answer['time']}": answer for answer in known["slices"]}
            trials = {"describe": known["describe"], **slices[name]}
            if "hyperplanes" not in without:
                trials.update((f"slice {answer['by']}", answer) for answer in known["sections"])
            if set(known["describe"]["answer"]["features"]) & set(without):
                del slices[name]
                trials, result = {"describe": None}, "invalid"
        yield each["id"], corpus / name, [Trial(request, result, answer) for request, answer in trials.items()]
    for each in load("damaged.json")["cases"]:
        if each["file"] in slices:
            trials = []
            for damage in each["trials"]:
                # A slice needs nothing of what is overwritten.
                answer = slices[each["file"]].get(damage["request"]) if "overwrite" in damage else None
                trials.append(Trial(damage["request"], "valid" if answer else "invalid", answer, damage))
            yield each["id"], corpus / each["file"], trials


class Reader:
    """A serving reader, started again after whatever is no answer."""

    def __init__(self, command, seconds):
        self.command, self.seconds, self.process, self.left = command, seconds, None, b""

    def ask(self, request, path):
        """(verdict, text): "accept" or "refuse", or "crashed" or "timed out" with the reason."""
        if not self.process:
            self.errors, self.left = tempfile.TemporaryFile(), b""
            self.process = subprocess.Popen([*self.command, "--serve"], bufsize=0, stdin=subprocess.PIPE,
                                            stdout=subprocess.PIPE, stderr=self.errors)
        end = time.monotonic() + self.seconds
        with contextlib.suppress(OSError):  # It has ended; how is found below.
            self.process.stdin.write(os.fsencode(f"{request} {path}\n"))
        while b"\n" not in self.left:
            if not self.has_more(max(0, end - time.monotonic())):
                return "timed out", self.end(f"no answer within {self.seconds} s")
            found = self.process.stdout.read(1 << 16)
            self.left += found
            if not found or len(self.left) > MOST_BYTES:
                return "crashed", self.end("16 MiB without a line end" if found else "ended instead of answering")
        line, self.left = self.left.split(b"\n", 1)
        verdict, _, text = line.decode("utf-8", "replace").partition(" ")
        return (verdict, text) if verdict in ("accept", "refuse") else ("crashed", self.end(f"answered {line[:80]!r}"))

    def has_more(self, seconds=0):
        """Whether it writes or ends within this time."""
        return self.process and (self.left or select.select([self.process.stdout], [], [], seconds)[0])

    def end(self, why=""):
        if self.process:
            with self.process as ended, self.errors:
                ended.kill()
                code = ended.wait()
                self.errors.seek(0)
                said = self.errors.read()[-300:].decode("utf-8", "replace").strip()
            self.process, why = None, f"{why} (exit code {code}): {said}"
        return why


def run(chosen, reader, jobs=1, seconds=60, first=False):
    """{id: (outcome, message), or None where all is right} of the cases [(id, path, trials)] that were tried."""
    results, left, outcomes = {}, iter(chosen), []

    def work(file):
        served, last = Reader(reader, seconds), None

        def late():
            if served.has_more():
                outcomes.append("crashed")
                results[last] = results[last] or ("crashed", served.end("wrote or ended after its answer"))

        for name, path, trials in left:  # which the threads share
            # A reader that waits for ever is asked some times more, not thousands of times.
            if first and outcomes or outcomes.count("timed out") > 20:
                break
            data, results[name] = path.read_bytes(), None
            for trial in trials:
                late()
                file.write_bytes(damaged(data, trial.damage) if trial.damage else data)
                outcome, text = served.ask(trial.request, file)
                last = name
                if outcome in ("accept", "refuse"):
                    outcome, text = "failed", fault(trial, outcome, text)
                if text:
                    outcomes.append(outcome)
                    results[name] = outcome, f"{trial.request} {trial.damage or ''}: {text}"
                    served.end()  # What it keeps from this request is not to mislead the next.
                    break
        late()
        served.end()

    with tempfile.TemporaryDirectory(prefix="t4d-conformance-") as folder, ThreadPoolExecutor(jobs) as pool:
        list(pool.map(work, [Path(folder) / f"{i}.t4d" for i in range(jobs)]))
    return {case[0]: results[case[0]] for case in chosen if case[0] in results}


def junit(results):
    lines = ['<?xml version="1.0" encoding="UTF-8"?>', f'<testsuite name="t4d-conformance" tests="{len(results)}" '
             f'failures="{sum(map(bool, results.values()))}">']
    for name, wrong in results.items():
        kind, name = map(escape, name.split("/"))
        found = f'<failure message="{escape(re.sub("[^ -~]", "?", wrong[1]))}"/>' if wrong else ""
        lines.append(f'<testcase classname="{kind}" name="{name}">{found}</testcase>')
    return "\n".join([*lines, "</testsuite>\n"])


def badge(results, version):
    passed = sum(not wrong for wrong in results.values())
    left, right = f".t4d corpus {version}", f"{passed} of {len(results)}"
    color = "#2e7d32" if passed == len(results) else "#c62828"
    return f'''<svg xmlns="http://www.w3.org/2000/svg" width="240" height="20" role="img" aria-label="{left}: {right}">
<rect width="130" height="20" fill="#444"/><rect x="130" width="110" height="20" fill="{color}"/>
<g fill="#fff" text-anchor="middle" font-family="sans-serif" font-size="11">
<text x="65" y="14">{left}</text><text x="185" y="14">{right}</text></g></svg>
'''


def main(arguments=None):
    parser = argparse.ArgumentParser(description="Runs a serving reader of .t4d files against the corpus.")
    parser.add_argument("--reader", required=True, metavar="COMMAND", help="is started with --serve")
    parser.add_argument("--corpus", type=Path, default=Path(__file__).resolve().parent / "corpus", metavar="FOLDER")
    parser.add_argument("--only", action="append", metavar="GLOB", help="run only these cases; repeatable")
    parser.add_argument("--without", default="", metavar="NAMES",
                        help="what the reader lacks, with commas: zstd, means, pose, grid, hyperplanes")
    parser.add_argument("--junit", type=Path, metavar="FILE", help="write a report for CI")
    parser.add_argument("--badge", type=Path, metavar="FILE", help="write a picture for a README (SVG)")
    parser.add_argument("--json", action="store_true", help="print the outcome of each case as JSON")
    parser.add_argument("--first", action="store_true", help="stop at the first fault")
    parser.add_argument("--timeout", type=float, default=60, metavar="SECONDS", help="per request")
    parser.add_argument("--parallel", type=int, default=os.cpu_count(), metavar="N")
    options = parser.parse_args(arguments)
    version = (options.corpus / "VERSION").read_text().split()[1]
    chosen = [case for case in cases(options.corpus, options.without.split(",")) if not options.only or any(
        fnmatch(name, each) for name in (case[0], *case[0].split("/")) for each in options.only)]
    if not chosen:
        parser.error("no case has such a name")
    results = run(chosen, shlex.split(options.reader), options.parallel, options.timeout, options.first)
    for file, text in (options.junit, junit(results)), (options.badge, badge(results, version)):
        if file:
            file.write_text(text)
    wrong = {name: found for name, found in results.items() if found}
    if options.json:
        print(json.dumps({"corpus_version": version, "cases": [
            {"id": name, "outcome": found[0] if found else "passed"} for name, found in results.items()]}))
    else:
        for name, (outcome, text) in list(wrong.items())[:20]:
            print(f"{outcome} {name}\n  {text}")
        print(f"{len(results) - len(wrong)} passed, {len(wrong)} failed (corpus {version})")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
