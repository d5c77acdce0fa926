"""The mutants that are known to change nothing, with the reason of each. Some change nothing for the tests of one room:
the conformance kit asks less than the tests of the library."""

import json
from pathlib import Path

FILE = Path(__file__).with_name("equivalent.json")


def load():
    """Reasons by room, "" for all, and Mutant.key."""
    return {(e.get("room", ""), e["file"], e["line"], e["change"]): e["reason"] for e in json.loads(FILE.read_text())}


def reason(known, mutant):
    """Why the mutant changes nothing, or None."""
    return known.get(("", *mutant.key)) or known.get((mutant.room, *mutant.key))


def check(known, files, found):
    """Every entry for these files must be one of their mutants."""
    keys = {mutant.key for mutant in found}
    for _, *key in known:
        if key[0] in files and tuple(key) not in keys:
            raise SystemExit(f"{FILE.name}: {key[0]} has no mutant '{key[2]}' in the line '{key[1]}' "
                             "any more: remove or correct the entry")
