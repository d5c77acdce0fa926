"""Mutants of the checks of the reader in C++, which serves the cases of the conformance kit: all are compiled at once
into the few sources in which the build has the library of .t4d files, and linked with the rest of the build."""

import json
import re
import shlex
import shutil
import subprocess
import tempfile
from collections import Counter, defaultdict
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from . import kit, schemata, tree
from .rooms import ROOT

BUILD = ROOT / "build/release"
FOLDER = tree.FOLDER / "cpp reader"
PROGRAM = FOLDER / "t4d-reader"
# What a mutant may take: memory in bytes, processor time in all, and seconds for a request.
MOST_BYTES, MOST_SECONDS, SECONDS = 4 << 30, 30, 60
LARGE = 1 << 20  # Such files are described, and not sliced, which takes long.


def find(files):
    from .find import find  # needs the bindings of clang

    return find(files, BUILD / "compile_commands.json", tree.FOLDER / "found")


def write(path, text):
    """Files that stay the same keep their times."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.exists() or path.read_bytes() != text:
        path.write_bytes(text)


def compile_unit(entry, mutated):
    """(object, messages): one of the sources of the library, or one that includes several; some have mutants."""
    unit = Path(entry["file"])
    source = FOLDER / unit.name
    text = unit.read_text() if "Unity" in unit.parts else f'#include "{unit}"\n'
    text = re.sub(rf'"{ROOT}/(.*)"', lambda found: f'"{FOLDER / found[1]}"' if found[1] in mutated else found[0], text)
    write(source, text.encode())
    words = shlex.split(re.sub(r"-include \S+", "", entry["command"]))
    flags = [word for word in words[words.index("-o") + 2:] + words[:words.index("-o")]
             if not word.startswith(("-W", "-O")) and word not in ("-c", entry["file"])]
    made = source.with_suffix(".o")
    cached = [shutil.which("ccache")] if shutil.which("ccache") and "ccache" not in flags[0] else []
    command = [*cached, *flags[:1], f"-I{FOLDER}", *flags[1:], "-O1", "-w", "-D_GLIBCXX_ASSERTIONS", "-o", made,
               "-c", source]
    done = subprocess.run(command, cwd=entry["directory"], stderr=subprocess.PIPE, text=True)
    return made, done.stderr if done.returncode else ""


def link(objects):
    lines = subprocess.run(["ninja", "-C", BUILD, "-t", "commands", "t4d-reader"], check=True, capture_output=True,
                           text=True).stdout.splitlines()
    library = "formats/t4d/libt4d_file.a"
    command = lines[-1].replace(library, " ".join(shlex.quote(str(each)) for each in objects), 1)
    command = command.replace(library, "").replace("-o t4d-reader", f"-o {shlex.quote(str(PROGRAM))}")
    subprocess.run(command, shell=True, cwd=BUILD, check=True)


def build(mutants):
    """Compiles them, and returns those that do not compile, which are tried once."""
    kept = FOLDER / "rejected.json"
    before = {tuple(key) for key in json.loads(kept.read_text())} if kept.exists() else set()
    rejected = [mutant for mutant in mutants if (*mutant.key, mutant.edits[0].begin) in before]
    units = [entry for entry in json.loads((BUILD / "compile_commands.json").read_text())
             if re.search(r"-o \S*/t4d_file\.dir/\S+\.(cpp|cxx)\.o", entry["command"])]
    while True:
        write(FOLDER / schemata.HEADER, schemata.header(mutants).encode())
        lines = {}
        for file in {mutant.file for mutant in mutants}:
            own = [mutant for mutant in mutants if mutant.file == file and mutant not in rejected]
            text, lines[file] = schemata.mutated((ROOT / file).read_bytes(), own)
            write(FOLDER / file, text)
        with ThreadPoolExecutor(2) as pool:
            made = list(pool.map(lambda unit: compile_unit(unit, lines), units))
        log = "".join(f"FAILED: {messages}" for _, messages in made if messages)
        if not log:
            link([made for made, _ in made])
            kept.write_text(json.dumps([(*mutant.key, mutant.edits[0].begin) for mutant in rejected]))
            return rejected
        numbers = tree.blamed("\n" + log, lines)
        if not numbers:
            raise SystemExit(f"the mutants of the reader in C++ do not compile:\n{log}")
        rejected += [mutant for mutant in mutants if mutant.number in numbers]


class Kit:
    """The program with all mutants, and the cases that it is asked."""

    def __init__(self, mutants, corpus):
        self.mutants = mutants
        for i, mutant in enumerate(mutants, 1):
            mutant.number = i
        self.rejected = {id(mutant) for mutant in build(mutants)}
        self.numbers = {id(mutant): mutant.number for mutant in mutants}
        self.folder = tempfile.TemporaryDirectory(prefix="t4d-mutate-")
        self.cases = [case for case in kit.cases(corpus, Path(self.folder.name))
                      if case.trial.request == "describe" or Path(case.path).stat().st_size < LARGE]
        trace = Path(self.folder.name) / "reached"
        if wrong := self.first_fault(range(len(self.cases)), f"T4D_MUTANT_TRACE={trace}"):
            raise SystemExit(f"the reader as it is fails in {self.cases[wrong[0]].name}: {wrong[1]}")
        self.reached = {int(number) for number in trace.read_text().split()}
        self.killers, self.near = Counter(), defaultdict(Counter)

    def first_fault(self, order, variable):
        """(number of the case, what is wrong) of the first case in this order that is answered wrongly, or None."""
        limits = ["prlimit", f"--data={MOST_BYTES}", f"--cpu={MOST_SECONDS}", "--core=0"]
        reader = kit.RUNNER.Reader(["env", variable, *limits, str(PROGRAM)], SECONDS)
        try:
            for number in order:
                trial = self.cases[number].trial
                verdict, text = reader.ask(trial.request, self.cases[number].path)
                answered = verdict in ("accept", "refuse")
                wrong = kit.RUNNER.fault(trial, verdict, text) if answered else f"{verdict}: {text}"
                if wrong:
                    return number, wrong
            return None
        finally:
            reader.end()

    def of_reader(self):
        """Those of functions that the reader calls: the others write files, or mend them."""
        called = {(m.file, m.function) for m in self.mutants if self.numbers[id(m)] in self.reached}
        return [m for m in self.mutants if (m.file, m.function) in called]

    def judge(self, mutant):
        number = self.numbers[id(mutant)]
        if id(mutant) in self.rejected:
            return {"outcome": "not built", "why": "does not compile"}
        if number not in self.reached:
            return {"outcome": "survived", "reached by": 0, "tests run": 0, "tests": []}
        near = self.near[mutant.file, mutant.function]
        # The mutants before tell which cases notice most.
        order = sorted(range(len(self.cases)),
                       key=lambda i: (-near[i], -self.killers[i] if self.killers[i] > 2 else 0))
        found = self.first_fault(order, f"T4D_MUTANT={number}")
        if not found:
            return {"outcome": "survived", "reached by": 1, "tests run": 1, "tests": ["the kit"]}
        near[found[0]] += 1
        self.killers[found[0]] += 1
        return {"outcome": "killed", "by": self.cases[found[0]].name, "how": found[1][:200], "reached by": 1}
