"""Frames of samples from whatever is an array over time: files, folders, URLs and objects of other libraries.

>>> frames = t4d.open_frames("scan/", region=":,:,10:40")
>>> frames.size, frames.times, frames.affine, frames.notes
>>> t4d.weave(frames, iso=300).save("scan.t4d")

Nothing but headers is read before a frame is asked for.
"""

from __future__ import annotations

import math
import os
from typing import Any, Iterator, List, Optional, Sequence, SupportsFloat, SupportsIndex, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from t4d import checks, readers
from t4d.checks import Numbers
from t4d.errors import InvalidInput, Unsupported
from t4d.readers import Choice, Volume, WrongOption

_SAME_PLACE = 1e-3  # of a voxel
_KINDS = "biuf"


class Frames:
    """A series of volumes over time; ``frame(i)`` reads one when it is asked for, and nothing is kept."""

    size: Tuple[int, int, int]
    """Samples along x, y and z."""
    times: Optional[List[float]]
    """One of each frame, increasing, in ``time_unit``; None if nothing says when they are."""
    time_unit: str
    affine: Optional[NDArray[np.float64]]
    """(4, 4), maps (i, j, k, 1) to space, in ``length_unit``; None if nothing says where samples are."""
    unsized: str
    """Axes of x, y and z along which nothing says how large a voxel is: the affine takes it as 1."""
    length_unit: str
    space: str
    """"RAS", "LPS", or "" if that is not said."""
    assumed_axes: List[str]
    """Orders of axes that nothing names, such as "tzyx"."""
    mask: bool
    """Samples are True or False."""
    whole: bool
    """Samples are stored as whole numbers, so that zero says nothing of inside and outside."""
    padded: bool
    """NaN stands for samples without data, which lie outside."""
    names: Optional[List[str]]
    """Of the files of frames, if each has its own."""
    notes: List[str]
    """What was found, chosen or left out."""
    losses: List[str]
    dtype: np.dtype[Any]

    def __init__(self, volumes: Sequence[Volume]) -> None:
        """Frames of one volume over time, or of several with a frame each; see ``open_frames``."""
        first = volumes[0]
        self._volumes = list(volumes)
        self._numbers = list(range(first.size("t") if len(volumes) == 1 else len(volumes)))
        self._box = tuple(slice(0, first.size(axis)) for axis in "xyz")
        self._filled: List[Tuple[float, float]] = []
        self._check()
        self.times = _times_of(volumes)
        self.time_unit, self.length_unit, self.space = first.time_unit, first.length_unit, first.space
        self.affine, self.unsized = _place_of(first)
        self.assumed_axes = [first.axes] if first.axes_assumed else []
        self.whole = any(volume.whole for volume in volumes)
        self.padded = any(volume.padded for volume in volumes)
        self.names = [volume.where for volume in volumes] if len(volumes) > 1 else _listed(first.names)
        self.notes = list(dict.fromkeys(note for volume in volumes for note in volume.notes))
        self.losses = list(dict.fromkeys(loss for volume in volumes for loss in volume.losses))
        self.dtype = _type_of(volumes)
        self.mask = self.dtype.kind == "b"
        self.size = self._sizes()

    def _sizes(self) -> Tuple[int, int, int]:
        x, y, z = (part.stop - part.start for part in self._box)
        return x, y, z

    def _check(self) -> None:
        first = self._volumes[0]
        if min(first.size(axis) for axis in "xyzt") < 1:
            raise InvalidInput("has no samples", first.where)
        for volume in self._volumes[1:]:
            _check_alike(volume, first)

    def __len__(self) -> int:
        return len(self._numbers)

    def __iter__(self) -> Iterator[NDArray[Any]]:
        return (self.frame(i) for i in range(len(self)))

    def __repr__(self) -> str:
        return f"<t4d.Frames: {len(self)} of {' x '.join(map(str, self.size))} {self.dtype}>"

    def frame(self, index: SupportsIndex) -> NDArray[Any]:
        """The samples (nx, ny, nz) of a frame, of ``dtype``, read now. Raises InvalidInput and FileError."""
        number = self._numbers[index]
        several = len(self._volumes) > 1
        volume = self._volumes[number if several else 0]
        found = volume.read(0 if several else number, self._box)  # type: ignore[arg-type]
        if found.shape != self.size:
            raise InvalidInput(f"frame {number} has the shape {found.shape}; expected {self.size}", volume.where)
        found = found.astype(self.dtype, copy=False)
        for value, filled in self._filled:
            found = np.where(np.isnan(found) if math.isnan(value) else found == value, filled, found)
            found = found.astype(self.dtype, copy=False)
        return found

    def filled(self, value: float) -> Frames:
        """The same frames with ``value`` in place of NaN; ``filled(0)`` makes labels of padded samples."""
        return self._replaced(math.nan, value) if self.dtype.kind == "f" else self

    def without(self, value: float) -> Frames:
        """The same frames with NaN in place of ``value``: samples that are no data."""
        made = self._replaced(value, math.nan)
        if self.dtype.kind != "f":
            made.dtype = np.dtype(np.float32 if self.dtype.itemsize < 4 else np.float64)
        made.padded = True
        return made

    def _replaced(self, value: float, by: float) -> Frames:
        made = Frames.__new__(Frames)
        made.__dict__.update(self.__dict__)
        made._filled = [*self._filled, (value, by)]
        return made

    def _cut(self, region: str) -> None:
        """Leaves of the frames what the region has; positions and times stay what they are."""
        ranges = _ranges(region)
        sizes = (*self.size, len(self))
        parts = [_extent(part, axis, n, self._volumes[0].where) for part, axis, n in zip(ranges, "xyzt", sizes)]
        self._box = tuple(parts[:3])
        self.size = self._sizes()
        if self.affine is not None:
            self.affine = self.affine.copy()
            self.affine[:3, 3] += self.affine[:3, :3] @ [part.start for part in parts[:3]]
        elif any(part.start for part in parts[:3]):
            self.affine = np.eye(4)
            self.affine[:3, 3] = [part.start for part in parts[:3]]
        if len(parts) == 4:
            self._numbers = self._numbers[parts[3]]
            self.times = None if self.times is None else self.times[parts[3]]
            self.names = None if self.names is None else self.names[parts[3]]


