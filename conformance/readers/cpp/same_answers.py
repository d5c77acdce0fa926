#!/usr/bin/env python3
"""Whether t4d-reader of another system answers as that of this one does: same_answers.py READER OTHER...

OTHER are the words that run it. Both are asked about the valid files of the corpus. Texts are equal, numbers to 1e-12
of the largest in their answer: only C libraries differ.
"""

import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
FILES = sorted(path.relative_to(ROOT) for path in ROOT.glob("conformance/corpus/files/valid/*.t4d"))
REQUESTS = [f"{words} {file.as_posix()}" for file in FILES for words in ("describe", "slice 0.5", "slice x 0.1")]


def numbers_of(value):
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        return [number for item in value for number in numbers_of(item)]
    return [value] if isinstance(value, float) else []


def same(one, other, tolerance):
    if isinstance(one, float) and isinstance(other, (int, float)):
        return abs(one - other) <= tolerance
    if isinstance(one, dict) and isinstance(other, dict):
        return list(one) == list(other) and all(same(one[key], other[key], tolerance) for key in one)
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(same(a, b, tolerance) for a, b in zip(one, other))
    return one == other


def answers_of(words):
    """Pairs of "accept" or "refuse" and what follows. Reasons have the words of the system."""
    run = subprocess.run([*words, "--serve"], input="\n".join(REQUESTS) + "\n", stdout=subprocess.PIPE,
                         encoding="utf-8", cwd=ROOT, check=True)  # fmt: skip
    for line in run.stdout.split("\n")[:-1]:
        verdict, _, rest = line.partition(" ")
        yield verdict, json.loads(rest) if verdict == "accept" else None


def main(reader, *other):
    answers = list(answers_of([Path(reader).resolve()]))
    others = list(answers_of(other))
    if not len(answers) == len(others) == len(REQUESTS):
        sys.exit(f"{len(REQUESTS)} requests have {len(answers)} answers of {reader} and {len(others)} of the other")
    for request, one, two in zip(REQUESTS, answers, others):
        largest = max((abs(number) for number in numbers_of(one[1])), default=0)
        if one[0] != two[0] or not same(one[1], two[1], 1e-12 * largest):
            sys.exit(f"{request}: answers {two}, expected {one}")
    accepted = sum(verdict == "accept" for verdict, _ in answers)
    print(f"{len(answers)} answers about {len(FILES)} files are the same, {accepted} accept")


main(*sys.argv[1:])
