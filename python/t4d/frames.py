"""Frames of samples from whatever is an array over time: files, folders, URLs and objects of other libraries.

>>> frames = t4d.open_frames("scan/", region=":,:,10:40")
>>> frames.size, frames.times, frames.affine, frames.notes
>>> t4d.weave(frames, iso=300).save("scan.t4d")

Nothing but headers is read before a frame is asked for.
"""

from __future__ import annotations

import itertools
import math
import os
import re
from typing import Any, Iterator, List, Optional, Sequence, SupportsFloat, SupportsIndex, Tuple, Union

import numpy as np
from numpy.typing import NDArray

from t4d import checks, readers
from t4d.checks import Numbers
from t4d.errors import InvalidInput, Unsupported
from t4d.readers.volume import Choice, Named, Volume, WrongOption, usable

MOST_FRAMES = 1_000_000
_SAME_PLACE = 1e-3  # of a voxel


class Frames:
    """A series of volumes over time; ``frame(i)`` reads one when it is asked for, and nothing is kept."""

    times: Optional[List[float]]
    """One of each frame, increasing, in ``time_unit``; None if nothing says when they are."""
    affine: Optional[NDArray[np.float64]]
    """(4, 4), maps (i, j, k, 1) to space, in ``length_unit``; None if nothing says where samples are."""
    unsized: str
    """Axes of x, y and z along which nothing says how large a voxel is: the affine takes it as 1."""
    space: str
    """"RAS", "LPS", or "" if that is not said."""
    assumed_axes: List[str]
    """Orders of axes that nothing names, such as "tzyx"."""
    whole: bool
    """Samples are stored as whole numbers, so that zero says nothing of inside and outside."""
    padded: bool
    """NaN stands for samples without data, which lie outside."""
    names: Optional[List[str]]
    """Of the files of frames, if each has its own."""
    notes: List[str]
    """What was found, chosen or left out."""
    name: str = ""
    """The path or the URL as it is given, or the first of several."""
    region: Optional[Tuple[List[int], List[int]]] = None
    """If a part is read: samples that there are along x, y and z, and the first of those that are read."""

    def __init__(self, volumes: Sequence[Volume]) -> None:
        """Frames of one volume over time, or of several with a frame each; see ``open_frames``."""
        first = volumes[0]
        if min(first.size(axis) for axis in "xyzt") < 1:
            raise InvalidInput("has no samples", first.where)
        if first.size("t") > MOST_FRAMES:
            raise InvalidInput(f"has {first.size('t')} frames; at most {MOST_FRAMES} are allowed", first.where)
        for volume in volumes[1:]:
            _check_alike(volume, first)
        several = len(volumes) > 1
        self._volumes = volumes
        self._numbers = list(range(len(volumes) if several else first.size("t")))
        self._box = tuple(slice(0, first.size(axis)) for axis in "xyz")
        self._replaced: List[Tuple[float, float]] = []
        self.dtype = _type_of(volumes)
        self.times = _times_of(volumes)
        self.time_unit, self.length_unit, self.space = first.time_unit, first.length_unit, first.space
        self.affine, self.unsized = _place_of(first)
        self.assumed_axes = [first.axes] if first.axes_assumed else []
        self.whole = any(volume.whole for volume in volumes)
        self.padded = any(volume.padded for volume in volumes)
        self.names = [volume.where for volume in volumes] if several else first.names
        self.notes = list(dict.fromkeys(note for volume in volumes for note in volume.notes))
        self.losses: List[str] = []

    @property
    def size(self) -> Tuple[int, int, int]:
        """Samples along x, y and z."""
        x, y, z = (part.stop - part.start for part in self._box)
        return x, y, z

    @property
    def mask(self) -> bool:
        """Samples are True or False."""
        return self.dtype.kind == "b"

    def __len__(self) -> int:
        return len(self._numbers)

    def __iter__(self) -> Iterator[NDArray[Any]]:
        return (self.frame(i) for i in range(len(self)))

    def __repr__(self) -> str:
        return f"<t4d.Frames: {len(self)} of {' x '.join(map(str, self.size))} {self.dtype}>"

    def frame(self, index: SupportsIndex) -> NDArray[Any]:
        """The samples (nx, ny, nz) of a frame, of ``dtype``, read now. Raises InvalidInput and FileError."""
        number = self._numbers[index]
        volume, own = (self._volumes[number], 0) if len(self._volumes) > 1 else (self._volumes[0], number)
        found = volume.read(own, self._box)
        if found.shape != self.size:
            raise InvalidInput(f"frame {number} has the shape {found.shape}; expected {self.size}", volume.where)
        for value, by in self._replaced:
            where = np.isnan(found) if math.isnan(value) else found == value
            found = np.where(where, by, found)
        if self.dtype.kind in "iu" and found.dtype.kind == "f" and not np.array_equal(found, np.rint(found)):
            raise InvalidInput("scales its samples to fractions, so they are not labels", volume.where)
        return found.astype(self.dtype, copy=False)

    def filled(self, value: float) -> Frames:
        """The same frames with ``value`` in place of NaN: ``filled(0)`` makes labels of padded samples, which are
        whole numbers if they are stored as such."""
        made = self._copy()
        if self.dtype.kind == "f":
            made._replaced = [*self._replaced, (math.nan, value)]
            made.dtype = np.dtype(np.int32 if self.dtype.itemsize < 8 else np.int64) if self.whole else self.dtype
        made.padded = False
        return made

    def without(self, value: float) -> Frames:
        """The same frames with NaN in place of ``value``: samples that are no data."""
        made = self._copy()
        made._replaced = [*self._replaced, (value, math.nan)]
        if self.dtype.kind != "f":
            made.dtype = np.dtype(np.float32 if self.dtype.itemsize < 4 else np.float64)
        made.padded = True
        return made

    def _copy(self) -> Frames:
        made = Frames.__new__(Frames)
        made.__dict__.update(self.__dict__)
        return made

    def _cut(self, region: str) -> None:
        """Leaves of the frames what the region has; positions and times stay what they are."""
        parts = _region(region, (*self.size, len(self)), self._volumes[0].where)
        begin = [part.start for part in parts[:3]]
        self.region = list(self.size), begin
        self._box = tuple(parts[:3])
        if any(begin):
            self.affine = np.eye(4) if self.affine is None else self.affine.copy()
            self.affine[:3, 3] += self.affine[:3, :3] @ begin
        for kept in ("_numbers", "times", "names"):
            there = getattr(self, kept)
            setattr(self, kept, there if there is None else there[parts[3]])


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
    if axes is not None and not usable(checks.text("axes", axes)):
        raise ValueError(f"axes is {axes!r}; expected an order of x, y, z, t and c, as 'tzyx'")
    named = None if dataset is None else checks.text("dataset", dataset)
    which = [_which(name, one) for name, one in (("channel", channel), ("level", level), ("series", series))]
    frames = Frames(_volumes(source, Choice(axes, which[0], which[1], which[2], named)))
    if is_path(source):
        first = checks.path_text(_parts(source)[0])
        frames.name = readers.shown(first).rstrip("/") or first
    if spacing is not None or origin is not None:
        _set_place(frames, spacing, origin)
    _set_times(frames, times, frame_time, start_time)
    if region is not None:
        frames._cut(checks.text("region", region))
    for name, unit in (("length_unit", length_unit), ("time_unit", time_unit)):
        if unit is not None:
            setattr(frames, name, checks.text(name, unit))
    bytes_ = math.prod(frames.size) * frames.dtype.itemsize
    if bytes_ > os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGESIZE") // 2:
        said = f"has frames of {bytes_} bytes, two of which do not fit into memory"
        raise InvalidInput(said, frames._volumes[0].where)
    return frames