def open_frames(
    source: Any,
    *,
    axes: Optional[str] = None,
    channel: Union[None, str, SupportsIndex] = None,
    level: Union[None, str, SupportsIndex] = None,
    series: Union[None, str, SupportsIndex] = None,
    dataset: Optional[str] = None,
    region: Optional[str] = None,
    spacing: Union[None, SupportsFloat, Numbers] = None,
    origin: Optional[Numbers] = None,
    frame_time: Optional[SupportsFloat] = None,
    start_time: Optional[SupportsFloat] = None,
    times: Optional[Numbers] = None,
    length_unit: Optional[str] = None,
    time_unit: Optional[str] = None,
) -> Frames:
    """Frames of a file, a folder, a URL, several files with a frame each, or an object: an array of numpy, dask,
    zarr, h5py or xarray over time, an image of SimpleITK or nibabel, or several of them with a frame each.

    ``axes`` says what the axes of an array or of the pages of a TIFF are, as "tczyx"; ``channel`` is the number or
    the name of one of several channels, ``level`` that of a level of OME-Zarr (0, the finest), ``series`` the UID
    or number of one of several series of DICOM, or the number of an image of a TIFF, and ``dataset`` the path of an
    array in HDF5, the name of an array of VTK, or that of a group, image or label in Zarr. ``region``
    "X0:X1,Y0:Y1,Z0:Z1[,T0:T1]" takes a part, counted from 0, of which alone chunks and pages are read.

    What the input says of places and times is replaced by ``spacing`` (one or three edges of a voxel, along its
    axes), ``origin``, ``times`` of each frame, ``frame_time`` and ``start_time``, and the units.

    Raises FileError and InvalidInput, which say where; Unsupported, also for a library that is missing, with the
    extra of the wheel that has it; and TypeError for an option that is not for the input.
    """
    choice = Choice(
        None if axes is None else _axes(axes), _which("channel", channel), _which("level", level),
        _which("series", series), None if dataset is None else checks.text("dataset", dataset),
    )  # fmt: skip
    if times is not None and (frame_time is not None or start_time is not None):
        raise WrongOption("times", "takes the place of frame_time and start_time")
    frames = Frames(_volumes(source, choice))
    if spacing is not None or origin is not None:
        _set_place(frames, spacing, origin)
    _set_times(frames, times, frame_time, start_time)
    if region is not None:
        frames._cut(checks.text("region", region))
    if length_unit is not None:
        frames.length_unit = checks.text("length_unit", length_unit)
    if time_unit is not None:
        frames.time_unit = checks.text("time_unit", time_unit)
    _check_memory(frames)
    return frames


