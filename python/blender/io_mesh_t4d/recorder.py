"""A recording: the solids of a scene at frames and between them, in a folder, from which the module t4d makes a 4D
mesh (t4d.recorded describes the files). The add-on for Blender and the module have it both: nothing here needs more
than numpy."""

from __future__ import annotations

import json
import os
import re
import sys
from dataclasses import dataclass, field
from typing import Any, Callable, Collection, Dict, Hashable, List, Optional, Protocol, Sequence, Tuple

import numpy as np
from numpy.typing import NDArray

# Positions may be in float32, whose seven digits leave a pose this far from a rotation.
RIGID = 1e-5
# Characters that do not fit in names of bodies: controls, slashes, and those that turn text round.
UNFIT = re.compile(r"[\x00-\x1f\x7f-\x9f/\\\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069]")
# An hour at 25 frames per second, and some: a file that says more is hardly meant so.
MOST_FRAMES = 100_000
# The shortest step, as a part of a frame: where motion jumps, no key in between helps.
SHORTEST = 1 / 64


class Problem(Exception):
    """The reason why something cannot be done, in one sentence for the user."""


@dataclass
class Faces:
    """The triangles (m, 3) of a solid, and its attributes by their names in a .t4d: (m, k) of the corners of
    triangles, or of triangles (m,)."""

    triangles: NDArray[np.integer[Any]]
    attributes: Dict[str, NDArray[Any]]


@dataclass
class Solid:
    """At a frame: the vertices (n, 3) in its own coordinates, and the matrix (4, 4) that places them. Equal `faces`
    say that it is made of the same polygons."""

    name: str
    vertices: NDArray[np.floating[Any]]
    matrix: NDArray[np.float64]
    faces: Tuple[str, bytes]

    def placed(self) -> NDArray[np.float64]:
        placed: NDArray[np.float64] = self.vertices @ self.matrix[:3, :3].T + self.matrix[:3, 3]
        return placed


class Scene(Protocol):
    """What can be recorded. `faces` has the triangles of all solids that were seen, `materials` the names that the
    attribute `material` counts from 1 on."""

    reader: str  # a program or a library, and its version
    metres: float  # in a unit of length
    fps: float
    faces: Dict[Tuple[str, bytes], Faces]
    materials: List[str]

    def at(self, frame: float, only: Optional[Collection[Hashable]] = None) -> Dict[Hashable, Solid]:
        """The solids at a frame, which may be a fraction; only some of them. Their keys are the same at all frames."""
        ...

    def losses(self) -> List[str]:
        """The contents of the scene that were not among the solids."""
        ...


class File(Scene, Protocol):
    """A scene in a file."""

    def span(self) -> Optional[Tuple[float, float]]:
        """The first and the last frame; None if nothing in it moves."""
        ...

    def notes(self) -> List[str]:
        """Notes on what is not done as the file says."""
        ...


@dataclass
class Distance:
    """The largest distance of a solid half way between two keys from what is between these, and where it is."""

    most: float = 0.0
    frame: float = 0.0

    def note(self, distance: float, frame: float) -> None:
        if distance > self.most:
            self.most, self.frame = distance, frame


@dataclass
class Track:
    """A solid from frame to frame, until it vanishes. It is rigid if its vertices stay, and its matrix only turns and
    moves it."""

    name: str
    first: Solid
    keys: List[Dict[str, Any]] = field(default_factory=list)
    shape: Optional[NDArray[np.floating[Any]]] = None  # of the last key
    rigid: bool = True
    straight: Distance = field(default_factory=Distance)  # from straight lines between the keys
    screw: Distance = field(default_factory=Distance)  # from screw motions between them, as long as it is rigid

    def __post_init__(self) -> None:
        self.back = np.linalg.pinv(self.first.matrix[:3, :3])

    def pose_of(self, solid: Solid) -> Optional[NDArray[np.float64]]:
        """The rotation and translation (4, 4) that takes the first to the solid; None if none does."""
        if solid.faces != self.first.faces or not np.array_equal(solid.vertices, self.first.vertices):
            return None
        left, scales, right = np.linalg.svd(solid.matrix[:3, :3] @ self.back)
        if np.abs(scales - 1).max() > RIGID or np.linalg.det(left @ right) < 0:
            return None
        return affine(left @ right, solid.matrix[:3, 3] - left @ right @ self.first.matrix[:3, 3])


