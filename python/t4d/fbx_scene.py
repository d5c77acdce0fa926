"""The solids of an .fbx at a frame, as the library ufbx evaluates them (PyPI: ufbx): curves with tangents, steps and
extrapolation, layers, skins, blend shapes and vertex caches. Frame n is n / fps seconds after the file's time 0."""

from __future__ import annotations

import ctypes
import gc
import importlib
import importlib.metadata
import os
from dataclasses import dataclass
from typing import Any, Collection, Dict, Hashable, Iterable, List, Optional, Set, Tuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from t4d import recorder
from t4d.polygons import triangulate
from t4d.recorder import Faces, Problem, Solid

_ON_FRAME = 0.01  # closer to a whole frame, a time was one before it was rounded
_SILENT = ("UNKNOWN", "EMPTY", "BONE", "MARKER", "LOD_GROUP", "CAMERA_SWITCHER")  # what shows nothing by itself
_T = TypeVar("_T")
_count_reference = ctypes.pythonapi.Py_IncRef
_count_reference.argtypes, _count_reference.restype = [ctypes.py_object], None


def _kept(found: _T) -> _T:
    """Keeps what ufbx hands out. Up to version 0.0.8 it counts one reference too few to the elements of a scene, and to
    lists of which arrays are made: with one more, they live as long as the scene."""
    _count_reference(found)
    return found


def _elements(found: Iterable[_T]) -> List[_T]:
    return [_kept(one) for one in found]


def _array(found: Any, kind: Any = np.float64) -> NDArray[Any]:
    """A copy, which outlives the scene."""
    return np.array(_kept(found), dtype=kind)


@dataclass
class _Node:
    number: int
    name: str
    kind: str
    parent: Optional[int]
    mesh: Optional[int]
    hidden: bool  # at all frames: by a display layer, or as a level of detail

    def label(self) -> str:
        return f"'{self.name}'"


