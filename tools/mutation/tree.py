"""A copy of the sources with the mutants in it, and its build. The working tree is never changed."""

import os
import re
import shutil
import subprocess

from . import schemata
from .rooms import ROOT

FOLDER = ROOT / "build/mutate"
TREE = FOLDER / "t4d"
BUILD = TREE / "build/release"
# Messages of g++: "model/slab.cpp:12:3: error: ...", "...: required from here".
PLACE = re.compile(r"(?:^|[\s/])((?:model|slice|mesh4d|voxel4d|formats|measure|edit|mill|tools/t4d)/[\w/.]+\.(?:cpp|h)):(\d+):(?:\d+:)?(.*)")


def tracked():
    listed = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
                            cwd=ROOT, check=True, capture_output=True, text=True).stdout
    return [name for name in listed.split("\0") if name and os.path.lexists(ROOT / name)]


def write(mutants):
    """Brings the copy up to date; files that stay the same keep their times, so that a build starts
    from the last one. Returns the lines of each mutant by file."""
    by_file = {}
    for mutant in mutants:
        by_file.setdefault(mutant.file, []).append(mutant)
    texts = {schemata.HEADER: schemata.header(mutants).encode()}
    lines = {}
    for file, own in by_file.items():
        texts[file], lines[file] = schemata.mutated((ROOT / file).read_bytes(), own)
    names = tracked()
    for name in {*names, *texts}:
        source, target = ROOT / name, TREE / name
        target.parent.mkdir(parents=True, exist_ok=True)
        if name not in texts and source.is_symlink():
            if not target.is_symlink():
                target.symlink_to(os.readlink(source))
            continue
        text = texts[name] if name in texts else source.read_bytes()
        if not target.exists() or target.read_bytes() != text:
            target.write_bytes(text)
            if name in names:
                shutil.copymode(source, target)
    remove_others({*names, *texts})
    shared = ROOT.parent / "shared"  # meshes that some tests read, if they are there
    if shared.exists() and not (FOLDER / "shared").is_symlink():
        (FOLDER / "shared").symlink_to(shared)
    return lines


def remove_others(names):
    for folder, folders, files in os.walk(TREE):
        if folder == str(TREE):
            folders.remove("build") if "build" in folders else None
        for file in files:
            path = os.path.join(folder, file)
            if os.path.relpath(path, TREE) not in names:
                os.remove(path)


def configure(folder, *options, source=ROOT):
    # An index that is out of range is a failure.
    subprocess.run(["cmake", "--preset", "release", "-B", folder, "-DT4D_BUILD_BENCHMARKS=OFF",
                    "-DCMAKE_CXX_FLAGS=-D_GLIBCXX_ASSERTIONS",
                    "-Wno-dev", "--log-level=ERROR", *options],
                   cwd=source, check=True, stdout=subprocess.DEVNULL)


def database():
    """compile_commands.json with a command for each file, and the sources that the build generates."""
    commands = FOLDER / "commands"
    configure(commands, "-DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON")
    subprocess.run(["cmake", "--build", commands, "--target", "t4d_pattern_numbers"], check=True,
                   stdout=subprocess.DEVNULL)
    return commands / "compile_commands.json"


def build(mutants, jobs, say):
    """Builds all mutants that compile, and returns (those, the others)."""
    rejected = []
    lines = write(mutants)
    configure(BUILD, source=TREE)
    while True:
        done = subprocess.run(["ninja", "-C", BUILD, "-k", "0", "-j", str(jobs)],
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if done.returncode == 0:
            return mutants, rejected
        numbers = blamed(done.stdout, lines)
        if not numbers:
            (FOLDER / "build.log").write_text(done.stdout)
            raise SystemExit(f"the build fails, and at no mutant: see {FOLDER / 'build.log'}")
        rejected += [m for m in mutants if m.number in numbers]
        mutants = [m for m in mutants if m.number not in numbers]
        say(f"{len(numbers)} mutants do not compile; builds without them")
        lines = write(mutants)


def blamed(log, lines):
    """The mutants at the places of errors, or else at those that instantiate a template."""
    numbers = set()
    log = log.replace(f"{TREE}/", "")
    for block in re.split(r"^FAILED: ", log, flags=re.M)[1:]:
        if " error: " not in block:  # interrupted
            continue
        errors, others = set(), set()
        for file, line, message in PLACE.findall(block):
            at = {number for number, ranges in lines.get(file, {}).items()
                  if any(first <= int(line) <= last for first, last in ranges)}
            (errors if " error: " in message else others).update(at)
        numbers |= errors or others
    return numbers