def is_path(source: Any) -> bool:
    """Whether it is a path, or several."""
    if isinstance(source, (list, tuple)):
        return len(source) > 0 and all(isinstance(one, (str, bytes, os.PathLike)) for one in source)
    return isinstance(source, (str, bytes, os.PathLike))


def _volumes(source: Any, choice: Choice) -> List[Volume]:
    if is_path(source):
        paths = list(source) if isinstance(source, (list, tuple)) else [source]
        return readers.read([checks.path_text(path) for path in paths], choice)
    if isinstance(source, (list, tuple)) and source:
        return [readers.of_object(one, f"frame {i}", choice) for i, one in enumerate(source)]
    return [readers.of_object(source, "", choice)]


def _axes(axes: Any) -> str:
    letters = checks.text("axes", axes).lower()
    if len(set(letters)) < len(letters) or not set("xy") <= set(letters) <= set("xyztc"):
        raise ValueError(f"axes is {axes!r}; expected an order of x, y, z, t and c, as 'tzyx'")
    return letters


def _which(option: str, value: Any) -> Union[None, int, str]:
    if value is None or isinstance(value, str):
        return value
    return checks.whole(option, value, 0)


def _listed(names: Optional[Sequence[str]]) -> Optional[List[str]]:
    return None if names is None else list(names)


def _type_of(volumes: Sequence[Volume]) -> np.dtype[Any]:
    """Of samples as they are given: float16 as float32, and other floats as float64; in the machine's order."""
    kind = np.result_type(*(volume.kind for volume in volumes))
    if kind.kind not in _KINDS:
        raise Unsupported(f"has samples of type {kind}; expected real numbers", volumes[0].where)
    if kind.kind == "f" and kind.itemsize not in (4, 8):
        kind = np.dtype(np.float32 if kind.itemsize < 4 else np.float64)
    return kind.newbyteorder("=")


def _place_of(volume: Volume) -> Tuple[Optional[NDArray[np.float64]], str]:
    """The affine, and the axes of which it takes a size as 1."""
    if volume.affine is not None:
        return np.asarray(volume.affine, np.float64), ""
    # Along an axis of one sample any size would do.
    unsized = "".join(axis for axis in "xyz" if axis not in volume.spacing)
    if not volume.spacing and not volume.origin:
        return None, "xyz"
    affine = np.diag([*(volume.spacing.get(axis, 1.0) for axis in "xyz"), 1.0])
    affine[:3, 3] = [volume.origin.get(axis, 0.0) for axis in "xyz"]
    return affine, unsized


def _times_of(volumes: Sequence[Volume]) -> Optional[List[float]]:
    """Files of one frame each say nothing of the time between frames, but of that of each."""
    first = volumes[0]
    if len(volumes) > 1:
        own = [volume.times[0] for volume in volumes if volume.times is not None and len(volume.times) == 1]
        return [float(time) for time in own] if len(own) == len(volumes) and len(set(own)) > 1 else None
    if first.times is not None:
        return [float(time) for time in first.times]
    if first.frame_time is None or first.size("t") < 2:
        return None
    return [(first.start_time or 0) + first.frame_time * i for i in range(first.size("t"))]


def _check_alike(volume: Volume, first: Volume) -> None:
    """Whether a file of a frame fits the first one."""
    if volume.size("t") > 1 or first.size("t") > 1:
        many = volume if volume.size("t") > 1 else first
        raise InvalidInput(
            f"holds {many.size('t')} frames; where there are several files, each must hold one", many.where
        )
    for axis in "xyz":
        if volume.size(axis) != first.size(axis):
            raise InvalidInput(
                f"has {volume.size(axis)} samples along {axis}, {first.size(axis)} in the first frame ({first.where})",
                volume.where,
            )
    for what, own, other in (
        ("samples of type", volume.kind, first.kind),
        ("the unit of length", volume.length_unit, first.length_unit),
        ("positions in the space", volume.space, first.space),
    ):
        if own != other:
            raise InvalidInput(f"has {what} '{own}', the first frame ({first.where}) '{other}'", volume.where)
    own, other = _place_of(volume)[0], _place_of(first)[0]
    if own is None or other is None:
        return
    size = [first.size(axis) - 1 for axis in "xyz"]
    corners = np.array([[i, j, k, 1] for i in (0, size[0]) for j in (0, size[1]) for k in (0, size[2])])
    voxels = np.linalg.solve(other, own @ corners.T - other @ corners.T)[:3]
    away = float(np.linalg.norm(voxels, axis=0).max())
    if away > _SAME_PLACE:
        raise InvalidInput(
            f"is placed elsewhere in space than the first frame ({first.where}): a corner of its samples is "
            f"{away:.6g} voxels away from there; up to {_SAME_PLACE} is taken as rounding", volume.where,
        )  # fmt: skip


