"""The program t4d-blender: a 4D mesh of an animation in any file that Blender imports.

A process of its own evaluates the scene and leaves a recording, of which ``t4d.recorded`` makes the 4D mesh: Blender,
whose Python need not have this module, or a library made for the format, if it is installed.
"""

from __future__ import annotations

import argparse
import importlib
import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Callable, Dict, List, NamedTuple, NoReturn, Optional, Sequence, Tuple

import t4d
from t4d import recorded
from t4d.errors import Error, VerbError

_FAILED, _USAGE, _LOSS, _INVALID = 1, 2, 3, 4
_RECORD = ("import importlib, json, sys; place, module, request = sys.argv[sys.argv.index('--') + 1:]; "
           "sys.path.insert(0, place); importlib.import_module(module).record_file(json.loads(request))")  # fmt: skip
_USD = (".usd", ".usda", ".usdc", ".usdz")
# By extension, the library that evaluates a file as its format says, its name on PyPI, and the module that asks it.
_LIBRARIES = {".fbx": ("ufbx", "ufbx", "t4d.fbx_scene"), **dict.fromkeys(_USD, ("pxr", "usd-core", "t4d.usd_scene"))}


class _Reader(NamedTuple):
    """What records a file: its name, the command that runs the Python code that follows it, and the module there."""

    name: str
    command: List[str]
    place: str
    module: str


class _Problem(Exception):
    """What cannot be done, and the exit code."""

    def __init__(self, message: str, code: int) -> None:
        super().__init__(message)
        self.code = code


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        raise _Problem(f"{message}\nRun with --help for more information.", _USAGE)


def _frames(text: str) -> Tuple[float, float]:
    first, last = map(float, text.split(":"))
    return first, last


def _above_zero(text: str) -> float:
    value = float(text)
    if not 0 < value < float("inf"):
        raise ValueError
    return value


def _arguments() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="t4d-blender", allow_abbrev=False,
        description="Make a 4D mesh of an animation: .fbx, .dae, .abc, .usd, .usdc, .usdz, .blend, .glb and whatever "
                    "else Blender imports, with a body for each object, in metres and seconds, z up.",
        epilog="All other options, after FILE, are those of `t4d sweep`, such as --mend and --caps. Example: "
               "t4d-blender walk.fbx --tolerance 0.001 -o walk.t4d",
    )  # fmt: skip
    for name, kind in ("range of frames A:B", _frames), ("number above zero", _above_zero):
        kind.__name__ = name  # of which argparse says that a value is none
    add = parser.add_argument
    add("file", metavar="FILE", help="animated file")
    add("-o", "--output", metavar="FILE", required=True, help="output (.t4d)")
    add("--object", metavar="NAME", action="append", default=[],
        help="only this object (repeatable; default: all that are visible)")  # fmt: skip
    add("--frame-range", metavar="A:B", type=_frames,
        help="first and last frame (default: those of the scene, or of all curves)")  # fmt: skip
    add("--step", metavar="N", type=_above_zero, default=1, help="frames between keys (default: 1)")
    add("--fps", metavar="RATE", type=_above_zero, help="frames per second (default: those of the file)")
    add("--tolerance", metavar="D", type=_above_zero,
        help="add keys where half frames are farther than D metres from straight lines")  # fmt: skip
    add("--voxel-size", metavar="H", type=_above_zero,
        help="voxel edge, in metres, for objects whose faces change (default: 0.01 of each)")  # fmt: skip
    add("--take", metavar="NAME", help="animation of an .fbx (default: the first)")
    add("--blender", metavar="PROGRAM",
        help="let this Blender read FILE (default: ufbx, usd-core, bpy, or blender of the PATH)")  # fmt: skip
    add("--json", action="store_true", help="print the result as JSON")
    add("-q", "--quiet", action="store_true", help="print errors and losses only")
    add("--version", action="version", version=f"t4d {t4d.__version__}")
    return parser


def _extension(path: str) -> str:
    return os.path.splitext(path)[1].lower()


def _readers(file: str, program: Optional[str]) -> List[_Reader]:
    """What may read a file, the best first: a library made for the format alone, otherwise Blenders."""
    library, package, module = _LIBRARIES.get(_extension(file), ("", "", ""))
    if library and program is None and importlib.util.find_spec(library):
        return [_Reader(package, [sys.executable, "-c"], str(Path(__file__).resolve().parents[1]), module)]
    found = []
    if program is None and importlib.util.find_spec("bpy"):
        found.append([sys.executable, "-c"])
    path = shutil.which(program or "blender")
    if path:
        found.append([path, "--background", "--factory-startup", "--disable-autoexec", "--python-exit-code", "1",
                      "--python-expr"])  # fmt: skip
    if not found:
        way = f"pip install {package}, or bpy" if package else "pip install bpy"
        raise _Problem(f"{program or 'Blender'} is not found\nt4d: try: {way}, or --blender PROGRAM", _FAILED)
    return [_Reader("Blender", command, _addon(), "io_mesh_t4d.recording") for command in found]


