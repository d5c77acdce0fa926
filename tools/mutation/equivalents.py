"""The mutants that are known to change nothing, with the reason of each."""

import json
from pathlib import Path

FILE = Path(__file__).with_name("equivalent.json")


def load():
    """Reasons by Mutant.key."""
    return {(e["file"], e["line"], e["change"]): e["reason"] for e in json.loads(FILE.read_text())}


def check(known, files, found):
    """Every entry for these files must be one of their mutants."""
    keys = {mutant.key for mutant in found}
    for key in known:
        if key[0] in files and key not in keys:
            raise SystemExit(f"{FILE.name}: {key[0]} has no mutant '{key[2]}' in the line '{key[1]}' "
                             "any more: remove or correct the entry")
