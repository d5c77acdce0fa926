"""The reader in Python with a line changed, for the readers in wrong/."""
import sys
import types
from pathlib import Path

READER = Path(__file__).resolve().parent / "python/t4d_reader.py"


def reader_with(*changes):
    """The reader's module, in which each (old, new) has been replaced. `old` must be there once."""
    source = READER.read_text(encoding="utf-8")
    for old, new in changes:
        if source.count(old) != 1:
            raise SystemExit(f"{READER.name} has {source.count(old)} times: {old}")
        source = source.replace(old, new)
    module = sys.modules["t4d_reader"] = types.ModuleType("t4d_reader")
    exec(compile(source, READER, "exec"), module.__dict__)
    return module
