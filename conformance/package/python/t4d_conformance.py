#!/usr/bin/env python3
"""Runs any reader of .t4d files against the corpus, without t4d:

    t4d-conformance --reader './my-reader' [--junit FILE] [--badge FILE]

The reader serves, as the appendix "A reader under test" of the specification of .t4d defines: it takes requests
such as `describe FILE` from standard input and answers each with a line `accept JSON` or `refuse WHY`. Exits with 0
if every case passed, 1 if one failed, 2 for wrong usage. One file, Python 3.9 or later, no other library; public domain
(CC0 1.0).
"""
import argparse
import fnmatch
import json
import os
import re
import select
import shlex
import subprocess
import sys
import tempfile
import threading
import time
from html import escape
from pathlib import Path

TEXTS = ("name", "domain", "version", "features")  # and checksums: all else that is a string is a number
BINARY64 = re.compile(r"[+-]?(0x[0-9a-f]*\.?[0-9a-f]*(p[+-]?\d+)?|\d*\.?\d*(e[+-]?\d+)?|inf(inity)?|nan)", re.I)
MOST_BYTES = 16 << 20  # of an answer


# What must be answered ----------------------------------------------------------------------------

def number(text):
    if not isinstance(text, str) or not text or not BINARY64.fullmatch(text):
        raise ValueError
    return float.fromhex(text) if "x" in text.lower() else float(text)


def difference(expected, actual, within=None, path=""):
    """The first place where the answer differs, or None. `within` has tolerances, as in NAME.json."""
    if isinstance(expected, dict):
        if not isinstance(actual, dict):
            return f"{path or 'the answer'} is not an object"
        for key, value in expected.items():
            inner, place = within, f"{path}.{key}".lstrip(".")
            if isinstance(within, dict):
                inner = within.get(key, within.get("length") if key in ("min", "max") else None)
            if key not in actual:
                return f"{place} is missing"
            if key in TEXTS or key.endswith("checksum"):
                found = None if actual[key] == value else f"{place} is {actual[key]!r}, not {value!r}"
            else:
                found = difference(value, actual[key], inner, place)
            if found:
                return found
    elif isinstance(expected, list):
        if not isinstance(actual, list) or len(actual) != len(expected):
            return f"{path} has not {len(expected)} entries"
        for i, (right, given) in enumerate(zip(expected, actual)):
            inner = within[i] if path == "bodies" and isinstance(within, list) else within
            found = difference(right, given, inner, f"{path}[{i}]")
            if found:
                return found
    elif expected is None:
        return None if actual is None else f"{path} is not null"
    else:
        try:
            right, given = number(expected), number(actual)
        except (ValueError, OverflowError):
            return f"{path} is {actual!r}, which is no number"
        allowed = number(within) if isinstance(within, str) else 0
        return None if abs(given - right) <= allowed else f"{path} is {actual}, not {expected}"
    return None


class Trial:
    """A request; `result` says what the reader must do: "valid" accept, "invalid" refuse, "either"."""

    def __init__(self, request, result, answer=None, damage=None):
        self.request, self.result, self.answer, self.damage = request, result, answer, damage

    def fault(self, verdict, text):
        """The fault of the reader's answer, or None."""
        if verdict == "refuse":
            return f"refused a valid file: {text[:200]}" if self.result == "valid" else None
        if self.result == "invalid":
            return "accepted, but must be refused"
        try:
            return difference(self.answer["answer"], json.loads(text), self.answer["within"])
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
    if "cut" in damage:
        del data[damage["cut"]:]
    elif "flip" in damage:
        byte, bit = damage["flip"]
        data[byte] ^= 1 << bit
    else:
        for begin, size in damage["overwrite"]:
            ones = damage["with"] == "ones"
            data[begin:begin + size] = b"\xff" * size if ones else bytes(map(noise, range(begin, begin + size)))
    return bytes(data)


