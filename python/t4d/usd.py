"""Writing binary USD (.usdc), which the library does not: by way of text, through Pixar's own package where it is
installed (PyPI: usd-core)."""

from __future__ import annotations

import contextlib
import importlib
import os
import tempfile
from typing import Any, Iterator, Tuple

from t4d.errors import Unsupported

BINARY = ".usdc"


def is_binary(path: Any) -> bool:
    """Whether a file that is written is binary."""
    return isinstance(path, (str, bytes, os.PathLike)) and os.fsdecode(path).lower().endswith(BINARY)


def _pixar(path: str) -> Tuple[Any, Any]:
    try:
        Sdf, Tf = (importlib.import_module(f"pxr.{name}") for name in ("Sdf", "Tf"))
    except ImportError:
        raise Unsupported(
            "is binary USD, which needs the package usd-core (pip install usd-core); without it, write a .usda, which "
            "`usdcat IN.usda -o OUT.usdc` converts",
            path,
        ) from None
    return Sdf, Tf


def _write(text: str, path: str) -> None:
    """Writes a text as a binary file, which appears whole or not at all."""
    Sdf, Tf = _pixar(path)
    with tempfile.TemporaryDirectory(prefix=".t4d-", dir=os.path.dirname(path) or ".") as folder:
        made = os.path.join(folder, "made.usdc")
        try:
            Sdf.Layer.FindOrOpen(text).Export(made)
        except Tf.ErrorException as error:
            raise Unsupported(f"Pixar's library cannot write it: {_first_line(error)}", path) from None
        os.replace(made, path)


@contextlib.contextmanager
def written(path: str) -> Iterator[str]:
    """Where to write: the file itself, or a text that becomes it if its name is that of a binary."""
    if not is_binary(path):
        yield path
        return
    _pixar(path)
    with tempfile.TemporaryDirectory(prefix="t4d-") as folder:
        text = os.path.join(folder, "written.usda")
        yield text
        _write(text, path)


def _first_line(error: BaseException) -> str:
    return (str(error).strip().splitlines() or [""])[-1].strip()