def _set_place(frames: Frames, spacing: Any, origin: Optional[Numbers]) -> None:
    affine = np.eye(4) if frames.affine is None else frames.affine.copy()
    if spacing is not None:
        edges = [spacing] * 3 if np.ndim(spacing) == 0 else spacing
        steps = [checks.positive("spacing", edge) for edge in checks.numbers("spacing", edges, 3)]
        affine[:3, :3] *= np.array(steps) / np.linalg.norm(affine[:3, :3], axis=0)
        frames.unsized = ""
    if origin is not None:
        affine[:3, 3] = checks.numbers("origin", origin, 3)
    frames.affine = affine


def _set_times(frames: Frames, times: Optional[Numbers], frame_time: Any, start_time: Any) -> None:
    where = frames._volumes[0].where
    if times is not None:
        frames.times = list(checks.numbers("times", times))
        if len(frames.times) != len(frames):
            counted = checks.counted(len(frames.times), "time"), checks.counted(len(frames), "frame")
            raise InvalidInput(f"{counted[0]} for {counted[1]}: expected one for each", where)
    elif frame_time is not None or start_time is not None:
        known = frames.times or [float(i) for i in range(len(frames))]
        if frame_time is not None:
            step = checks.positive("frame_time", frame_time)
            known = [known[0] + step * i for i in range(len(frames))]
        elif frames.times is None:
            frames.notes.append("the input has no times: frames are taken to be 1 apart")
        if start_time is not None:
            start = checks.number("start_time", start_time)
            known = [start + (time - known[0]) for time in known]
        frames.times = known
    for i, (before, after) in enumerate(zip(frames.times or [], (frames.times or [])[1:])):
        if not before < after < math.inf:
            raise InvalidInput(f"times do not increase: frame {i + 1} is at {after:.9g}, the one before at {before:.9g}", where)


def _ranges(region: str) -> List[Tuple[Optional[int], Optional[int]]]:
    words = region.split(",")
    if len(words) not in (3, 4):
        raise ValueError(
            f"'{region}' has {len(words)} ranges; expected those along x, y and z, and of frames if not all are used, as "
            "0:64,10:20,:,0:8"
        )
    ranges = []
    for axis, word in zip("xyzt", words):
        ends = word.split(":")
        if len(ends) != 2 or not all(end == "" or end.lstrip("-").isdigit() for end in ends):
            raise ValueError(f"'{word}' is not a range of whole numbers along {axis}, as 10:20, 10: or :")
        begin, end = (None if one == "" else int(one) for one in ends)
        if begin is not None and end is not None and begin >= end:
            raise ValueError(f"{word} along {axis} is empty: a range begins below its end")
        ranges.append((begin, end))
    return ranges


def _extent(ends: Tuple[Optional[int], Optional[int]], axis: str, count: int, where: str) -> slice:
    begin = ends[0] or 0
    end = count if ends[1] is None else ends[1]
    what = "frames" if axis == "t" else "samples"
    if not 0 <= begin < end <= count:
        said = ":".join("" if one is None else str(one) for one in ends)
        raise InvalidInput(f"the region has {said} along {axis}, where there are {count} {what}, counted from 0", where)
    if axis == "t" and end - begin < 2:
        raise InvalidInput("the region has one frame; a 4D mesh needs two or more", where)
    return slice(begin, end)


def _check_memory(frames: Frames) -> None:
    bytes_ = math.prod(frames.size) * frames.dtype.itemsize
    if bytes_ > os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGESIZE") // 2:
        raise InvalidInput(f"has frames of {bytes_} bytes, two of which do not fit into memory", frames._volumes[0].where)


__all__ = ["ArrayLike", "Frames", "is_path", "open_frames"]
