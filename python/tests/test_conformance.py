"""The conformance kit tests the module as it tests any reader."""

import os
import subprocess
import sys
from pathlib import Path


def test_the_module_is_a_reader(program):
    effort = [] if os.environ.get("T4D_ALL") else ["--quick"]
    reader = Path(__file__).with_name("module_reader.py")
    run = subprocess.run(
        [program, "conform", "reader", "--reader", f"{sys.executable} {reader}", "--serve", *effort],
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stdout[-3000:] + run.stderr[-1000:]
