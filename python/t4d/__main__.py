"""The program t4d, and the Python door of its verbs: ``python3 -m t4d weave scan/ --iso 300 -o scan.t4d``,
``python3 -m t4d sweep walk.fbx -o walk.t4d``, ``python3 -m t4d mend part.fbx -o part.ply``.

The words are those of the program. If weave is given what readers of Python know (``t4d.open_frames``), its frames
go to the program through a pipe; if sweep is given an animation of other programs, it is t4d-blender (``t4d.blender``);
other inputs of such programs become triangle meshes first (``t4d.converted``). All else is the program's work alone.
Messages and exit codes are the program's.
"""

from __future__ import annotations

import contextlib
import inspect
import logging
import os
import re
import signal
import subprocess
import sys
import tempfile
import warnings
from pathlib import Path
from typing import Any, Callable, Dict, List, NamedTuple, NoReturn, Optional, Sequence, Tuple

import numpy as np

from t4d import blender, converted, readers, scenes
from t4d.commands import options_of, program
from t4d.errors import Error
from t4d.frames import MOST_FRAMES, Frames, open_frames
from t4d.readers.volume import Missing, WrongOption, extension_of, natural
from t4d.stream import write_nrrd, write_stream

_USAGE, _LOSS, _INVALID = 2, 3, 4
# What open_frames takes is the door's: a region counts what the file has, and so do times and an origin beside it.
_DOOR = [name for name in inspect.signature(open_frames).parameters if name != "source"]
_NUMBERS = ("spacing", "origin", "times", "frame_time", "start_time")
_LEAST_OF_PATTERN = 3  # names
_PATIENCE = 10  # seconds for the program to clean up
_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)


class Given(NamedTuple):
    """An option as it is given."""

    words: List[str]
    values: List[str]


Options = Dict[str, List[Given]]
"""By name, as frame_time, for each time it is given."""


def split(words: Sequence[str]) -> Tuple[List[str], Options]:
    """Inputs and options of the words after weave. The program's description tells how many values an option
    takes."""
    known: Dict[str, Dict[str, Any]] = {name: {"value": "TEXT", "repeats": False} for name in _DOOR}
    known.update(options_of("weave"))
    inputs: List[str] = []
    options: Options = {}
    left = list(words)
    while left:
        word = left.pop(0)
        if word == "--":
            return [*inputs, *left], options
        if not _is_option(word):
            inputs.append(word)
            continue
        if re.match(r"-[a-zA-Z].", word) and known.get(word[1], {"value": ""})["value"] is None:
            left.insert(0, "-" + word[2:])  # short options in one word
            word = word[:2]
        name, equals, value = word.partition("=") if word.startswith("--") else (word[:2], word[2:], word[2:])
        plain = name.lstrip("-").replace("-", "_")
        option = known.get(plain, {"value": None})
        values = [value] if equals else []
        if option["value"] is not None and not equals:
            most = len(left) if option["repeats"] else len(option["value"].split())
            while left and len(values) < most and not _is_option(left[0]):
                values.append(left.pop(0))
        options.setdefault(plain, []).append(Given([word, *([] if equals else values)], values))
    return inputs, options


def _is_option(word: str) -> bool:
    return len(word) > 1 and word[0] == "-" and not re.match(r"-\.?\d", word)


def _values(options: Options, name: str) -> List[str]:
    return [value for given in options.get(name, []) for value in given.values]


def _velocity_files(options: Options) -> List[str]:
    return [file for value in _values(options, "velocity_file") for file in value.split(",")]


def _parameters(options: Options) -> Dict[str, Any]:
    """The parameters of open_frames. Raises ValueError for what is no number."""
    given = {name: ",".join(options[name][0].values) for name in _DOOR if name in options}
    parameters: Dict[str, Any] = dict(given)
    for name, text in given.items():
        if len(options[name]) > 1 or not text:
            raise WrongOption(name, f"is given {len(options[name])} times" if text else "has no value")
        if name not in _NUMBERS:
            continue
        try:
            if ":" in text:
                begin, end, count = text.split(":")
                if not 1 <= int(count) <= MOST_FRAMES:
                    raise ValueError
                numbers = [float(time) for time in np.linspace(float(begin), float(end), int(count))]
            else:
                numbers = [float(number) for number in text.split(",")]
        except ValueError:
            expected = f"a number, several with commas, or A:B:N with N from 1 to {MOST_FRAMES}"
            raise ValueError(f"{name} is '{text}'; expected {expected}") from None
        parameters[name] = numbers[0] if len(numbers) == 1 and name != "times" else numbers
    return parameters


