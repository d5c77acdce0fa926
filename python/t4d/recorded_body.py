"""A body of a recording, and the file that is made of it: swept along its poses, or from key to key, or woven of voxels
if its faces change."""

from __future__ import annotations

import json
import os
import re
import warnings
from pathlib import Path
from typing import Any, Collection, Dict, List, NamedTuple, Optional, Sequence, Tuple
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from t4d import _t4d
from t4d.commands import run_words
from t4d.errors import InvalidInput, Loss, VerbError
from t4d.mesh import Mesh, read, sweep
from t4d.motions import _quaternion
from t4d.still import merged, whole
from t4d.triangles import TriangleMesh

# Voxels along the longest side of a body whose faces change, without --voxel-size.
_VOXELS = 100
# Vertices within this part of the body's size are one: they move together up to float32.
_TOGETHER = 1e-5


class Made(NamedTuple):
    """A mesh, of one body or more, and sentences for people."""

    mesh: Mesh
    notes: List[str]
    losses: List[str]


class RecordedBody:
    """A body, and a folder of its own."""

    def __init__(
        self, folder: Path, place: Path, scene: Dict[str, Any], body: Dict[str, Any], words: Sequence[str]
    ) -> None:
        """A body of a recording. The words are options of sweep; some need keys where poses would do."""
        self._folder, self._place, self._body = folder, place, body
        self._scene, self._keys, self._metres = scene, body["keys"], float(scene["metres"])
        self._words = list(words)
        self.name = str(body["name"])
        self.way = "poses" if body["rigid"] and not is_divided(words) and "--union" not in words else "keys"
        if len({key["faces"] for key in self._keys}) > 1:
            self.way = "voxels"
        # Vertices that are kept; those that triangles use, their numbers among the kept, and the triangles by these.
        self._merged: Optional[Tuple[NDArray[Any], NDArray[Any], NDArray[Any], NDArray[Any]]] = None

    def with_words(self, words: Sequence[str]) -> RecordedBody:
        """The same body with other options."""
        return RecordedBody(self._folder, self._place, self._scene, self._body, words)

    def made(self, voxel_size: Optional[float]) -> Made:
        """The mesh, from memory or, with options, from the program. Raises Error if it is no solid."""
        if len(self._keys) < 2:
            raise InvalidInput(f"it is visible at frame {self._keys[0]['frame']:g} alone; a motion has at least 2")
        self._place.mkdir(exist_ok=True)
        output = self._place / "body.t4d"
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            self._save(output, voxel_size)
        said = [one for one in caught if issubclass(one.category, UserWarning)]
        notes = [self.without_paths(str(one.message)) for one in said if not issubclass(one.category, Loss)]
        if self.way == "voxels" and self._words:
            notes.append(f"it is woven of voxels, since its faces change, without {' '.join(self._words)}")
        losses = [self.without_paths(str(one.message)) for one in said if issubclass(one.category, Loss)]
        return Made(read(output), notes, losses)

    def _save(self, output: Path, voxel_size: Optional[float]) -> None:
        name = f"--body={self.name}"
        if self.way == "voxels":
            size = voxel_size or self.size() / _VOXELS
            run_words(["weave", self._write_frames(), f"--voxel-size={size!r}", name, "-o", str(output)])
        elif self.way == "poses":
            motion = {"length_unit": "m", "time_unit": "s", "poses": [self._pose(key) for key in self._keys]}
            if not self._words:
                sweep(self._solid(), motion=motion, name=self.name).save(output)
                return
            file, solid = self._place / "motion.json", self._place / "solid.vtp"
            file.write_text(json.dumps(motion), encoding="utf-8")
            self._solid().save(solid, attributes=True)
            run_words(["sweep", str(solid), "--motion", str(file), name, "-o", str(output), *self._words])
        elif is_divided(self._words):
            self._divide(output)
        elif self._words:
            run_words(["sweep", self._write_frames(), name, "-o", str(output), *self._words])
        else:
            times = [self._time(key) for key in self._keys]
            keys = [self._positions(key) for key in self._keys]
            producer = _t4d.sweep_keys(self._solid()._mesh, times, keys, caps="tetgen", prism=14)
            Mesh._of(producer=producer, name=self.name).save(output)

    def _divide(self, output: Path) -> None:
        """A body for each component, with numbers that make no name of another body; of one component, as without."""
        name, others = self.name, {body["name"] for body in self._scene["bodies"]} - {self.name}
        while name in others or any(other.startswith(f"{name} ") for other in others):
            name += " part"
        run_words(["sweep", self._write_frames(name), "-o", str(output), *self._words])
        if len(read(output).names) == 1 and (self._body["rigid"] or name != self.name):
            one = self.with_words(without_division(self._words))
            one._save(output, None)
            self.way = one.way

    def refusal(self) -> str:
        """What the program says of its keys, with the options that help if it knows some; nothing if it sweeps them."""
        try:
            run_words(["sweep", self._write_frames(), "-o", str(self._place / "body.t4d"), *self._words])
        except VerbError as error:
            return str(error)
        return ""

    def size(self) -> float:
        """The longest side at the first key, in metres."""
        return float(np.ptp(self._positions(self._keys[0]), axis=0).max())

    def distance(self) -> Dict[str, Any]:
        if self.way == "voxels":
            return {"distance": None, "distance_frame": None}
        most, frame = self._body["from_screws" if self.way == "poses" else "from_lines"]
        return {"distance": most, "distance_frame": frame}

    def without_paths(self, text: str) -> str:
        """A message of the program, whose files nobody else sees, without its advice."""
        lines = [line for line in text.splitlines() if not line.startswith("try: ")]
        plain = re.sub(f"{re.escape(str(self._place) + os.sep)}(?:solid.vtp: |[^:/]*.pvd: )?", "", "\n".join(lines))
        return re.sub("^(note|lost): ", "", plain)

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

    def _solid(self) -> TriangleMesh:
        """The solid at the first key."""
        vertices = self._positions(self._keys[0])
        assert self._merged is not None
        found = self._attributes()
        triangles = self._merged[3]
        left = whole(triangles)
        return TriangleMesh(vertices, triangles[left], {}, {name: values[left] for name, values in found.items()})

    def _attributes(self) -> Dict[str, NDArray[Any]]:
        """The attributes of the triangles of the first key, also of those that are dropped."""
        return {name: rows for name, rows in self._array(self._keys[0]["faces"]).items() if name != "triangles"}

    def _pose(self, key: Dict[str, Any]) -> Dict[str, Any]:
        pose = np.array(key["pose"])
        return {"time": self._time(key), "position": (pose[:3, 3] * self._metres).tolist(),
                "quaternion": _quaternion(pose[:3, :3]).tolist()}  # fmt: skip

    def _write_frames(self, name: str = "frames") -> str:
        """A mesh for each key, and the collection that lists them. The first has the attributes, if they are kept."""
        lines = []
        for number, key in enumerate(self._keys):
            file = f"frame_{number}.vtp"
            triangles = self._array(key["faces"])["triangles"]
            positions = self._positions(key)
            triangles = triangles if self._merged is None else self._merged[3]
            attributes = {} if number or self.way == "voxels" else self._attributes()
            TriangleMesh(positions, triangles, {}, attributes).save(self._place / file, attributes=True)
            lines.append(f'<DataSet timestep="{self._time(key)!r}" file={quoteattr(file)}/>')
        frames = self._place / f"{name}.pvd"
        frames.write_text('<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1"><Collection>\n'
                          + "\n".join(lines) + "\n</Collection></VTKFile>\n", encoding="utf-8")  # fmt: skip
        return str(frames)


def is_divided(words: Collection[str]) -> bool:
    """Whether options make a body of each component."""
    return "component" in words or "--bodies=component" in words


def without_division(words: Sequence[str]) -> List[str]:
    return [word for word in words if word not in ("--bodies", "component", "--bodies=component")]
