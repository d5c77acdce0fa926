"""Binary USD (.usdc), which the library does not read or write: by way of text, through Pixar's own
package where it is installed (PyPI: usd-core)."""

from __future__ import annotations

import contextlib
import importlib
import os
import tempfile
from pathlib import Path
from typing import Any, Iterator, Tuple

from t4d.errors import InvalidInput, Unsupported

BINARY = ".usdc"


def is_binary(path: str) -> bool:
    """Whether a file that is read is binary: by its first bytes, where its extension may be either's."""
    extension = os.path.splitext(path)[1].lower()
    if extension not in (BINARY, ".usd", ".usdz"):
        return False
    try:
        with open(path, "rb") as file:
            begin = file.read(4096)
    except OSError:
        return False  # the library says why
    # The first file of a package begins within its first 64 bytes and a name.
    return begin.startswith(b"PXR-USDC") or (extension == ".usdz" and b"PXR-USDC" in begin)


def is_named_binary(path: Any) -> bool:
    """Whether a file that is written is binary."""
    return isinstance(path, (str, bytes, os.PathLike)) and os.fsdecode(path).lower().endswith(BINARY)


def _pixar(path: str) -> Tuple[Any, Any, Any]:
    try:
        Sdf, Tf, Usd = (importlib.import_module(f"pxr.{name}") for name in ("Sdf", "Tf", "Usd"))
    except ImportError:
        raise Unsupported(
            "is binary USD, which needs the package usd-core (pip install usd-core); without it, "
            "`usdcat --flatten IN.usdc -o OUT.usda` converts a file, and `usdcat IN.usda -o "
            "OUT.usdc` back",
            path,
        ) from None
    return Sdf, Tf, Usd


def to_text(path: str, folder: Path) -> str:
    """The path of a text that says what the file does, in the folder. Layers that it refers to are in
    it, too."""
    _, Tf, Usd = _pixar(path)
    text = folder / f"{Path(path).stem}-{len(list(folder.iterdir()))}.usda"
    try:
        Usd.Stage.Open(path).Flatten().Export(str(text))
    except Tf.ErrorException as error:
        raise InvalidInput(f"Pixar's library cannot read it: {_first_line(error)}", path) from None
    return str(text)


def from_text(text: str, path: str) -> None:
    """Writes a text as a binary file, which appears whole or not at all."""
    Sdf, Tf, _ = _pixar(path)
    with tempfile.TemporaryDirectory(prefix=".t4d-", dir=os.path.dirname(path) or ".") as folder:
        made = os.path.join(folder, "made.usdc")
        try:
            Sdf.Layer.FindOrOpen(text).Export(made)
        except Tf.ErrorException as error:
            raise Unsupported(f"Pixar's library cannot write it: {_first_line(error)}", path) from None
        os.replace(made, path)


@contextlib.contextmanager
def as_text(path: str) -> Iterator[str]:
    """The file, or a text with what it says if it is binary."""
    if not is_binary(path):
        yield path
        return
    with tempfile.TemporaryDirectory(prefix="t4d-") as folder:
        yield to_text(path, Path(folder))


@contextlib.contextmanager
def written(path: str) -> Iterator[str]:
    """Where to write: the file itself, or a text that becomes it if its name is that of a binary."""
    if not is_named_binary(path):
        yield path
        return
    _pixar(path)
    with tempfile.TemporaryDirectory(prefix="t4d-") as folder:
        text = os.path.join(folder, "written.usda")
        yield text
        from_text(text, path)


def _first_line(error: BaseException) -> str:
    return (str(error).strip().splitlines() or [""])[-1].strip()