class File:
    """A scene in an .fbx, in metres, z up."""

    metres = 1.0

    def __init__(self, request: Dict[str, Any]) -> None:
        self._ufbx = importlib.import_module("ufbx")
        self.reader = f"ufbx {importlib.metadata.version('ufbx')}"
        try:
            self._scene = self._ufbx.load_file(
                request["file"], target_axes=self._ufbx.axes_right_handed_z_up, target_unit_meters=1.0,
                load_external_files=True, ignore_missing_external_files=True,
            )  # fmt: skip
        except self._ufbx.UfbxError as error:
            raise Problem(f"{self.reader} cannot read it: {error}") from None
        self.fps = float(self._scene.settings.frames_per_second)
        self.faces: Dict[Tuple[str, bytes], Faces] = {}
        self.materials: List[str] = []
        self._takes = _elements(self._scene.anim_stacks)
        self._take = self._take_of(request["take"])
        self._meshes = _elements(self._scene.meshes)
        self._still = [None if mesh.all_deformers else _array(mesh.vertices) for mesh in self._meshes]
        self._nodes = self._read_nodes()
        self._wanted = set(request["objects"]) or {node.name for node in self._nodes}
        unknown = self._wanted - {node.name for node in self._nodes}
        if unknown:
            known = ", ".join(node.label() for node in self._nodes if node.mesh is not None)
            raise Problem(f"there is no object '{min(unknown)}'; there are {known or 'none'}")
        self._shown: Set[int] = set()

    def _take_of(self, name: Optional[str]) -> Any:
        chosen = [take for take in self._takes if name in (None, take.name)]
        if name is not None and not chosen:
            known = ", ".join(f"'{take.name}'" for take in self._takes)
            raise Problem(f"there is no take '{name}'; there are {known or 'none'}")
        return chosen[0] if chosen else None

    def _read_nodes(self) -> List[_Node]:
        nodes = _elements(self._scene.nodes)
        layers = (layer for layer in _elements(self._scene.display_layers) if not layer.visible)
        hidden = {node.typed_id for layer in layers for node in _elements(layer.nodes)}
        display = self._ufbx.LodDisplay
        for group in _elements(self._scene.lod_groups):
            shown = [level.display for level in group.lod_levels]
            for node in _elements(group.instances):
                for number, child in enumerate(_elements(node.children)):
                    of_child = shown[number] if number < len(shown) else display.USE_LOD
                    if of_child == display.HIDE or (of_child == display.USE_LOD and number > 0):
                        hidden.add(child.typed_id)
        found: List[_Node] = []
        for number, node in enumerate(nodes):
            parent, mesh = _kept(node.parent), _kept(node.mesh)
            inherits = parent is not None and node.props.find_bool("VisibilityInheritance", True)
            found.append(_Node(
                number, node.name or f"node {number}", node.attrib_type.name, parent.typed_id if inherits else None,
                None if mesh is None else mesh.typed_id, number in hidden,
            ))  # fmt: skip
        return found

    def span(self) -> Optional[Tuple[float, float]]:
        """The range that the take says, or that of its keys and of vertex caches; None if there are none."""
        layers = _elements(self._take.layers) if self._take else []
        values = [_kept(one.anim_value) for layer in layers for one in layer.anim_props]
        curves = [curve for value in values for curve in _elements(value.curves) if curve is not None]
        ranges = [(curve.min_time, curve.max_time) for curve in curves]
        channels = [cache.external_channel for cache in _elements(self._scene.cache_deformers)]
        for samples in (channel.frames for channel in channels if channel is not None):
            ranges.append((samples[0].time, samples[len(samples) - 1].time))
        if not ranges:
            return None
        if self._take and self._take.time_end > self._take.time_begin:
            ranges = [(self._take.time_begin, self._take.time_end)]
        ends = min(begin for begin, _ in ranges), max(end for _, end in ranges)
        return _on_frame(ends[0] * self.fps), _on_frame(ends[1] * self.fps)

    def at(self, frame: float, only: Optional[Collection[Hashable]] = None) -> Dict[Hashable, Solid]:
        """The solids at a frame, which may be a fraction; only some of them. Their keys are the same at all frames."""
        animation = self._take.anim if self._take else self._scene.anim
        state = self._ufbx.evaluate_scene(
            self._scene, animation, frame / self.fps, evaluate_skinning=True, evaluate_caches=True,
            load_external_files=True,
        )  # fmt: skip
        try:
            return self._solids(state, only)
        finally:
            state.free()

    def _solids(self, state: Any, only: Optional[Collection[Hashable]]) -> Dict[Hashable, Solid]:
        nodes, meshes = _elements(state.nodes), _elements(state.meshes)
        visible: List[bool] = []  # parents come before their children
        deformed: Dict[int, NDArray[np.float64]] = {}
        found: Dict[Hashable, Solid] = {}
        for node, there in zip(self._nodes, nodes):
            above = node.parent is None or visible[node.parent]
            visible.append(above and there.visible and not node.hidden)
            if not visible[-1] or node.mesh is None or node.name not in self._wanted:
                continue
            if only is not None and node.number not in only:
                continue
            mesh = meshes[node.mesh]
            vertices = self._still[node.mesh]
            if vertices is None:
                if node.mesh not in deformed:
                    deformed[node.mesh] = _array(mesh.skinned_position.values)
                vertices = deformed[node.mesh]
            faces = (str(node.number), b"")
            if faces not in self.faces:
                materials = [material.name for material in _elements(there.materials)]
                self.faces[faces] = self._faces_of(node.mesh, vertices, materials)
            if len(self.faces[faces].triangles):
                self._shown.add(node.number)
                matrix = _array(there.geometry_to_world).T if mesh.skinned_is_local else np.eye(3, 4)
                found[node.number] = Solid(node.name, vertices, np.vstack([matrix, [0, 0, 0, 1]]), faces)
        return found

    def _faces_of(self, number: int, vertices: NDArray[np.float64], materials: List[str]) -> Faces:
        mesh = self._meshes[number]
        corners = _array(mesh.vertex_indices, np.uint32)
        counts = _array(mesh.faces, np.uint32).reshape(-1, 2)[:, 1]
        triangles, polygons = triangulate(counts, corners, vertices)
        if len(mesh.face_hole):
            solid = ~_array(mesh.face_hole, bool)[polygons]
            triangles, polygons = triangles[solid], polygons[solid]
        attributes: Dict[str, NDArray[Any]] = {}
        if not len(triangles):
            return Faces(corners[triangles], attributes)
        if mesh.vertex_uv.exists:
            places = _array(mesh.vertex_uv.values, np.float32)[_array(mesh.vertex_uv.indices, np.uint32)]
            attributes["uv:corners"] = places[triangles].reshape(-1, 6)
        if mesh.vertex_color.exists:
            colors = _array(mesh.vertex_color.values)[_array(mesh.vertex_color.indices, np.uint32)]
            rounded = np.rint(colors.clip(0, 1) * 255).astype(np.uint8)
            attributes["color:corners"] = rounded[triangles].reshape(-1, 12)
        if materials and len(mesh.face_material):
            numbers = np.array([self._number_of(name) for name in materials], dtype=np.uint32)
            chosen = _array(mesh.face_material, np.uint32)[polygons]
            attributes["material"] = numbers[np.minimum(chosen, len(numbers) - 1)]
        return Faces(corners[triangles], attributes)

    def _number_of(self, material: str) -> int:
        if material not in self.materials:
            self.materials.append(material)
        return self.materials.index(material) + 1

    def losses(self) -> List[str]:
        """What the scene has that was not among the solids, by the kind of object, and what did not move it."""
        kinds: Dict[str, List[str]] = {}
        for node in self._nodes:
            if node.number in self._shown or node.kind in _SILENT or node.name not in self._wanted:
                continue
            kind = f"objects of the type {node.kind.lower().replace('_', ' ')}"
            if node.mesh is not None:
                kind = "objects without faces" if self._meshes[node.mesh].num_triangles == 0 else "hidden objects"
            kinds.setdefault(kind, []).append(node.label())
        for constraint in _elements(self._scene.constraints):
            if constraint.active and constraint.weight:
                kinds.setdefault("constraints", []).append(f"'{constraint.name}'")
        for cache in _elements(self._scene.cache_deformers):
            if cache.external_channel is None:
                kinds.setdefault("vertex caches whose files are not found", []).append(f"'{cache.name}'")
        return [f"{kind}: {', '.join(sorted(names))}" for kind, names in sorted(kinds.items())]

    def notes(self) -> List[str]:
        if not self._take or len(self._takes) == 1:
            return []
        others = ", ".join(f"'{take.name}'" for take in self._takes if take is not self._take)
        return [f"the take is '{self._take.name}'; there are also {others}: choose by --take"]


def _on_frame(frame: float) -> float:
    return round(frame) if abs(frame - round(frame)) < _ON_FRAME else frame


def record_file(request: Dict[str, Any]) -> None:
    """What t4d-blender asks of a process of its own, which ends without Python's garbage collector: up to ufbx 0.0.8 it
    crashes on scenes."""
    gc.disable()
    recorder.record_file(request, File)
    os._exit(0)