def _which(option: str, given: Union[None, str, SupportsIndex]) -> Named:
    return given if given is None or isinstance(given, str) else checks.whole(option, given, 0)


def is_path(source: Any) -> bool:
    """Whether it is a path, or several."""
    return all(isinstance(one, (str, bytes, os.PathLike)) for one in _parts(source))


def _parts(source: Any) -> List[Any]:
    return list(source) if isinstance(source, (list, tuple)) and source else [source]


def _volumes(source: Any, choice: Choice) -> List[Volume]:
    parts = _parts(source)
    if is_path(source):
        return readers.read([checks.path_text(path) for path in parts], choice)
    return [readers.of_object(one, f"frame {i}" if parts[1:] else "", choice) for i, one in enumerate(parts)]


def _type_of(volumes: Sequence[Volume]) -> np.dtype[Any]:
    """The type of samples as given: float16 as float32, and other floats as float64; in the machine's order."""
    kind = np.result_type(*(volume.kind for volume in volumes))
    if kind.kind not in "biuf":
        raise Unsupported(f"has samples of type {kind}; expected real numbers", volumes[0].where)
    if kind.kind == "f" and kind.itemsize not in (4, 8):
        kind = np.dtype(np.float32 if kind.itemsize < 4 else np.float64)
    return kind.newbyteorder("=")