def cases(corpus, without=()):
    """(id, path, trials) of every case: valid files, the simplest first, then the others, then damaged ones."""
    def load(name):
        return json.loads((corpus / name).read_text(encoding="utf-8"))

    def order(entry):
        rank = {"valid": 0, "either": 1, "invalid": 2}[entry["result"]]
        return (rank, len(entry["features"]), entry["bytes"]) if rank == 0 else (rank, 0, 0)

    answers, unknown = {}, set()
    for entry in sorted(load("manifest.json")["files"], key=order):
        path, result, trials = corpus / entry["file"], entry["result"], []
        if entry["expected"]:
            known = load(entry["expected"])
            answers[entry["file"]] = {f"slice {each['time']}": each for each in known["slices"]}
            if set(known["describe"]["answer"]["features"]) & set(without):
                unknown.add(entry["file"])
                yield entry["id"], path, [Trial("describe", "invalid")]
                continue
            trials.append(Trial("describe", result, known["describe"]))
            trials += [Trial(request, result, each) for request, each in answers[entry["file"]].items()]
            if "hyperplanes" not in without:
                trials += [Trial(f"slice {each['by']}", result, each) for each in known["sections"]]
        else:
            trials = [Trial(request, result) for request in
                      ["describe", *(f"slice {at}" for at in entry.get("refused_slices", []))]]
        yield entry["id"], path, trials
    for each in load("damaged.json")["cases"]:
        if each["file"] not in unknown:
            yield each["id"], corpus / each["file"], [
                Trial(damage["request"], "valid", answers[each["file"]][damage["request"]], damage)
                if "overwrite" in damage and damage["request"] != "describe"
                else Trial(damage["request"], "invalid", None, damage) for damage in each["trials"]]


# The reader ---------------------------------------------------------------------------------------

class Reader:
    """A serving reader, started again after whatever is no answer."""

    def __init__(self, command, seconds):
        self.command, self.seconds, self.process, self.left = command, seconds, None, b""

    def ask(self, request, path):
        """(verdict, text): "accept" or "refuse", or "crashed" or "timed out" with the reason."""
        if not self.process:
            self.errors, self.left = tempfile.TemporaryFile(), b""
            self.process = subprocess.Popen([*self.command, "--serve"], stdin=subprocess.PIPE,
                                            stdout=subprocess.PIPE, stderr=self.errors)
        end = time.monotonic() + self.seconds
        try:
            self.process.stdin.write(os.fsencode(f"{request} {path}\n"))
            self.process.stdin.flush()
        except OSError:
            pass  # It has ended; how is found below.
        while b"\n" not in self.left:
            if not select.select([self.process.stdout], [], [], max(0, end - time.monotonic()))[0]:
                return self.end("timed out", f"no answer within {self.seconds} s")
            found = os.read(self.process.stdout.fileno(), 1 << 16)
            self.left += found
            if not found or len(self.left) > MOST_BYTES:
                return self.end("crashed", "ended instead of answering" if not found else "16 MiB without a line end")
        line, self.left = self.left.split(b"\n", 1)
        verdict, _, text = line.decode("utf-8", "replace").partition(" ")
        if verdict not in ("accept", "refuse"):
            return self.end("crashed", f"answered {line[:80]!r}")
        return verdict, text

    def late_fault(self):
        """What it did after its last answer, though it was not asked; or None."""
        if self.process and (self.left or select.select([self.process.stdout], [], [], 0)[0]):
            return self.end("crashed", "wrote or ended after its answer")[1]
        return None

    def end(self, verdict="", why=""):
        if self.process:
            self.process.kill()
            code = self.process.wait()
            self.process.stdin.close()
            self.process.stdout.close()
            self.errors.seek(0)
            said = self.errors.read()[-300:].decode("utf-8", "replace").strip()
            self.errors.close()
            why, self.process = f"{why} (exit code {code}){': ' + said if said else ''}", None
        return verdict, why


