"""When Python ends, work that other threads do ends first."""

from __future__ import annotations

import atexit
import os
import sys
from typing import Callable


def at_end(function: Callable[[], None]) -> None:
    """Calls it before the interpreter ends; in processes of multiprocessing, too, which end without
    atexit."""
    atexit.register(function)
    _finalize(function)
    os.register_at_fork(after_in_child=lambda: _after_fork(function))


def _finalize(function: Callable[[], None]) -> None:
    multiprocessing = sys.modules.get("multiprocessing")
    if multiprocessing is not None and multiprocessing.parent_process() is not None:
        sys.modules["multiprocessing.util"].Finalize(None, function, exitpriority=0)


def _after_fork(function: Callable[[], None]) -> None:
    # multiprocessing forgets finalizers after a fork, and then calls what is registered here.
    util = sys.modules.get("multiprocessing.util")
    if util is not None:
        util.register_after_fork(function, _finalize)
