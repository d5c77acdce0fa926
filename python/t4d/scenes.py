"""Scenes in files of other programs, recorded for ``t4d.recorded`` and ``t4d.still``.

A process of its own evaluates the scene and leaves a recording: Blender, whose Python need not have this module, or a
library made for the format, if it is installed.
"""

from __future__ import annotations

import importlib
import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Callable, Dict, List, NamedTuple, Optional, Sequence, Tuple

from t4d.errors import Failed, FileError, InvalidInput, Unsupported

_RECORD = ("import importlib, json, sys; place, module, request = sys.argv[sys.argv.index('--') + 1:]; "
           "sys.path.insert(0, place); importlib.import_module(module).record_file(json.loads(request))")  # fmt: skip
_USD = (".usd", ".usda", ".usdc", ".usdz")
# For each extension, the library that evaluates a file as its format says, its name on PyPI, and
# the module that asks it.
_LIBRARIES = {".fbx": ("ufbx", "ufbx", "t4d.fbx_scene"), **dict.fromkeys(_USD, ("pxr", "usd-core", "t4d.usd_scene"))}
# Extensions of files that nothing else reads.
EXTENSIONS = (".abc", ".blend", ".dae", ".fbx", *_USD)


class Reader(NamedTuple):
    """What records a file: its name, the command that runs the Python code that follows it, and the module there."""

    name: str
    command: List[str]
    place: str
    module: str


@dataclass
class Request:
    """What is recorded: keys at every `step` frames of a range, by default that of the file; if it is `still`, only
    the first. The tolerance is in metres."""

    still: bool = False
    frame_range: Optional[Tuple[float, float]] = None
    objects: Sequence[str] = ()
    take: Optional[str] = None
    fps: Optional[float] = None
    step: float = 1
    tolerance: Optional[float] = None
    blender: Optional[str] = None  # the program that reads the file


def extension_of(path: str) -> str:
    return os.path.splitext(path)[1].lower()


def is_scene(path: str) -> bool:
    return extension_of(path) in EXTENSIONS


def readers(file: str, program: Optional[str] = None) -> List[Reader]:
    """What may read a file, the best first: a library made for the format alone, otherwise Blenders. Raises
    Unsupported if there is none."""
    library, package, module = _LIBRARIES.get(extension_of(file), ("", "", ""))
    if library and program is None and importlib.util.find_spec(library):
        return [Reader(package, [sys.executable, "-c"], str(Path(__file__).resolve().parents[1]), module)]
    found = []
    if program is None and importlib.util.find_spec("bpy"):
        found.append([sys.executable, "-c"])
    path = shutil.which(program or "blender")
    if path:
        found.append([path, "--background", "--factory-startup", "--disable-autoexec", "--python-exit-code", "1",
                      "--python-expr"])  # fmt: skip
    if not found:
        way = f"pip install {package}, or bpy" if package else "pip install bpy"
        if extension_of(file) == ".dae":
            way = "pip install pycollada, for what is at rest, or bpy before version 5"
        raise Unsupported(f"{program or 'Blender'} is not found, which reads it\nt4d: try: {way}, or a Blender: "
                          "t4d-blender --blender PROGRAM", file)  # fmt: skip
    return [Reader("Blender", command, _addon(), "io_mesh_t4d.recording") for command in found]


def record(file: str, request: Request, folder: str, say: Callable[[str], None] = lambda text: None) -> List[str]:
    """Lets a reader write a recording into a folder. Returns notes."""
    if not os.path.isfile(file):
        raise FileError("cannot be opened: there is no such file", file)
    found = readers(file, request.blender)
    asked = not request.fps and found[0].name == "Blender"
    fps, notes = _rate_of(file) if asked else (request.fps, [])
    said = json.dumps({**vars(request), "file": os.path.abspath(file), "folder": folder, "fps": fps})
    say(f"starting {found[0].name}")
    reasons: Dict[str, None] = {}
    for reader in found:
        reason = _let(reader, file, said, Path(folder), say)
        if reason is None:
            return notes
        reasons[reason] = None
    raise InvalidInput("; ".join(reasons), file)


def _let(reader: Reader, file: str, request: str, folder: Path, say: Callable[[str], None]) -> Optional[str]:
    """Lets one reader write it. Returns why it cannot."""
    with open(folder / "reader.log", "w+", encoding="utf-8", errors="replace") as log:
        with subprocess.Popen(
            [*reader.command, _RECORD, "--", reader.place, reader.module, request],
            stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.PIPE, encoding="utf-8", errors="replace",
        ) as process:  # fmt: skip
            assert process.stderr is not None
            try:
                for line in process.stderr:
                    if line.startswith("frame "):
                        say(line.strip())
                    else:
                        log.write(line)
            except BaseException:
                process.kill()
                raise
        problem = folder / "problem.txt"
        if problem.exists():
            return problem.rename(folder / "last.txt").read_text(encoding="utf-8")
        if process.returncode or not (folder / "scene.json").exists():
            log.seek(0)
            last = [line for line in log.read().splitlines() if line.strip() and line != "Blender quit"][-1:]
            raise Failed(f"{reader.name} ended with {process.returncode}: {' '.join(last)}", file)
    return None


def _addon() -> str:
    """Where Python finds the add-on: the archive of the wheel, the installation or the build folder, or the sources."""
    here = Path(__file__).resolve()
    archive = "io_mesh_t4d.zip"
    shared = [up / "share" / "t4d" / "blender" / archive for up in here.parents]
    for place in (here.parent / archive, here.parents[2] / "blender" / archive, *shared, here.parents[1] / "blender"):
        if place.exists():
            return str(place)
    raise Failed(f"{archive}, the add-on for Blender, is not found beside the module t4d")


def _rate_of(path: str) -> Tuple[Optional[float], List[str]]:
    """Frames per second, where Blender's importer does not set them: those that the file says, and a note if it cannot
    be asked. A wrong rate lets USD play at another speed; an .abc then has its keys between samples."""
    extension = extension_of(path)
    if extension not in (".abc", *_USD):
        return None, []
    if extension != ".abc" and importlib.util.find_spec("pxr"):
        return float(importlib.import_module("pxr.Usd").Stage.Open(path).GetTimeCodesPerSecond()), []
    said = rb"(?:FramesPerTimeUnit|DCC FPS)=" if extension == ".abc" else rb"timeCodesPerSecond = "
    with open(path, "rb") as file:
        found = re.search(said + rb"([0-9.]+)", file.read())
    if found:
        return float(found[1]), []
    hint = "" if extension == ".abc" else ", or pip install usd-core, which reads it"
    return None, [f"the frame rate of the file is not known and taken as 24: give --fps{hint}"]
