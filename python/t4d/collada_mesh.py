"""The triangles of a COLLADA file at rest, read by the library pycollada (PyPI)."""

from __future__ import annotations

import importlib
import warnings
from typing import Any, Iterator, List, NamedTuple, Tuple

import numpy as np
from numpy.typing import NDArray

from t4d.errors import InvalidInput, Unsupported
from t4d.polygons import triangulate


# The axes that become x, y and z with z up, by the axis that is up.
_UPRIGHT = {
    "X_UP": np.array([[0.0, -1, 0], [0, 0, -1], [1, 0, 0]]), "Y_UP": np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]),
    "Z_UP": np.eye(3),
}  # fmt: skip


class ColladaMesh(NamedTuple):
    """Vertices (n, 3) in metres, triangles (m, 3), the names of geometries, and what is lost, in sentences."""

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int64]
    names: List[str]
    losses: List[str]


def read(path: str, upright: bool = False) -> ColladaMesh:
    """All geometries of the scene, moved by their nodes: turned so that z is up, or along the axes of the file, as
    robots in RViz. Raises Error."""
    try:
        collada = importlib.import_module("collada")
    except ImportError:
        raise Unsupported("is COLLADA, which needs the package pycollada (pip install pycollada)", path) from None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            whole = collada.Collada(path, ignore=[collada.common.DaeUnsupportedError])
            parts = list(_parts(whole)) if whole.scene else []
    except (collada.common.DaeError, ValueError, LookupError, AttributeError, TypeError, SyntaxError) as error:
        raise InvalidInput(f"pycollada cannot read it: {' '.join(str(error).split())}", path) from None
    losses = [f"what pycollada does not know: {' '.join(str(error).split())}" for error in whole.errors]
    skins = len(list(whole.scene.objects("controller"))) if whole.scene else 0
    if whole.animations:
        losses.append("the animation: the mesh is as it is at rest")
    if skins:
        losses.append(f"{skins} {'mesh' if skins == 1 else 'meshes'} with a skin or with morph targets")
    if not sum(len(triangles) for _, triangles in parts):
        raise InvalidInput("; ".join(["has no triangles in its scene, expected a mesh", *losses]), path)
    counts = [len(vertices) for vertices, _ in parts]
    begins = np.cumsum(counts) - counts
    vertices = np.concatenate([vertices for vertices, _ in parts]) * float(whole.assetInfo.unitmeter or 1)
    if upright:
        vertices = vertices @ _UPRIGHT[whole.assetInfo.upaxis or "Y_UP"].T
    names = [geometry.original.name or geometry.original.id for geometry in whole.scene.objects("geometry")]
    triangles = np.concatenate([part + at for (_, part), at in zip(parts, begins)])
    return ColladaMesh(vertices, triangles, names, losses)


def _parts(whole: Any) -> Iterator[Tuple[NDArray[np.float64], NDArray[np.int64]]]:
    """The vertices and the triangles of each primitive with faces."""
    for geometry in whole.scene.objects("geometry"):
        matrix = np.asarray(geometry.matrix, dtype=np.float64)
        for primitive in geometry.original.primitives:
            kind = type(primitive).__name__
            if kind not in ("TriangleSet", "Polylist", "Polygons") or primitive.vertex_index is None:
                continue  # lines
            vertices = np.asarray(primitive.vertex, dtype=np.float64)
            corners = np.asarray(primitive.vertex_index, dtype=np.int64).ravel()
            counts = np.full(len(corners) // 3, 3) if kind == "TriangleSet" else primitive.vcounts
            triangles = corners[triangulate(counts, corners, vertices)[0]]
            if np.linalg.det(matrix[:3, :3]) < 0:
                triangles = triangles[:, ::-1]
            yield vertices @ matrix[:3, :3].T + matrix[:3, 3], triangles
