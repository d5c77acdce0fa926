"""The text of a URDF file, for robots in other formats."""

from __future__ import annotations

from typing import List, NamedTuple
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from t4d.triangles import TriangleMesh

_SIDES = 64  # of an ellipsoid, as of the program's spheres


class UrdfRobot(NamedTuple):
    """The text of a URDF file, and what is lost, in sentences."""

    urdf: str
    losses: List[str]


class UrdfText:
    """Collects links and joints. Places are matrices of 4 x 4."""

    def __init__(self, name: str) -> None:
        self._elements = ['<?xml version="1.0"?>', f"<robot name={quoteattr(name)}>"]

    def add_link(self, name: str, solids: List[str]) -> None:
        self._elements.append(f"<link name={quoteattr(name)}>{''.join(solids)}</link>")

    def add_joint(
        self, name: str, kind: str, parent: str, child: str, place: NDArray[np.float64], more: str = ""
    ) -> None:
        self._elements.append(
            f'<joint name={quoteattr(name)} type="{kind}"><parent link={quoteattr(parent)}/>'
            f"<child link={quoteattr(child)}/>{_origin(place)}{more}</joint>"
        )

    def text(self) -> str:
        return "\n".join([*self._elements, "</robot>", ""])


def solid(word: str, place: NDArray[np.float64], shape: str) -> str:
    """An element of a link; the word is collision or visual."""
    return f"<{word}>{_origin(place)}<geometry>{shape}</geometry></{word}>"


def _origin(place: NDArray[np.float64]) -> str:
    return f'<origin xyz="{numbers(place[:3, 3])}" rpy="{numbers(_roll_pitch_yaw(place[:3, :3]))}"/>'


def numbers(values: NDArray[np.float64]) -> str:
    return " ".join(repr(float(value)) for value in values)


def ellipsoid(radii: NDArray[np.float64]) -> TriangleMesh:
    """Inscribed, with its axes along x, y and z."""
    rows = _SIDES // 2
    polar, around = np.meshgrid(np.pi * np.arange(1, rows) / rows, 2 * np.pi * np.arange(_SIDES) / _SIDES, indexing="ij")
    ring = np.stack([np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), -np.cos(polar)], axis=-1)
    vertices = np.concatenate([ring.reshape(-1, 3), [[0, 0, -1], [0, 0, 1]]]) * radii
    low, high = len(vertices) - 2, len(vertices) - 1
    triangles = []
    for i in range(_SIDES):
        k = (i + 1) % _SIDES
        triangles += [(k, i, low), ((rows - 2) * _SIDES + i, (rows - 2) * _SIDES + k, high)]
        for row in range(0, (rows - 2) * _SIDES, _SIDES):
            triangles += [(row + i, row + k, row + _SIDES + k), (row + i, row + _SIDES + k, row + _SIDES + i)]
    return TriangleMesh(vertices, np.array(triangles, dtype=np.int64))


def _roll_pitch_yaw(turn: NDArray[np.float64]) -> NDArray[np.float64]:
    """The angles of a rotation, as URDF has it: about x, then y, then z, which stand."""
    flat = np.hypot(turn[0, 0], turn[1, 0])
    if flat < 1e-9:  # x is along z: yaw is free
        return np.array([np.arctan2(-turn[1, 2], turn[1, 1]), np.arctan2(-turn[2, 0], flat), 0.0])
    return np.array([
        np.arctan2(turn[2, 1], turn[2, 2]), np.arctan2(-turn[2, 0], flat), np.arctan2(turn[1, 0], turn[0, 0])])  # fmt: skip
