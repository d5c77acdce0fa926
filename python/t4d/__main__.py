"""The program t4d, and the Python door of its verb weave: ``python3 -m t4d weave scan/ --iso 300 -o scan.t4d``.

The words are those of the program. If weave is given what readers of Python know (``t4d.open_frames``), its frames
go to the program through a pipe; all else is the program's work alone. Messages and exit codes are the program's.
"""

from __future__ import annotations

import contextlib
import inspect
import os
import re
import signal
import subprocess
import sys
from typing import Any, Dict, List, NoReturn, Optional, Sequence, Tuple

from t4d import readers
from t4d.commands import options_of, program
from t4d.errors import Error
from t4d.frames import Frames, open_frames
from t4d.readers.volume import Missing, WrongOption, extension_of, natural
from t4d.stream import write_stream

_INVALID, _USAGE = 4, 2
# What the stream leaves to the program; the other parameters of open_frames are the door's.
_OF_PROGRAM = ("source", "spacing", "origin", "frame_time", "start_time", "times", "length_unit", "time_unit")
_DOOR = [name for name in inspect.signature(open_frames).parameters if name not in _OF_PROGRAM]
_LEAST_OF_PATTERN = 3  # names
_PATIENCE = 10  # seconds for the program to clean up


def split(words: Sequence[str]) -> Tuple[List[str], List[str], Dict[str, str]]:
    """Inputs, words that the program gets, and options of the door, of the words after weave. What takes values
    is told by the program's description of its options."""
    known = options_of("weave")
    inputs: List[str] = []
    others: List[str] = []
    own: Dict[str, str] = {}
    left = list(words)
    while left:
        word = left.pop(0)
        if word == "--":
            return [*inputs, *left], others, own
        if not _is_option(word):
            inputs.append(word)
            continue
        name, equals, value = word.partition("=")
        plain = name.lstrip("-").replace("-", "_")
        plain = plain if name.startswith("--") else plain[:1]
        option = known.get(plain, {"value": "TEXT" if plain in _DOOR else None, "repeats": False})
        values = [value] if equals else []
        joined = not name.startswith("--") and len(name) > 2  # -oFILE
        if option["value"] is not None and not equals and not joined:
            most = len(left) if option["repeats"] and plain != "output" and plain != "o" else len(option["value"].split())
            while left and len(values) < most and (not values or not _is_option(left[0])):
                values.append(left.pop(0))
        if plain in _DOOR and name.startswith("--"):
            own[plain] = values[0] if values else ""
        else:
            others += [word, *([] if equals else values)]
    return inputs, others, own


def _is_option(word: str) -> bool:
    return len(word) > 1 and word[0] == "-" and not re.match(r"-\.?\d", word)


def _value(words: Sequence[str], name: str) -> Optional[str]:
    """Of an option among words."""
    for word, following in zip(words, [*words[1:], ""]):
        if word.partition("=")[0] == name:
            return word.partition("=")[2] if "=" in word else following
    return None


def in_order(paths: List[str]) -> Tuple[List[str], str]:
    """Names stay in the order given, unless it is the one in which a shell sorts what a pattern matches: frame1
    frame10 frame2. These are put in the order of their numbers. Also a note, or ""."""
    by_number = sorted(paths, key=natural)
    if len(paths) < 2 or paths == by_number or len({re.sub(r"\d+", "0", path) for path in paths}) > 1:
        return paths, ""
    if paths == sorted(paths) and len(paths) >= _LEAST_OF_PATTERN:
        ends = f"{by_number[0]} to {by_number[-1]}"
        return by_number, f"frames are in the order of the numbers in their names, from {ends}"
    ends = f"{paths[0]} to {paths[-1]}"
    return paths, f"frames are in the order given, from {ends}, which is not that of the numbers in their names"


def is_door(paths: Sequence[str]) -> bool:
    """Whether one of the inputs is for a reader of Python, and not for the program."""
    return any(extension_of(path) not in readers.PROGRAM and readers.kind_of(path) for path in paths)


