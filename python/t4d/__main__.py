"""The program t4d, and the Python door of its verb weave: ``python3 -m t4d weave scan/ --iso 300 -o scan.t4d``.

The words are those of the program. If weave is given what readers of Python know (``t4d.open_frames``), its frames
go to the program through a pipe; all else is the program's work alone. Messages and exit codes are the program's.
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
import warnings
from typing import Any, Dict, List, NoReturn, Optional, Sequence, Tuple

import numpy as np

from t4d import readers
from t4d.commands import options_of, program
from t4d.errors import Error
from t4d.frames import MOST_FRAMES, Frames, open_frames
from t4d.readers.volume import Missing, WrongOption, extension_of, natural
from t4d.stream import write_stream

_INVALID, _USAGE = 4, 2
# What open_frames takes is the door's: a region counts what the file has, and so do times and an origin beside it.
_DOOR = [name for name in inspect.signature(open_frames).parameters if name != "source"]
_LEAST_OF_PATTERN = 3  # names
_PATIENCE = 10  # seconds for the program to clean up


def split(words: Sequence[str]) -> Tuple[List[str], Dict[str, List[str]], Dict[str, List[str]]]:
    """Inputs, the program's options with their words, and the values of the door's, of the words after weave. How
    many values an option takes is told by the program's description."""
    known = options_of("weave")
    inputs: List[str] = []
    others: Dict[str, List[str]] = {}
    own: Dict[str, List[str]] = {}
    left = list(words)
    while left:
        word = left.pop(0)
        if re.match(r"-[a-zA-Z].", word) and known.get(word[1], {"value": ""})["value"] is None:
            left.insert(0, "-" + word[2:])  # short options in one word
            word = word[:2]
        if word == "--":
            return [*inputs, *left], others, own
        if not _is_option(word):
            inputs.append(word)
            continue
        long = word.startswith("--")
        name, equals, value = word.partition("=") if long else (word[:2], word[2:], word[2:])
        plain = name.lstrip("-").replace("-", "_")
        option = known.get(plain, {"value": "TEXT" if plain in _DOOR else None, "repeats": False})
        values = [value] if equals else []
        if option["value"] is not None and not equals:
            most = len(left) if option["repeats"] else len(option["value"].split())
            own_word = long and plain in _DOOR
            while left and len(values) < most and not ((values or own_word) and _is_option(left[0])):
                values.append(left.pop(0))
        if long and plain in _DOOR:
            own.setdefault(plain, []).append(",".join(values))
        else:
            others.setdefault(name, []).extend([word, *([] if equals else values)])
    return inputs, others, own


def _unknown(options: Dict[str, List[str]]) -> bool:
    """Whether the program does not know one of these; it says so itself."""
    known = options_of("weave")
    return any(name.lstrip("-").replace("-", "_") not in known for name in options)


def _is_option(word: str) -> bool:
    return len(word) > 1 and word[0] == "-" and not re.match(r"-\.?\d", word)


def _value(options: Dict[str, List[str]], name: str) -> Optional[str]:
    """The first value of an option; None if it is not given."""
    words = options.get(name, [])
    return words[0].partition("=")[2] if words and "=" in words[0] else words[1] if len(words) > 1 else None


def _parameters(own: Dict[str, List[str]]) -> Dict[str, Any]:
    """Of open_frames, by the values of options. Raises ValueError for what is no number."""
    given: Dict[str, Any] = {}
    for name, words in own.items():
        if len(words) > 1 or not words[0]:
            option = f"--{name.replace('_', '-')}"
            raise ValueError(f"{option} is given {len(words)} times" if words[0] else f"{option} has no value")
        given[name] = words[0]
    for name in ("spacing", "origin", "times", "frame_time", "start_time"):
        if name not in given:
            continue
        text = given[name]
        try:
            if ":" in text:
                begin, end, count = text.split(":")
                if not 1 <= int(count) <= MOST_FRAMES:
                    raise ValueError
                numbers = [float(time) for time in np.linspace(float(begin), float(end), int(count))]
            else:
                numbers = [float(number) for number in text.split(",")]
        except ValueError:
            said = f"is not a number, several with commas, or A:B:N with N from 1 to {MOST_FRAMES}"
            raise ValueError(f"--{name.replace('_', '-')}: '{text}' {said}") from None
        given[name] = numbers[0] if len(numbers) == 1 and name != "times" else numbers
    return given


