"""The solids of a USD stage at a time code, as Pixar's library evaluates them (PyPI: usd-core): layers and references,
samples of points and transformations, skins and blend shapes of UsdSkel, instances. Frames are time codes."""

from __future__ import annotations

import hashlib
import importlib
from typing import Any, Collection, Dict, Hashable, Iterator, List, Optional, Set, Tuple

import numpy as np
from numpy.typing import NDArray

from t4d import recorder
from t4d.polygons import triangulate
from t4d.recorder import Faces, Problem, Solid

_MODULES = ("Tf", "Usd", "UsdGeom", "UsdLux", "UsdShade", "UsdSkel")
_Y_UP = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1.0]])  # makes it z
_Shown = Tuple[Tuple[str, Tuple[int, ...]], str, Any, NDArray[np.float64]]


class File:
    """A stage, in units of its own, z up."""

    def __init__(self, request: Dict[str, Any]) -> None:
        pxr = {name: importlib.import_module(f"pxr.{name}") for name in _MODULES}
        self._usd, self._geom, self._light = pxr["Usd"], pxr["UsdGeom"], pxr["UsdLux"].LightAPI
        self._shade, self._skel = pxr["UsdShade"], pxr["UsdSkel"]
        self.reader = f"usd-core {'.'.join(str(part) for part in self._usd.GetVersion()[1:])}"
        try:
            self._stage = self._usd.Stage.Open(request["file"])
        except pxr["Tf"].ErrorException as error:
            raise Problem(f"{self.reader} cannot read it: {str(error).strip().splitlines()[-1].strip()}") from None
        self.metres = float(self._geom.GetStageMetersPerUnit(self._stage))
        self.fps = float(self._stage.GetTimeCodesPerSecond())
        if not (self.fps > 0 or request["fps"]):
            raise Problem(f"its timeCodesPerSecond is {self.fps:g}, expected a number above zero; --fps gives another")
        self._up = _Y_UP if self._geom.GetStageUpAxis(self._stage) == self._geom.Tokens.y else np.eye(4)
        self.faces: Dict[Tuple[str, bytes], Faces] = {}
        self.materials: List[str] = []
        self._prims = list(self._below(self._stage.GetPseudoRoot()))
        self._wanted = set(request["objects"])
        unknown = self._wanted - {prim.GetName() for prim in self._prims}
        if unknown:
            known = ", ".join(f"'{prim.GetName()}'" for prim in self._prims if prim.IsA(self._geom.Mesh))
            raise Problem(f"there is no object '{min(unknown)}'; there are {known or 'none'}")
        self._lasting: Dict[str, Tuple[str, bytes]] = {}  # faces that never change, by path
        self._solid: Set[Any] = set()  # prims with faces
        self._broken: Dict[str, str] = {}  # why faces are invalid, by the name of the mesh
        self._skins = dict(self._read_skins())

    def _below(self, root: Any) -> Any:
        """An iterator over the prims in one, and in its instances."""
        return iter(self._usd.PrimRange(root, self._usd.TraverseInstanceProxies()))

    def _read_skins(self) -> Iterator[Tuple[Any, Tuple[Any, Any, Any]]]:
        """The queries of the skeleton, the skin and the blend shapes that deform a mesh, by its path."""
        cache = self._skel.Cache()
        for prim in self._prims:
            if not prim.IsA(self._skel.Root):
                continue
            root, predicate = self._skel.Root(prim), self._usd.TraverseInstanceProxies()
            cache.Populate(root, predicate)
            for binding in cache.ComputeSkelBindings(root, predicate):
                skeleton = cache.GetSkelQuery(binding.GetSkeleton())
                for skinning in binding.GetSkinningTargets():
                    shapes = self._skel.BlendShapeQuery(self._skel.BindingAPI(skinning.GetPrim()))
                    yield skinning.GetPrim().GetPath(), (skeleton, skinning, shapes)

    def span(self) -> Optional[Tuple[float, float]]:
        """The range that the stage says, or that of all samples; None if there are none."""
        authored = (attribute for prim in self._prims for attribute in prim.GetAuthoredAttributes())
        attributes = [attribute for attribute in authored if attribute.ValueMightBeTimeVarying()]
        if not attributes:
            return None
        if self._stage.HasAuthoredTimeCodeRange():
            return self._stage.GetStartTimeCode(), self._stage.GetEndTimeCode()
        samples = [sample for one in attributes for sample in one.GetTimeSamples()]
        return min(samples), max(samples)

    def at(self, frame: float, only: Optional[Collection[Hashable]] = None) -> Dict[Hashable, Solid]:
        """The solids at a frame, which may be a fraction; only some of them. Their keys are the same at all frames."""
        time = self._usd.TimeCode(frame)
        found: Dict[Hashable, Solid] = {}
        places = self._geom.XformCache(time)
        for key, name, prim, matrix in self._shown(time, places, self._stage.GetPseudoRoot(), np.eye(4), (), ""):
            if only is not None and key not in only:
                continue
            points = self._geom.Mesh(prim).ComputePointsAtTime(time, time)
            faces = self._faces_of(prim, points, time)
            if faces is None:
                continue
            vertices, matrix = self._deformed(prim, points, matrix, time, places)
            self._solid.add(prim)
            found[key] = Solid(name, vertices, self._up @ matrix.T, faces)
        return found

    def _shown(
        self, time: Any, places: Any, root: Any, place: NDArray[np.float64], number: Tuple[int, ...], within: str
    ) -> Iterator[_Shown]:
        """A key, a name, the mesh and its place, for rows, of all that is visible below a root at a place."""
        back = np.linalg.inv(_matrix(places.GetLocalToWorldTransform(root)))
        prims = self._below(root)
        for prim in prims:
            if not (prim.IsA(self._geom.Mesh) or prim.IsA(self._geom.PointInstancer)):
                continue
            instancer = self._geom.PointInstancer(prim)
            if instancer:
                prims.PruneChildren()  # prototypes
            if not self._is_visible(prim, time) or not (within or self._is_wanted(prim)):
                continue
            matrix = _matrix(places.GetLocalToWorldTransform(prim)) @ back @ place
            if not instancer:
                yield (str(prim.GetPath()), number), within + prim.GetName(), prim, matrix
                continue
            paths = instancer.GetPrototypesRel().GetForwardedTargets()
            prototypes = [self._stage.GetPrimAtPath(path) for path in paths]
            mask, options = instancer.ComputeMaskAtTime(time), (instancer.IncludeProtoXform, instancer.IgnoreMask)
            instances = instancer.ComputeInstanceTransformsAtTime(time, time, *options)
            for one, (kind, there) in enumerate(zip(instancer.GetProtoIndicesAttr().Get(time) or [], instances)):
                if not mask or mask[one]:
                    numbers, name = (*number, one), f"{within}{prim.GetName()} "
                    yield from self._shown(time, places, prototypes[kind], _matrix(there) @ matrix, numbers, name)

    def _is_visible(self, prim: Any, time: Any) -> bool:
        one, tokens = self._geom.Imageable(prim), self._geom.Tokens
        shown = one.ComputePurpose() in (tokens.default_, tokens.render)
        return bool(shown and one.ComputeVisibility(time) != tokens.invisible)

    def _is_wanted(self, prim: Any) -> bool:
        """Whether it, or what it is part of, is among the names that were given."""
        names = str(prim.GetPath()).split("/")
        return not self._wanted or bool(self._wanted.intersection(names))

    def _deformed(
        self, prim: Any, points: Any, matrix: NDArray[np.float64], time: Any, places: Any
    ) -> Tuple[NDArray[np.float32], NDArray[np.float64]]:
        """The vertices of a mesh and its place, for rows, with its blend shapes and its skin."""
        if prim.GetPath() not in self._skins:
            return np.array(points), matrix
        skeleton, skinning, shapes = self._skins[prim.GetPath()]
        animation = skeleton.GetAnimQuery()
        weights = animation.ComputeBlendShapeWeights(time) if animation and skinning.HasBlendShapes() else None
        if weights:
            chosen = shapes.ComputeSubShapeWeights(skinning.GetBlendShapeMapper().Remap(weights))
            shapes.ComputeDeformedPoints(
                *chosen, shapes.ComputeBlendShapePointIndices(), shapes.ComputeSubShapePointOffsets(), points
            )
        if not skinning.HasJointInfluences():
            return np.array(points), matrix
        joints = skeleton.ComputeSkinningTransforms(time)
        there = _matrix(places.GetLocalToWorldTransform(skeleton.GetPrim()))
        if skinning.IsRigidlyDeformed():
            return np.array(points), _matrix(skinning.ComputeSkinnedTransform(joints, time)) @ there
        skinning.ComputeSkinnedPoints(joints, points, time)
        return np.array(points), there

    def _faces_of(self, prim: Any, points: Any, time: Any) -> Optional[Tuple[str, bytes]]:
        """The faces; None if there are none, or if they are invalid."""
        mesh, path = self._geom.Mesh(prim), str(prim.GetPath())
        if path in self._lasting:
            return self._lasting[path]
        of_counts, of_corners = mesh.GetFaceVertexCountsAttr(), mesh.GetFaceVertexIndicesAttr()
        counts, corners = of_counts.Get(time), of_corners.Get(time)
        if not counts or not corners or not points:
            return None
        valid, why = self._geom.Mesh.ValidateTopology(corners, counts, len(points))
        if not valid:
            self._broken.setdefault(prim.GetName(), why)
            return None
        digest = hashlib.blake2b(np.array(counts).tobytes(), digest_size=16)
        digest.update(np.array(corners).tobytes() + len(points).to_bytes(8, "little"))
        faces = path, digest.digest()
        if faces not in self.faces:
            self.faces[faces] = self._read_faces(mesh, np.array(counts), np.array(corners), np.array(points), time)
        if not len(self.faces[faces].triangles):
            return None
        if not (of_counts.ValueMightBeTimeVarying() or of_corners.ValueMightBeTimeVarying()):
            self._lasting[path] = faces
        return faces

    def _read_faces(
        self, mesh: Any, counts: NDArray[Any], corners: NDArray[Any], points: NDArray[Any], time: Any
    ) -> Faces:
        triangles, polygons = triangulate(counts, corners, points)
        holes = mesh.GetHoleIndicesAttr().Get(time)
        if holes:
            solid = ~np.isin(polygons, np.array(holes))
            triangles, polygons = triangles[solid], polygons[solid]
        if mesh.GetOrientationAttr().Get(time) == self._geom.Tokens.leftHanded:
            triangles = triangles[:, ::-1]
        attributes: Dict[str, NDArray[Any]] = {}
        if not len(triangles):
            return Faces(corners[triangles], attributes)
        primvars = self._geom.PrimvarsAPI(mesh)
        where = triangles, polygons, corners, len(points), time
        places = self._values(self._texture_places(primvars), *where)
        if places is not None:
            attributes["uv:corners"] = places.astype(np.float32).reshape(-1, 6)
        colors = self._values(primvars.GetPrimvar("displayColor"), *where)
        if colors is not None:
            opacity = self._values(primvars.GetPrimvar("displayOpacity"), *where)
            alpha = np.ones(colors.shape[:2]) if opacity is None else opacity
            attributes["color:corners"] = np.dstack([colors, alpha]).astype(np.float32).reshape(-1, 12)
        numbers = self._materials_of(mesh.GetPrim(), len(counts), time)
        if numbers.any():
            attributes["material"] = numbers[polygons]
        return Faces(corners[triangles], attributes)

    @staticmethod
    def _texture_places(primvars: Any) -> Any:
        """The primvar st, otherwise the first of texture coordinates."""
        kinds = "texCoord2f[]", "float2[]"
        found = [one for one in primvars.GetPrimvarsWithValues() if str(one.GetTypeName()) in kinds]
        return next((one for one in found if one.GetPrimvarName() == "st"), found[0] if found else None)

    @staticmethod
    def _values(
        primvar: Any, triangles: NDArray[Any], polygons: NDArray[Any], corners: NDArray[Any], points: int, time: Any
    ) -> Optional[NDArray[Any]]:
        """Values of triangle corners (m, 3, ...); None if there are none, or too few or too many."""
        found = primvar.ComputeFlattened(time) if primvar else None
        if not found:
            return None
        values = np.array(found)
        kind = primvar.GetInterpolation()
        if kind == "faceVarying":
            where, count = triangles, len(corners)
        elif kind in ("vertex", "varying"):
            where, count = corners[triangles], points
        elif kind == "uniform":
            where, count = polygons[:, None].repeat(3, axis=1), int(polygons.max()) + 1
        else:
            where, count = np.zeros_like(triangles), 1
        return values[where] if len(values) >= count else None

    def _materials_of(self, prim: Any, polygons: int, time: Any) -> NDArray[np.uint32]:
        """The number of each polygon's material; 0 for none."""
        binding = self._shade.MaterialBindingAPI(prim)
        numbers = np.full(polygons, self._number_of(binding), dtype=np.uint32)
        for subset in binding.GetMaterialBindSubsets():
            chosen = np.array(subset.GetIndicesAttr().Get(time) or [], dtype=np.int64)
            known = chosen[(0 <= chosen) & (chosen < polygons)]
            numbers[known] = self._number_of(self._shade.MaterialBindingAPI(subset.GetPrim()))
        return numbers

    def _number_of(self, binding: Any) -> int:
        material, _ = binding.ComputeBoundMaterial()
        if not material:
            return 0
        name = material.GetPrim().GetName()
        if name not in self.materials:
            self.materials.append(name)
        return self.materials.index(name) + 1

    def losses(self) -> List[str]:
        """What the stage has that was not among the solids, by the kind of prim."""
        kinds: Dict[str, List[str]] = {}
        for prim in self._prims:
            if not self._is_wanted(prim) or prim in self._solid or prim.GetName() in self._broken:
                continue
            kind = f"objects of the type {prim.GetTypeName()}"
            if prim.IsA(self._geom.Mesh):
                kind = "hidden objects or such without faces"
            elif not (prim.IsA(self._geom.Gprim) or prim.IsA(self._geom.Camera) or prim.HasAPI(self._light)):
                continue
            kinds.setdefault(kind, []).append(f"'{prim.GetName()}'")
        broken = [f"the faces of '{name}' are invalid: {why}" for name, why in self._broken.items()]
        errors = [str(error).strip().splitlines()[-1] for error in self._stage.GetCompositionErrors()]
        return [*(f"{kind}: {', '.join(sorted(names))}" for kind, names in sorted(kinds.items())), *broken, *errors]

    def notes(self) -> List[str]:
        none = self._geom.Tokens.none
        smooth = sorted(f"'{prim.GetName()}'" for prim in self._solid
                        if self._geom.Mesh(prim).GetSubdivisionSchemeAttr().Get() != none)  # fmt: skip
        return [f"subdivision surfaces are read as their cages: {', '.join(smooth)}"] if smooth else []


def _matrix(found: Any) -> NDArray[np.float64]:
    return np.array(found, dtype=np.float64)


def record_file(request: Dict[str, Any]) -> None:
    """Records a file in a process of its own, for t4d-blender."""
    recorder.record_file(request, File)
