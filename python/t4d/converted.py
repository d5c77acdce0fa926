"""Words of the program whose inputs are scenes of other programs, which it does not read: their solids at rest become
triangle meshes in temporary files (``t4d.still``)."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Dict, Iterator, List, NamedTuple, Sequence, Tuple

from t4d import scenes, still
from t4d.triangles import TriangleMesh

_OUTPUTS = ("-o", "--output")


class Converted(NamedTuple):
    """The words as the program is given them, what the user calls the files among them, and sentences for people."""

    words: List[str]
    names: Dict[str, str]
    notes: List[str]
    losses: List[str]


def is_needed(words: Sequence[str]) -> bool:
    """Whether the words after a verb name a scene as an input."""
    return any(True for _ in _inputs(words))


def animation_of(words: Sequence[str]) -> List[str]:
    """What t4d-blender is given if the words after sweep name an animation, not a solid that something else moves;
    nothing otherwise."""
    files = [words[at] for at, option in _inputs(words) if not option]
    if len(files) != 1 or any(word.partition("=")[0] in ("-m", "--motion") for word in words):
        return []
    return [files[0], *(word for word in words if word != files[0])]


def convert(words: Sequence[str], folder: Path) -> Converted:
    """The words, a verb and what follows, with meshes in the folder. Raises Error."""
    made = Converted(list(words), {}, [], [])
    for number, (at, option) in enumerate(_inputs(words)):
        name = words[at].removeprefix(option)
        found = still.read(name)
        place = folder / str(number) / f"{Path(name).stem}.vtp"
        place.parent.mkdir()
        attributes = found.attributes if words[0] == "sweep" else {}  # no other verb keeps them
        TriangleMesh(found.vertices, found.triangles, {}, attributes).save(place, attributes=True)
        made.words[at] = f"{option}{place}"
        made.names[str(place)] = name
        made.names[str(place.parent)] = os.path.dirname(name) or "."  # where the program proposes an output
        made.notes.extend(f"{name}: {note}" for note in found.notes)
        made.losses.extend(f"{name}: {loss}" for loss in found.losses)
    return made


def _inputs(words: Sequence[str]) -> Iterator[Tuple[int, str]]:
    """Where words end in the name of a scene, and what is before the name: the option, as --tool=, or nothing."""
    for at, (before, word) in enumerate(zip(["", *words], words)):
        option = word[: word.find("=") + 1] if word.startswith("--") else ""
        is_output = before in _OUTPUTS or option.rstrip("=") in _OUTPUTS
        is_option = word[:1] == "-" and not option
        if scenes.is_scene(word) and not is_output and not is_option:
            yield at, option
