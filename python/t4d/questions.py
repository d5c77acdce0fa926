"""Questions to motion, and repairs, of meshes in memory or in files.

They run verbs of the program (``t4d.verbs``) and take their options: ``clearance=0.2`` is
``--clearance 0.2``, and ``help(t4d.verbs.collide)`` prints all of them. Each returns a
report of ``t4d.verbs``: what the verb found, and as ``report.mesh`` what it made.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Optional, Union

from numpy.typing import ArrayLike

from t4d.checks import Path
from t4d.mesh import Mesh
from t4d.triangles import TriangleMesh

if TYPE_CHECKING:
    from t4d.verbs import CollideReport, EnvelopeReport, MendReport, ResolveReport


def collide(
    first: Union[Mesh, Path], second: Union[Mesh, Path, None] = None, **options: Any
) -> CollideReport:
    """Whether two moving solids touch or overlap, when, where and how deep, or their smallest
    distance: ``report.pairs[0].verdict``. Without ``second``, the bodies of ``first`` are tested
    against each other."""
    from t4d import verbs

    return verbs.collide(first, *([] if second is None else [second]), **options)


def envelope(mesh: Union[Mesh, Path], **options: Any) -> EnvelopeReport:
    """The solid that a motion passes through (its swept volume), a TriangleMesh: ``report.mesh``.
    ``voxel_size=0.1`` sets how fine it is; with ``outside=True`` it contains the motion for
    certain."""
    from t4d import verbs

    options.setdefault("output", TriangleMesh)
    return verbs.envelope(mesh, **options)


def mend(
    vertices: Union[TriangleMesh, Path, ArrayLike], triangles: Optional[ArrayLike] = None, **options: Any
) -> MendReport:
    """A closed, manifold TriangleMesh without self-intersections: ``report.mesh``. Takes vertices
    (n, 3) and triangles (m, 3), a TriangleMesh, or a file."""
    from t4d import verbs

    solid: Any = vertices if triangles is None else TriangleMesh(vertices, triangles)  # type: ignore[arg-type]
    options.setdefault("output", TriangleMesh)
    return verbs.mend(solid, **options)


def resolve(obstacles: Union[Mesh, Path], mesh: Union[Mesh, Path], **options: Any) -> ResolveReport:
    """``mesh`` deformed so that it avoids ``obstacles``: ``report.mesh``, a Mesh."""
    from t4d import verbs

    options.setdefault("output", Mesh)
    return verbs.resolve(obstacles, mesh, **options)
