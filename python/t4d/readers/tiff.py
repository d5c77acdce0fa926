"""TIFF with tifffile: ImageJ's hyperstacks, OME-TIFF in one and several files, and pages that are planes."""

from __future__ import annotations

import contextlib
import math
import os
import xml.etree.ElementTree as ElementTree
from typing import Any, Dict, List, Optional, Sequence, Tuple

import numpy as np
from numpy.typing import NDArray

from t4d.errors import InvalidInput
from t4d.readers.units import factor_to, in_one_unit, unit_named
from t4d.readers.volume import Choice, Missing, Volume, chosen_channel, library, through, usable

EXTRA = "tiff"
OPTIONS = ("axes", "channel", "series")

_MINISWHITE = 0
_TRANSPOSED = 5  # orientations from this on swap rows and columns


def read(paths: Sequence[str], choice: Choice) -> List[Volume]:
    """One volume a file, or one of all files if they are those of one image of OME."""
    first = _read(paths[0], choice, len(paths) > 1)
    if len(paths) > 1 and first.size("t") > 1:
        parts = {os.path.realpath(name) for name in first.array.files}
        if {os.path.realpath(path) for path in paths} <= parts:
            return [first]
    return [first, *(_read(path, choice, True) for path in paths[1:])]


def _read(path: str, choice: Choice, is_frame: bool) -> Volume:
    tifffile = library("tifffile", EXTRA, path, "TIFF")
    with through(path), tifffile.TiffFile(path) as file:
        notes: List[str] = []
        series = _series(file, choice, path, notes)
        pages = _Pages(file, series, path)
        axes, assumed = _axes(pages, choice, path)
        volume = Volume(path, pages, axes, axes_assumed=assumed, whole=pages.dtype.kind in "iu")
        _describe(volume, file, series, choice, pages)
        volume.notes += notes + pages.notes
        if volume.size("t") == 1 and not is_frame and assumed:
            raise Missing(
                f"has one frame only, of {volume.size('z')} slices; a 4D mesh needs two or more", path, "axes",
                "tyx, if each of its pages is a frame",
            )  # fmt: skip
        return volume


def _series(file: Any, choice: Choice, path: str, notes: List[str]) -> Any:
    """The image of the file that is chosen, or the first."""
    count = len(file.series)
    if choice.series is None:
        if count > 1:
            notes.append(f"holds {count} images, of which the first is used")
        return file.series[0]
    names = [str(series.name) for series in file.series]
    if str(choice.series) in names:
        return file.series[names.index(str(choice.series))]
    number = int(choice.series) if str(choice.series).isdigit() else -1
    if not 0 <= number < count:
        raise Missing(f"has {count} images ({', '.join(names)}), and none is {choice.series}", path, "series", "N")
    return file.series[number]


