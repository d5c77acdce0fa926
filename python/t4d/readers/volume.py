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

Box = Tuple[slice, slice, slice]
"""Samples along x, y and z."""

_KEPT_BYTES = 1 << 28  # of frames that share chunks


class WrongOption(TypeError):
    """An option that the input has no use for; the message is "OPTION REASON"."""

    def __init__(self, option: str, reason: str) -> None:
        super().__init__(f"{option} {reason}")
        self.option = option
        self.reason = reason


class Missing(InvalidInput):
    """What ``option`` must say of the input, since the input does not; ``value`` is how it is given."""

    def __init__(self, message: str, where: str, option: str, value: str) -> None:
        super().__init__(message, where)
        self.option = option
        self.value = value

    def __reduce__(self) -> Tuple[Any, ...]:
        return type(self), (self.message, self.where, self.option, self.value), self.__dict__


@dataclasses.dataclass
class Choice:
    """What is to be read of the input, as of ``open_frames``; None for what is not chosen."""

    axes: Optional[str] = None
    channel: Union[None, int, str] = None
    level: Union[None, int, str] = None
    series: Union[None, int, str] = None
    dataset: Optional[str] = None

    def allow(self, *names: str, what: str) -> None:
        """Raises WrongOption for a choice that is not one of these, which is for ``what`` it says."""
        for field in dataclasses.fields(self):
            if getattr(self, field.name) is not None and field.name not in names:
                raise WrongOption(field.name, f"is not for {what}; it is for {_CHOICES_FOR[field.name]}")


