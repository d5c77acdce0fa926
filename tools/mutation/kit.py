"""Judges mutants of the reader in Python by the cases of the conformance kit, all in one process that forks for
each mutant: a start of the reader for each of a thousand mutants would take hours.

Run as a program, with the folder of a corpus, it reads sources of the reader from standard input, each as its length in
bytes and a line end, then the bytes, and answers with a line of JSON: the case that notices the mutant, or null. The
first source has to be the reader as it is. It shows which cases reach which statements, and what they take: a mutant is
tried with those that reach its statement, first those that break its rule, then those that notice others of the same
block, then the quickest. A second argument is the processor time after which a first run of a case is given up: such a
case comes last, and with every mutant.
"""

import ast
import gc
import importlib.util
import json
import os
import re
import resource
import signal
import subprocess
import sys
import tempfile
import threading
import time
import types
from collections import Counter, defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# A request to a mutant may take that many times its usual processor time, and some seconds.
TIMES, SECONDS = 10, 2
MOST_BYTES = 4 << 30
# What no case takes, in seconds.
LONGEST = 2


def load_runner():
    spec = importlib.util.spec_from_file_location(
        "t4d_conformance", ROOT / "conformance/package/python/t4d_conformance.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


RUNNER = load_runner()


class Late(BaseException):
    """A request takes too long. No `except Exception` of the reader catches it."""


def late(*_):
    raise Late


class Case:
    def __init__(self, name, trial, path):
        self.name, self.trial, self.path, self.seconds = name, trial, path, 0.0
        self.reached = b""  # a byte for each block


def cases(corpus, folder):
    """Every request to a reader. Damaged copies are written into the folder."""
    made = []
    for name, path, trials in RUNNER.cases(corpus):
        for trial in trials:
            file = path
            if trial.damage:
                file = folder / f"{len(made)}.t4d"
                file.write_bytes(RUNNER.damaged(path.read_bytes(), trial.damage))
            made.append(Case(f"{name}: {trial.request}", trial, str(file)))
    return made


class Checksums:
    """CRC-32C as the reader computes it, once for the same bytes."""

    def __init__(self, right):
        self.right, self.known = right, {}

    def __call__(self, data, before=0):
        key = bytes(data), before
        if key not in self.known:
            self.known[key] = self.right(*key)
        return self.known[key]


class Blocks(ast.NodeTransformer):
    """Makes each sequence of statements in functions note that it was reached: `reached[its number] = 1`."""

    def __init__(self, source):
        self.spans = []  # first and last line of each, outer ones first
        self.tree = ast.fix_missing_locations(self.visit(ast.parse(source)))
        self.reached = bytearray(len(self.spans))

    def generic_visit(self, node):
        inside = isinstance(node, (ast.FunctionDef, ast.If, ast.For, ast.While, ast.With, ast.Try, ast.ExceptHandler))
        for name in ("body", "orelse", "finalbody") if inside else ():
            if statements := getattr(node, name, []):
                self.spans.append((statements[0].lineno, statements[-1].end_lineno))
                mark = ast.parse(f"reached[{len(self.spans) - 1}] = 1").body
                setattr(node, name, mark + statements)
        return super().generic_visit(node)

    def of_line(self, line):
        """The innermost block that has the line, or None."""
        having = [i for i, (first, last) in enumerate(self.spans) if first <= line <= last]
        return having[-1] if having else None


def reader_of(source, **more):
    module = types.ModuleType("t4d_reader")
    module.__dict__.update(more)
    sys.modules["t4d_reader"] = module
    exec(compile(source, "t4d_reader.py", "exec"), module.__dict__)
    return module


def free(case):
    """What a reader leaves in cycles, where it may be large."""
    if case.seconds > 0.1:
        gc.collect()


def fault(reader, case):
    """What is wrong with the reader's answer, or None."""
    words = case.trial.request.split()
    request = reader.request_of(words)
    if not request:
        return "does not know the request"
    code, found = reader.answer(case.path, *request)
    if code > 1:
        return f"crashed: {found}"
    return RUNNER.fault(case.trial, "refuse" if code else "accept", found if code else json.dumps(found))


def noticed(source, ordered, checksums, own_checksums):
    """(number of the case that notices the mutant, how), or None."""
    try:
        reader = reader_of(source)
    except Exception as error:
        return 0, f"does not start: {error}"
    if not own_checksums:
        reader.crc32c = checksums
    for number in ordered:
        case = ALL[number]
        signal.setitimer(signal.ITIMER_PROF, TIMES * case.seconds + SECONDS)
        try:
            wrong = fault(reader, case)
        except Late:
            wrong = "takes too long"
        except Exception as error:
            wrong = f"crashed: {error!r}"
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0)
        free(case)
        if wrong:
            return number, wrong
    return None


