"""Robots (.urdf, .xml of MuJoCo, and .sdf and .world of Gazebo) and mechanisms (.json) that the program does not read, or
whose solids are in files that it does not: these become triangle meshes in temporary files, and so does what names
them."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path
from typing import Dict, List, NamedTuple, Optional, Union
from xml.etree import ElementTree
from xml.sax.saxutils import quoteattr, unescape

from t4d import collada_mesh, mujoco_robot, scenes, sdf_robot, still
from t4d.collada_mesh import ColladaMesh
from t4d.still import Still
from t4d.triangles import TriangleMesh

_LINKS = re.compile(r"\.(?:%s)[\"']" % "|".join(one[1:] for one in scenes.EXTENSIONS), re.IGNORECASE)
_MESH = re.compile(r"""(<mesh\b[^>]*?\bfilename\s*=\s*)("[^"]*"|'[^']*')""")

_MUJOCO, _GAZEBO = (".xml", ".mjcf"), (".sdf", ".world")


class Robot(NamedTuple):
    """What the program is given, and what the user calls the files in it."""

    path: str
    names: Dict[str, str]
    losses: List[str]


def is_needed(path: str) -> bool:
    """Whether a file is of this kind, and links what the program does not read."""
    if scenes.extension_of(path) not in (".urdf", ".json", *_MUJOCO, *_GAZEBO):
        return False
    try:
        text = Path(path).read_text(encoding="utf-8")
    except (OSError, ValueError):
        return False  # the program says why
    if scenes.extension_of(path) in _MUJOCO:
        return "<mujoco" in text
    if scenes.extension_of(path) in _GAZEBO:
        return "<sdf" in text
    is_robot = "<robot" in text if scenes.extension_of(path) == ".urdf" else '"bodies"' in text
    return is_robot and _LINKS.search(text) is not None


def convert(path: str, folder: Path, geometry: str = "", packages: Optional[Dict[str, Path]] = None) -> Robot:
    """Writes the files to the folder; packages are the folders of --package. Raises Error."""
    solids = _Solids(path, folder)
    if scenes.extension_of(path) in (*_MUJOCO, *_GAZEBO):
        if scenes.extension_of(path) in _MUJOCO:
            robot = mujoco_robot.read(path, folder)
        else:
            robot = sdf_robot.read(path, folder, lambda uri: _gazebo_place(uri, solids, packages or {}))
        made = folder / f"{Path(path).stem}.urdf"
        made.write_text(robot.urdf, encoding="utf-8")
        losses = [f"{path}: {loss}" for loss in robot.losses]
        return Robot(str(made), {**solids.names, str(made): path}, losses + solids.losses)
    text = Path(path).read_text(encoding="utf-8")
    place = folder / os.path.basename(path)
    is_urdf = scenes.extension_of(path) == ".urdf"
    written = _urdf(text, geometry, solids, packages or {}) if is_urdf else _mechanism(text, solids)
    place.write_text(written, encoding="utf-8")
    return Robot(str(place), {**solids.names, str(place): path}, solids.losses)


class _Solids:
    """The files that one names, each converted once."""

    def __init__(self, path: str, folder: Path) -> None:
        self.home, self._folder = Path(os.path.abspath(path)).parent, folder
        self.names: Dict[str, str] = {}
        self.losses: List[str] = []
        self._places: Dict[str, str] = {}

    def place_of(self, path: Path) -> str:
        """The place where the program finds a file that the robot names."""
        name = str(path)
        if not scenes.is_scene(name) or not path.is_file():  # of what is missing, the program says so
            return name
        if name not in self._places:
            made = self._folder / str(len(self._places)) / f"{path.stem}.ply"
            made.parent.mkdir(parents=True)
            is_collada = scenes.extension_of(name) == ".dae"
            found: Union[ColladaMesh, Still] = collada_mesh.read(name) if is_collada else still.read(name)
            TriangleMesh(found.vertices, found.triangles).save(made)
            self.losses += [f"{name}: {loss}" for loss in found.losses]
            self._places[name] = str(made)
            self.names[str(made)] = name
            self.names[f"{made.parent}{os.sep}"] = f"{path.parent}{os.sep}"  # where the program proposes an output
        return self._places[name]


def _urdf(text: str, geometry: str, solids: _Solids, packages: Dict[str, Path]) -> str:
    """The robot with the places of its meshes, on the same lines."""
    try:
        robot = ElementTree.fromstring(text)
    except ElementTree.ParseError:
        return text  # the program says what is wrong
    chosen = geometry or ("visual" if robot.find("link/collision") is None else "collision")
    used = {link.get("filename") for link in robot.iterfind(f".//{chosen}//mesh")}

    def placed(found: "re.Match[str]") -> str:
        name = unescape(found[2][1:-1], {"&quot;": '"', "&apos;": "'"})
        path = _path_of(name, solids.home, packages) if name in used else None
        return found[0] if path is None else found[1] + quoteattr(solids.place_of(path))

    return _MESH.sub(placed, text)


def _gazebo_place(uri: str, solids: _Solids, packages: Dict[str, Path]) -> str:
    """The place of a file that a URI names, as model://arm/arm.stl."""
    name = "package://" + uri[len("model://") :] if uri.startswith("model://") else uri
    path = _path_of(name, solids.home, packages)
    return name if path is None else solids.place_of(path)


def _path_of(name: str, home: Path, packages: Dict[str, Path]) -> Optional[Path]:
    """The path that the program finds (formats/motion/package_path.h). None if it finds none."""
    if name.startswith("file://"):
        return Path(name[len("file://") :])
    if not name.startswith("package://"):
        return home / name
    package, _, within = name[len("package://") :].partition("/")
    within = within.lstrip("/")
    if package in packages:
        return packages[package] / within
    places = [home, *home.parents]
    for variable in ("ROS_PACKAGE_PATH", "GZ_SIM_RESOURCE_PATH", "GAZEBO_MODEL_PATH"):
        places += [Path(one) for one in os.environ.get(variable, "").split(":") if one]
    places += [Path(one) / "share" for one in os.environ.get("AMENT_PREFIX_PATH", "").split(":") if one]
    for folder in places:
        if (folder / package / within).is_file():
            return folder / package / within
        if (folder / within).is_file() and _is_package(folder, package):
            return folder / within
    return None


def _is_package(folder: Path, name: str) -> bool:
    if folder.name == name:
        return True
    try:
        found = re.search(r"<name>\s*([^\s<]*)", (folder / "package.xml").read_text(encoding="utf-8", errors="replace"))
    except OSError:
        return False
    return found is not None and found[1] == name


def _mechanism(text: str, solids: _Solids) -> str:
    """The mechanism with the places of all files. Those in metres say so."""
    try:
        whole = json.loads(text)
        bodies = [body for body in whole.get("bodies", []) if isinstance(body, dict)]
        robots = [robot for robot in whole.get("robots", []) if isinstance(robot, dict)]
    except (ValueError, AttributeError, TypeError):
        return text  # the program says what is wrong
    for robot in robots:
        for key in ("robot", "motion"):
            if isinstance(robot.get(key), str):
                robot[key] = str(solids.home / robot[key])
    for body in bodies:
        solid, motion = body.get("solid"), body.get("motion")
        if isinstance(solid, str):
            body["solid"] = solids.place_of(solids.home / solid)
            if scenes.is_scene(solid) and whole.get("length_unit"):
                body.setdefault("unit", "m")
        if isinstance(motion, dict) and isinstance(motion.get("file"), str):
            motion["file"] = str(solids.home / motion["file"])
    return json.dumps(whole)
