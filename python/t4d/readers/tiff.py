"""TIFF with tifffile: ImageJ's hyperstacks, OME-TIFF in one and several files, and pages that are planes."""

from __future__ import annotations

import contextlib
import logging
import math
import os
import xml.etree.ElementTree as ElementTree
from typing import Any, Dict, Iterator, List, Sequence, Tuple

import numpy as np
from numpy.typing import NDArray

from t4d.errors import InvalidInput
from t4d.readers.units import factor_to, in_one_unit, unit_named
from t4d.readers.volume import Choice, Missing, Volume, choose_channel, library, number_of, through, usable

OPTIONS = ("axes", "channel", "series")

_MINISWHITE = 0
_TRANSPOSED = 5  # orientations from this on swap rows and columns


def read(paths: Sequence[str], choice: Choice) -> List[Volume]:
    """One volume a file, or one of all files if they are those of one image of OME."""
    first = _read(paths[0], choice, len(paths) > 1)
    parts = {os.path.realpath(name) for name in first.array.files}
    if len(paths) > 1 and first.size("t") > 1 and {os.path.realpath(path) for path in paths} <= parts:
        return [first]
    return [first, *(_read(path, choice, True) for path in paths[1:])]


class _Faults(logging.Handler):
    """Keeps messages of pages that cannot be read."""

    def __init__(self) -> None:
        super().__init__()
        self.said: List[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        if record.levelno >= logging.ERROR or "invalid page" in record.getMessage():  # once a warning
            self.said.append(record.getMessage())


@contextlib.contextmanager
def _whole(path: str) -> Iterator[None]:
    """Raises InvalidInput for errors that tifffile logs: it leaves out pages that are cut off."""
    faults = _Faults()
    logging.getLogger("tifffile").addHandler(faults)
    try:
        yield
    except Exception:
        if not faults.said:
            raise
    finally:
        logging.getLogger("tifffile").removeHandler(faults)
    if faults.said:
        raise InvalidInput(f"is damaged or cut off: {faults.said[0].rpartition('> ')[2]}", path)


def _read(path: str, choice: Choice, is_frame: bool) -> Volume:
    tifffile = library("tifffile", "tiff", path, "TIFF")
    with through(path), _whole(path), tifffile.TiffFile(path) as file:
        names = [str(series.name) for series in file.series]
        number = number_of("series", choice.series, names, path)
        pages = _Pages(file, file.series[number], path)
        axes, assumed = _axes(pages, choice, path)
        volume = Volume(path, pages, axes, axes_assumed=assumed, whole=pages.dtype.kind in "iu", notes=pages.notes)
        if len(names) > 1 and choice.series is None:
            volume.notes.append(f"holds {len(names)} images, of which the first is used")
        pixels: Any = _pixels(file, number) if file.is_ome else []
        channels = [str(part.get("Name") or "") for part in pixels if part.tag.endswith("}Channel")]
        choose_channel(volume, choice, channels)
        if file.is_ome:
            _describe_ome(volume, pixels)
        elif file.is_imagej:
            _describe_imagej(volume, file.imagej_metadata or {}, pages.key)
        if pages.swapped:
            volume.spacing = {{"x": "y", "y": "x"}.get(axis, axis): size for axis, size in volume.spacing.items()}
        if volume.size("t") == 1 and not is_frame and assumed:
            said = f"has one frame only, of {volume.size('z')} slices; a 4D mesh needs two or more"
            raise Missing(said, path, "axes", "tyx, if each of its pages is a frame")
        return volume


class _Pages:
    """The samples of an image of the file, each page read when it is asked for: axes of pages, and then y and x,
    in the order that the orientation of pages says, and brighter for larger values."""

    def __init__(self, file: Any, series: Any, path: str) -> None:
        self.key = key = series.keyframe
        self.notes: List[str] = []
        # Axes include those of a single plane; until version 2026.11 they are behind functions.
        whole = hasattr(series, "get_axes")
        self.all_letters = str(series.get_axes(False) if whole else series.axes).lower()
        self.all_sizes = series.get_shape(False) if whole else series.shape
        several = [(a, int(n)) for a, n in zip(self.all_letters, self.all_sizes) if n > 1 or a in "yx"]
        self.letters = "".join(axis for axis, _ in several)
        """Of axes that have several samples."""
        if not self.letters.endswith(("yx", "yxs")):
            raise InvalidInput(f"has the axes '{self.letters}'; the last ones must be those of pages, yx", path)
        shape = [n for _, n in several]
        self._planes = tuple(shape[: self.letters.index("yx")])
        self._stored = tuple(shape[len(self._planes) :])
        """Of a page: rows, columns, samples."""
        self._orientation = int(key.tags.valueof("Orientation", default=1))
        self.swapped = self._orientation >= _TRANSPOSED
        rows, columns = self._stored[:2][:: -1 if self.swapped else 1]
        self.shape = (*self._planes, rows, columns, *self._stored[2:])
        self.dtype = np.dtype(series.dtype)
        self._white = 0
        """Black, where the smallest value is white; else 0."""
        if int(key.photometric) == _MINISWHITE:
            unsigned = self.dtype.kind == "u"
            self._white = 2 ** min(int(key.bitspersample), 8 * self.dtype.itemsize) - 1 if unsigned else 0
            done = "its samples were inverted" if unsigned else "its samples are not inverted, for they have signs"
            self.notes.append(f"in the file, small values are white (MINISWHITE): {done}")
        # Planes that follow one another without compression, as those of ImageJ's files above 4 GiB.
        count = math.prod(self._planes)
        self._mapped: Any = None
        self._pages: List[Any] = []
        if count > 1 and series.dataoffset is not None:
            there = count if len(file.pages) == 1 else min(count, len(file.pages))
            end = series.dataoffset + count * math.prod(self._stored) * self.dtype.itemsize
            if os.path.getsize(path) < end:
                raise InvalidInput(f"is cut off: it has {os.path.getsize(path)} bytes; its samples end at {end}", path)
            stored: Any = self.dtype.newbyteorder(file.byteorder)
            self._mapped = np.memmap(path, stored, "r", series.dataoffset, (count, *self._stored))
        else:
            self._pages = [page for page in series.pages if page is not None]
            there = len(self._pages)
            if len({(page.parent.filehandle.path, page.offset) for page in self._pages}) < there:
                raise InvalidInput("its description uses a page for two planes", path)
        if there != count:
            raise InvalidInput(f"its description says that it has {count} planes, but {there} are there", path)
        self.files = {page.parent.filehandle.path for page in self._pages} | {path}

    def __getitem__(self, at: Tuple[Any, ...]) -> NDArray[Any]:
        planes, rest = at[: len(self._planes)], at[len(self._planes) :]
        numbers = np.arange(math.prod(self._planes)).reshape(self._planes)[planes]
        pages = [self._pages[number] for number in np.ravel(numbers)] if self._mapped is None else []
        with contextlib.ExitStack() as opened:
            for file in {page.parent.filehandle for page in pages}:
                file.open()
                opened.callback(file.close)
            found = [self._page(int(number))[rest] for number in np.ravel(numbers)]
        return np.reshape(np.stack(found), (*np.shape(numbers), *found[0].shape))

    def _page(self, number: int) -> NDArray[Any]:
        """A plane (y, x) or (y, x, sample), with the first row at the top and the first column at the left."""
        plane = self._pages[number].asarray() if self._mapped is None else self._mapped[number]
        plane = np.reshape(plane, self._stored)
        plane = plane.swapaxes(0, 1) if self.swapped else plane
        plane = plane[::-1] if self._orientation in (3, 4, 7, 8) else plane
        plane = plane[:, ::-1] if self._orientation in (2, 3, 6, 7) else plane
        return np.asarray(self._white - plane if self._white else plane, self.dtype)


    def as_one_axis(self) -> str:
        """Makes one axis of those of pages, whatever they are; returns the letters of all."""
        self._planes = (math.prod(self._planes),)
        self.shape = (*self._planes, *self.shape[-len(self._stored) :])
        self.letters = "p" + self.letters[-len(self._stored) :]
        return self.letters


def _axes(pages: _Pages, choice: Choice, path: str) -> Tuple[str, bool]:
    """A letter for each axis of the pages that has several samples, and whether they are assumed: x and y are those
    of a page, and others can be z, t and c."""
    named = pages.letters if "c" in pages.letters else pages.letters.replace("s", "c")
    given = choice.axes
    if given is not None and len(given) == len(pages.all_letters) > len(named):
        several = zip(given, pages.all_letters, pages.all_sizes)
        given = "".join(axis for axis, letter, count in several if count > 1 or letter in "yx")
    unnamed = not set(named) <= set("tczyx")
    if unnamed and given is not None and len(given) < len(named) and given.endswith(("yx", "yxc")):
        named = pages.as_one_axis()  # as tyx: each page is a frame
    assumed = given is None and unnamed and len(named) in (3, 4)
    axes = "tzyx"[-len(named) :] if assumed else named if given is None else given
    if len(axes) != len(named) or not axes.endswith(("yx", "yxc")) or not usable(axes):
        counts = " x ".join(str(n) for n in pages.shape[:-2])
        given = "" if given is None else f", to which '{given}' does not fit"
        said = f"does not say how its {counts} pages are arranged: its axes are '{pages.letters}'{given}"
        raise Missing(said, path, "axes", "ORDER, as in --axes tzyx")
    return axes, assumed


def _describe_imagej(volume: Volume, said: Dict[str, Any], page: Any) -> None:
    unit = unit_named(str(said.get("unit", "")))
    units = {axis: unit_named(str(said.get(f"{axis}unit") or unit)) for axis in "xyz"}
    lengths: Dict[str, float] = {}
    for axis, tag in (("x", "XResolution"), ("y", "YResolution")):
        over, under = page.tags.valueof(tag, default=(0, 1))
        lengths.update({axis: under / over} if over > 0 and under > 0 and units[axis] else {})
    depth = abs(_number(said.get("spacing")))  # stacks may be recorded downward
    volume.spacing, volume.length_unit = in_one_unit({**lengths, **({"z": depth} if depth else {})}, units)
    rate = _number(said.get("fps"))
    volume.frame_time = _number(said.get("finterval")) or (1 / rate if rate else None)  # 0 if it is not known
    volume.time_unit = unit_named(str(said.get("tunit") or "s")) if volume.frame_time else ""


def _pixels(file: Any, number: int) -> Any:
    """The element Pixels of an image of OME, which has its sizes and planes."""
    images = ElementTree.fromstring(file.ome_metadata).findall("{*}Image")
    return images[number if len(images) == len(file.series) else 0].find("{*}Pixels")


def _describe_ome(volume: Volume, pixels: Any) -> None:
    lengths = {axis: _number(pixels.get(f"PhysicalSize{axis.upper()}")) for axis in "xyz"}
    units = {axis: unit_named(pixels.get(f"PhysicalSize{axis.upper()}Unit", "um")) for axis in "xyz"}
    sized = {axis: length for axis, length in lengths.items() if length > 0}
    volume.spacing, volume.length_unit = in_one_unit(sized, units) if sized else ({}, "")
    increment = _number(pixels.get("TimeIncrement"))
    volume.frame_time = increment if increment > 0 else None
    volume.time_unit = unit_named(pixels.get("TimeIncrementUnit", "s")) if increment > 0 else ""
    # The times of planes are measured, and go before the increment.
    taken: Dict[int, List[float]] = {}
    for plane in pixels.findall("{*}Plane"):
        if plane.get("DeltaT") is not None and int(plane.get("TheC", 0)) == volume.channel:
            time = _number(plane.get("DeltaT")) * factor_to(unit_named(plane.get("DeltaTUnit", "s")), "s")
            taken.setdefault(int(plane.get("TheT", 0)), []).append(time)
    means = [sum(taken[i]) / len(taken[i]) for i in range(volume.size("t")) if i in taken]
    if len(means) == volume.size("t") and all(a < b for a, b in zip(means, means[1:])):
        volume.time_unit = volume.time_unit or "s"
        volume.times = [float(f"{mean * factor_to('s', volume.time_unit):.12g}") for mean in means]
    elif any(means):
        said = "they are not there for all frames, or do not increase"
        volume.notes.append(f"the times of its planes (DeltaT) are not used: {said}")


def _number(value: Any) -> float:
    """0 for what is no finite number."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        return 0.0
    return number if math.isfinite(number) else 0.0
