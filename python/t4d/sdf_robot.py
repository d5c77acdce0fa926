"""Robots and worlds of Gazebo (SDF) as URDF with the same links, joints and solids."""

from __future__ import annotations

from pathlib import Path
from typing import Callable, Dict, List, NamedTuple, Optional, Tuple
from xml.etree import ElementTree
from xml.etree.ElementTree import Element
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from t4d import urdf_text
from t4d.errors import InvalidInput
from t4d.urdf_text import UrdfRobot, UrdfText, numbers

_Matrix = NDArray[np.float64]
_UNLIMITED = 1e15  # SDF writes 1e16


def read(path: str, folder: Path, place_of: Callable[[str], str]) -> UrdfRobot:
    """`place_of` gives the file that a URI names; the folder is for meshes of shapes that URDF has not. Raises Error."""
    try:
        root = ElementTree.parse(path).getroot()
    except ElementTree.ParseError as error:
        raise InvalidInput(f"is not XML: {error}", path) from None
    if root.tag != "sdf":
        raise InvalidInput(f"found the element <{root.tag}>, expected <sdf>", path)
    return _Robot(root, path, folder, place_of).made()


class _Model:
    """A model, and where its frames are in it."""

    def __init__(self, element: Element, path: str, outer: Optional["_Model"] = None) -> None:
        self.name, self._element, self._path, self._outer = element.get("name", ""), element, path, outer
        self.links, self.joints, self._frames = (_named(element, tag) for tag in ("link", "joint", "frame"))
        self.models = {name: _Model(one, path, self) for name, one in _named(element, "model").items()}
        self._open: List[Element] = []  # whose places are being found

    def place(self) -> _Matrix:
        """Where the model is in what contains it."""
        pose, relative = self.pose_of(self._element)
        if self._outer is not None:
            pose = self._outer.frame(relative) @ pose
        elif relative not in ("", "world"):
            raise self.error(f"its pose is relative to {relative!r}, expected the world")
        placed = self._element.get("placement_frame", "")
        return pose @ np.linalg.inv(self.frame(placed)) if placed else pose

    def frame(self, name: str) -> _Matrix:
        """Where a link, joint or frame is at rest."""
        model, _, inner = name.partition("::")
        if model in self.models:
            return self.models[model].place() @ self.models[model].frame(inner)
        if name in ("", "__model__"):
            return np.eye(4)
        if name in self.links:
            return self.at(self.links[name], "")
        if name in self._frames:
            return self.at(self._frames[name], self._frames[name].get("attached_to", ""))
        if name in self.joints:
            return self.at(self.joints[name], _text_of(self.joints[name], "child"))
        raise self.error(f"{name!r} is no link, joint or frame of it")

    def at(self, element: Element, usual: str) -> _Matrix:
        """Where an element is whose pose is usually relative to this frame."""
        pose, relative = self.pose_of(element)
        if element in self._open:
            raise self.error(f"the pose of {element.get('name')!r} depends on itself")
        self._open.append(element)
        found: _Matrix = self.frame(relative or usual) @ pose
        self._open.pop()
        return found

    def link_of(self, name: str) -> str:
        """The link that a frame is attached to, or "world"."""
        for _ in range(len(self._frames) + 1):
            model, _, inner = name.partition("::")
            if model in self.models:
                return f"{model}::{self.models[model].link_of(inner)}"
            if name in self.links or name == "world":
                return name
            if name in self._frames:
                name = self._frames[name].get("attached_to", "")
            elif name in ("", "__model__") and self.links:
                name = next(iter(self.links))
        raise self.error(f"{name!r} is no link of it")

    def pose_of(self, element: Element) -> Tuple[_Matrix, str]:
        """The <pose> of an element, and what it is relative to."""
        pose = element.find("pose")
        made = np.eye(4)
        if pose is None:
            return made, ""
        values = self._numbers(pose, "a position and three angles or a quaternion")
        if pose.get("rotation_format") == "quat_xyzw" and len(values) == 7:
            made[:3, :3] = _of_quaternion(values[3:])
        elif len(values) in (0, 6):
            values = values if len(values) else np.zeros(6)
            turns = np.radians(values[3:]) if pose.get("degrees") in ("true", "1") else values[3:]
            made[:3, :3] = _of_roll_pitch_yaw(turns)
        else:
            raise self.error(f"found the pose {pose.text!r}, expected a position and three angles or a quaternion")
        made[:3, 3] = values[:3]
        return made, pose.get("relative_to", pose.get("frame", ""))

    def vector(self, element: Element, tag: str, otherwise: Tuple[float, ...]) -> NDArray[np.float64]:
        found = element.find(tag)
        if found is None:
            return np.array(otherwise)
        values = self._numbers(found, f"{len(otherwise)} numbers")
        if len(values) != len(otherwise):
            raise self.error(f"found {found.text!r} in <{tag}>, expected {len(otherwise)} numbers")
        return values

    def _numbers(self, element: Element, expected: str) -> NDArray[np.float64]:
        try:
            values = np.array([float(word) for word in (element.text or "").split()])
        except ValueError:
            values = np.array([np.nan])
        if np.any(np.isnan(values)):
            raise self.error(f"found {element.text!r} in <{element.tag}>, expected {expected}")
        return values

    def error(self, message: str) -> InvalidInput:
        return InvalidInput(f"model {self.name!r}: {message}", self._path)