_CHOICES_FOR = {
    "axes": "arrays and TIFF files",
    "channel": "inputs with channels: TIFF, Zarr, HDF5 and VTK",
    "level": "images of OME-Zarr",
    "series": "DICOM and TIFF files",
    "dataset": "HDF5, Zarr and VTK files",
}


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
    """Samples are stored as whole numbers, whatever they are made of them."""
    padded: bool = False
    """NaN stands for samples without data."""
    values: Optional[Callable[[NDArray[Any]], NDArray[Any]]] = None
    """What makes values of the stored samples, of ``dtype``."""
    dtype: Optional[np.dtype[Any]] = None
    names: Optional[Sequence[str]] = None
    notes: List[str] = dataclasses.field(default_factory=list)
    losses: List[str] = dataclasses.field(default_factory=list)
    _kept: Tuple[Any, Any] = (None, None)

    def size(self, axis: str) -> int:
        """Samples along an axis; 1 along one that is not there."""
        return int(self.array.shape[self.axes.index(axis)]) if axis in self.axes else 1

    @property
    def kind(self) -> np.dtype[Any]:
        return np.dtype(self.dtype if self.dtype is not None else self.array.dtype)

    def read(self, frame: int, box: Box) -> NDArray[Any]:
        """The samples (nx, ny, nz) of a frame in a box."""
        with through(self.where):
            found = self._stored(frame, box)
            kept = [axis for axis in self.axes if axis in "xyz"]
            found = found.transpose([kept.index(axis) for axis in "xyz" if axis in kept])
            for i, axis in enumerate("xyz"):
                if axis not in kept:
                    found = np.expand_dims(found, i)
            return found if self.values is None else self.values(found)

    def _at(self, frame: Union[int, slice], box: Box) -> Tuple[Union[int, slice], ...]:
        parts: Dict[str, Union[int, slice]] = {"t": frame, "c": self.channel, **dict(zip("xyz", box))}
        return tuple(parts[axis] for axis in self.axes)

    def _stored(self, frame: int, box: Box) -> NDArray[Any]:
        """Frames that share chunks are read and kept together, so that chunks are unpacked once."""
        together = self._frames_of_chunk(box)
        if together < 2:
            return np.asarray(self.array[self._at(frame, box)])
        first = frame - frame % together
        key = (first, *((part.start, part.stop) for part in box))
        if self._kept[0] != key:
            self._kept = (None, None)
            last = min(first + together, self.size("t"))
            self._kept = key, np.asarray(self.array[self._at(slice(first, last), box)])
        time = [axis for axis in self.axes if axis != "c"].index("t")
        return np.asarray(self._kept[1].take(frame - first, axis=time))

    def _frames_of_chunk(self, box: Box) -> int:
        chunks = getattr(self.array, "chunks", None)
        if not chunks or "t" not in self.axes:
            return 1
        along = chunks[self.axes.index("t")]
        frames = int(along if isinstance(along, int) else along[0])
        bytes_ = np.dtype(self.array.dtype).itemsize * math.prod(part.stop - part.start for part in box)
        return min(frames, max(1, _KEPT_BYTES // max(1, bytes_)))


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
        raise FileError(error.strerror or first_line(error), where) from error
    except Exception as error:  # libraries raise anything for damaged files
        raise InvalidInput(f"cannot be read: {first_line(error)}", where) from error


def first_line(error: BaseException) -> str:
    lines = str(error).strip().splitlines()
    return lines[0] if lines else type(error).__name__


def chosen_channel(count: int, choice: Choice, where: str, names: Sequence[str] = ()) -> int:
    """The channel, by its number or one of the names. Raises Missing if one of several must be chosen."""
    listed = ", ".join(f"{i} {name}" for i, name in enumerate(names) if name)
    listed = f" ({listed})" if listed else ""
    channel = choice.channel
    if channel is None:
        if count > 1:
            raise Missing(f"has {count} channels{listed}; choose one, 0 to {count - 1}", where, "channel", "NUMBER, counted from 0")
        return 0
    if isinstance(channel, str) and channel in names:
        return list(names).index(channel)
    number = int(channel) if str(channel).isdigit() else -1
    if not 0 <= number < count:
        said = f"{count} channel" + ("" if count == 1 else "s")
        raise InvalidInput(f"has {said}{listed}, so there is no channel {channel} (counted from 0)", where)
    return number


_AXIS_NAMES = {
    "t": ("t", "time"),
    "c": ("c", "channel", "channels"),
    "z": ("z", "depth", "height", "altitude", "lev", "level", "plev"),
    "y": ("y", "lat", "latitude", "northing", "projection_y_coordinate"),
    "x": ("x", "lon", "longitude", "easting", "projection_x_coordinate"),
}


def axis_named(name: str) -> str:
    """x, y, z, t or c by a name; "" for another."""
    word = name.lower()
    return next((axis for axis, names in _AXIS_NAMES.items() if word in names), "")


def usable(axes: str) -> bool:
    """Whether x and y are there, and none twice."""
    return len(set(axes)) == len(axes) and set("xy") <= set(axes) <= set("xyztc")


def axes_of(shape: Sequence[int], named: Sequence[str], choice: Choice, where: str) -> Tuple[str, bool]:
    """A letter for each axis of an array, and whether they are assumed: those that are chosen, or that the
    array names, or txyz or xyz. Raises Missing for what cannot be told."""
    count = len(shape)
    if choice.axes is not None:
        axes = choice.axes if len(choice.axes) == count else choice.axes.replace("t", "")
        if len(axes) != count:
            raise InvalidInput(f"has {count} axes, not those of '{choice.axes}'", where)
        return axes, False
    axes = "".join(axis_named(name) for name in named)
    if len(axes) == count and usable(axes):
        return axes, False
    if count in (3, 4) and not any(named):
        return "txyz"[-count:], True
    said = "'" + "', '".join(named) + "'" if any(named) else "of a shape " + " x ".join(map(str, shape))
    raise Missing(f"has the axes {said}, which do not tell x, y, z, t and c", where, "axes", "ORDER, as in --axes tzyx")


def even_step(values: NDArray[Any], axis: str, where: str) -> Tuple[float, Optional[float]]:
    """The first of the coordinates along an axis of space, and their distance; None of a single one. Raises
    InvalidInput unless they are evenly spaced."""
    places = np.asarray(values, np.float64)
    if len(places) < 2:
        return float(places[0]), None
    step = (places[-1] - places[0]) / (len(places) - 1)
    even = np.abs(places - (places[0] + step * np.arange(len(places))))
    if step == 0 or not np.all(even <= 1e-3 * abs(step)):
        raise InvalidInput(f"its coordinates along {axis} are not evenly spaced", where)
    return float(places[0]), float(f"{step:.12g}")


def natural(name: str) -> List[Any]:
    """A key that sorts runs of digits as numbers: frame2 before frame10."""
    return [(0, int(part), "") if part.isdigit() else (1, 0, part) for part in re.findall(r"[0-9]+|[^0-9]", name)]


def extension_of(path: str) -> str:
    """In lower case; ".nii.gz" and the like as one."""
    name = os.path.basename(path.rstrip("/")).lower()
    root, extension = os.path.splitext(name)
    return os.path.splitext(root)[1] + extension if extension == ".gz" else extension
