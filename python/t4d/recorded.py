"""4D meshes of recordings: solids at frames of a scene, which ``t4d.recorder`` wrote into a folder.

``scene.json`` has the ``bodies``, each with its ``name`` and its ``keys``: the ``frame``, the ``shape``, a file with
``vertices`` (n, 3), the ``matrix`` (4, 4) that places them, and the ``faces``, a file with ``triangles`` (m, 3) and
attributes. A body is ``rigid`` if all its keys have a ``pose`` (4, 4), which moves the first key to this one. In
between, the scene is at most ``distance`` from the body, at ``distance_frame``. Also ``fps``, ``metres``, the length of
a unit of the scene, ``materials``, ``source``, ``reader``, ``notes`` and ``losses``.
"""

from __future__ import annotations

import json
import os
import re
import tempfile
import warnings
from pathlib import Path
from typing import Any, Callable, Dict, List, NamedTuple, Optional, Sequence, Tuple
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from t4d import _t4d
from t4d.commands import run_words
from t4d.errors import Error, InvalidInput, Loss, VerbError
from t4d.mesh import Mesh, read, sweep
from t4d.motions import _quaternion
from t4d.still import merged, whole
from t4d.triangles import TriangleMesh

# Without --voxel-size: of the longest side of a body whose faces change.
_VOXELS = 100
# Of its size: vertices that are one move together up to float32.
_TOGETHER = 1e-5


class Recorded(NamedTuple):
    """What became of a recording: a dictionary for JSON, and sentences for people."""

    report: Dict[str, Any]
    notes: List[str]
    losses: List[str]


def save(
    folder: str,
    output: str,
    words: Sequence[str] = (),
    voxel_size: Optional[float] = None,
    say: Callable[[str], None] = lambda text: None,
) -> Recorded:
    """Writes a .t4d file of a recording, with a body for each of its own: rigid ones swept along their poses, others
    from key to key, and those whose faces change woven from voxels of ``voxel_size`` metres. ``words`` are options for
    ``t4d sweep``. A body that is not a solid is a loss; raises VerbError if all are."""
    scene = json.loads((Path(folder) / "scene.json").read_text(encoding="utf-8"))
    notes, losses = list(scene["notes"]), list(scene["losses"])
    failures: List[Error] = []
    bodies: List[Dict[str, Any]] = []
    with tempfile.TemporaryDirectory(prefix="t4d-") as place:
        meshes: List[Mesh] = []
        for number, body in enumerate(scene["bodies"]):
            name = body["name"]
            say(f"body {number + 1} of {len(scene['bodies'])}: {name}")
            made = _Made(Path(folder), Path(place) / str(number), scene, body)
            try:
                with warnings.catch_warnings(record=True) as caught:
                    warnings.simplefilter("always")
                    made.save(words, voxel_size)
            except Error as error:
                if isinstance(error, VerbError) and error.exit_code == 2:
                    raise
                failures.append(error)
                losses.append(f"the body '{name}': {made.without_paths(str(error))}")
                continue
            for one in (one for one in caught if issubclass(one.category, UserWarning)):
                kept = losses if issubclass(one.category, Loss) else notes
                kept.append(f"body '{name}': {made.without_paths(str(one.message))}")
            meshes.append(read(made.output))
            bodies.append({"name": name, "way": made.way, "keys": len(body["keys"]), **made.distance()})
        if not meshes:
            failed = any(getattr(error, "exit_code", 4) == 1 for error in failures)
            raise VerbError("\n".join(losses), "sweep", 1 if failed else 4)
        say("writing")
        details = {"source": {"scene": scene["source"], "reader": scene["reader"]},
                   "parameters": {"fps": scene["fps"], "options": list(words)}}  # fmt: skip
        if scene["materials"]:
            details["materials"] = scene["materials"]
        about = {"backend": "mesh4d", "length_unit": "m", "time_unit": "s", "up": "z", "details": json.dumps(details)}
        size = Mesh._of([mesh._bodies[0] for mesh in meshes], metadata=about).save(output)
    report = {"bodies": bodies, "fps": scene["fps"], "bytes": size, "losses": losses}
    return Recorded(report, notes, losses)


def lines_of(report: Dict[str, Any]) -> List[str]:
    """What was made of each body, a line for each."""
    lines = []
    for body in report["bodies"]:
        far = body["distance"]
        said = "" if far is None else f", half frames within {far:.3g} m"
        lines.append(f"{body['name']}: {body['keys']} keys, by {body['way']}{said}")
    return lines


