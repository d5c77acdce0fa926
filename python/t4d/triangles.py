"""Triangle meshes in space."""

from __future__ import annotations

import os
from typing import Any, Dict, Iterator, Mapping, Optional

import numpy as np
from numpy.typing import ArrayLike, NDArray

from t4d import _t4d, checks, scenes, still, usd
from t4d.checks import Path
from t4d.errors import Loss, about, warn


class TriangleMesh:
    """The surface of a solid, counter-clockwise seen from outside: the input of a sweep, or a slice.

    ``vertices, triangles = mesh`` gives both arrays. All arrays are read-only, without copies.
    """

    def __init__(
        self,
        vertices: ArrayLike,
        triangles: ArrayLike,
        vertex_attributes: Optional[Mapping[str, ArrayLike]] = None,
        triangle_attributes: Optional[Mapping[str, ArrayLike]] = None,
    ) -> None:
        """Copies ``vertices`` (n, 3) and ``triangles`` (m, 3), indices of vertices; attributes have a
        row for each."""
        self._mesh = _t4d.TriangleMesh(
            checks.array("vertices", vertices),
            checks.indices("triangles", triangles),
            _attributes(vertex_attributes),
            _attributes(triangle_attributes),
        )

    @classmethod
    def _of(cls, mesh: _t4d.TriangleMesh) -> TriangleMesh:
        made = cls.__new__(cls)
        made._mesh = mesh
        return made

    @property
    def vertices(self) -> NDArray[np.float64]:
        """(n, 3) float64, in length units."""
        return self._mesh.vertices

    @property
    def triangles(self) -> NDArray[np.uint32]:
        """(m, 3) uint32, indices of vertices."""
        return self._mesh.triangles

    @property
    def vertex_attributes(self) -> Dict[str, NDArray[Any]]:
        """Attributes of vertices by name, (n,) or (n, components)."""
        return self._mesh.vertex_attributes

    @property
    def triangle_attributes(self) -> Dict[str, NDArray[Any]]:
        """Attributes of triangles by name, (m,) or (m, components)."""
        return self._mesh.triangle_attributes

    @property
    def volume(self) -> float:
        """Enclosed, in cubic length units; positive if the triangles face outward."""
        return self._mesh.volume

    @property
    def area(self) -> float:
        return self._mesh.area

    @property
    def closed(self) -> bool:
        """Whether every edge is traversed equally often in both directions."""
        return self._mesh.closed

    def save(self, path: Path, name: str = "", attributes: bool = False) -> None:
        """Writes .stl, .obj, .ply, .off, .vtp, .glb, .gltf, .usda or .usdz, by the extension; with
        the package usd-core also .usdc.

        With ``attributes``, those are written, too: .ply, .vtp and USD hold all of them, .glb and
        .gltf those of vertices, the others none; each one that is lost is a warning (``Loss``).
        """
        place = checks.path_text(path)
        checks.text("name", name)
        checks.flag("attributes", attributes)
        with about(place, output=place), usd.written(place) as written:
            losses = _t4d.write_triangles(self._mesh, os.fsencode(written), name, attributes)
        warn(Loss, losses)

    def __iter__(self) -> Iterator[NDArray[Any]]:
        yield self.vertices
        yield self.triangles

    def __repr__(self) -> str:
        return f"<t4d.TriangleMesh: {len(self.vertices)} vertices, {len(self.triangles)} triangles>"


def _attributes(given: Optional[Mapping[str, ArrayLike]]) -> Dict[str, NDArray[Any]]:
    if not isinstance(given, (Mapping, type(None))):
        raise TypeError(f"the attributes are {given!r}; expected a dictionary of arrays")
    found = {
        checks.text("the name of an attribute", name): checks.array(f"attribute '{name}'", values)
        for name, values in (given or {}).items()
    }
    return {
        name: values.astype(values.dtype.newbyteorder("="), copy=False)
        for name, values in found.items()
    }


def read_triangles(path: Path) -> TriangleMesh:
    """Reads .stl, .obj, .ply, .off, .vtp, .vtu, .gltf or .glb; and scenes, in metres and z up, of which it is what is
    visible at the first frame: .fbx, .usd, .usda, .usdc, .usdz, .dae, .abc and .blend, with ufbx, usd-core or Blender
    (docs/blender.md). Vertices with equal coordinates become one. Warns of what was changed or is lost."""
    place = checks.path_text(path)
    if scenes.is_scene(place):
        with about(place):
            scene = still.read(place)
        read = TriangleMesh(scene.vertices, scene.triangles, {}, scene.attributes)
        notices, losses = scene.notes, scene.losses
    else:
        with about(place):
            mesh, notices, losses = _t4d.read_triangles(os.fsencode(place))
        read = TriangleMesh._of(mesh)
    warn(UserWarning, notices)
    warn(Loss, losses)
    return read