def in_order(paths: List[str]) -> Tuple[List[str], List[str]]:
    """Names stay in the order given, unless it is the one in which a shell sorts what a pattern matches: frame1
    frame10 frame2. These are put in the order of their numbers. Also notes."""
    by_number = sorted(paths, key=natural)
    if paths == by_number or len({re.sub(r"\d+", "0", path) for path in paths}) > 1:
        return paths, []
    if paths == sorted(paths) and len(paths) >= _LEAST_OF_PATTERN:
        ends = f"{by_number[0]} to {by_number[-1]}"
        return by_number, [f"frames are in the order of the numbers in their names, from {ends}"]
    ends = f"{paths[0]} to {paths[-1]}"
    return paths, [f"frames are in the order given, from {ends}, which is not that of the numbers in their names"]


def is_door(paths: Sequence[str]) -> bool:
    """Whether one of the inputs is for a reader of Python, and not for the program."""
    return "-" not in paths and any(extension_of(path) not in readers.PROGRAM and readers.kind_of(path) for path in paths)


def _open(paths: List[str], options: Dict[str, List[str]], own: Dict[str, List[str]]) -> Frames:
    """The frames as the options of the program need them, which are changed where the frames say what is no data.
    Raises Error and WrongOption."""
    paths, notes = in_order(paths)
    frames = open_frames(paths, **_parameters(own))
    frames.notes[:0] = notes
    label, outside = _value(options, "--label"), _value(options, "--outside-value")
    if label is not None:
        return frames.filled(-1 if label == "0" else 0) if frames.padded else frames
    if "--iso" not in options and "--below" not in options and frames.whole and frames.dtype.kind == "f":
        said = "has whole numbers as samples, which do not say what is inside; an iso value or a label must be given"
        raise Missing(said, paths[0], "iso", "VALUE, if the samples are densities (inside is where they are above it)")
    if frames.padded:
        options["--outside-value"] = ["--outside-value=nan"]
        return frames if outside is None or outside.lower() == "nan" else frames.without(float(outside))
    return frames


def _part(said: str, frames: int) -> Optional[Tuple[int, int]]:
    """The first and the last frame of a part, K/N; None for all."""
    found = re.fullmatch(r"(\d+)/(\d+)", said)
    if not found or not 1 <= int(found[1]) <= int(found[2]):
        return None
    number, count, steps = int(found[1]), int(found[2]), frames - 1
    begin, end = (part * (steps // count) + min(part, steps % count) for part in (number - 1, number))
    return (begin, end) if begin < end else None


def _feed(frames: Frames, command: List[str], part: Optional[Tuple[int, int]]) -> int:
    """Runs the program on the frames; returns its exit code. Ends it before what reading raises is raised."""
    process = subprocess.Popen(command, stdin=subprocess.PIPE)
    assert process.stdin is not None
    try:
        with contextlib.suppress(BrokenPipeError):  # the program says why it ended
            write_stream(frames, process.stdin, part)
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


def weave(inputs: List[str], options: Dict[str, List[str]], own: Dict[str, List[str]]) -> int:
    """The exit code of weave, for inputs of the door."""
    try:
        for option in ("axes", "spacing", "origin", "region"):
            if option in own and "--velocity-file" in options:
                raise WrongOption(option, "is not for files of velocities, which the program reads: leave it out, or "
                                  "use t4d weave")  # fmt: skip
        frames = _open(inputs, options, own)
        words = [word for of_option in options.values() for word in of_option]
        every = any(word.endswith("all") for word in options.get("--label", []))  # are looked for in all frames
        part = None if every else _part(_value(options, "--part") or "", len(frames))
        return _feed(frames, [program(), "weave", "-", *words], part)
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


def _help() -> int:
    """Of the program, and what the door adds."""
    code = subprocess.run([program(), "weave", "--help"], check=False).returncode
    print(f"\npython3 -m t4d weave also reads {', '.join(readers.known())}, with these options:\n  "
          "--dataset TEXT  HDF5, Zarr, VTK: path or name of the array\n"
          "  --channel, --level, --series  also by name")  # fmt: skip
    return code


def main(words: List[str]) -> int:
    if words[:1] == ["weave"] and {"-h", "--help"} & set(words) and "--json" not in words:
        return _help()
    if words[:1] == ["weave"] and not {"-h", "--help"} & set(words):
        given = split(words[1:])
        if is_door(given[0]) and not _unknown(given[1]):
            signal.signal(signal.SIGTERM, _terminate)
            logging.disable()  # libraries say in their own way what an error or a note says
            warnings.simplefilter("ignore")
            try:
                code = weave(*given)
            except KeyboardInterrupt:
                code = -signal.SIGINT
            if code < 0:  # ends as the program did
                if code != -signal.SIGKILL:
                    signal.signal(-code, signal.SIG_DFL)
                os.kill(os.getpid(), -code)
            return code
    sys.stdout.flush()
    os.execv(program(), [program(), *words])


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except FileNotFoundError as error:  # of the program
        _say(str(error))
        sys.exit(1)