class _Made:
    """A body and its own file."""

    def __init__(self, folder: Path, place: Path, scene: Dict[str, Any], body: Dict[str, Any]) -> None:
        self._folder, self._place, self._body = folder, place, body
        self._scene, self._keys, self._metres = scene, body["keys"], float(scene["metres"])
        self.output = str(place / "body.t4d")
        self.way = "poses" if body["rigid"] else "keys"
        if len({key["faces"] for key in self._keys}) > 1:
            self.way = "voxels"
        # Vertices that are kept; those that triangles use, their numbers among the kept, and the triangles by these.
        self._merged: Optional[Tuple[NDArray[Any], NDArray[Any], NDArray[Any], NDArray[Any]]] = None
        place.mkdir()

    def save(self, words: Sequence[str], voxel_size: Optional[float]) -> None:
        """Writes the body to `output`. In memory, which keeps attributes; with options, by the program."""
        if len(self._keys) < 2:
            raise InvalidInput(f"it is visible at frame {self._keys[0]['frame']:g} alone; a motion has at least 2")
        name = [f"--body={self._body['name']}", "-o", self.output]
        if self.way == "voxels":
            size = voxel_size or float(np.ptp(self._positions(self._keys[0]), axis=0).max()) / _VOXELS
            run_words(["weave", self._write_frames(), f"--voxel-size={size!r}", *name])
        elif self.way == "poses":
            motion = {"length_unit": "m", "time_unit": "s", "poses": [self._pose(key) for key in self._keys]}
            if not words:
                sweep(self._solid(), motion=motion, name=self._body["name"]).save(self.output)
                return
            file, solid = self._place / "motion.json", self._place / "solid.vtp"
            file.write_text(json.dumps(motion), encoding="utf-8")
            self._solid(attributes=False).save(solid)
            run_words(["sweep", str(solid), "--motion", str(file), *name, *words])
        elif words:
            run_words(["sweep", self._write_frames(), *name, *words])
        else:
            times = [self._time(key) for key in self._keys]
            keys = [self._positions(key) for key in self._keys]
            producer = _t4d.sweep_keys(self._solid()._mesh, times, keys, caps="tetgen", prism=14)
            Mesh._of(producer=producer, name=self._body["name"]).save(self.output)

    def distance(self) -> Dict[str, Any]:
        if self.way == "voxels":
            return {"distance": None, "distance_frame": None}
        return {"distance": self._body["distance"], "distance_frame": self._body["distance_frame"]}

    def without_paths(self, text: str) -> str:
        """A message of the program, whose files nobody else sees."""
        lines = [line for line in text.splitlines() if str(self._place) not in line or "try:" not in line]
        return re.sub("^(note|lost): ", "", "\n".join(lines).replace(str(self._place) + os.sep, ""))

    def _time(self, key: Dict[str, Any]) -> float:
        """Seconds after the first frame of the recording."""
        first = min(body["keys"][0]["frame"] for body in self._scene["bodies"])
        return float((key["frame"] - first) / self._scene["fps"])

    def _array(self, file: str) -> Dict[str, NDArray[Any]]:
        with np.load(self._folder / file) as arrays:
            return dict(arrays)

    def _positions(self, key: Dict[str, Any]) -> NDArray[np.float64]:
        """(n, 3) at a key, in metres: the vertices that triangles use; those at one place at the first key are one."""
        matrix = np.array(key["matrix"])
        vertices: NDArray[np.float64] = self._array(key["shape"])["vertices"] @ matrix[:3, :3].T + matrix[:3, 3]
        if self.way == "voxels":
            return vertices * self._metres
        if self._merged is None:
            used, corners = np.unique(self._array(key["faces"])["triangles"], return_inverse=True)
            first, number = merged(vertices[used])
            self._merged = used[first], used, number, number[corners].reshape(-1, 3)
        kept, used, number, _ = self._merged
        apart = np.abs(vertices[kept][number] - vertices[used]).max()
        if apart > _TOGETHER * np.ptp(vertices, axis=0).max():
            frame = f"frame {key['frame']:g}"
            raise InvalidInput(f"vertices that are at one place at first are {apart:.3g} apart at {frame}")
        together: NDArray[np.float64] = vertices[kept] * self._metres
        return together

    def _solid(self, attributes: bool = True) -> TriangleMesh:
        """At the first key."""
        vertices = self._positions(self._keys[0])
        assert self._merged is not None
        found = self._array(self._keys[0]["faces"]) if attributes else {}
        found.pop("triangles", None)
        triangles = self._merged[3]
        left = whole(triangles)
        return TriangleMesh(vertices, triangles[left], {}, {name: values[left] for name, values in found.items()})

    def _pose(self, key: Dict[str, Any]) -> Dict[str, Any]:
        pose = np.array(key["pose"])
        return {"time": self._time(key), "position": (pose[:3, 3] * self._metres).tolist(),
                "quaternion": _quaternion(pose[:3, :3]).tolist()}  # fmt: skip

    def _write_frames(self) -> str:
        """A mesh for each key, and the collection that lists them."""
        lines = []
        for number, key in enumerate(self._keys):
            file = f"frame_{number}.vtp"
            triangles = self._array(key["faces"])["triangles"]
            positions = self._positions(key)
            TriangleMesh(positions, triangles if self._merged is None else self._merged[3]).save(self._place / file)
            lines.append(f'<DataSet timestep="{self._time(key)!r}" file={quoteattr(file)}/>')
        frames = self._place / "frames.pvd"
        frames.write_text('<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1"><Collection>\n'
                          + "\n".join(lines) + "\n</Collection></VTKFile>\n", encoding="utf-8")  # fmt: skip
        return str(frames)