def in_order(paths: List[str]) -> Tuple[List[str], List[str]]:
    """Names stay in the order given, unless it is the one in which a shell sorts what a pattern matches: frame1
    frame10 frame2. These are put in the order of their numbers. Also notes."""
    by_number = sorted(paths, key=natural)
    if paths == by_number or len({re.sub(r"\d+", "0", path) for path in paths}) > 1:
        return paths, []
    if paths == sorted(paths) and len(paths) >= _LEAST_OF_PATTERN:
        return by_number, [readers.order_note(by_number)]
    ends = f"{paths[0]} to {paths[-1]}"
    return paths, [f"frames are in the order given, from {ends}, which is not that of the numbers in their names"]


def _is_of_door(path: str) -> bool:
    return extension_of(path) not in readers.PROGRAM and readers.kind_of(path) != ""


def is_door(words: Sequence[str], folder: str = "") -> bool:
    """Whether one of the inputs among the words after weave is for a reader of Python, and not for the program."""
    inputs, options = split(words)
    paths = [path if "://" in path else os.path.join(folder, path) for path in [*inputs, *_velocity_files(options)]]
    return "-" not in inputs and any(map(_is_of_door, paths))


def _open(paths: List[str], options: Options) -> Frames:
    """The frames as the options of the program need them, which are changed where the frames say what is no data.
    Raises Error and WrongOption."""
    paths, notes = in_order(paths)
    frames = open_frames(paths, **_parameters(options))
    frames.notes[:0] = notes
    label, outside = _values(options, "label"), _values(options, "outside_value")
    if label:
        return frames.filled(-1 if label[0] == "0" else 0) if frames.padded else frames
    if not {"iso", "below"} & set(options) and frames.whole and frames.dtype.kind == "f":
        said = "has whole numbers as samples, which do not say what is inside; an iso value or a label must be given"
        raise Missing(said, paths[0], "iso", "VALUE, if the samples are densities (inside is where they are above it)")
    if frames.padded:
        options["outside_value"] = [Given(["--outside-value=nan"], [])]
        return frames.without(float(outside[0])) if outside and outside[0].lower() != "nan" else frames
    return frames