def _place_of(volume: Volume) -> Tuple[Optional[NDArray[np.float64]], str]:
    """The affine, and the axes of which it takes a size as 1."""
    if volume.affine is not None:
        return volume.affine, ""
    if 0 in volume.spacing.values():
        raise InvalidInput("has voxels without volume", volume.where)
    if not volume.spacing and not volume.origin:
        return None, "xyz"
    affine = np.diag([*(volume.spacing.get(axis, 1.0) for axis in "xyz"), 1.0])
    affine[:3, 3] = [volume.origin.get(axis, 0.0) for axis in "xyz"]
    return affine, "".join(axis for axis in "xyz" if axis not in volume.spacing)


def _times_of(volumes: Sequence[Volume]) -> Optional[List[float]]:
    """Files of one frame each say nothing of the time between frames, but may of that of each."""
    first = volumes[0]
    if len(volumes) > 1:
        own = [volume.times[0] for volume in volumes if volume.times is not None]
        return [float(time) for time in own] if len(set(own)) == len(volumes) else None
    if first.times is not None:
        return [float(time) for time in first.times]
    if first.frame_time is None or first.size("t") < 2:
        return None
    return [first.start_time + first.frame_time * i for i in range(first.size("t"))]


def _check_alike(volume: Volume, first: Volume) -> None:
    """Whether a file of a frame fits the first one."""
    for one in (first, volume):
        if one.size("t") > 1:
            said = f"holds {one.size('t')} frames; where there are several files, each must hold one"
            raise InvalidInput(said, one.where)
    for what, own, other in (
        *((f"size along {axis}", volume.size(axis), first.size(axis)) for axis in "xyz"),
        ("type of samples", volume.kind, first.kind),
        ("unit of length", volume.length_unit, first.length_unit),
        ("space", volume.space, first.space),
    ):
        if own != other:
            raise InvalidInput(f"has the {what} '{own}', the first frame ({first.where}) '{other}'", volume.where)
    places = [_place_of(one)[0] for one in (volume, first)]
    if places[0] is None or places[1] is None:
        return
    corners = np.array([*itertools.product(*((0, volume.size(axis) - 1) for axis in "xyz"), (1,))]).T
    away = float(np.linalg.norm(np.linalg.solve(places[1], (places[0] - places[1]) @ corners)[:3], axis=0).max())
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
    if times is not None and (frame_time is not None or start_time is not None):
        raise WrongOption("times", "says when all frames are; no time between frames or of the first can be given")
    if times is not None:
        frames.times = list(checks.numbers("times", times))
    elif frame_time is not None or start_time is not None:
        known = frames.times or [float(i) for i in range(len(frames))]
        start = known[0] if start_time is None else checks.number("start_time", start_time)
        if frame_time is not None:
            known = [checks.positive("frame_time", frame_time) * i for i in range(len(frames))]
        elif frames.times is None:
            frames.notes.append("the input has no times: frames are taken to be 1 apart")
        frames.times = [start + (time - known[0]) for time in known]
    found = frames.times or range(len(frames))
    if len(found) != len(frames):
        counted = f"{checks.counted(len(found), 'time')} for {checks.counted(len(frames), 'frame')}"
        raise InvalidInput(f"{counted}: expected one for each", where)
    for i in np.flatnonzero(~(np.diff(found) > 0)):
        said = f"frame {i + 1} is at {found[i + 1]:.9g}, the one before at {found[i]:.9g}"
        raise InvalidInput(f"times do not increase: {said}", where)


def _region(region: str, counts: Sequence[int], where: str) -> List[slice]:
    """The ranges of a region along x, y, z and t. Raises ValueError for what is none, and InvalidInput for what is
    not within the counts."""
    words = region.split(",")
    if len(words) not in (3, 4):
        expected = "ranges along x, y and z, and of frames if not all are used, as 0:64,10:20,:,0:8"
        raise ValueError(f"region is {region!r}; expected {expected}")
    parts = []
    for axis, word, count in zip("xyzt", [*words, ":"], counts):
        found = re.fullmatch(r"(-?\d*):(-?\d*)", word)
        if not found or "-" in found.groups():
            raise ValueError(f"region is {region!r}; expected whole numbers along {axis}, as 10:20, 10: or :")
        begin, end = int(found[1] or 0), int(found[2] or count)
        if found[1] and found[2] and begin >= end:
            raise ValueError(f"region is {region!r}; expected a range along {axis} that begins below its end")
        if not 0 <= begin < end <= count:
            there = f"{count} {'frames' if axis == 't' else 'samples'}, counted from 0"
            raise InvalidInput(f"the region has {word} along {axis}, where there are {there}", where)
        if axis == "t" and end - begin < 2:
            raise InvalidInput("the region has one frame; a 4D mesh needs two or more", where)
        parts.append(slice(begin, end))
    return parts
