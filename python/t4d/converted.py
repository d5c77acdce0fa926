"""Words of the program whose inputs are scenes of other programs, which it does not read, or robots made of these:
their solids at rest become triangle meshes in temporary files (``t4d.still``, ``t4d.robots``)."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Dict, Iterator, List, NamedTuple, Optional, Sequence

from t4d import robots, scenes, still
from t4d.triangles import TriangleMesh

_OUTPUTS = ("-o", "--output")


class Converted(NamedTuple):
    """The words as the program is given them, what the user calls the files among them, and sentences for people."""

    words: List[str]
    names: Dict[str, str]
    notes: List[str]
    losses: List[str]


def is_needed(words: Sequence[str], folder: str = "") -> bool:
    """Whether the words after a verb, which runs in a folder, name such an input."""
    names = [word[len(option) :] for word, option in zip(words, _options(words)) if option is not None]
    return any(scenes.is_scene(name) or robots.is_needed(os.path.join(folder, name)) for name in names)


def animation_of(words: Sequence[str]) -> List[str]:
    """What t4d-blender is given if the words after sweep name an animation, not a solid that something else moves;
    nothing otherwise."""
    files = [word for word, option in zip(words, _options(words)) if option == "" and scenes.is_scene(word)]
    if len(files) != 1 or any(word.partition("=")[0] in ("-m", "--motion") for word in words):
        return []
    return [files[0], *(word for word in words if word != files[0])]


def convert(words: Sequence[str], folder: Path) -> Converted:
    """Converts the meshes of a verb and its words to files in the folder. Raises Error."""
    made = Converted(list(words), {}, [], [])
    for at, option in enumerate(_options(words)):
        name, home = words[at][len(option or "") :], folder / str(at)
        if option is None or not (scenes.is_scene(name) or robots.is_needed(name)):
            continue
        home.mkdir()
        if scenes.is_scene(name):
            place = _save(name, home, made, attributes=words[0] == "sweep")  # no other verb keeps them
        else:
            packages = {one: Path(there) for one, _, there in (v.partition("=") for v in _values(words, "--package"))}
            robot = robots.convert(name, home, "".join(_values(words, "--geometry")[:1]), packages)
            place = robot.path
            made.names.update(robot.names)
            made.losses.extend(robot.losses)
        made.words[at] = option + place
        made.names[f"{home}{os.sep}"] = os.path.join(os.path.dirname(name), "")  # where the program proposes an output
    return made


def _save(name: str, home: Path, made: Converted, attributes: bool) -> str:
    found = still.read(name)
    place = home / f"{Path(name).stem}.vtp"
    kept = found.attributes if attributes else {}
    TriangleMesh(found.vertices, found.triangles, {}, kept).save(place, attributes=True)
    made.names[str(place)] = name
    made.notes.extend(f"{name}: {note}" for note in found.notes)
    made.losses.extend(f"{name}: {loss}" for loss in found.losses)
    return str(place)


def _options(words: Sequence[str]) -> Iterator[Optional[str]]:
    """Of each word, what is before the name of an input in it, as --tool=, or nothing; None if it is an option alone,
    or the name of an output."""
    for before, word in zip(["", *words], words):
        option = word[: word.find("=") + 1] if word.startswith("--") else ""
        is_output = before in _OUTPUTS or option.rstrip("=") in _OUTPUTS
        yield None if is_output or (word[:1] == "-" and not option) else option


def _values(words: Sequence[str], option: str) -> List[str]:
    """The values given for an option."""
    apart = [word for before, word in zip(words, words[1:]) if before == option]
    return [*apart, *(word[len(option) + 1 :] for word in words if word.startswith(f"{option}="))]
