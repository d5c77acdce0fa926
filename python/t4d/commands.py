"""Runs the program t4d: files and options as words, and what it prints as a Report (``t4d.verbs``)."""

from __future__ import annotations

import atexit
import contextlib
import copy
import functools
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import (
    TYPE_CHECKING, Any, Dict, Iterable, List, Mapping, Optional, Sequence, Set, SupportsFloat, Tuple, Type, TypeVar,
    Union, cast, get_args, get_origin, get_type_hints,
)  # fmt: skip

import numpy as np

from t4d import converted, usd
from t4d.checks import Path as PathLike
from t4d.errors import Loss, VerbError, warn
from t4d.mesh import Mesh, file_of, read
from t4d.motions import Motion, plain
from t4d.triangles import TriangleMesh, read_triangles

File = Union[PathLike, Mesh, TriangleMesh, Iterable[Union[PathLike, Mesh, TriangleMesh]]]
"""Of a verb: a file, or what stands for one, or several."""

Number = Union[str, SupportsFloat]

Option = Union[PathLike, SupportsFloat, Iterable[Union[PathLike, SupportsFloat]], Mapping[str, Any]]
"""A word of the command line; numbers with commas, or the option once for each; or a file of JSON."""

Output = Union[Option, Type[Mesh], Type[TriangleMesh]]


AReport = TypeVar("AReport", bound="Report")


class Report(Dict[str, Any]):
    """What a verb found: a dictionary whose members are attributes, too (``report.volume``); those
    that this run did not print are None. ``mesh`` is what the verb made, if its output is a class."""

    mesh: Any = None

    if not TYPE_CHECKING:  # the classes of t4d.verbs say which there are

        def __getattr__(self, name):
            if name in self:
                return self[name]
            if name in _members(type(self)):
                return None
            raise AttributeError(f"the report has no '{name}'; it has {', '.join(self)}")

    def copy(self: AReport) -> AReport:
        return copy.copy(self)

    def __dir__(self) -> Iterable[str]:
        return [*super().__dir__(), *self]


def report_as(kind: Type[AReport], report: Any) -> AReport:
    """The report as the class that describes it, with the reports in it."""
    return cast(AReport, _as_hinted(kind, report))


def _as_hinted(hint: Any, value: Any) -> Any:
    if get_origin(hint) is Union:
        hint = next(kind for kind in get_args(hint) if kind is not type(None))
    if isinstance(value, list) and get_origin(hint) is list:
        return [_as_hinted(get_args(hint)[0], item) for item in value]
    if not isinstance(value, dict):
        return value
    if get_origin(hint) is dict:
        return Report({name: _as_hinted(get_args(hint)[1], item) for name, item in value.items()})
    if not isinstance(hint, type) or not issubclass(hint, Report):
        return value
    members = _members(hint)
    found = hint({name: _as_hinted(members.get(name), item) for name, item in value.items()})
    if isinstance(value, Report) and value.mesh is not None:
        found.mesh = value.mesh
    return found


@functools.lru_cache(maxsize=None)
def _members(kind: Type[Report]) -> Dict[str, Any]:
    return get_type_hints(kind)


@functools.lru_cache(maxsize=None)
def program() -> str:
    """The program: T4D_PROGRAM, or the one installed or built with this package, or that of the PATH."""
    chosen = os.environ.get("T4D_PROGRAM")
    if chosen:
        return chosen
    here = Path(__file__).resolve()
    places = (here.parent / "bin" / "t4d", *(up / "bin" / "t4d" for up in here.parents),
              here.parents[2] / "t4d")  # in a build folder  # fmt: skip
    for place in places:
        if os.access(place, os.X_OK) and place.is_file():
            return str(place)
    found = shutil.which("t4d")
    if found is None:
        raise FileNotFoundError("the program t4d is not found: set T4D_PROGRAM to its path")
    return found


