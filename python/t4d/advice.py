"""Options with which bodies that could not be swept become solids, tried before they are given."""

from __future__ import annotations

import re
from typing import Callable, Dict, List, Optional, Sequence

from t4d.errors import Error
from t4d.recorded_body import RecordedBody

# The thickness that sheets get, as a part of the longest side.
_THICKNESS = 1 / 200
_ORDER = ("--mend", "--thicken", "--bodies", "--caps")
_CONES = {"--caps": "cone"}
_COMPONENTS = {"--bodies": "component"}

Options = Dict[str, str]
"""Values by the names of options; empty for those without."""


def of(
    lost: Sequence[RecordedBody], words: Sequence[str], voxel_size: Optional[float], say: Callable[[str], None]
) -> str:
    """What to add to the words so that the lost bodies are swept, all or as many as possible; nothing if none is."""
    if "--union" in words:
        return ""
    wanted: List[Options] = []
    for body in lost:
        say(f"looking for what helps '{body.name}'")
        wanted.append(_for_one(body, words, voxel_size))
    helped = [body for body, options in zip(lost, wanted) if options]
    if not helped:
        return ""
    least = _together(wanted)
    best, most = "", 0
    for options in (least, {**least, **_CONES}, {**least, **_COMPONENTS, **_CONES}):
        added = _words(options)
        saved = sum(_works(body, [*words, *added], voxel_size) for body in helped)
        if saved > most:
            best, most = " ".join(added), saved
        if most == len(helped):
            break
    return best


def _for_one(body: RecordedBody, words: Sequence[str], voxel_size: Optional[float]) -> Options:
    """The least that helps one body: what mends a rigid one, otherwise what the program says of its keys."""
    if body.way == "voxels":
        return {}
    try:
        thickness = {"--thicken": f"{float(f'{_THICKNESS * body.size():.0e}'):g}"}
        for options in ({"--mend": ""}, {"--mend": "", **thickness}) if body.way == "poses" else ():
            added = {name: value for name, value in options.items() if name not in words}
            if added and _works(body, [*words, *_words(added)], voxel_size):
                return added
        found = re.search("^try: (--.+)", body.refusal(), re.MULTILINE)
    except Error:
        return {}  # it has no keys that could be swept
    return _parsed(found[1]) if found else {}


def _works(body: RecordedBody, words: Sequence[str], voxel_size: Optional[float]) -> bool:
    try:
        body.with_words(words).made(voxel_size)
    except Error:
        return False
    return True


def _parsed(text: str) -> Options:
    words = text.split()
    return {name: "" if value.startswith("--") else value
            for name, value in zip(words, [*words[1:], "--"]) if name.startswith("--")}  # fmt: skip


def _together(wanted: Sequence[Options]) -> Options:
    """The options of all; sheets become as thick as is fit for the smallest."""
    all_ = {name: value for options in wanted for name, value in options.items()}
    if "--thicken" in all_:
        all_["--thicken"] = min((options["--thicken"] for options in wanted if "--thicken" in options), key=float)
    return all_


def _words(options: Options) -> List[str]:
    return [word for name in _ORDER if name in options for word in (name, options[name]) if word]
