#!/usr/bin/env python3
"""The program t4d, for tests, with one fault: T4D_FAULT is KIND:WORD:FOLDER. The first call that has
WORD among its words has the fault, or with a KIND that ends with "-always" all of them; a file in FOLDER
remembers that it happened.

  kill    the worker that calls it is killed, as by the system when memory is short
  full    the disk of the output is full
  stall   nothing happens for a minute
  slow    nothing happens for three seconds
  damage  a byte of the part whose manifest is named first is changed before anything is done
"""

import os
import signal
import sys
import time
from pathlib import Path

program, library = os.environ["T4D_REAL"], os.environ["T4D_FAILING_DISK"]
words = sys.argv[1:]
kind, word, folder = os.environ.get("T4D_FAULT", "::").split(":", 2)
if kind and word in words:
    mark = Path(folder) / "happened"
    try:
        mark.touch(exist_ok=False)
        first = True
    except FileExistsError:
        first = kind.endswith("-always")
    kind = kind.split("-")[0]
    if first and kind == "kill":
        os.kill(os.getppid(), signal.SIGKILL)
        time.sleep(1)
    if first and kind in ("stall", "slow"):
        time.sleep(60 if kind == "stall" else 3)
    if first and kind == "damage":
        victim = next(Path(name).with_suffix(".t4d") for name in words if name.endswith(".t4dm"))
        content = bytearray(victim.read_bytes())
        content[len(content) // 2] ^= 255
        victim.write_bytes(content)
    if first and kind == "full":
        output = next(name for name in words if name.startswith("--output=")).split("=", 1)[1]
        os.environ.update(LD_PRELOAD=library, T4D_FAIL_FOLDER=os.path.dirname(output), T4D_FAIL_FROM="3",
                          T4D_FAIL_ERRNO="28")  # fmt: skip
os.execv(program, [program, *words])
