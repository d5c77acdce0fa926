"""Robots of MuJoCo (MJCF) as URDF with the same links, joints and solids, read by the library mujoco (PyPI)."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any, Dict, List, Optional
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from t4d import urdf_text
from t4d.errors import InvalidInput, Unsupported
from t4d.triangles import TriangleMesh
from t4d.urdf_text import UrdfRobot, UrdfText, numbers


def read(path: str, folder: Path) -> UrdfRobot:
    """Writes the meshes to the folder. Geoms that collide are the collision geometry of their bodies, others the visual
    one. Raises Error."""
    try:
        mujoco = importlib.import_module("mujoco")
    except ImportError:
        raise Unsupported("is MJCF, which needs the package mujoco (pip install mujoco)", path) from None
    try:
        model = mujoco.MjModel.from_xml_path(path)
    except (ValueError, RuntimeError) as error:
        raise InvalidInput(f"mujoco cannot read it: {' '.join(str(error).split())}", path) from None
    return _Robot(mujoco, model, folder).made()


class _Robot:
    """All frames of links have the axes of the world while joints are at 0, and their origin on the axis of the joint."""

    def __init__(self, mujoco: Any, model: Any, folder: Path) -> None:
        self._mujoco, self._model, self._folder = mujoco, model, folder
        self._data = mujoco.MjData(model)
        for joint in range(model.njnt):
            if self._kind(joint) != "floating":
                self._data.qpos[model.jnt_qposadr[joint]] = 0
        mujoco.mj_kinematics(model, self._data)
        self._ends: List[str] = []  # the link of each body that its geoms are in
        self._origins: Dict[str, NDArray[np.float64]] = {}
        self._text = UrdfText("mjcf")
        self._losses: List[str] = []
        self._mimics = self._followers()

    def made(self) -> UrdfRobot:
        for body in range(self._model.nbody):
            self._add_body(body)
        return UrdfRobot(self._text.text(), self._losses)

    def _name(self, kind: str, number: int) -> str:
        what = getattr(self._mujoco.mjtObj, f"mjOBJ_{kind.upper()}")
        return self._mujoco.mj_id2name(self._model, what, number) or f"{kind} {number}"

    def _followers(self) -> Dict[int, str]:
        """The <mimic> of each joint that an equality lets follow another one, evenly."""
        model, found = self._model, {}
        for number in range(model.neq):
            joint, leader = int(model.eq_obj1id[number]), int(model.eq_obj2id[number])
            factors = model.eq_data[number][:5]
            if model.eq_type[number] != self._mujoco.mjtEq.mjEQ_JOINT:
                self._losses.append(f"the equality {self._name('equality', number)}, which closes a loop")
            elif leader < 0 or np.any(factors[2:] != 0):
                self._losses.append(f"the equality of joint {self._name('joint', joint)}, which is not linear")
            else:
                name = quoteattr(self._name("joint", leader))
                ratio = float(factors[1])  # of what both have moved from their places in the file
                places = [float(model.qpos0[model.jnt_qposadr[one]]) for one in (joint, leader)]
                offset = places[0] + float(factors[0]) - ratio * places[1]
                found[joint] = f'<mimic joint={name} multiplier="{ratio!r}" offset="{offset!r}"/>'
        return found

    def _add_body(self, body: int) -> None:
        model, name = self._model, self._name("body", body)
        first, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
        parent: Optional[str] = self._ends[model.body_parentid[body]] if body else None
        for joint in range(first, first + count):
            link = name if joint == first + count - 1 else f"{name} {self._name('joint', joint)}"
            self._add_link(link, parent, joint, self._data.xanchor[joint], body if link == name else None)
            parent = link
        if not count:
            self._add_link(name, parent, None, self._data.xpos[body], body)
        self._ends.append(name)

    def _add_link(
        self, link: str, parent: Optional[str], joint: Optional[int], origin: NDArray[np.float64], body: Optional[int]
    ) -> None:
        self._origins[link] = np.array(origin)
        geoms = range(self._model.ngeom) if body is not None else []
        solids = [self._geom(geom, link) for geom in geoms if self._model.geom_bodyid[geom] == body]
        self._text.add_link(link, solids)
        if parent is None:
            return
        kind, more = "fixed", ""
        name = f"{link} fixed"
        if joint is not None:
            name, kind, more = self._name("joint", joint), self._kind(joint), self._mimics.get(joint, "")
            more += f'<axis xyz="{numbers(self._data.xaxis[joint])}"/>'
            if self._model.jnt_limited[joint] and kind in ("revolute", "prismatic"):
                low, high = self._model.jnt_range[joint]
                more += f'<limit lower="{float(low)!r}" upper="{float(high)!r}"/>'
        place = _matrix(np.eye(3), self._origins[link] - self._origins[parent])
        self._text.add_joint(name, kind, parent, link, place, more)

    def _kind(self, joint: int) -> str:
        kinds = self._mujoco.mjtJoint
        if self._model.jnt_type[joint] == kinds.mjJNT_SLIDE:
            return "prismatic"
        if self._model.jnt_type[joint] == kinds.mjJNT_HINGE:
            return "revolute" if self._model.jnt_limited[joint] else "continuous"
        return "floating"

    def _geom(self, geom: int, link: str) -> str:
        model, kinds = self._model, self._mujoco.mjtGeom
        kind, size = kinds(int(model.geom_type[geom])), model.geom_size[geom]
        if kind == kinds.mjGEOM_BOX:
            shape = f'<box size="{numbers(2 * size)}"/>'
        elif kind == kinds.mjGEOM_SPHERE:
            shape = f'<sphere radius="{float(size[0])!r}"/>'
        elif kind in (kinds.mjGEOM_CYLINDER, kinds.mjGEOM_CAPSULE):
            word = "cylinder" if kind == kinds.mjGEOM_CYLINDER else "capsule"
            shape = f'<{word} radius="{float(size[0])!r}" length="{2 * float(size[1])!r}"/>'
        elif kind in (kinds.mjGEOM_MESH, kinds.mjGEOM_ELLIPSOID):
            file = self._folder / f"geom{geom}.ply"
            (self._mesh(int(model.geom_dataid[geom])) if kind == kinds.mjGEOM_MESH else urdf_text.ellipsoid(size)).save(file)
            shape = f"<mesh filename={quoteattr(str(file))}/>"
        else:
            self._losses.append(f"{self._name('geom', geom)} of {link}: a plane, a height field or another endless solid")
            return ""
        collides = model.geom_contype[geom] or model.geom_conaffinity[geom]
        word = "collision" if collides else "visual"
        turn = self._data.geom_xmat[geom].reshape(3, 3)
        return urdf_text.solid(word, _matrix(turn, self._data.geom_xpos[geom] - self._origins[link]), shape)

    def _mesh(self, mesh: int) -> TriangleMesh:
        model = self._model
        vertices = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]]
        faces = model.mesh_face[model.mesh_faceadr[mesh] :][: model.mesh_facenum[mesh]]
        return TriangleMesh(np.array(vertices, dtype=float), np.array(faces, dtype=np.int64))


def _matrix(turn: NDArray[np.float64], origin: NDArray[np.float64]) -> NDArray[np.float64]:
    made = np.eye(4)
    made[:3, :3], made[:3, 3] = turn, origin
    return made
