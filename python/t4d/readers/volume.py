"""What a reader says of its input: an array with named axes, and where and when its samples are."""

from __future__ import annotations

import contextlib
import dataclasses
import importlib
import math
import os
import re
from typing import Any, Callable, Dict, Iterator, List, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import NDArray

from t4d.errors import Error, FileError, InvalidInput, Unsupported

Box = Tuple[slice, ...]
"""Samples along x, y and z."""

_KEPT_BYTES = 1 << 28  # of frames that share chunks
MOST_LISTED = 20


class WrongOption(TypeError):
    """An option that the input has no use for; the message is "OPTION REASON"."""

    def __init__(self, option: str, reason: str) -> None:
        super().__init__(f"{option} {reason}")
        self.option, self.reason = option, reason


class Missing(InvalidInput):
    """What ``option`` must say of the input, since the input does not; ``value`` is how it is given."""

    option = value = ""

    def __init__(self, message: str, where: str, option: str = "", value: str = "") -> None:
        super().__init__(message, where)
        self.option, self.value = option, value


@dataclasses.dataclass
class Choice:
    """What is to be read of the input, as of ``open_frames``; None for what is not chosen."""

    axes: Optional[str] = None
    channel: Union[None, int, str] = None
    level: Union[None, int, str] = None
    series: Union[None, int, str] = None
    dataset: Optional[str] = None

    def allow(self, names: Sequence[str], what: str) -> None:
        """Raises WrongOption for a choice that is not one of these, which are for ``what`` it says."""
        for field in dataclasses.fields(self):
            if getattr(self, field.name) is not None and field.name not in names:
                raise WrongOption(field.name, f"is not for {what}")