def _write_velocities(options: Options, folder: str) -> None:
    """Makes of the files of velocities those that the program reads, along x, y and z, where they are by themselves."""
    files = _velocity_files(options)
    if len(files) not in (1, 3):
        raise WrongOption("velocity_file", "takes three files, or one with three channels")
    if "region" in options:
        raise WrongOption("region", "and velocities exclude each other: where a solid is cut off it does not move")
    written = []
    for channel, path in enumerate(files * (3 // len(files))):
        if extension_of(path) in readers.PROGRAM and extension_of(path) != ".npy":  # which needs --axes
            written.append(path)
            continue
        name = re.sub(r"[^\w.-]", "_", os.path.basename(os.path.normpath(path)))
        written.append(os.path.join(folder, f"{'xyz'[channel]}-{name}.nrrd"))
        choices = {*readers.options_of(path)} - {"channel"}
        parameters = {name: value for name, value in _parameters(options).items() if name in choices}
        if len(files) == 1:
            parameters["channel"] = channel
            if "c" not in parameters.get("axes", "c"):  # of the frames, which have no channels
                del parameters["axes"]
        write_nrrd(open_frames(path, **parameters), written[-1])
    options["velocity_file"] = [Given(["--velocity-file", *written], written)]


def _part(said: str, frames: int) -> Optional[Tuple[int, int]]:
    """The first and the last frame of a part, K/N; None for all."""
    found = re.fullmatch(r"(\d+)/(\d+)", said)
    if not found or not 1 <= int(found[1]) <= int(found[2]):
        return None
    number, count, steps = int(found[1]), int(found[2]), frames - 1
    begin, end = (part * (steps // count) + min(part, steps % count) for part in (number - 1, number))
    return (begin, end) if begin < end else None


class Ended(BaseException):
    """The program was ended by a signal."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number


def _end(number: int, _: Any) -> NoReturn:
    raise Ended(number)


def _run(
    command: List[str],
    frames: Optional[Frames] = None,
    part: Optional[Tuple[int, int]] = None,
    names: Optional[Dict[str, str]] = None,
) -> int:
    """Runs the program, on frames if there are any; returns its exit code. Ends it before what reading raises is
    raised. Its messages call files by other names, if they are given."""
    pipe = subprocess.PIPE
    process = subprocess.Popen(command, stdin=None if frames is None else pipe, stderr=pipe if names else None)
    try:
        for line in process.stderr or []:
            for own, name in (names or {}).items():
                line = line.replace(os.fsencode(own), os.fsencode(name))
            sys.stderr.buffer.write(line.replace(b"try: t4d ", b"try: python3 -m t4d "))
            sys.stderr.buffer.flush()
        if frames is not None and process.stdin is not None:
            with contextlib.suppress(BrokenPipeError):  # the program says why it ended
                write_stream(frames, process.stdin, part)
            with contextlib.suppress(BrokenPipeError):
                process.stdin.close()
        return process.wait()
    except BaseException as error:
        process.send_signal(error.number if isinstance(error, Ended) else signal.SIGTERM)
        try:
            process.wait(_PATIENCE)
        except subprocess.TimeoutExpired:
            process.kill()
        raise


def _say(text: str) -> None:
    print("t4d: " + text.encode(errors="replace").decode().replace("\n", "\\n"), file=sys.stderr)


def _in_options(said: str) -> str:
    """A message about a parameter of open_frames, as one about the option."""
    found = re.match(r"(\w+)(\[\d\])?( is (?!not|given))? ?", said)
    if not found or found[1] not in (*_DOOR, "velocity_file"):
        return said
    return f"--{found[1].replace('_', '-')}{':' if found[3] else ''} {said[found.end():]}"


def weave(inputs: List[str], options: Options) -> int:
    """The exit code of weave, for inputs of the door."""
    if not {*_DOOR, *options_of("weave")}.issuperset(options):  # the program says what is wrong with them
        return _run([program(), "weave", "-", *(word for all_ in options.values() for one in all_ for word in one.words)])
    try:
        with tempfile.TemporaryDirectory(prefix="t4d-velocities-") as folder:
            frames = _open(inputs, options) if any(map(_is_of_door, inputs)) else None
            done = {name for name in _DOOR if frames is not None}
            if "velocity_file" in options:
                _write_velocities(options, folder)
                done -= {"spacing", "origin"}  # the program gives velocities the place of the solid
            names = [name for name in options if name not in done]
            words = [word for name in names for given in options[name] for word in given.words]
            every = "all" in _values(options, "label")  # are looked for in all frames
            part = None
            if frames is not None and not every:
                part = _part("".join(_values(options, "part")), len(frames))
            return _run([program(), "weave", *(inputs if frames is None else ["-"]), *words], frames, part)
    except Error as error:
        _say(str(error))
        if isinstance(error, Missing):
            _say(f"try: --{error.option} {error.value}")
        return _INVALID
    except (TypeError, ValueError) as error:
        _say(_in_options(str(error)))
        return _USAGE


def _weave(words: List[str]) -> int:
    logging.basicConfig(handlers=[logging.NullHandler()])  # what libraries log, an error or a note says
    warnings.simplefilter("ignore")
    return weave(*split(words))


def _until_ended(work: Callable[[List[str]], int], words: List[str]) -> int:
    """The exit code of work on words; a signal that ends this process ends the program first, and both by it."""
    caught = [number for number in _SIGNALS if signal.getsignal(number) is not signal.SIG_IGN]
    try:
        for number in caught:
            signal.signal(number, _end)
        code = work(words)
    except Ended as ended:
        code = -ended.number
    finally:
        for number in caught:
            signal.signal(number, signal.SIG_DFL)
    if code < 0:
        os.kill(os.getpid(), -code)  # ends as the program did
    return code


def _on_meshes(words: List[str]) -> int:
    """The exit code of the program on words whose scenes have become meshes."""
    with tempfile.TemporaryDirectory(prefix="t4d-") as folder:
        try:
            made = converted.convert(words, Path(folder))
        except Error as error:
            _say(str(error))
            return blender.code_of(error)
        if not {"-q", "--quiet"} & set(words):
            for note in made.notes:
                _say(f"note: {note}")
        for loss in made.losses:
            _say(f"lost: {loss}")
        code = _run([program(), *made.words], names=made.names)
        return _LOSS if code == 0 and made.losses else code


def _help(verb: str) -> int:
    """Prints the help of the program, and what this module adds."""
    code = subprocess.run([program(), verb, "--help"], check=False).returncode
    also = ", ".join(readers.known()) if verb == "weave" else f"{', '.join(scenes.EXTENSIONS)}, as t4d-blender does"
    print(f"\npython3 -m t4d {verb} also reads {also}")
    return code


def main(words: List[str]) -> int:
    is_help = bool({"-h", "--help"} & set(words))
    if words[:1] in (["weave"], ["sweep"]) and is_help and "--json" not in words:
        return _help(words[0])
    animation = converted.animation_of(words[1:]) if words[:1] == ["sweep"] and not is_help else []
    if animation:
        return blender.main(animation)
    if converted.is_needed(words[1:]) and not is_help:
        return _until_ended(_on_meshes, words)
    if words[:1] == ["weave"]:
        door = False
        with contextlib.suppress(ValueError, KeyError):  # what does not describe itself is run, too
            door = not is_help and is_door(words[1:])
        if door:
            return _until_ended(_weave, words[1:])
    sys.stdout.flush()
    os.execv(program(), [program(), *words])


if __name__ == "__main__":
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    try:
        sys.exit(main(sys.argv[1:]))
    except OSError as error:  # of the program
        _say(str(error))
        sys.exit(1)
