"""The solids that a scene shows at a frame: triangles, attributes, names, and where they are."""

from __future__ import annotations

import hashlib
import math
from typing import Any, Collection, Dict, Hashable, Iterator, List, Optional, Tuple

import bpy
import numpy as np
from numpy.typing import NDArray

from .recorder import Faces, Problem, Solid
from .units import metres_per_unit

SOLIDS = ("MESH", "CURVE", "SURFACE", "META", "FONT")  # what Blender makes meshes of
SILENT = ("EMPTY", "ARMATURE", "LATTICE", "SPEAKER", "LIGHT_PROBE")  # what shows nothing by itself


class Scene:
    """What the scene shows. `faces` has the triangles of all solids that were seen, `materials` the names that the
    attribute `material` counts from 1 on."""

    def __init__(self, context: Any, wanted: Collection[str]) -> None:
        """`wanted` are names of objects; none for all that are visible."""
        self.context = context
        self.scene = context.scene
        self.reader = f"Blender {bpy.app.version_string}"
        self.metres = metres_per_unit(self.scene)
        self.fps = self.scene.render.fps / self.scene.render.fps_base
        self.faces: Dict[Tuple[str, bytes], Faces] = {}
        self.materials: List[str] = []
        self.seen: set[str] = set()  # with faces or without
        self.solid: set[str] = set()  # with faces
        self.wanted = set(wanted)
        unknown = self.wanted - {one.name for one in self.scene.objects}
        if unknown:
            known = ", ".join(f"'{one.name}'" for one in self.scene.objects if one.type in SOLIDS)
            raise Problem(f"there is no object '{min(unknown)}'; there are {known or 'none'}")

    def at(self, frame: float, only: Optional[Collection[Hashable]] = None) -> Dict[Hashable, Solid]:
        """The solids at a frame, which may be a fraction; only some of them. Their keys are the same at all frames."""
        whole = math.floor(frame)
        self.scene.frame_set(whole, subframe=frame - whole)
        graph = self.context.evaluated_depsgraph_get()
        meshes: Dict[Hashable, Tuple[NDArray[np.float32], Tuple[str, bytes]]] = {}
        found: Dict[Hashable, Solid] = {}
        for key, name, owner, matrix in self._shown(graph):
            if only is not None and key not in only:
                continue
            data = (owner.name, owner.data.as_pointer() if owner.data else 0)
            if data not in meshes:  # that instances share
                meshes[data] = self._mesh_of(owner)
            vertices, faces = meshes[data]
            if len(self.faces[faces].triangles):
                self.solid |= {owner.name, key[0]}
                found[key] = Solid(name, vertices, matrix, faces)
        return found

    def _shown(self, graph: Any) -> Iterator[Tuple[Tuple[str, str, Tuple[int, ...]], str, Any, NDArray[np.float64]]]:
        """A key, a name, the evaluated object, and where it is."""
        for shown in graph.object_instances:
            owner = shown.object
            parent = shown.parent if shown.is_instance else None
            root = parent or owner
            if owner.type not in SOLIDS or root.original.hide_render or owner.original.hide_render:
                continue
            if not shown.show_self or (self.wanted and not self.wanted & {owner.original.name, root.original.name}):
                continue
            self.seen |= {owner.original.name, root.original.name}
            if owner.type != "MESH" and not parent:
                continue  # the mesh that Blender made of it is an instance, too
            key = (root.name, owner.name, tuple(shown.persistent_id) if parent else ())
            name = f"{parent.name} {owner.name}" if parent and parent.name != owner.name else owner.name
            yield key, name, owner, np.array(shown.matrix_world, dtype=np.float64)

    def _mesh_of(self, owner: Any) -> Tuple[NDArray[np.float32], Tuple[str, bytes]]:
        mesh = owner.to_mesh()
        vertices = array_of(mesh.vertices, "co", np.float32, 3)
        digest = hashlib.blake2b(array_of(mesh.loops, "vertex_index", np.int32).tobytes(), digest_size=16)
        digest.update(array_of(mesh.polygons, "loop_start", np.int32).tobytes())
        digest.update(len(vertices).to_bytes(8, "little"))
        faces = (owner.name, digest.digest())
        if faces not in self.faces:
            mesh.calc_loop_triangles()
            triangles = array_of(mesh.loop_triangles, "vertices", np.int32, 3)
            self.faces[faces] = Faces(triangles, self._attributes_of(mesh, owner))
        owner.to_mesh_clear()
        return vertices, faces

    def _attributes_of(self, mesh: Any, owner: Any) -> Dict[str, NDArray[Any]]:
        found: Dict[str, NDArray[Any]] = {}
        loops = array_of(mesh.loop_triangles, "loops", np.int32, 3)
        if not len(loops):
            return found
        if mesh.uv_layers.active:
            places = array_of(mesh.uv_layers.active.data, "uv", np.float32, 2)
            found["uv:corners"] = places[loops].reshape(len(loops), 6)
        colors = mesh.color_attributes.active_color if mesh.color_attributes else None
        if colors and len(colors.data):
            srgb = colors.data_type == "BYTE_COLOR"
            values = array_of(colors.data, "color_srgb" if srgb else "color", np.float32, 4)
            at = array_of(mesh.loops, "vertex_index", np.int32)[loops] if colors.domain == "POINT" else loops
            values = np.rint(values * 255).astype(np.uint8) if srgb else values
            found["color:corners"] = values[at].reshape(len(loops), 12)
        slots = [slot.material for slot in owner.material_slots] or list(mesh.materials)
        if any(slots):
            numbers = np.array([self._number_of(one.name) if one else 0 for one in slots], dtype=np.uint32)
            polygons = array_of(mesh.loop_triangles, "polygon_index", np.int32)
            chosen = array_of(mesh.polygons, "material_index", np.int32)[polygons]
            found["material"] = numbers[np.minimum(chosen, len(slots) - 1)]
        return found

    def _number_of(self, material: str) -> int:
        if material not in self.materials:
            self.materials.append(material)
        return self.materials.index(material) + 1

    def losses(self) -> List[str]:
        """What the scene has that was not among the solids, by the kind of object."""
        kinds: Dict[str, List[str]] = {}
        bones = [bone for one in self.scene.objects if one.pose for bone in one.pose.bones]
        shapes = {bone.custom_shape.name for bone in bones if bone.custom_shape}  # how an armature is drawn
        for one in self.scene.objects:
            if one.name in self.solid | shapes or one.type in SILENT or (self.wanted and one.name not in self.wanted):
                continue
            if one.type == "META" and one.name in self.seen:
                continue  # the first of its kind has the faces of all
            kind = f"objects of the type {one.type.lower().replace('_', ' ')}"
            if one.type in SOLIDS:
                kind = "objects without faces" if one.name in self.seen else "hidden objects"
            kinds.setdefault(kind, []).append(f"'{one.name}'")
        return [f"{kind}: {', '.join(sorted(names))}" for kind, names in sorted(kinds.items())]


def array_of(elements: Any, name: str, kind: Any, columns: int = 1) -> NDArray[Any]:
    """A property of all elements of a collection: (n,), or (n, columns)."""
    values = np.empty(len(elements) * columns, dtype=kind)
    elements.foreach_get(name, values)
    return values.reshape(-1, columns) if columns > 1 else values
