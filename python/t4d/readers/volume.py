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
Named = Union[None, int, str]
"""A number counted from 0, or a name."""

_KEPT_BYTES = 1 << 28  # of frames that share chunks
_MOST_CHUNKS = 1 << 20
_MOST_LISTED = 20
_MOST_SAID = 300  # characters of another library


class WrongOption(TypeError, ValueError):
    """An option that is not for the input, or that has no such value; the message begins with its name."""

    def __init__(self, option: str, reason: str) -> None:
        super().__init__(f"{option} {reason}")


class Missing(InvalidInput):
    """What ``option`` must say of the input, since the input does not; ``value`` is how it is given."""

    option = value = ""

    def __init__(self, message: str, where: str, option: str = "", value: str = "") -> None:
        super().__init__(message, where)
        self.option, self.value = option, value


@dataclasses.dataclass
class Choice:
    """The choice of what ``open_frames`` reads of the input; None for what is not chosen."""

    axes: Optional[str] = None
    channel: Named = None
    level: Named = None
    series: Named = None
    dataset: Optional[str] = None

    def allow(self, names: Sequence[str], what: str) -> None:
        """Raises WrongOption for a choice that is not one of these, which are for ``what`` it says."""
        for name, chosen in vars(self).items():
            if chosen is not None and name not in names:
                raise WrongOption(name, f"is not for {what}")


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
    start_time: float = 0
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
            self._check_chunks(box)
            found = self._stored(frame, box)
            kept = [axis for axis in self.axes if axis in "xyz"]
            found = found.transpose([kept.index(axis) for axis in "xyz" if axis in kept])
            found = np.expand_dims(found, [i for i, axis in enumerate("xyz") if axis not in kept])
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

    def _check_chunks(self, box: Box) -> None:
        """Raises InvalidInput for more chunks than libraries unpack in hours."""
        sizes = dict(zip(self.axes, getattr(self.array, "chunks", None) or ()))
        along = [(part, np.ravel(sizes[axis])[0]) for axis, part in zip("xyz", box) if axis in sizes]
        count = math.prod(-(-part.stop // size) - part.start // size for part, size in along)
        if count > _MOST_CHUNKS:
            raise InvalidInput(f"has {count} chunks in a frame; at most {_MOST_CHUNKS} are read", self.where)

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
    """Turns exceptions of other libraries into errors that say where."""
    try:
        yield
    except (Error, WrongOption):
        raise
    except OSError as error:
        raise FileError(error.strerror or said_by(error), where) from error
    except Exception as error:  # libraries raise anything for damaged files
        raise InvalidInput(f"cannot be read: {said_by(error)}", where) from error


def said_by(error: BaseException) -> str:
    """What an exception of another library says, in one line; of ITK, what follows its places in C++."""
    text = re.sub(r".*(\bERROR: (\w+\(0x\w+\): )?|\[nrrd\] )", "", str(error).strip(), flags=re.DOTALL)
    text = re.sub(r"\s*Reason: .*", "", text)  # whatever the system said last
    line = " ".join(text.split()) if text != str(error).strip() else text.partition("\n")[0]
    return line[:_MOST_SAID] or type(error).__name__


def listed(names: Sequence[str], separator: str = ", ") -> str:
    """The first of many names, and how many there are besides."""
    more = f"{separator}and {len(names) - _MOST_LISTED} more" if len(names) > _MOST_LISTED else ""
    return separator.join(names[:_MOST_LISTED]) + more


def number_of(option: str, chosen: Named, names: Sequence[str], where: str) -> int:
    """The number of what an option chooses by number or name; the first if it is not given. Raises WrongOption for
    a word that is no number and no name, and InvalidInput for a number that is not there."""
    if chosen in names:
        return list(names).index(str(chosen))
    if chosen is None or str(chosen).isdigit() and int(chosen) < len(names):
        return int(chosen or 0)
    if not str(chosen).isdigit():
        raise WrongOption(option, f"is '{chosen}'; expected a number, counted from 0, or a name{_named(names)}")
    raise InvalidInput(f"has {_several(option, names)}, so there is no {option} {chosen} (counted from 0)", where)


def _several(what: str, names: Sequence[str]) -> str:
    return f"{len(names)} {what}{'' if len(names) == 1 or what.endswith('s') else 's'}{_named(names)}"


def _named(names: Sequence[str]) -> str:
    named = [f"{i} {name}" for i, name in enumerate(names) if name not in ("", str(i))]
    return f" ({listed(named)})" if named else ""


def choose_channel(volume: Volume, choice: Choice, names: Sequence[str] = ()) -> None:
    """Sets the channel. Raises Missing if one of several must be chosen, which have the names if there are as many."""
    count = volume.size("c")
    names = names if len(names) == count else [""] * count
    if choice.channel is None and count > 1:
        said = f"has {_several('channel', names)}; choose one, 0 to {count - 1}"
        raise Missing(said, volume.where, "channel", "NUMBER, counted from 0")
    volume.channel = number_of("channel", choice.channel, names, volume.where)


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
    """The extension in lower case; ".nii.gz" and the like as one."""
    root, extension = os.path.splitext(os.path.basename(path.rstrip("/")).lower())
    return os.path.splitext(root)[1] + extension if extension == ".gz" else extension
