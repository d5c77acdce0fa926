"""Rigid motions."""

from __future__ import annotations

import json
import math
import os
from typing import Any, Mapping, SupportsFloat, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from t4d import _t4d, checks
from t4d.checks import Path
from t4d.errors import about, warn
from t4d.unchanging import Unchanging

MotionLike = Union["Motion", Mapping[str, Any], Path]


class Motion(Unchanging):
    """A sequence of screw motions: rotations about an axis with a translation, both uniform."""

    _instead = "pickle what it is made of, or the path of its file"
    _motion: _t4d.Motion

    def __init__(self, given: MotionLike) -> None:
        """Takes the members of a motion file as a dictionary (docs/motion.md), or a file: .json,
        or a table of poses (.csv, .tsv, .txt). Warns of poses that are half a turn apart, which do
        not tell the direction of the turn."""
        if isinstance(given, Motion):
            self._motion = given._motion
        elif isinstance(given, Mapping):
            self._motion = _t4d.parse_motion(json.dumps(plain(given, "")))
            self._warn()
        elif not isinstance(given, (str, bytes, os.PathLike)):
            raise TypeError(f"the motion is {given!r}; expected a dictionary or a file")
        else:
            place = checks.path_text(given)
            with about(place):
                self._motion = _t4d.read_motion(os.fsencode(place))
            self._warn()

    @classmethod
    def _of(cls, motion: _t4d.Motion) -> Motion:
        made = cls.__new__(cls)
        made._motion = motion
        made._warn()
        return made

    def _warn(self) -> None:
        if self._motion.notice:
            warn(UserWarning, [self._motion.notice])

    @classmethod
    def from_quaternions(
        cls, times: ArrayLike, positions: ArrayLike, quaternions: ArrayLike
    ) -> Motion:
        """Poses at ``times`` (n,), joined by screws of at most half a turn: ``positions`` (n, 3), and
        ``quaternions`` (n, 4) of unit length as (x, y, z, w), scipy's order."""
        times = _doubles("times", times)
        positions = _doubles("positions", positions)
        quaternions = _doubles("quaternions", quaternions)
        if (
            times.ndim != 1
            or positions.shape != (len(times), 3)
            or quaternions.shape != (len(times), 4)
        ):
            raise ValueError(
                f"times {times.shape}, positions {positions.shape}, quaternions {quaternions.shape}: "
                "expected (n,), (n, 3) and (n, 4)"
            )
        return cls._of(_t4d.join_poses([float(time) for time in times], positions, quaternions))

    @classmethod
    def from_matrices(cls, times: ArrayLike, matrices: ArrayLike) -> Motion:
        """Poses as 4 x 4 ``matrices`` (n, 4, 4), rotation and translation, at ``times`` (n,)."""
        matrices = _doubles("matrices", matrices)
        if matrices.ndim != 3 or matrices.shape[1:] != (4, 4):
            raise ValueError(f"matrices have the shape {matrices.shape}; expected (n, 4, 4)")
        rotations = matrices[:, :3, :3]
        defect = np.abs(rotations @ rotations.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2))
        wrong = (defect > 1e-6) | (np.linalg.det(rotations) < 0)
        wrong |= np.any(matrices[:, 3] != [0, 0, 0, 1], axis=1)
        if wrong.any():
            raise ValueError(
                f"matrix {int(np.argmax(wrong))} is not a rotation with a translation: "
                "solids neither scale nor shear nor mirror"
            )
        quaternions = np.array([_quaternion(rotation) for rotation in rotations])
        return cls.from_quaternions(times, matrices[:, :3, 3], quaternions)

    @property
    def time_span(self) -> Tuple[float, float]:
        return self._motion.time_span

    @property
    def length_unit(self) -> str:
        """"" if unknown."""
        return self._motion.length_unit

    @property
    def time_unit(self) -> str:
        return self._motion.time_unit

    def at(self, time: SupportsFloat) -> NDArray[np.float64]:
        """The pose at a time, a 4 x 4 matrix; times outside are clamped."""
        moment = checks.number("time", time, holds=lambda x: not math.isnan(x))
        return self._motion.at(moment)

    def __repr__(self) -> str:
        begin, end = self.time_span
        units = ", ".join(unit for unit in (self.length_unit, self.time_unit) if unit)
        return f"<t4d.Motion: from {begin} to {end}{f' ({units})' if units else ''}>"


def _doubles(what: str, values: ArrayLike) -> NDArray[np.float64]:
    found = checks.array(what, values).astype(np.float64)
    wrong = np.argwhere(~np.isfinite(found))
    if len(wrong):
        place = "".join(f"[{i}]" for i in wrong[0])
        raise ValueError(f"{what}{place} is {found[tuple(wrong[0])]}; expected a finite number")
    return found


def plain(given: Any, place: str) -> Any:
    """The value for JSON: numbers and arrays of numpy, and other mappings and sequences, become Python's."""
    if isinstance(given, (np.generic, np.ndarray)):
        given = checks.array(place, given).tolist()
    if isinstance(given, Mapping):
        return {
            key: plain(value, f"{place}.{key}" if place else str(key))
            for key, value in given.items()
        }
    if isinstance(given, (list, tuple)):
        return [plain(value, f"{place}[{i}]") for i, value in enumerate(given)]
    if isinstance(given, float) and not math.isfinite(given):
        raise ValueError(f"{place} is {given}; expected a finite number")
    if given is None or isinstance(given, (bool, int, float, str)):
        return given
    raise TypeError(f"{place} is {given!r}; expected numbers, texts, lists and dictionaries")


def _quaternion(rotation: NDArray[np.float64]) -> NDArray[np.float64]:
    """(x, y, z, w) of unit length: the eigenvector of the largest eigenvalue of Bar-Itzhack's
    matrix, which no rotation makes ill-conditioned."""
    r = rotation
    k = np.array(
        [
            [r[0, 0] - r[1, 1] - r[2, 2], 0, 0, 0],
            [r[1, 0] + r[0, 1], r[1, 1] - r[0, 0] - r[2, 2], 0, 0],
            [r[2, 0] + r[0, 2], r[2, 1] + r[1, 2], r[2, 2] - r[0, 0] - r[1, 1], 0],
            [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], r.trace()],
        ]
    )
    vectors: NDArray[np.float64] = np.linalg.eigh(k)[1]
    return vectors[:, -1]