class _Pages:
    """The samples of an image of the file, each page read when it is asked for: axes of pages, and then y and x,
    in the order that the orientation of pages says, and brighter for larger values."""

    def __init__(self, file: Any, series: Any, path: str) -> None:
        key = series.keyframe
        self._path = path
        self._series = series
        self.notes: List[str] = []
        self.all_sizes = tuple(series.get_shape(False))
        self.all_letters = str(series.get_axes(False)).lower()
        several = [(a, n) for a, n in zip(self.all_letters, self.all_sizes) if n > 1 or a in "yx"]
        self.letters = "".join(a for a, _ in several)
        if not self.letters.endswith(("yx", "yxs")):
            raise InvalidInput(f"has the axes '{self.letters}'; the last ones must be those of pages, yx", path)
        shape = [n for _, n in several]
        self._planes = tuple(shape[: self.letters.index("yx")])
        self._stored = tuple(shape[len(self._planes) :])
        """Of a page: rows, columns, samples."""
        orientation = int(key.tags.valueof("Orientation", default=1))
        self._orientation = orientation if 1 <= orientation <= 8 else 1
        self.swapped = self._orientation >= _TRANSPOSED
        rows, columns = self._stored[:2][:: -1 if self.swapped else 1]
        self.shape = (*self._planes, rows, columns, *self._stored[2:])
        self.dtype = np.dtype(series.dtype)
        self._white = self._whitest(key)
        # Planes that follow one another without compression, as those of ImageJ's files above 4 GiB.
        self._mapped = series.dataoffset if math.prod(self._planes) > 1 else None
        self._order = file.byteorder
        self._pages = [] if self._mapped is not None else list(series.pages)
        self.files = sorted({page.parent.filehandle.path for page in self._pages if page is not None} | {path})
        lacking = sum(page is None for page in self._pages)
        if self._mapped is None and (lacking or len(self._pages) != math.prod(self._planes)):
            raise InvalidInput(
                f"its description says that it has {math.prod(self._planes)} planes, but {len(self._pages) - lacking} "
                "are there", path,
            )  # fmt: skip

    def _whitest(self, key: Any) -> Optional[int]:
        """The value of black where the smallest is white."""
        if int(key.photometric) != _MINISWHITE:
            return None
        if self.dtype.kind != "u":
            self.notes.append("its samples are shown inverted (MINISWHITE); they are taken as they are stored")
            return None
        self.notes.append("its samples are shown inverted (MINISWHITE), and are inverted")
        return int(2 ** min(int(key.bitspersample), 8 * self.dtype.itemsize) - 1)

    def __getitem__(self, at: Tuple[Any, ...]) -> NDArray[Any]:
        planes, rest = at[: len(self._planes)], at[len(self._planes) :]
        numbers = np.arange(math.prod(self._planes)).reshape(self._planes)[planes]
        pages = [] if self._mapped is not None else [self._pages[number] for number in np.ravel(numbers)]
        with contextlib.ExitStack() as opened:
            for file in {page.parent.filehandle for page in pages}:
                file.open()
                opened.callback(file.close)
            found = [self._page(int(number))[rest] for number in np.ravel(numbers)]
        return np.stack(found).reshape(*np.shape(numbers), *found[0].shape)

    def _page(self, number: int) -> NDArray[Any]:
        """A plane (y, x) or (y, x, sample)."""
        if self._mapped is not None:
            count = math.prod(self._stored)
            offset = self._mapped + number * count * self.dtype.itemsize
            plane = np.fromfile(self._path, self.dtype.newbyteorder(self._order), count, offset=offset)
            if plane.size != count:
                raise InvalidInput(f"is cut off: plane {number} is not in it", self._path)
            plane = plane.astype(self.dtype, copy=False)
        else:
            plane = np.asarray(self._pages[number].asarray())
        plane = _oriented(plane.reshape(self._stored), self._orientation)
        return plane if self._white is None else np.asarray(self._white - plane, self.dtype)


def _oriented(plane: NDArray[Any], orientation: int) -> NDArray[Any]:
    """With the first row at the top and the first column at the left, as the tag Orientation says."""
    if orientation >= _TRANSPOSED:
        plane = plane.swapaxes(0, 1)
    if orientation in (3, 4, 7, 8):
        plane = plane[::-1]
    if orientation in (2, 3, 6, 7):
        plane = plane[:, ::-1]
    return plane


def _axes(pages: _Pages, choice: Choice, path: str) -> Tuple[str, bool]:
    """A letter for each axis of the pages that has several samples, and whether they are assumed."""
    named = list(pages.letters)
    if "s" in named and "c" not in named:
        named[named.index("s")] = "c"
    unknown = [axis for axis in named if axis not in "tczyx"]
    given = choice.axes
    if given is not None and len(given) == len(pages.all_letters) > len(named):
        several = zip(given, pages.all_letters, pages.all_sizes)
        given = "".join(axis for axis, letter, count in several if count > 1 or letter in "yx")
    assumed = given is None and bool(unknown) and len(named) in (3, 4)
    if given is not None and len(given) == len(named) and usable(given):
        named = list(given)
    elif assumed:
        named = list("tzyx"[-len(named) :])
    elif unknown or given is not None:
        counts = " x ".join(str(n) for n in pages.shape[:-2])
        raise Missing(
            f"does not say how its {counts} pages are arranged: its axes are '{pages.letters}'", path, "axes", "ORDER, as in --axes tzyx"
        )
    axes = "".join(named)
    if not (axes.endswith("yx") or axes.endswith("yxc")) or not usable(axes):
        raise InvalidInput(f"has the axes '{axes}'; x and y are those of a page, and others can be z, t and c", path)
    return axes, assumed


# What descriptions say ---------------------------------------------------------------------------


