"""4D meshes: the boundary of a moving solid in space-time (x, y, z, t), made of tetrahedra.

>>> import t4d
>>> mesh = t4d.read("bolt.t4d")
>>> V, F = mesh.slice(time=2.5)
>>> t4d.sweep(V, F, "screw-in.json").save("x.t4d")

``sweep`` and ``weave`` make 4D meshes, ``read`` opens files of them, ``open_frames`` reads volumes over
time, ``collide``, ``envelope`` and ``resolve`` ask and change motions, ``mend`` repairs solids, and
``verbs`` has all that the program can do. Lengths and times are in the units of the mesh.
"""

import importlib
from typing import Any

from t4d import _t4d
from t4d.errors import Error, Failed, FileError, InvalidInput, Loss, Unsupported, VerbError
from t4d.frames import Frames, open_frames
from t4d.mesh import Mesh, Slab, read, sweep, weave
from t4d.motions import Motion
from t4d.questions import collide, envelope, mend, resolve
from t4d.triangles import TriangleMesh, read_triangles

__version__ = _t4d.version


def __getattr__(name: str) -> Any:
    """``t4d.verbs`` and ``t4d.distributed`` are loaded when they are used."""
    if name in ("distributed", "verbs"):
        return importlib.import_module(f"t4d.{name}")
    raise AttributeError(f"module 't4d' has no attribute '{name}'")


__all__ = [
    "Error",
    "Failed",
    "FileError",
    "Frames",
    "InvalidInput",
    "Loss",
    "Mesh",
    "Motion",
    "Slab",
    "TriangleMesh",
    "Unsupported",
    "VerbError",
    "collide",
    "envelope",
    "mend",
    "open_frames",
    "read",
    "read_triangles",
    "resolve",
    "sweep",
    "weave",
]