def in_a_child(job):
    """What job() returns, as JSON, or None where the child ends otherwise."""
    out, into = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(out)
        resource.setrlimit(resource.RLIMIT_AS, (MOST_BYTES, MOST_BYTES))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        with open(os.devnull, "w") as nowhere:
            os.dup2(nowhere.fileno(), 1)
            os.dup2(nowhere.fileno(), 2)
        with open(into, "w") as answer:
            json.dump(job(), answer)
        os._exit(0)
    os.close(into)
    with open(out) as answer:
        text = answer.read()
    _, status = os.waitpid(child, 0)
    return json.loads(text) if status == 0 else [0, f"ends with status {status}"]


def measure(reader, reached, patience):
    for case in ALL:
        reached[:] = bytes(len(reached))
        begin = time.process_time()
        signal.setitimer(signal.ITIMER_PROF, patience)
        try:
            wrong = fault(reader, case)
            case.seconds, case.reached = time.process_time() - begin, bytes(reached)
        except Late:
            wrong, case.seconds, case.reached = None, LONGEST, b"\1" * len(reached)
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0)
        free(case)
        if wrong:
            raise SystemExit(f"the reader as it is fails in {case.name}: {wrong}")


def line_of(right, source):
    """The line of the first byte that differs."""
    return right.count(b"\n", 0, len(os.path.commonprefix([right, source]))) + 1


def rules_at(source, line):
    """The rules that the statement of the line names, or a line beside it."""
    near = source.decode().splitlines()[max(0, line - 2):line + 3]
    return tuple(f"invalid/{rule}-" for rule in re.findall(r'"([A-Z]\d+)"', "\n".join(near)))


def serve(patience):
    killers, of_block = Counter(), defaultdict(Counter)
    checksums = None
    stream = sys.stdin.buffer
    out = os.fdopen(os.dup(1), "w")
    while length := stream.readline():
        source = stream.read(int(length))
        if checksums is None:
            right, blocks = source, Blocks(source)
            reader = reader_of(blocks.tree, reached=blocks.reached)
            at_start = bytes(blocks.reached)
            checksums = reader.crc32c = Checksums(reader.crc32c)
            measure(reader, blocks.reached, patience)
            gc.freeze()
            print(json.dumps(len(ALL)), file=out, flush=True)
            continue
        begin, end = right.index(b"def crc_table"), right.index(b"def padded")
        own = source[begin:end] != right[begin:end]
        line = line_of(right, source)
        block, rules = blocks.of_line(line), rules_at(right, line)
        # Those of checksums are not reached where a checksum is known already.
        by_all = block is None or own or at_start[block]
        reaching = [i for i, case in enumerate(ALL) if by_all or case.reached[block]]
        # The mutants before tell which cases notice most.
        ordered = sorted(reaching, key=lambda i: (not ALL[i].name.startswith(rules), -of_block[block][i],
                                                  -killers[i] if killers[i] > 2 else 0, ALL[i].seconds))
        found = in_a_child(lambda: noticed(source, ordered, checksums, own))
        if found:
            killers[found[0]] += 1
            of_block[block][found[0]] += 1
            found = {"by": ALL[found[0]].name, "how": found[1][:200]}
        print(json.dumps(found), file=out, flush=True)


class Worker(threading.local):
    """A process that judges, one for each thread."""

    process = None
    patience = LONGEST

    def judge(self, corpus, right, source):
        """The case that notices that the reader has another source, and how; or None."""
        if not self.process:
            self.process = subprocess.Popen(["/usr/bin/python3", "-S", __file__, str(corpus), str(self.patience)],
                                            stdin=subprocess.PIPE, stdout=subprocess.PIPE)
            self.ask(right)
        return self.ask(source)

    def ask(self, source):
        self.process.stdin.write(b"%d\n" % len(source) + source)
        self.process.stdin.flush()
        line = self.process.stdout.readline()
        if not line:
            raise SystemExit("tools/mutation/kit.py has ended")
        return json.loads(line)


if __name__ == "__main__":
    signal.signal(signal.SIGPROF, late)
    gc.disable()  # It takes a fifth of the time; free() makes up for it.
    with tempfile.TemporaryDirectory(prefix="t4d-mutate-") as made:
        ALL = cases(Path(sys.argv[1]), Path(made))
        serve(float(sys.argv[2]))
