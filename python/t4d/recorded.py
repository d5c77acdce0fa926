"""4D meshes of recordings: solids at frames of a scene, which ``t4d.recorder`` wrote into a folder.

``scene.json`` has the ``bodies``, each with its ``name`` and its ``keys``: the ``frame``, the ``shape``, a file with
``vertices`` (n, 3), the ``matrix`` (4, 4) that places them, and the ``faces``, a file with ``triangles`` (m, 3) and
attributes. A body is ``rigid`` if all its keys have a ``pose`` (4, 4), which moves the first key to this one. Half way
between two keys the scene is at most the first number of ``from_lines`` from straight lines, at the frame that is the
second, and that of ``from_screws`` from the screw motion between two poses. Also ``fps``, ``metres``, the length of a
unit of the scene, ``materials``, ``source``, ``reader``, ``notes`` and ``losses``.
"""

from __future__ import annotations

import json
import tempfile
from pathlib import Path
from typing import Any, Callable, Dict, List, NamedTuple, Optional, Sequence

from t4d import advice, united
from t4d.errors import Error, VerbError
from t4d.mesh import Mesh
from t4d.recorded_body import RecordedBody


class Recorded(NamedTuple):
    """What became of a recording: a dictionary for JSON, sentences for people, and options with which more of it would
    become bodies."""

    report: Dict[str, Any]
    notes: List[str]
    losses: List[str]
    advice: str = ""


class NoSolids(VerbError):
    """Nothing can be made of a recording, at least not without the options of the advice."""

    def __init__(self, message: str, exit_code: int, advice: str) -> None:
        super().__init__(message, "sweep", exit_code)
        self.advice = advice


def save(
    folder: str,
    output: str,
    words: Sequence[str] = (),
    voxel_size: Optional[float] = None,
    say: Callable[[str], None] = lambda text: None,
    advised: bool = False,
) -> Recorded:
    """Writes a .t4d file of a recording, with a body for each of its own (``t4d.recorded_body``), or with --union one
    of all. ``words`` are options for ``t4d sweep``. What is no solid is a loss, with advice if that is wanted; raises
    NoSolids if all are."""
    scene = json.loads((Path(folder) / "scene.json").read_text(encoding="utf-8"))
    notes, losses = list(scene["notes"]), list(scene["losses"])
    failures: List[Error] = []
    lost: List[RecordedBody] = []
    meshes: List[Mesh] = []
    bodies: List[Dict[str, Any]] = []
    with tempfile.TemporaryDirectory(prefix="t4d-") as place:
        if "--union" in words:
            scene = united.scene_of(Path(folder), scene)
            words = [*words, *([f"--voxel-size={voxel_size!r}"] if voxel_size else [])]
        for number, one in enumerate(scene["bodies"]):
            say(f"body {number + 1} of {len(scene['bodies'])}: {one['name']}")
            body = RecordedBody(Path(folder), Path(place) / str(number), scene, one, words)
            try:
                made = body.made(voxel_size)
            except Error as error:
                if isinstance(error, VerbError) and error.exit_code == 2:
                    raise
                failures.append(error)
                lost.append(body)
                losses.append(f"the body '{body.name}': {body.without_paths(str(error))}")
                continue
            notes.extend(f"body '{body.name}': {note}" for note in made.notes)
            losses.extend(f"body '{body.name}': {loss}" for loss in made.losses)
            meshes.append(made.mesh)
            for name in made.mesh.names:
                bodies.append({"name": name, "way": body.way, "keys": len(one["keys"]), **body.distance()})
        found = advice.of(lost, words, voxel_size, say) if advised else ""
        if not meshes:
            failed = any(getattr(error, "exit_code", 4) == 1 for error in failures)
            raise NoSolids("\n".join(losses), 1 if failed else 4, found)
        say("writing")
        details: Dict[str, Any] = {"source": {"scene": scene["source"], "reader": scene["reader"]},
                   "parameters": {"fps": scene["fps"], "options": list(words)}}  # fmt: skip
        if scene["materials"]:
            details["materials"] = ["", *scene["materials"]]
        about = {"backend": "mesh4d", "length_unit": "m", "time_unit": "s", "up": "z", "details": json.dumps(details)}
        size = Mesh._of([body for mesh in meshes for body in mesh._bodies], metadata=about).save(output)
    report = {"bodies": bodies, "fps": scene["fps"], "bytes": size, "losses": losses}
    return Recorded(report, notes, losses, found)


def lines_of(report: Dict[str, Any]) -> List[str]:
    """The results for each body, a line for each."""
    lines = []
    for body in report["bodies"]:
        far = body["distance"]
        said = "" if far is None else f", half frames within {far:.3g} m"
        lines.append(f"{body['name']}: {body['keys']} keys, by {body['way']}{said}")
    return lines
