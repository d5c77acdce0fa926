"""Scenes at rest: all solids of one frame of a recording, as one triangle mesh."""

from __future__ import annotations

import importlib.util
import json
import tempfile
from pathlib import Path
from typing import Any, Callable, Dict, List, NamedTuple, Tuple

import numpy as np
from numpy.typing import NDArray

from t4d import collada_mesh, scenes
from t4d.scenes import Request


class Still(NamedTuple):
    """Vertices (n, 3) in metres, z up, triangles (m, 3) and their attributes, what they were made of, and sentences for
    people."""

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int64]
    attributes: Dict[str, NDArray[Any]]
    bodies: List[str]
    materials: List[str]
    notes: List[str]
    losses: List[str]


def read(path: str, request: Request = Request(still=True), say: Callable[[str], None] = lambda text: None) -> Still:
    """The solids that a file shows at the first frame of the request. Raises Error."""
    if scenes.extension_of(path) == ".dae" and request == Request(still=True) and importlib.util.find_spec("collada"):
        mesh = collada_mesh.read(path, upright=True)
        return Still(*_one_at_a_place(mesh.vertices, mesh.triangles)[:2], {}, mesh.names, [], [], mesh.losses)
    with tempfile.TemporaryDirectory(prefix="t4d-") as folder:
        notes = scenes.record(path, request, folder, say)
        still = _of(Path(folder))
    return still._replace(notes=[*notes, *still.notes])


def merged(vertices: NDArray[Any]) -> Tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The first of all that are at one place, in their order, and for each vertex its number among these."""
    _, first, number = np.unique(vertices, axis=0, return_index=True, return_inverse=True)
    return np.sort(first), np.argsort(np.argsort(first))[number.ravel()]


def whole(triangles: NDArray[Any]) -> NDArray[np.bool_]:
    """Whether triangles have three different corners."""
    found: NDArray[np.bool_] = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)
    return found


def _of(folder: Path) -> Still:
    scene = json.loads((folder / "scene.json").read_text(encoding="utf-8"))
    places: List[NDArray[Any]] = []
    faces: List[Dict[str, NDArray[Any]]] = []
    count = 0
    for body in scene["bodies"]:
        key = body["keys"][0]
        matrix = np.array(key["matrix"])
        with np.load(folder / key["shape"]) as shape, np.load(folder / key["faces"]) as own:
            places.append(shape["vertices"] @ matrix[:3, :3].T + matrix[:3, 3])
            faces.append({**own, "triangles": own["triangles"] + count})
        count += len(places[-1])
    attributes, notes = _together(faces)
    vertices = np.concatenate(places) * float(scene["metres"])
    vertices, triangles, left = _one_at_a_place(vertices, np.concatenate([own["triangles"] for own in faces]))
    return Still(
        vertices, triangles, {name: values[left] for name, values in attributes.items()},
        [body["name"] for body in scene["bodies"]], scene["materials"], [*scene["notes"], *notes], scene["losses"],
    )  # fmt: skip


def _one_at_a_place(
    vertices: NDArray[np.float64], triangles: NDArray[Any]
) -> Tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.bool_]]:
    """The vertices that triangles use, the triangles that are left, and which these are."""
    kept, number = merged(vertices)
    left = whole(number[triangles])
    used, corners = np.unique(number[triangles][left], return_inverse=True)
    return vertices[kept][used], corners.reshape(-1, 3), left


def _together(faces: List[Dict[str, NDArray[Any]]]) -> Tuple[Dict[str, NDArray[Any]], List[str]]:
    """The attributes of all triangles, and notes: where a body has none, colours are white and all else is zero."""
    kinds = {name: values for own in faces for name, values in own.items() if name != "triangles"}
    found, notes = {}, []
    for name, like in kinds.items():
        none = 0 if not name.startswith("color") else 255 if like.dtype == np.uint8 else 1
        parts = [own[name] if name in own else np.full((len(own["triangles"]), *like.shape[1:]), none, like.dtype)
                 for own in faces]  # fmt: skip
        found[name] = np.concatenate(parts)
        without = sum(name not in own for own in faces)
        if without and name != "material":
            notes.append(f"{without} of {len(faces)} objects have no '{name}': there it is {none}")
    return found, notes