@dataclasses.dataclass
class Volume:
    """Frames of samples on one lattice. ``array`` has a shape, a dtype, and gives its samples by
    ``array[...]`` with a number or a slice for each axis; ``axes`` has x, y, z, t or c (the channel) for
    each of them. Lengths and times are in ``length_unit`` and ``time_unit``, "" if unknown."""

    where: str
    array: Any
    axes: str
    spacing: Dict[str, float] = dataclasses.field(default_factory=dict)
    """By axis of space; without those that nothing says."""
    origin: Dict[str, float] = dataclasses.field(default_factory=dict)
    affine: Optional[NDArray[np.float64]] = None
    """(4, 4), maps (i, j, k, 1) to space; in place of spacing and origin."""
    times: Optional[Sequence[float]] = None
    frame_time: Optional[float] = None
    start_time: Optional[float] = None
    length_unit: str = ""
    time_unit: str = ""
    space: str = ""
    channel: int = 0
    axes_assumed: bool = False
    whole: bool = False
    """Samples are stored as whole numbers, whatever is made of them."""
    padded: bool = False
    """NaN stands for samples without data."""
    values: Optional[Callable[[NDArray[Any]], NDArray[Any]]] = None
    """What makes values, of ``dtype``, of the stored samples."""
    dtype: Optional[np.dtype[Any]] = None
    names: Optional[List[str]] = None
    notes: List[str] = dataclasses.field(default_factory=list)
    losses: List[str] = dataclasses.field(default_factory=list)
    _kept: Tuple[Any, Any] = (None, None)

    def size(self, axis: str) -> int:
        """Samples along an axis; 1 along one that is not there."""
        return int(self.array.shape[self.axes.index(axis)]) if axis in self.axes else 1

    @property
    def kind(self) -> np.dtype[Any]:
        return np.dtype(self.array.dtype if self.dtype is None else self.dtype)

    def read(self, frame: int, box: Box) -> NDArray[Any]:
        """The samples (nx, ny, nz) of a frame in a box."""
        with through(self.where):
            found = self._stored(frame, box)
            kept = [axis for axis in self.axes if axis in "xyz"]
            found = found.transpose([kept.index(axis) for axis in "xyz" if axis in kept])
            for i, axis in enumerate("xyz"):
                found = found if axis in kept else np.expand_dims(found, i)
            return found if self.values is None else self.values(found)

    def _at(self, frame: Union[int, slice], box: Box) -> Tuple[Any, ...]:
        parts: Dict[str, Any] = {"t": frame, "c": self.channel, **dict(zip("xyz", box))}
        return tuple(parts[axis] for axis in self.axes)

    def _stored(self, frame: int, box: Box) -> NDArray[Any]:
        """Frames that share chunks are read and kept together, so that chunks are unpacked once."""
        together = self._frames_of_chunk(box)
        if together < 2:
            return np.asarray(self.array[self._at(frame, box)])
        first = frame - frame % together
        key = (first, *((part.start, part.stop) for part in box))
        if self._kept[0] != key:
            self._kept = None, None
            frames = slice(first, min(first + together, self.size("t")))
            self._kept = key, np.asarray(self.array[self._at(frames, box)])
        return np.asarray(self._kept[1].take(frame - first, axis=self.axes.replace("c", "").index("t")))

    def _frames_of_chunk(self, box: Box) -> int:
        chunks = getattr(self.array, "chunks", None)
        if not chunks or "t" not in self.axes:
            return 1
        along = chunks[self.axes.index("t")]  # of dask, all of them
        bytes_ = np.dtype(self.array.dtype).itemsize * math.prod(part.stop - part.start for part in box)
        return int(min(np.ravel(along)[0], max(1, _KEPT_BYTES // max(1, bytes_))))


def library(name: str, extra: str, where: str, what: str) -> Any:
    """A package that an extra of the wheel installs. Raises Unsupported, which names the extra."""
    try:
        return importlib.import_module(name)
    except ImportError:
        package = name.partition(".")[0]
        raise Unsupported(f"is {what}, which needs the package {package}: pip install t4d[{extra}]", where) from None


@contextlib.contextmanager
def through(where: str) -> Iterator[None]:
    """What the libraries of others raise becomes an error that says where."""
    try:
        yield
    except (Error, WrongOption):
        raise
    except OSError as error:
        raise FileError(error.strerror or _first_line(error), where) from error
    except Exception as error:  # libraries raise anything for damaged files
        raise InvalidInput(f"cannot be read: {_first_line(error)}", where) from error


def _first_line(error: BaseException) -> str:
    return (str(error).strip().splitlines() or [type(error).__name__])[0]


def number_of(chosen: Union[int, str], names: Sequence[str]) -> int:
    """Of a channel, level or image that is chosen by its number or its name; -1 if there is none."""
    if chosen in names:
        return list(names).index(str(chosen))
    number = int(chosen) if str(chosen).isdigit() else -1
    return number if number < len(names) else -1


def choose_channel(volume: Volume, choice: Choice, names: Sequence[str] = ()) -> None:
    """Sets the channel. Raises Missing if one of several must be chosen, which have the names if there are as many."""
    count = volume.size("c")
    named = names if len(names) == count else [""] * count
    listed = ", ".join(f"{i} {name}" for i, name in enumerate(named) if name)
    said = f"has {count} channel{'' if count == 1 else 's'}{f' ({listed})' if listed else ''}"
    if choice.channel is None and count > 1:
        raise Missing(f"{said}; choose one, 0 to {count - 1}", volume.where, "channel", "NUMBER, counted from 0")
    volume.channel = 0 if choice.channel is None else number_of(choice.channel, named)
    if volume.channel < 0:
        raise InvalidInput(f"{said}, so there is no channel {choice.channel} (counted from 0)", volume.where)


_AXIS_NAMES = {
    "t": ("t", "time"),
    "c": ("c", "channel", "channels"),
    "z": ("z", "depth", "height", "altitude", "lev", "level", "plev"),
    "y": ("y", "lat", "latitude", "northing", "projection_y_coordinate"),
    "x": ("x", "lon", "longitude", "easting", "projection_x_coordinate"),
}


def axis_named(name: str) -> str:
    """x, y, z, t or c by a name; "" for another."""
    return next((axis for axis, names in _AXIS_NAMES.items() if name.lower() in names), "")


def usable(axes: str) -> bool:
    """Whether x and y are there, and none twice."""
    return len(set(axes)) == len(axes) and set("xy") <= set(axes) <= set("xyztc")


def axes_of(shape: Sequence[int], named: Sequence[str], choice: Choice, where: str) -> Tuple[str, bool]:
    """A letter for each axis of an array, and whether they are assumed: those that are chosen, or that the
    array names, or txyz or xyz. Raises Missing for what cannot be told."""
    if choice.axes is not None:
        axes = choice.axes if len(choice.axes) == len(shape) else choice.axes.replace("t", "")
        if len(axes) != len(shape):
            raise InvalidInput(f"has {len(shape)} axes, not those of '{choice.axes}'", where)
        return axes, False
    axes = "".join(map(axis_named, named))
    if len(axes) == len(shape) and usable(axes):
        return axes, False
    if len(shape) in (3, 4) and not any(named):
        return "txyz"[-len(shape) :], True
    raise unknown_axes("'" + "', '".join(named) + "'" if any(named) else f"of a shape {tuple(shape)}", where)


def unknown_axes(said: str, where: str) -> Missing:
    said = f"has the axes {said}, which do not tell x, y, z, t and c"
    return Missing(said, where, "axes", "ORDER, as in --axes tzyx")


def natural(name: str) -> List[Tuple[int, int, str]]:
    """A key that sorts runs of digits as numbers: frame2 before frame10."""
    return [(0, int(part), "") if part.isdigit() else (1, 0, part) for part in re.findall(r"[0-9]+|[^0-9]", name)]


def extension_of(path: str) -> str:
    """In lower case; ".nii.gz" and the like as one."""
    root, extension = os.path.splitext(os.path.basename(path.rstrip("/")).lower())
    return os.path.splitext(root)[1] + extension if extension == ".gz" else extension
