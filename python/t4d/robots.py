"""Robots (.urdf) and mechanisms (.json) whose solids are in files that the program does not read: these become triangle
meshes in temporary files, and so does what names them."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path
from typing import Dict, List, NamedTuple, Optional, Union
from xml.etree import ElementTree
from xml.sax.saxutils import quoteattr, unescape

from t4d import collada_mesh, scenes, still
from t4d.collada_mesh import ColladaMesh
from t4d.still import Still
from t4d.triangles import TriangleMesh

_LINKS = re.compile(r"\.(?:%s)[\"']" % "|".join(one[1:] for one in scenes.EXTENSIONS), re.IGNORECASE)
_MESH = re.compile(r"""(<mesh\b[^>]*?\bfilename\s*=\s*)("[^"]*"|'[^']*')""")


class Robot(NamedTuple):
    """What the program is given, and what the user calls the files in it."""

    path: str
    names: Dict[str, str]
    losses: List[str]


def is_needed(path: str) -> bool:
    """Whether a file is of this kind, and links what the program does not read."""
    if scenes.extension_of(path) not in (".urdf", ".json"):
        return False
    try:
        text = Path(path).read_text(encoding="utf-8")
    except (OSError, ValueError):
        return False  # the program says why
    is_robot = "<robot" in text if scenes.extension_of(path) == ".urdf" else '"bodies"' in text
    return is_robot and _LINKS.search(text) is not None


def convert(path: str, folder: Path, geometry: str = "collision") -> Robot:
    """Writes the files to the folder. Raises Error."""
    solids = _Solids(path, folder)
    text = Path(path).read_text(encoding="utf-8")
    place = folder / os.path.basename(path)
    written = _urdf(text, geometry, solids) if scenes.extension_of(path) == ".urdf" else _mechanism(text, solids)
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
        """Where the program finds what a file says."""
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


def _urdf(text: str, geometry: str, solids: _Solids) -> str:
    """The robot with the places of its meshes, on the same lines."""
    try:
        links = ElementTree.fromstring(text).iterfind(f".//{geometry}//mesh")
        used = {link.get("filename") for link in links}
    except ElementTree.ParseError:
        return text  # the program says what is wrong

    def placed(found: "re.Match[str]") -> str:
        name = unescape(found[2][1:-1], {"&quot;": '"', "&apos;": "'"})
        path = _path_of(name, solids.home) if name in used else None
        return found[0] if path is None else found[1] + quoteattr(solids.place_of(path))

    return _MESH.sub(placed, text)


def _path_of(name: str, home: Path) -> Optional[Path]:
    """As the program finds it: package://NAME/PATH in the folders that contain the robot, as NAME/PATH, and as PATH
    where one is called NAME. None if it is in none."""
    if name.startswith("file://"):
        return Path(name[len("file://") :])
    if not name.startswith("package://"):
        return home / name
    rest = name[len("package://") :]
    package, _, within = rest.partition("/")
    for folder in (home, *home.parents):
        for path in (folder / rest, *([folder / within] if folder.name == package else [])):
            if path.is_file():
                return path
    return None


def _mechanism(text: str, solids: _Solids) -> str:
    """The mechanism with the places of all files. What is in metres says so."""
    try:
        whole = json.loads(text)
        bodies = [body for body in whole["bodies"] if isinstance(body, dict)]
    except (ValueError, KeyError, TypeError):
        return text  # the program says what is wrong
    for body in bodies:
        solid, motion = body.get("solid"), body.get("motion")
        if isinstance(solid, str):
            body["solid"] = solids.place_of(solids.home / solid)
            if scenes.is_scene(solid) and whole.get("length_unit"):
                body.setdefault("unit", "m")
        if isinstance(motion, dict) and isinstance(motion.get("file"), str):
            motion["file"] = str(solids.home / motion["file"])
    return json.dumps(whole)