def affine(turn: NDArray[np.float64], move: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.vstack([np.column_stack([turn, move]), [0, 0, 0, 1]])


def half_way(here: NDArray[np.float64], there: NDArray[np.float64]) -> NDArray[np.float64]:
    """What takes the pose here half way of the screw motion to the pose there, by half the angle."""
    turn = there[:3, :3] @ here[:3, :3].T
    move = there[:3, 3] - turn @ here[:3, 3]
    left, _, right = np.linalg.svd(np.eye(3) + turn)  # of its root, times the cosine of half the angle across the axis
    root = left @ right
    left, scales, right = np.linalg.svd(np.eye(3) + root)  # half the way, and once more after the turn, is all of it
    return affine(root, right.T @ (left.T @ move / scales))


def most_between(here: NDArray[np.float64], there: NDArray[np.float64]) -> float:
    return float(np.sqrt(((here - there) ** 2).sum(axis=1).max()))


def without_rests(keys: List[Dict[str, Any]]) -> List[Dict[str, Any]]:
    """The keys without those at which nothing moves, neither before nor after."""
    moves = [{**here, "frame": 0} != {**there, "frame": 0} for here, there in zip(keys, keys[1:])]
    return [key for key, before, after in zip(keys, [True, *moves], [*moves, True]) if before or after]


class Recorder:
    """Records the solids of a scene into a folder."""

    def __init__(self, scene: Scene, folder: str, tolerance: Optional[float] = None) -> None:
        """The tolerance is in metres."""
        self.scene, self.folder, self.tolerance = scene, folder, tolerance
        self.metres = scene.metres
        self.tracks: List[Track] = []
        self.open: Dict[Hashable, Track] = {}
        self.names: Dict[str, int] = {}
        self.saved: Dict[Tuple[str, bytes], str] = {}
        self.files = 0

    def record(self, first: float, last: float, step: float, progress: Callable[[float], None]) -> None:
        """Keys at every frame from the first to the last, or at every second and so on. With a tolerance, also between
        two of these where a solid half way is farther than that from the straight lines between them. Raises Problem
        if there is nothing to record."""
        if last <= first:
            raise Problem(f"frames {first:g} to {last:g} are {int(last == first)}; a motion has at least 2")
        if (last - first) / step > MOST_FRAMES:
            many = f"{(last - first) / step:,.0f}, expected at most {MOST_FRAMES:,}"
            raise Problem(f"frames {first:g} to {last:g} are {many}: choose some by --frame-range, or a larger --step")
        frames = [*np.arange(first, last, step).tolist(), last]
        left = self.scene.at(first)
        self._add(first, left)
        for a, b in zip(frames, frames[1:]):
            progress(b)
            middle, right = self.scene.at((a + b) / 2), self.scene.at(b)
            self._refine(a, b, left, middle, right, list(self.open))
            self.open = {key: track for key, track in self.open.items() if key in right}  # the others vanish
            self._add(b, right)
            left = right
        self._check()

    def record_still(self, frame: float) -> None:
        """Records one key. Raises Problem if there is nothing to record."""
        self._add(frame, self.scene.at(frame))
        self._check()

    def _check(self) -> None:
        if not self.tracks:
            raise Problem("no visible object has faces")

    def _refine(
        self,
        a: float,
        b: float,
        left: Dict[Hashable, Solid],
        middle: Dict[Hashable, Solid],
        right: Dict[Hashable, Solid],
        keys: List[Hashable],
    ) -> None:
        """Compares solids at (a + b) / 2 with those at a and b, and adds keys between these where one is far."""
        frame, far = (a + b) / 2, []
        for key in keys:
            if not (key in left and key in middle and key in right):
                continue
            here, half, there = left[key], middle[key], right[key]
            if not here.faces == half.faces == there.faces:
                continue
            placed = half.placed()
            straight = most_between((here.placed() + there.placed()) / 2, placed) * self.metres
            if self.tolerance is not None and straight > self.tolerance and b - a > SHORTEST:
                far.append(key)
                continue
            track = self.open[key]
            track.straight.note(straight, frame)
            first, last = (track.pose_of(here), track.pose_of(there)) if track.rigid else (None, None)
            if first is not None and last is not None:
                screw = half_way(first, last)
                screwed = here.placed() @ screw[:3, :3].T + screw[:3, 3]
                track.screw.note(most_between(screwed, placed) * self.metres, frame)
        if far:
            self._refine(a, frame, left, self.scene.at((a + frame) / 2, far), middle, far)
            self._add(frame, {key: middle[key] for key in far})
            self._refine(frame, b, middle, self.scene.at((frame + b) / 2, far), right, far)

    def _add(self, frame: float, solids: Dict[Hashable, Solid]) -> None:
        """Adds a key to the tracks of solids, and begins tracks of those that appear."""
        for key, solid in solids.items():
            if not np.isfinite(solid.placed()).all():
                raise Problem(f"'{solid.name}' has no finite place at frame {frame:g}")
            track = self.open.get(key)
            if track is None:
                track = self.open[key] = Track(self._name_of(solid), solid)
                self.tracks.append(track)
            if track.shape is None or not np.array_equal(track.shape, solid.vertices):
                track.shape = solid.vertices
                shape = self._save(vertices=solid.vertices)
            else:
                shape = track.keys[-1]["shape"]
            pose = track.pose_of(solid) if track.rigid else None
            track.rigid = pose is not None
            track.keys.append({
                "frame": frame, "shape": shape, "faces": self._faces_of(solid), "matrix": solid.matrix.tolist(),
                "pose": None if pose is None else pose.tolist(),
            })  # fmt: skip

    def _name_of(self, solid: Solid) -> str:
        """The name of a solid; with a number if it appears again, and for instances."""
        plain = UNFIT.sub("_", solid.name)
        name = plain
        while name in self.names:
            self.names[plain] += 1
            name = f"{plain} {self.names[plain]}"
        self.names[name] = 1
        return name

    def _faces_of(self, solid: Solid) -> str:
        if solid.faces not in self.saved:
            faces = self.scene.faces[solid.faces]
            self.saved[solid.faces] = self._save(triangles=faces.triangles, **faces.attributes)
        return self.saved[solid.faces]

    def _save(self, **arrays: Any) -> str:
        self.files += 1
        np.savez(os.path.join(self.folder, f"{self.files}.npz"), **arrays)
        return f"{self.files}.npz"

    def finish(self, source: str, fps: Optional[float] = None, notes: Sequence[str] = ()) -> None:
        """Writes what the arrays are; frames become seconds by the scene's rate or another."""
        bodies = []
        for track in self.tracks:
            lines, screws = track.straight, track.screw
            bodies.append({
                "name": track.name, "rigid": track.rigid, "keys": without_rests(track.keys),
                "from_lines": (lines.most, lines.frame), "from_screws": (screws.most, screws.frame),
            })  # fmt: skip
        about = {
            "source": source, "reader": self.scene.reader, "fps": fps or self.scene.fps,
            "metres": self.metres, "materials": self.scene.materials, "losses": self.scene.losses(),
            "notes": list(notes), "bodies": bodies,
        }  # fmt: skip
        with open(os.path.join(self.folder, "scene.json"), "w", encoding="utf-8") as file:
            json.dump(about, file)


def record_file(request: Dict[str, Any], opened: Callable[[Dict[str, Any]], File]) -> None:
    """What t4d-blender asks of another process: records the file that a function opens into a folder, or writes there,
    in `problem.txt`, why that cannot be done."""
    try:
        file = opened(request)
        span = request["frame_range"] or file.span()
        if span is None and not request["still"]:
            raise Problem("nothing in it moves; -o with a .ply or another triangle mesh writes the solids at rest")
        first, last = span or (0, 0)
        recorder = Recorder(file, request["folder"], request["tolerance"])

        def say(frame: float) -> None:
            print(f"frame {frame:g} of {last:g}", file=sys.stderr, flush=True)

        if request["still"]:
            recorder.record_still(first)
        else:
            recorder.record(first, last, request["step"], say)
        recorder.finish(os.path.basename(request["file"]), request["fps"], file.notes())
    except Problem as problem:
        with open(os.path.join(request["folder"], "problem.txt"), "w", encoding="utf-8") as text:
            text.write(str(problem))