class _Joint(NamedTuple):
    name: str
    element: Element
    model: _Model
    parent: str
    place: _Matrix  # in the world


class _Robot:
    """All models hang on the link `world`. The frame of a link is that of the joint that moves it, as in URDF."""

    def __init__(self, root: Element, path: str, folder: Path, place_of: Callable[[str], str]) -> None:
        self._path, self._folder, self._place_of = path, folder, place_of
        version = [int(part) if part.isdigit() else 0 for part in root.get("version", "1.7").split(".")]
        self._axes_of_model = version < [1, 5]
        models = [one for world in (root, *root.iter("world")) for one in world.findall("model")]
        self._models = [_Model(one, path) for one in models]
        self._losses = [f"what it includes: {_text_of(one, 'uri')}" for one in root.iter("include")]
        self._links: Dict[str, Tuple[Element, _Model, _Matrix]] = {}
        self._moving: Dict[str, _Joint] = {}  # by the link that they move
        self._urdf = UrdfText("sdf")

    def made(self) -> UrdfRobot:
        if not self._models:
            raise InvalidInput("has no <model>, expected a robot or a world with one", self._path)
        for model in self._models:
            self._collect(model, f"{model.name}::" if len(self._models) > 1 else "", model.place())
        self._urdf.add_link("world", [])
        for link, (element, model, place) in self._links.items():
            frame = self._frame(link)
            words = ((word, solid) for word in ("collision", "visual") for solid in element.findall(word))
            self._urdf.add_link(link, [
                self._solid(word, solid, model, np.linalg.inv(frame) @ place, link) for word, solid in words])  # fmt: skip
        for link in self._links:
            self._add_joint(link)
        return UrdfRobot(self._urdf.text(), self._losses)

    def _collect(self, model: _Model, prefix: str, place: _Matrix) -> None:
        for name, element in model.links.items():
            if prefix or name != "world":  # some write a link in place of the world
                self._links[prefix + name] = (element, model, place @ model.frame(name))
        for name, element in model.joints.items():
            parent, child = (model.link_of(_text_of(element, role)) for role in ("parent", "child"))
            if child == "world" or prefix + child in self._moving:
                self._losses.append(f"joint {prefix}{name}, which closes a loop")
                continue
            whole = parent if parent == "world" else prefix + parent
            at = place @ model.at(element, _text_of(element, "child"))
            self._moving[prefix + child] = _Joint(prefix + name, element, model, whole, at)
        for name, inner in model.models.items():
            self._collect(inner, f"{prefix}{name}::", place @ inner.place())

    def _frame(self, link: str) -> _Matrix:
        if link == "world":
            return np.eye(4)
        return self._moving[link].place if link in self._moving else self._links[link][2]

    def _add_joint(self, link: str) -> None:
        if link not in self._moving:
            self._urdf.add_joint(f"{link} fixed", "fixed", "world", link, self._frame(link))
            return
        name, element, model, parent, place = self._moving[link]
        written = element.get("type", "")
        kind = {"ball": "floating"}.get(written, written)
        if kind not in ("fixed", "floating", "revolute", "continuous", "prismatic"):
            self._losses.append(f"joint {name}, which is of type {written} and stays at rest")
            kind = "fixed"
        more = ""
        axis = element.find("axis")
        if axis is not None and kind not in ("fixed", "floating"):
            low, high = (float(model.vector(axis, f"limit/{end}", (far,))[0])
                         for end, far in (("lower", -np.inf), ("upper", np.inf)))  # fmt: skip
            is_limited = min(-low, high) < _UNLIMITED
            kind = "continuous" if kind == "revolute" and not is_limited else kind
            more = f'<axis xyz="{numbers(self._axis(axis, model, element))}"/>'
            if is_limited:
                low, high = np.clip([low, high], -_UNLIMITED, _UNLIMITED)
                more += f'<limit lower="{float(low)!r}" upper="{float(high)!r}"/>'
            more += self._mimic(axis, model, name[: len(name) - len(element.get("name", ""))])
        self._urdf.add_joint(name, kind, parent, link, np.linalg.inv(self._frame(parent)) @ place, more)

    def _axis(self, axis: Element, model: _Model, joint: Element) -> NDArray[np.float64]:
        """In the frame of the joint."""
        xyz = axis.find("xyz")
        frame = "" if xyz is None else xyz.get("expressed_in", "")
        old = _text_of(axis, "use_parent_model_frame")
        if old in ("1", "true") or (self._axes_of_model and not old):
            frame = "__model__"
        direction = model.vector(axis, "xyz", (0, 0, 1))
        if not frame:
            return direction
        own = model.at(joint, _text_of(joint, "child"))[:3, :3]
        turned: NDArray[np.float64] = own.T @ model.frame(frame)[:3, :3] @ direction
        return turned

    @staticmethod
    def _mimic(axis: Element, model: _Model, prefix: str) -> str:
        mimic = axis.find("mimic")
        if mimic is None:
            return ""
        ratio, offset, reference = (
            float(model.vector(mimic, tag, (usual,))[0])
            for tag, usual in (("multiplier", 1), ("offset", 0), ("reference", 0))
        )
        leader = quoteattr(prefix + mimic.get("joint", ""))
        return f'<mimic joint={leader} multiplier="{ratio!r}" offset="{offset - ratio * reference!r}"/>'

    def _solid(self, word: str, element: Element, model: _Model, place: _Matrix, link: str) -> str:
        """An element of URDF; nothing for a solid without end. The place is that of the link."""
        geometry = element.find("geometry")
        shape = None if geometry is None or not len(geometry) else geometry[0]
        made = None if shape is None else self._shape(shape, model)
        if made is None:
            what = "geometry" if shape is None else shape.tag
            self._losses.append(f"{element.get('name', word)} of {link}: {what}, which is no solid that URDF has")
            return ""
        pose, relative = model.pose_of(element)
        if relative:
            own = next(name for name, one in model.links.items() if element in one)
            place = place @ np.linalg.inv(model.frame(own)) @ model.frame(relative)
        return urdf_text.solid(word, place @ pose, made)

    def _shape(self, shape: Element, model: _Model) -> Optional[str]:
        if shape.tag == "box":
            return f'<box size="{numbers(model.vector(shape, "size", (1, 1, 1)))}"/>'
        if shape.tag in ("sphere", "cylinder", "capsule"):
            sizes = ("radius",) if shape.tag == "sphere" else ("radius", "length")
            written = (f'{name}="{numbers(model.vector(shape, name, (1,)))}"' for name in sizes)
            return f"<{shape.tag} {' '.join(written)}/>"
        if shape.tag == "ellipsoid":
            file = self._folder / f"ellipsoid{len(list(self._folder.iterdir()))}.ply"
            urdf_text.ellipsoid(model.vector(shape, "radii", (1, 1, 1))).save(file)
            return f"<mesh filename={quoteattr(str(file))}/>"
        if shape.tag != "mesh":
            return None
        if shape.find("submesh") is not None:
            self._losses.append(f"the <submesh> of {_text_of(shape, 'uri')}: all of the file is taken")
        scale = numbers(model.vector(shape, "scale", (1, 1, 1)))
        return f'<mesh filename={quoteattr(self._place_of(_text_of(shape, "uri")))} scale="{scale}"/>'


def _named(element: Element, tag: str) -> Dict[str, Element]:
    return {one.get("name", ""): one for one in element.findall(tag)}


def _text_of(element: Element, tag: str) -> str:
    return (element.findtext(tag) or "").strip()


def _of_roll_pitch_yaw(angles: NDArray[np.float64]) -> _Matrix:
    """The rotation about x, then y, then z, which stand."""
    (cx, cy, cz), (sx, sy, sz) = np.cos(angles), np.sin(angles)
    about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    about_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    turn: _Matrix = about_z @ about_y @ about_x
    return turn


def _of_quaternion(xyzw: NDArray[np.float64]) -> _Matrix:
    x, y, z, w = xyzw / np.linalg.norm(xyzw)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])  # fmt: skip
