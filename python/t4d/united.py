"""A recording of one body, which is all bodies of another at once."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, List

import numpy as np
from numpy.typing import NDArray

from t4d.errors import InvalidInput


def scene_of(folder: Path, scene: Dict[str, Any]) -> Dict[str, Any]:
    """The scene with one body, whose files are written to the folder. Raises InvalidInput if a body does not last, or
    changes its faces."""
    bodies = [_Moving(folder, body) for body in scene["bodies"]]
    frames = sorted({frame for body in bodies for frame in body.frames})
    for body in bodies:
        if len(bodies) > 1 and (body.frames[0], body.frames[-1]) != (frames[0], frames[-1]):
            there = f"at frames {body.frames[0]:g} to {body.frames[-1]:g}, not {frames[0]:g} to {frames[-1]:g}"
            raise InvalidInput(f"the object '{body.name}' is there {there}; --union needs all to last: choose by "
                               "--object")  # fmt: skip
    counts = [body.count for body in bodies]
    begins = np.cumsum(counts) - counts
    faces = "united-faces.npz"
    np.savez(folder / faces, triangles=np.concatenate([body.triangles + at for body, at in zip(bodies, begins)]))
    keys: List[Dict[str, Any]] = []
    for number, frame in enumerate(frames):
        shape = f"united-{number}.npz"
        np.savez(folder / shape, vertices=np.concatenate([body.at(frame) for body in bodies]))
        keys.append({"frame": frame, "shape": shape, "faces": faces, "matrix": np.eye(4).tolist()})
    far = max((body["from_lines"] for body in scene["bodies"]), key=lambda one: float(one[0]))
    one = {"name": Path(scene["source"]).stem or "scene", "rigid": False, "keys": keys, "from_lines": far}
    return {**scene, "bodies": [one]}


class _Moving:
    """A body at any frame, on straight lines between its keys."""

    def __init__(self, folder: Path, body: Dict[str, Any]) -> None:
        self._folder, self._keys = folder, body["keys"]
        self.name = body["name"]
        self.frames: List[float] = [key["frame"] for key in self._keys]
        if len({key["faces"] for key in self._keys}) > 1:
            raise InvalidInput(f"the faces of the object '{self.name}' change; --union needs all to keep theirs: "
                               "choose by --object")  # fmt: skip
        with np.load(folder / self._keys[0]["faces"]) as faces:
            self.triangles = faces["triangles"].astype(np.int64)
        self.count = len(self._placed(0))

    def at(self, frame: float) -> NDArray[np.float64]:
        after = int(np.searchsorted(self.frames, frame))
        if self.frames[after] == frame:
            return self._placed(after)
        share = (frame - self.frames[after - 1]) / (self.frames[after] - self.frames[after - 1])
        return (1 - share) * self._placed(after - 1) + share * self._placed(after)

    def _placed(self, number: int) -> NDArray[np.float64]:
        matrix = np.array(self._keys[number]["matrix"])
        with np.load(self._folder / self._keys[number]["shape"]) as shape:
            placed: NDArray[np.float64] = shape["vertices"] @ matrix[:3, :3].T + matrix[:3, 3]
        return placed