@functools.lru_cache(maxsize=None)
def options_of(verb: str) -> Dict[str, Dict[str, Any]]:
    """What the verb takes, by each of its names as a Python word: ``options_of("slice")["time"]``
    has the members of docs/schemas/help.json."""
    described = json.loads(_printed(verb, "--help", "--json"))
    options = {}
    for option in described["options"]:
        for name in option["names"]:
            options[name.lstrip("-").replace("-", "_")] = option
    return options


def _printed(verb: str, *words: str) -> str:
    return subprocess.run(
        [program(), *verb.split(), *words], capture_output=True, text=True, check=False
    ).stdout


def _is_one(value: Any) -> bool:
    if isinstance(value, np.ndarray):
        return value.ndim == 0
    return isinstance(value, (str, bytes, os.PathLike)) or not hasattr(value, "__iter__")


def _text(value: Any) -> str:
    if not _is_one(value):
        return ",".join(map(_text, value))
    return os.fsdecode(value) if isinstance(value, (bytes, os.PathLike)) else str(value)


def words_of(verb: str, options: Dict[str, Any]) -> List[str]:
    """The options as words of a command line."""
    words: List[str] = []
    known = options_of(verb)
    for name, value in options.items():
        plain = name.rstrip("_").replace("-", "_")
        option = known.get(plain, {"names": [], "value": None, "repeats": False})
        word = "--" + plain.replace("_", "-")
        if f"-{plain}" in option["names"]:
            word = f"-{plain}"
        if isinstance(value, np.bool_):
            value = bool(value)
        if value is None or value is False:
            continue
        if value is True:
            if option["value"] is not None:
                raise TypeError(f"{name} is True; expected a value: see help(verbs.{verb})")
            words.append(word)
            continue
        several = option["repeats"] and not _is_one(value)
        texts = [_text(item) for item in value] if several else [_text(value)]
        # Values after "=" may begin with a minus.
        words += [f"{word}={text}" if word[1] == "-" else word + text for text in texts]
    return words


# The formats of temporary files, which hold meshes without rounding.
_EXTENSIONS = {Mesh: ".t4d", TriangleMesh: ".ply"}


def _saved(mesh: Union[Mesh, TriangleMesh], folder: Path) -> str:
    kind = Mesh if isinstance(mesh, Mesh) else TriangleMesh
    place = folder / f"mesh-{len(list(folder.iterdir())) + 1}{_EXTENSIONS[kind]}"
    mesh.save(place)
    return str(place)


def _names(files: Iterable[Any], folder: Path) -> List[str]:
    """The names of files, of meshes saved in the folder, and of lists of both. A name that begins
    with a minus would be an option; "-" alone is the standard input."""
    names: List[str] = []
    for file in files:
        if isinstance(file, (str, bytes, os.PathLike)):
            name = os.fsdecode(file)
            names.append(f"./{name}" if name.startswith("-") and name != "-" else name)
        elif isinstance(file, (Mesh, TriangleMesh)):
            names.append((isinstance(file, Mesh) and file_of(file)) or _saved(file, folder))
        elif hasattr(file, "__iter__"):
            names += _names(file, folder)
        else:
            raise TypeError(f"{file!r} is not the name of a file; options are given as keywords")
    return names


def run(verb: str, /, *files: Any, **options: Any) -> Any:
    """Runs a verb; see the module. Raises ``VerbError`` if it fails, and warns of notes and losses
    (``Loss``)."""
    with tempfile.TemporaryDirectory(prefix="t4d-") as name:
        folder = Path(name)
        names = _names(files, folder)
        for option, value in options.items():
            if isinstance(value, Motion):
                raise TypeError(f"{option} is a t4d.Motion; expected a motion file or a dictionary")
            if isinstance(value, Mapping):
                options[option] = folder / f"{option}.json"
                options[option].write_text(json.dumps(plain(value, "")), encoding="utf-8")
        made = None
        binary = contextlib.ExitStack()
        places: Dict[str, str] = {}
        for option in ("output", "o"):
            if usd.is_binary(options.get(option)):
                place = os.fsdecode(options[option])
                options[option] = binary.enter_context(usd.written(place))
                places[options[option]] = place
            if isinstance(options.get(option), type):
                kind = options[option]
                if kind not in _EXTENSIONS:
                    raise TypeError(f"output is {kind}; expected a path, t4d.Mesh or t4d.TriangleMesh")
                made = folder / f"made{_EXTENSIONS[kind]}"
                options[option] = made
        with binary:
            report = _run(verb, names, options)
        if places and isinstance(report, Report) and "files" in report:
            report["files"] = [places.get(file, file) for file in report["files"]]
            report["bytes"] = sum(os.path.getsize(file) for file in report["files"])
        if made is not None:
            report = report if isinstance(report, Report) else Report()
            report.mesh = read(made).load() if made.suffix == ".t4d" else read_triangles(made)
        return report