def _open(paths: List[str], words: Sequence[str], own: Dict[str, str]) -> Frames:
    """The frames, as the options of the program need them. Raises Error and WrongOption."""
    paths, note = in_order(paths)
    frames = open_frames(paths, **own)  # type: ignore[arg-type]
    frames.notes[:0] = [note] if note else []
    label, outside = _value(words, "--label"), _value(words, "--outside-value")
    if label is not None and frames.padded:
        return frames.filled(0 if label != "0" else -1)
    if outside is not None and frames.padded and outside.lower() != "nan":
        frames = frames.without(float(outside))
    decided = label is not None or _value(words, "--iso") is not None or _value(words, "--below") is not None
    if not decided and frames.whole and frames.dtype.kind == "f":
        raise Missing(
            "has whole numbers as samples, which do not say what is inside; an iso value or a label must be given",
            paths[0], "iso", "VALUE, if the samples are densities (inside is where they are above it)",
        )  # fmt: skip
    return frames


def _words_for(frames: Frames, words: List[str], name: str) -> List[str]:
    """The program's own command line for a stream of the frames."""
    label = _value(words, "--label")
    given = list(words)
    if frames.padded and label is None:
        at = next((i for i, word in enumerate(given) if word.partition("=")[0] == "--outside-value"), None)
        if at is not None:
            del given[at : at + (1 if "=" in given[at] else 2)]
        given.append("--outside-value=nan")
    if label in (None, *map(str, range(10))) and _value(words, "--body") is None:
        given.append(f"--body={name}")
    return ["weave", "-", *given]


def _part(words: Sequence[str], frames: int) -> Optional[Tuple[int, int]]:
    """The first and the last frame of a part, --part K/N; None for all."""
    said = re.fullmatch(r"(\d+)/(\d+)", _value(words, "--part") or "")
    if not said or not 1 <= int(said[1]) <= int(said[2]):
        return None
    number, count, steps = int(said[1]), int(said[2]), frames - 1
    begin, end = (part * (steps // count) + min(part, steps % count) for part in (number - 1, number))
    return (begin, end) if begin < end else None


def _feed(frames: Frames, command: List[str], part: Optional[Tuple[int, int]]) -> int:
    """Runs the program on the frames; returns its exit code. Ends it before what reading raises is raised."""
    process = subprocess.Popen(command, stdin=subprocess.PIPE)
    assert process.stdin is not None
    try:
        with contextlib.suppress(BrokenPipeError):  # the program says why it ended
            write_stream(frames, process.stdin, part)  # type: ignore[arg-type]
        with contextlib.suppress(BrokenPipeError):
            process.stdin.close()
        return process.wait()
    except BaseException as error:
        process.send_signal(signal.SIGINT if isinstance(error, KeyboardInterrupt) else signal.SIGTERM)
        try:
            process.wait(_PATIENCE)
        except subprocess.TimeoutExpired:
            process.kill()
        raise


def _say(text: str) -> None:
    print("t4d: " + text.encode(errors="replace").decode().replace("\n", "\\n"), file=sys.stderr)


def weave(words: List[str]) -> int:
    """The exit code of weave, for inputs of the door."""
    inputs, others, own = split(words)
    try:
        frames = _open(inputs, others, own)
        name = re.sub(r"(\.ome)?\.[^.]*$", "", os.path.basename(os.path.normpath(inputs[0])))
        return _feed(frames, [program(), *_words_for(frames, others, name)], _part(others, len(frames)))
    except WrongOption as error:
        _say(f"--{error.option.replace('_', '-')} {error.reason}")
        return _USAGE
    except Error as error:
        _say(str(error))
        if isinstance(error, Missing):
            _say(f"try: --{error.option} {error.value}")
        return _INVALID
    except (TypeError, ValueError) as error:
        _say(str(error))
        return _USAGE


def _terminate(number: int, _: Any) -> NoReturn:
    raise SystemExit(128 + number)


def main(words: List[str]) -> int:
    asks = any(word in ("-h", "--help") for word in words)
    if words[:1] == ["weave"] and not asks and is_door(split(words[1:])[0]):
        signal.signal(signal.SIGTERM, _terminate)
        try:
            return _end(weave(words[1:]))
        except KeyboardInterrupt:
            return _end(-signal.SIGINT)
    sys.stdout.flush()
    os.execv(program(), [program(), *words])


def _end(code: int) -> int:
    """Ends as the program did, also by a signal."""
    if code < 0:
        signal.signal(-code, signal.SIG_DFL)
        os.kill(os.getpid(), -code)
    return code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
