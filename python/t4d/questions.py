"""Questions to motion, and repairs, of meshes in memory or in files.

They run verbs of the program (``t4d.verbs``) and take their options: ``clearance=0.2`` is
``--clearance 0.2``, and ``help(t4d.verbs.collide)`` prints all of them. Each returns a
``t4d.verbs.Report``: what the verb found, and as ``report.mesh`` what it made.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Callable, Optional, Union

from numpy.typing import ArrayLike

from t4d.checks import Path
from t4d.mesh import Mesh
from t4d.triangles import TriangleMesh

if TYPE_CHECKING:
    from t4d.verbs import Report


def _run() -> Callable[..., Report]:
    """verbs.run, which is not there in a build without the program."""
    from t4d.verbs import run

    return run


def collide(first: Union[Mesh, Path], second: Union[Mesh, Path, None] = None, **options: Any) -> Report:
    """Whether two moving solids touch or overlap, when, where and how deep, or their smallest
    distance: ``report.pairs[0].verdict``. Without ``second``, the bodies of ``first`` are tested
    against each other."""
    return _run()("collide", first, *([] if second is None else [second]), **options)


def envelope(mesh: Union[Mesh, Path], **options: Any) -> Report:
    """The solid that a motion passes through (its swept volume), a TriangleMesh: ``report.mesh``.
    ``voxel_size=0.1`` sets how fine it is; with ``outside=True`` it contains the motion for
    certain."""
    return _run()("envelope", mesh, **{"output": TriangleMesh, **options})


def mend(
    vertices: Union[TriangleMesh, Path, ArrayLike], triangles: Optional[ArrayLike] = None, **options: Any
) -> Report:
    """A closed, manifold TriangleMesh without self-intersections: ``report.mesh``. Takes vertices
    (n, 3) and triangles (m, 3), a TriangleMesh, or a file."""
    solid = vertices if triangles is None else TriangleMesh(vertices, triangles)  # type: ignore[arg-type]
    return _run()("mend", solid, **{"output": TriangleMesh, **options})


def resolve(obstacles: Union[Mesh, Path], mesh: Union[Mesh, Path], **options: Any) -> Report:
    """``mesh`` deformed so that it avoids ``obstacles``: ``report.mesh``, a Mesh."""
    return _run()("resolve", obstacles, mesh, **{"output": Mesh, **options})