def _run(verb: str, names: List[str], options: Dict[str, Any]) -> Any:
    # Files come first: the last option could take a file for one more of its values.
    return run_words([verb, *names, *words_of(verb, options)])


_HELP = "Run with --help for more information."


def run_words(
    words: Sequence[str], *, cwd: Optional[str] = None, memory: int = 0, text: bool = False
) -> Any:
    """Runs a verb with the words of its command line, in a folder and with so many bytes of memory
    at most, if they are given. Returns its report, or its text. Raises and warns as ``run``."""
    verb = words[0]
    has_json = not text and "json" in options_of(verb)
    through = converted.is_needed(words[1:], cwd or "") or (verb == "weave" and _is_door(words[1:], cwd or ""))
    first, environment = _door() if through else ([program()], None)
    command = [*first, verb, *(["--json"] if has_json else []), *words[1:]]
    with subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        encoding="utf-8", errors="surrogateescape", cwd=cwd, env=environment,
    ) as process:
        _running.add(process)
        if memory:
            _limit_memory(process.pid, memory)
        try:
            printed, said = process.communicate()
        except KeyboardInterrupt:
            process.send_signal(signal.SIGINT)
            process.communicate()
            raise
        finally:
            _running.discard(process)
    lines = [line.removeprefix("t4d: ") for line in said.splitlines() if line and line != _HELP]
    code = process.returncode
    if memory and (code == 127 or (code == -signal.SIGSEGV and not lines)):  # of the dynamic linker
        lines.append("the memory of the task is not enough to start the program")
    if code < 0 and _ended:
        raise SystemExit  # silent in a thread
    # A report that says what is wrong, or different.
    told = code == 4 or (code == 1 and verb == "diff")
    if code not in (0, 3) and not (told and printed):
        raise VerbError("\n".join(lines) or f"t4d {verb} ended with {code}", verb, code)
    notes: List[str] = []
    for line in lines:
        if not line.startswith("try: "):
            notes.append(line)
        elif notes:
            notes[-1] += f"; {line}"
        # A hint by itself is about what the result says.
    warn(Loss if code == 3 else UserWarning, notes)
    return json.loads(printed, object_hook=Report) if has_json and printed else printed


def _is_door(words: Sequence[str], folder: str) -> bool:
    from t4d.__main__ import is_door

    return is_door(words, folder)


def _door() -> Tuple[List[str], Dict[str, str]]:
    """The command that reads what the program does not, and its environment, in which it is this package."""
    paths = [str(Path(__file__).absolute().parents[1]), *filter(None, [os.environ.get("PYTHONPATH")])]
    environment = {**os.environ, "T4D_PROGRAM": program(), "PYTHONPATH": os.pathsep.join(paths)}
    return [sys.executable, "-m", "t4d"], environment


def _limit_memory(pid: int, limit: int) -> None:
    """Limits the memory of a running process, where the system can do that."""
    import resource

    if hasattr(resource, "prlimit"):
        with contextlib.suppress(OSError):
            resource.prlimit(pid, resource.RLIMIT_DATA, (limit, limit))


_running: Set["subprocess.Popen[str]"] = set()
_ended = False


def _end() -> None:
    global _ended
    _ended = True
    processes = list(_running)
    for process in processes:
        process.terminate()
    for process in processes:
        try:
            process.wait(5)
        except subprocess.TimeoutExpired:
            process.kill()


atexit.register(_end)
os.register_at_fork(after_in_child=_running.clear)
