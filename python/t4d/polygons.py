"""Triangles of polygons: two for a quad, along a diagonal that is inside, and ears for others."""

from __future__ import annotations

from typing import Any, List, Tuple

import numpy as np
from numpy.typing import NDArray

# The smallest part of a quad: with a smaller triangle, the other diagonal is taken. Rounding leaves
# less of none.
_LEAST = 1e-5


def triangulate(
    counts: NDArray[Any], corners: NDArray[Any], vertices: NDArray[Any]
) -> Tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The triangles of polygons, of which each has its count of the corners, which number vertices (n, 3): (m, 3)
    positions among the corners, in the order of polygons, and the polygon of each (m,). Points and lines have none."""
    counts = np.asarray(counts, dtype=np.int64)
    begins = np.cumsum(counts) - counts
    found = [_triangles(begins[counts == 3]), _quads(begins[counts == 4], corners, vertices)]
    owners = [np.flatnonzero(counts == 3), np.repeat(np.flatnonzero(counts == 4), 2)]
    for polygon in np.flatnonzero(counts > 4):
        own = np.arange(begins[polygon], begins[polygon] + counts[polygon])
        found.append(own[_ears(_flat(vertices[corners[own]]))])
        owners.append(np.full(counts[polygon] - 2, polygon))
    order = np.argsort(np.concatenate(owners), kind="stable")
    return np.concatenate(found)[order], np.concatenate(owners)[order]


def _triangles(begins: NDArray[np.int64]) -> NDArray[np.int64]:
    return begins[:, None] + np.arange(3)


def _quads(begins: NDArray[np.int64], corners: NDArray[Any], vertices: NDArray[Any]) -> NDArray[np.int64]:
    """Along the diagonal of the first corner, unless a triangle there is turned round or almost nothing."""
    a, b, c, d = np.moveaxis(vertices[corners[begins[:, None] + np.arange(4)]], 1, 0)
    whole = np.cross(c - a, d - b)  # twice the area, along the normal
    parts = [(np.cross(one - a, other - a) * whole).sum(axis=1) for one, other in ((b, c), (c, d))]
    folds = np.minimum(*parts) <= _LEAST * (whole**2).sum(axis=1)
    ways = np.array([[[0, 1, 2], [0, 2, 3]], [[0, 1, 3], [1, 2, 3]]])
    triangles: NDArray[np.int64] = begins[:, None, None] + ways[folds.astype(int)]
    return triangles.reshape(-1, 3)


def _flat(points: NDArray[Any]) -> NDArray[np.float64]:
    """A polygon (n, 3) in the plane of its mean normal (n, 2), counter-clockwise."""
    points = points - points.mean(axis=0)
    normal = np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)
    length = float(np.linalg.norm(normal))
    normal = normal / length if length else np.array([0.0, 0.0, 1.0])
    side = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    side /= np.linalg.norm(side)
    flat: NDArray[np.float64] = points @ np.stack([side, np.cross(normal, side)], axis=1)
    return flat


def _doubled(a: NDArray[Any], b: NDArray[Any], c: NDArray[Any]) -> NDArray[Any]:
    """Twice the area of triangles, above zero if they are counter-clockwise."""
    doubled: NDArray[Any] = (b - a)[..., 0] * (c - a)[..., 1] - (b - a)[..., 1] * (c - a)[..., 0]
    return doubled


def _ears(flat: NDArray[np.float64]) -> List[List[int]]:
    """The triangles of a polygon (n, 2): the ears, cut off one by one, the best first. An ear has no other corner in
    it. One that crosses itself has as many, of which some overlap."""
    left = list(range(len(flat)))
    ears = []
    while len(left) > 3:
        points = flat[left]
        before, after = np.roll(points, 1, axis=0), np.roll(points, -1, axis=0)
        sides = (before, points), (points, after), (after, before)
        edges = sum(((one - other) ** 2).sum(axis=1) for one, other in sides)
        quality = _doubled(before, points, after) / np.maximum(edges, np.finfo(float).tiny)
        order = np.argsort(-quality, kind="stable")
        ear = next((one for one in order if quality[one] > 0 and not _holds(points, one)), order[0])
        ears.append([left[ear - 1], left[ear], left[(ear + 1) % len(left)]])
        del left[ear]
    return [*ears, left]


def _holds(points: NDArray[np.float64], ear: int) -> bool:
    """Whether another corner is in an ear or on its border, and none of its own places."""
    own = points[[ear - 1, ear, (ear + 1) % len(points)]]
    others = points[~(points[:, None] == own).all(axis=2).any(axis=1)]
    sides = [_doubled(own[i - 1], own[i], others) >= 0 for i in range(3)]
    return bool(np.logical_and.reduce(sides).any())