def _describe(volume: Volume, file: Any, series: Any, choice: Choice, pages: _Pages) -> None:
    """Puts places, times, units and the channel into the volume, as ImageJ and OME have them."""
    names: List[str] = []
    if file.is_imagej:
        _describe_imagej(volume, file.imagej_metadata or {}, series.keyframe)
    elif file.is_ome:
        names = _describe_ome(volume, _pixels(file, series), choice)
    elif getattr(file, "lsm_metadata", None):
        lsm = file.lsm_metadata
        volume.spacing = {axis: 1e6 * float(lsm[f"VoxelSize{axis.upper()}"]) for axis in "xyz"}
        volume.length_unit, volume.time_unit = "um", "s"
        volume.frame_time = float(lsm.get("TimeIntervall", 0)) or None
    if pages.swapped:
        turn = {"x": "y", "y": "x", "z": "z"}
        volume.spacing = {turn[axis]: size for axis, size in volume.spacing.items()}
    count = volume.size("c")
    volume.channel = chosen_channel(count, choice, volume.where, names if len(names) == count else ())


def _describe_imagej(volume: Volume, said: Dict[str, Any], page: Any) -> None:
    unit = unit_named(str(said.get("unit", "")))
    units = {axis: unit_named(str(said.get(f"{axis}unit", "") or unit)) for axis in "xyz"}
    lengths: Dict[str, float] = {}
    for axis, tag in (("x", "XResolution"), ("y", "YResolution")):
        over, under = page.tags.valueof(tag, default=(0, 1))
        if over > 0 and under > 0 and units[axis]:
            lengths[axis] = under / over
    depth = _number(said.get("spacing"))
    if depth:
        lengths["z"] = abs(depth)  # stacks may be recorded downward
    volume.spacing, volume.length_unit = in_one_unit(lengths, units)
    interval = _number(said.get("finterval")) or (1 / _number(said["fps"]) if _number(said.get("fps")) else 0)
    if interval > 0:  # 0 if it is not known
        volume.frame_time = interval
        volume.time_unit = unit_named(str(said.get("tunit", ""))) or "s"


def _pixels(file: Any, series: Any) -> Any:
    """The element Pixels of the image of OME, which has its sizes and planes."""
    try:
        images = ElementTree.fromstring(file.ome_metadata).findall("{*}Image")
    except ElementTree.ParseError as error:
        raise InvalidInput(f"its OME-XML is damaged: {error}", file.filename) from None
    pixels = images[file.series.index(series)].find("{*}Pixels") if len(images) == len(file.series) else None
    return images[0].find("{*}Pixels") if pixels is None else pixels


def _describe_ome(volume: Volume, pixels: Any, choice: Choice) -> List[str]:
    """Also returns the names of channels."""
    lengths = {axis: _number(pixels.get(f"PhysicalSize{axis.upper()}")) for axis in "xyz"}
    units = {axis: unit_named(pixels.get(f"PhysicalSize{axis.upper()}Unit", "um")) for axis in "xyz"}
    sized = {axis: length for axis, length in lengths.items() if length > 0}
    volume.spacing, volume.length_unit = in_one_unit(sized, units)
    increment = _number(pixels.get("TimeIncrement"))
    if increment > 0:
        volume.frame_time = increment
        volume.time_unit = unit_named(pixels.get("TimeIncrementUnit", "s"))
    names = [str(channel.get("Name") or "") for channel in pixels.findall("{*}Channel")]
    count = volume.size("c")
    channel = chosen_channel(count, choice, volume.where, names if len(names) == count else ())
    _take_planes(volume, [plane for plane in pixels.findall("{*}Plane") if int(plane.get("TheC", 0)) == channel])
    return names


def _take_planes(volume: Volume, planes: List[Any]) -> None:
    """The times of frames by those of planes: the mean of each frame. They are measured, and go before the
    increment; planes without times, and times that do not increase, say nothing."""
    taken: Dict[int, List[float]] = {}
    for plane in planes:
        if plane.get("DeltaT") is not None:
            time = float(plane.get("DeltaT")) * factor_to(unit_named(plane.get("DeltaTUnit", "s")), "s")
            taken.setdefault(int(plane.get("TheT", 0)), []).append(time)
    frames = volume.size("t")
    means = [sum(taken[i]) / len(taken[i]) for i in range(frames) if i in taken]
    if not any(means) or frames < 2:
        return
    unit = volume.time_unit or "s"
    if len(means) < frames or any(b <= a for a, b in zip(means, means[1:])):
        volume.notes.append("the times of its planes (DeltaT) are not used: they are not there for all frames, or do "
                            "not increase")  # fmt: skip
        return
    volume.times = [float(f"{mean * factor_to('s', unit):.12g}") for mean in means]
    volume.time_unit = unit


def _number(value: Any) -> float:
    """0 for what is no finite number."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        return 0.0
    return number if math.isfinite(number) else 0.0