def run(corpus, reader, chosen, jobs=1, seconds=60, first=False, say=lambda text: None):
    """{id: [(outcome, message)]} of the cases [(id, path, trials)]; outcomes are as in the summary."""
    results, queue, lock = {case[0]: [] for case in chosen}, iter(chosen), threading.Lock()
    slow = []  # A reader that waits for ever is asked some times more, not thousands of times.

    def work(folder):
        served, last = Reader(reader, seconds), None
        while True:
            with lock:
                case = next(queue, None)
            if not case or len(slow) > 20 or first and any(results.values()):
                break
            name, path, trials = case
            data = path.read_bytes()
            for trial in trials:
                if last and (late := served.late_fault()):
                    results[last].append(("crashed", late))
                file, last = Path(folder) / "file.t4d", name
                file.write_bytes(damaged(data, trial.damage) if trial.damage else data)
                verdict, text = served.ask(trial.request, file)
                about = trial.request + (f", {json.dumps(trial.damage)[:80]}" if trial.damage else "")
                if verdict not in ("accept", "refuse"):
                    results[name].append((verdict, f"{about}: {text}"))
                    if verdict == "timed out":
                        slow.append(name)
                        if slow.count(name) > 1:
                            break
                elif fault := trial.fault(verdict, text):
                    results[name].append(("failed", f"{about}: {fault}"))
                    served.end()  # What it keeps from this request is not to mislead the next.
        if last and (late := served.late_fault()):
            results[last].append(("crashed", late))
        served.end()

    with tempfile.TemporaryDirectory(prefix="t4d-conformance-") as folder:
        threads = [threading.Thread(target=work, args=(tempfile.mkdtemp(dir=folder),)) for _ in range(jobs)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    return results


# Reports ------------------------------------------------------------------------------------------

def junit(results):
    failed = sum(bool(wrong) for wrong in results.values())
    return "\n".join([
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<testsuite name="t4d-conformance" tests="{len(results)}" failures="{failed}">',
        *(f'<testcase classname="{escape(name.split("/")[0])}" name="{escape(name.split("/")[1])}">' + "".join(
            f'<failure message="{escape(re.sub("[^ -~]", "?", text))}"/>' for _, text in wrong[:1]) + "</testcase>"
          for name, wrong in results.items()), "</testsuite>", ""])


def badge(results, version):
    passed = sum(not wrong for wrong in results.values())
    text, color = f"{passed} of {len(results)}", "#2e7d32" if passed == len(results) else "#c62828"
    left, right = f".t4d corpus {version}", 8 * len(text) + 10
    return (f'<svg xmlns="http://www.w3.org/2000/svg" width="{130 + right}" height="20" role="img" '
            f'aria-label="{left}: {text}"><rect width="130" height="20" fill="#444"/><rect x="130" width="{right}" '
            f'height="20" fill="{color}"/><g fill="#fff" text-anchor="middle" font-family="sans-serif" '
            f'font-size="11"><text x="65" y="14">{left}</text><text x="{130 + right / 2:g}" y="14">{text}</text>'
            "</g></svg>\n")


def main(arguments=None):
    here = Path(__file__).resolve().parent
    parser = argparse.ArgumentParser(description="Runs a serving reader of .t4d files against the corpus.")
    parser.add_argument("--reader", required=True, metavar="COMMAND", help="is started with --serve")
    parser.add_argument("--corpus", type=Path, default=here / "corpus", metavar="FOLDER")
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
    chosen = [case for case in cases(options.corpus, options.without.split(","))
              if not options.only or any(fnmatch.fnmatch(case[0], each) or fnmatch.fnmatch(case[0], each + "/*")
                                         or fnmatch.fnmatch(case[0].split("/")[1], each) for each in options.only)]
    if not chosen:
        parser.error("no case has such a name")
    results = run(options.corpus, shlex.split(options.reader), chosen, options.parallel, options.timeout, options.first)
    if options.junit:
        options.junit.write_text(junit(results))
    if options.badge:
        options.badge.write_text(badge(results, version))
    wrong = {name: found for name, found in results.items() if found}
    if options.json:
        print(json.dumps({"corpus_version": version, "cases": [
            {"id": name, "outcome": found[0][0] if found else "passed"} for name, found in results.items()]}))
    else:
        for name, found in list(wrong.items())[:20]:
            print(f"{found[0][0]} {name}\n  {found[0][1]}" + (f"; and {len(found) - 1} more" if found[1:] else ""))
        print(f"{len(results) - len(wrong)} passed, {len(wrong)} failed (corpus {version})")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
