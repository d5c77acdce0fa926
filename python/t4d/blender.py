"""The program t4d-blender: a 4D mesh of an animation in any file that Blender imports, or a triangle mesh at rest.

Another process records the scene (``t4d.scenes``); the mesh is made of the recording (``t4d.recorded``, ``t4d.still``).
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import time
import warnings
from typing import Any, Callable, Dict, NoReturn, Optional, Sequence, Tuple

import t4d
from t4d import recorded, scenes, still
from t4d.errors import Error, FileError, InvalidInput, VerbError
from t4d.scenes import Request
from t4d.triangles import TriangleMesh

_FAILED, _USAGE, _LOSS, _INVALID = 1, 2, 3, 4
_MESHES = (".ply", ".vtp", ".obj", ".stl", ".off", ".glb", ".gltf", ".usda", ".usdc", ".usdz")


class _Problem(Exception):
    """The reason why something cannot be done, and the exit code."""

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
                    "else Blender imports, with a body for each object, in metres and seconds, z up; or one triangle "
                    "mesh of its objects at the first frame.",
        epilog="All other options, after FILE, are those of `t4d sweep`, such as --mend and --caps. Examples: "
               "t4d-blender walk.fbx --tolerance 0.001 -o walk.t4d; t4d-blender part.fbx -o part.ply",
    )  # fmt: skip
    for name, kind in ("range of frames A:B", _frames), ("number above zero", _above_zero):
        kind.__name__ = name  # of which argparse says that a value is none
    add = parser.add_argument
    add("file", metavar="FILE", help="file with a scene")
    add("-o", "--output", metavar="FILE", required=True,
        help=f"output: .t4d, or a triangle mesh ({', '.join(_MESHES)})")  # fmt: skip
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


def _check(options: argparse.Namespace, words: Sequence[str]) -> None:
    """Checks what would be found wrong only after the scene is read."""
    extension = scenes.extension_of(options.output)
    if extension not in (".t4d", *_MESHES):
        raise _Problem(f"--output: {options.output}: expected a name that ends in .t4d, or for a triangle mesh of the "
                       f"first frame in {', '.join(_MESHES[:-1])} or {_MESHES[-1]}", _USAGE)  # fmt: skip
    if os.path.exists(options.output) and os.path.exists(options.file):
        if os.path.samefile(options.output, options.file):
            raise _Problem(f"--output: {options.output}: is the input, which is never replaced", _USAGE)
    if extension != ".t4d" and words:
        raise _Problem(f"{words[0]} is an option of t4d sweep, which makes a .t4d, not {options.output}", _USAGE)
    if any(word.partition("=")[0] == "--part" for word in words):
        raise _Problem("--part is for what t4d sweep reads itself: t4d-blender makes all parts at once", _USAGE)
    if options.take is not None and scenes.readers(options.file, options.blender)[0].name != "ufbx":
        raise _Problem("--take is for an .fbx that ufbx reads (pip install ufbx)", _USAGE)


def _request(options: argparse.Namespace) -> Request:
    return Request(
        still=scenes.extension_of(options.output) != ".t4d", frame_range=options.frame_range, objects=options.object,
        take=options.take, fps=options.fps, step=options.step, tolerance=options.tolerance, blender=options.blender,
    )  # fmt: skip


def _sweep(options: argparse.Namespace, words: Sequence[str], say: Callable[[str], None]) -> recorded.Recorded:
    with tempfile.TemporaryDirectory(prefix="t4d-") as folder:
        notes = scenes.record(options.file, _request(options), folder, say)
        try:
            done = recorded.save(folder, options.output, words, options.voxel_size, say, advised=True)
        except VerbError as error:
            named = "" if error.exit_code == _USAGE else f"{options.file}: "
            advice = error.advice if isinstance(error, recorded.NoSolids) else ""
            raise _Problem("\nt4d: try: ".join([f"{named}{error}", *filter(None, [advice])]), error.exit_code) from None
        except InvalidInput as error:
            raise _Problem(f"{options.file}: {error}", _INVALID) from None
    return done._replace(notes=[*notes, *done.notes])


def _save_still(options: argparse.Namespace, say: Callable[[str], None]) -> recorded.Recorded:
    found = still.read(options.file, _request(options), say)
    mesh = TriangleMesh(found.vertices, found.triangles, {}, found.attributes)
    with warnings.catch_warnings(record=True) as lost:
        warnings.simplefilter("always")
        try:
            mesh.save(options.output, attributes=True)
        except FileError as error:
            raise _Problem(str(error), _FAILED) from None
    losses = [*found.losses, *(str(one.message) for one in lost)]
    report = {"bodies": [{"name": name} for name in found.bodies], "vertices": len(mesh.vertices),
              "triangles": len(mesh.triangles), "materials": found.materials,
              "bytes": os.path.getsize(options.output), "losses": losses}  # fmt: skip
    return recorded.Recorded(report, found.notes, losses)


def _text_of(report: Dict[str, Any]) -> str:
    """The report as text for people."""
    count = len(report["bodies"])
    if "fps" in report:
        first = f"{count} {'body' if count == 1 else 'bodies'}, {report['fps']:g} frames per second"
        return "\n  ".join([first, *recorded.lines_of(report)])
    return f"{report['triangles']:,} triangles of {count} {'object' if count == 1 else 'objects'}, in metres, z up"


def code_of(error: Exception) -> int:
    """The exit code of what a reader raises."""
    return _INVALID if isinstance(error, (InvalidInput, FileError)) else _FAILED


def _print(options: argparse.Namespace, done: recorded.Recorded, seconds: float) -> None:
    if options.json:
        print(json.dumps({**done.report, "seconds": seconds}, indent=2))
    elif not options.quiet:
        print(f"{options.output}: {_text_of(done.report)}")
        print(f"  {done.report['bytes'] / 1e3:,.1f} kB, {seconds:.2f} s")
    for note in [] if options.quiet else done.notes:
        print(f"t4d: note: {note}", file=sys.stderr)
    for loss in done.losses:
        print(f"t4d: lost: {loss}", file=sys.stderr)
    if done.advice:
        print(f"t4d: try: {done.advice}", file=sys.stderr)


def main(arguments: Optional[Sequence[str]] = None) -> int:
    begin = time.monotonic()
    terminal = sys.stderr.isatty()

    def say(text: str) -> None:
        if terminal:
            print(f"\r{text}\033[K", end="", file=sys.stderr, flush=True)

    try:
        options, words = _arguments().parse_known_args(arguments)
        _check(options, words)
        is_swept = scenes.extension_of(options.output) == ".t4d"
        done = _sweep(options, words, say) if is_swept else _save_still(options, say)
    except (_Problem, Error, OSError) as error:
        say("")
        print(f"t4d: {error}", file=sys.stderr)
        return error.code if isinstance(error, _Problem) else code_of(error)
    except KeyboardInterrupt:
        say("")
        return 130
    say("")
    _print(options, done, time.monotonic() - begin)
    return _LOSS if done.losses else 0


if __name__ == "__main__":
    sys.exit(main())