def _addon() -> str:
    """Where Python finds the add-on: the archive of the wheel, the installation or the build folder, or the sources."""
    here = Path(__file__).resolve()
    archive = "io_mesh_t4d.zip"
    shared = [up / "share" / "t4d" / "blender" / archive for up in here.parents]
    for place in (here.parent / archive, here.parents[2] / "blender" / archive, *shared, here.parents[1] / "blender"):
        if place.exists():
            return str(place)
    raise _Problem(f"{archive}, the add-on for Blender, is not found beside the module t4d", _FAILED)


def _rate_of(path: str) -> Tuple[Optional[float], List[str]]:
    """Frames per second, where Blender's importer does not set them: those that the file says, and a note if it cannot
    be asked. A wrong rate lets USD play at another speed; an .abc then has its keys between samples."""
    extension = _extension(path)
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


def _record(file: str, reader: _Reader, request: Dict[str, Any], say: Callable[[str], None]) -> Optional[str]:
    """Lets a reader write a recording. Returns why it cannot."""
    folder = Path(request["folder"])
    with open(folder / "reader.log", "w+", encoding="utf-8", errors="replace") as log:
        with subprocess.Popen(
            [*reader.command, _RECORD, "--", reader.place, reader.module, json.dumps(request)],
            stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.PIPE, encoding="utf-8", errors="replace",
        ) as process:  # fmt: skip
            assert process.stderr is not None
            for line in process.stderr:
                if line.startswith("frame "):
                    say(line.strip())
                else:
                    log.write(line)
        problem = folder / "problem.txt"
        if problem.exists():
            return problem.rename(folder / "last.txt").read_text(encoding="utf-8")
        if process.returncode or not (folder / "scene.json").exists():
            log.seek(0)
            last = [line for line in log.read().splitlines() if line.strip() and line != "Blender quit"][-1:]
            raise _Problem(f"{file}: {reader.name} ended with {process.returncode}: {' '.join(last)}", _FAILED)
    return None


def _run(options: argparse.Namespace, words: Sequence[str], say: Callable[[str], None]) -> recorded.Recorded:
    if not options.output.lower().endswith(".t4d"):
        raise _Problem(f"--output: {options.output}: expected a name that ends in .t4d", _USAGE)
    if not os.path.isfile(options.file):
        raise _Problem(f"{options.file}: cannot be opened: there is no such file", _INVALID)
    readers = _readers(options.file, options.blender)
    blenders = readers[0].name == "Blender"
    if options.take is not None and (blenders or _extension(options.file) != ".fbx"):
        raise _Problem("--take is for an .fbx that ufbx reads (pip install ufbx)", _USAGE)
    fps, notes = (options.fps, []) if options.fps or not blenders else _rate_of(options.file)
    with tempfile.TemporaryDirectory(prefix="t4d-") as folder:
        request = {
            "file": os.path.abspath(options.file), "folder": folder, "objects": options.object, "take": options.take,
            "fps": fps, "frame_range": options.frame_range, "step": options.step, "tolerance": options.tolerance,
        }  # fmt: skip
        say(f"starting {readers[0].name}")
        reasons: Dict[str, None] = {}
        for reader in readers:
            reason = _record(options.file, reader, request, say)
            if reason is None:
                break
            reasons[reason] = None
        else:
            raise _Problem(f"{options.file}: {'; '.join(reasons)}", _INVALID)
        try:
            done = recorded.save(folder, options.output, words, options.voxel_size, say)
        except VerbError as error:
            named = "" if error.exit_code == _USAGE else f"{options.file}: "
            hint = "" if words or error.exit_code != _INVALID else "\nt4d: try: --mend, or --caps cone"
            raise _Problem(f"{named}{error}{hint}", error.exit_code) from None
    return done._replace(notes=[*notes, *done.notes])


def _print(options: argparse.Namespace, done: recorded.Recorded, seconds: float) -> None:
    if options.json:
        print(json.dumps({**done.report, "seconds": seconds}, indent=2))
    elif not options.quiet:
        count, fps = len(done.report["bodies"]), done.report["fps"]
        print(f"{options.output}: {count} {'body' if count == 1 else 'bodies'}, {fps:g} frames per second")
        for line in recorded.lines_of(done.report):
            print(f"  {line}")
        print(f"  {done.report['bytes'] / 1e3:,.1f} kB, {seconds:.2f} s")
    for note in [] if options.quiet else done.notes:
        print(f"t4d: note: {note}", file=sys.stderr)
    for loss in done.losses:
        print(f"t4d: lost: {loss}", file=sys.stderr)


def main(arguments: Optional[Sequence[str]] = None) -> int:
    begin = time.monotonic()
    terminal = sys.stderr.isatty()

    def say(text: str) -> None:
        if terminal:
            print(f"\r{text}\033[K", end="", file=sys.stderr, flush=True)

    try:
        options, words = _arguments().parse_known_args(arguments)
        done = _run(options, words, say)
    except (_Problem, Error, OSError) as error:
        say("")
        print(f"t4d: {error}", file=sys.stderr)
        return error.code if isinstance(error, _Problem) else _FAILED
    except KeyboardInterrupt:
        say("")
        return 130
    say("")
    _print(options, done, time.monotonic() - begin)
    return _LOSS if done.losses else 0


if __name__ == "__main__":
    sys.exit(main())
