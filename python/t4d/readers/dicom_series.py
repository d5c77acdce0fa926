"""How the images of a DICOM series lie in space and time."""

from __future__ import annotations

from typing import Any, Dict, List, Optional, Sequence, Tuple

import numpy as np
from numpy.typing import NDArray

from t4d.errors import InvalidInput
from t4d.readers.dicom_images import (
    ACQUISITION, CARDIAC, CONTENT, POSITION, RESPIRATORY, TIMES, Image, Layout, Planes,
)  # fmt: skip
from t4d.readers.volume import Volume

# Positions are rounded when they are written as decimals.
_SAME_PLACE = 1e-3  # mm
_UNEVEN_SLICES = 0.01  # of the distance of two slices
_SAME_DIRECTION = 1e-4
_SKEW = 1e-3
_DAY = 86400.0


def arrange(images: List[Image], layouts: List[Layout], files: Sequence[str], where: str) -> Volume:
    """The volume of a series. Images are sorted by their place along the normal of their planes and, at each
    place, by time. Raises InvalidInput, which names the file, for what is not one volume over time."""
    layout = _one_layout(layouts, files)
    for image in images:
        _check_alike(image, images[0])
    slices = _slices(images, where)
    step = _step(slices)
    notes: List[str] = []
    kind, times = _times(images, slices, notes, where)
    first = slices[0][0]
    affine = np.eye(4)
    affine[:3, 0] = first.orientation[:3] / np.linalg.norm(first.orientation[:3]) * first.spacing[1]
    affine[:3, 1] = first.orientation[3:] / np.linalg.norm(first.orientation[3:]) * first.spacing[0]
    affine[:3, 2], affine[:3, 3] = step, first.position
    if layout.inverted:
        notes.append("its samples are shown inverted (MONOCHROME1); they are taken as they are stored")
    frames = [[place[i] for place in slices] for i in range(len(times))]
    dtype = _dtype(images, layout)
    volume = Volume(where, Planes(frames, layout, dtype), "tzyx", affine=affine, length_unit="mm", space="LPS")
    volume.whole = layout.kind != "f"
    volume.padded = any(image.padding is not None for image in images)
    volume.notes = notes
    volume.names = [frame[0].file for frame in frames]
    if kind != POSITION:  # which is a number only: frames are 1 apart
        start = times[0] if kind in (ACQUISITION, CONTENT) else 0  # times of day begin with the first image
        volume.times = [time - start for time in times]
        volume.time_unit = "%" if kind in (CARDIAC, RESPIRATORY) else "s"
    return volume


def _one_layout(layouts: List[Layout], files: Sequence[str]) -> Layout:
    first = layouts[0]
    for layout, file in zip(layouts, files):
        for said, other in ((_size(layout), _size(first)), (_samples(layout), _samples(first))):
            if said != other:
                raise InvalidInput(f"has {said}, but {files[0]} in the same series has {other}", file)
    return first


def _size(layout: Layout) -> str:
    return f"{layout.columns} columns and {layout.rows} rows"


def _samples(layout: Layout) -> str:
    inverted = ", inverted (MONOCHROME1)" if layout.inverted else ""
    return f"samples of type {layout.dtype} with {layout.stored} bits{inverted}"


def _dtype(images: List[Image], layout: Layout) -> np.dtype[Any]:
    """The smallest type that holds all values as they are; float64 for those that are scaled to fractions."""
    if layout.kind == "f" and all(i.slope == 1 and i.intercept == 0 and i.lut is None for i in images):
        return layout.dtype
    slopes = {(image.slope, image.intercept) for image in images}
    if layout.kind == "f" or not all(slope == int(slope) and add == int(add) for slope, add in slopes):
        return np.dtype(np.float64)
    ends = [slope * end + add for slope, add in slopes for end in layout.span]
    luts = [image.lut for image in images if image.lut is not None]
    if luts:
        ends += [0, 2.0 ** max(int(lut.ModalityLUTSequence[0].LUTDescriptor[2]) for lut in luts) - 1]
    if any(image.padding is not None for image in images):
        return np.dtype(np.float32 if max(map(abs, ends)) <= 2**24 else np.float64)
    if slopes == {(1.0, 0.0)} and not luts:
        return layout.dtype
    types = (np.uint8, np.int8, np.uint16, np.int16, np.uint32, np.int32)
    fitting = (one for one in types if np.iinfo(one).min <= min(ends) and max(ends) <= np.iinfo(one).max)
    return np.dtype(next(fitting, np.float64))


def _check_alike(image: Image, first: Image) -> None:
    row, column = image.orientation[:3], image.orientation[3:]
    lengths = abs(np.linalg.norm(row) - 1), abs(np.linalg.norm(column) - 1), abs(row @ column)
    if not max(lengths) < _SKEW:
        raise InvalidInput("its ImageOrientationPatient is not two perpendicular unit vectors", image.file)
    for i in np.flatnonzero(np.abs(image.orientation - first.orientation) > _SAME_DIRECTION):
        raise InvalidInput(
            f"its planes lie in another direction than those of {first.file}: number {i + 1} of its "
            f"ImageOrientationPatient is {image.orientation[i]}, not {first.orientation[i]}; the series is not one "
            "volume over time", image.file,
        )  # fmt: skip
    for i in np.flatnonzero(np.abs(image.spacing - first.spacing) > _SAME_DIRECTION * image.spacing):
        raise InvalidInput(
            f"its PixelSpacing differs from that of {first.file}: {image.spacing[i]}, not {first.spacing[i]}, along "
            f"{'yx'[i]}", image.file,
        )  # fmt: skip


def _slices(images: List[Image], where: str) -> List[List[Image]]:
    """Images of each place along the normal."""
    normal = np.cross(images[0].orientation[:3], images[0].orientation[3:])
    normal /= np.linalg.norm(normal)
    depths = [float(normal @ image.position) for image in images]
    slices: List[List[Image]] = []
    begin = -np.inf
    for i in sorted(range(len(images)), key=depths.__getitem__):
        if depths[i] - begin > _SAME_PLACE:
            slices.append([])
            begin = depths[i]
        slices[-1].append(images[i])
    if len(slices) == 1:
        raise InvalidInput(f"is not a volume over time: its images, {len(images)} in all, are at one position", where)
    return slices


def _step(slices: List[List[Image]]) -> NDArray[np.float64]:
    """From slice to slice, which are equally far apart on a straight line."""
    places = np.array([place[0].position for place in slices])
    step: NDArray[np.float64] = (places[-1] - places[0]) / (len(places) - 1)
    normal = np.cross(slices[0][0].orientation[:3], slices[0][0].orientation[3:])
    gaps = np.diff(places @ normal)
    usual = float(np.sort(gaps)[len(gaps) // 2])
    tolerance = _UNEVEN_SLICES * usual + _SAME_PLACE
    for i in np.flatnonzero(np.abs(gaps - usual) > tolerance):
        raise InvalidInput(
            f"is {gaps[i]:.6g} mm from the slice of {slices[i][0].file}, but other slices are {usual:.6g} mm apart: "
            "slices that are not equally far apart cannot be read", slices[i + 1][0].file,
        )  # fmt: skip
    for i, place in enumerate(slices):
        for image in place:
            beside = float(np.linalg.norm(image.position - (places[0] + i * step)))
            if beside > tolerance:
                raise InvalidInput(
                    f"is {beside:.6g} mm beside the line on which the slices of the series are: it is not one volume "
                    "over time", image.file,
                )  # fmt: skip
    return step


def _times(images: List[Image], slices: List[List[Image]], notes: List[str], where: str) -> Tuple[str, List[float]]:
    """What says when images were taken, and the time of each frame by it. It is the same for all images: one
    that lacks it is an error. Sorts the images of each slice by it."""
    if all(len(place) == 1 for place in slices):
        raise InvalidInput(f"has one frame only, of {len(slices)} slices; a 4D mesh needs two or more", where)
    fault: Optional[InvalidInput] = None
    skipped = ""
    for kind in TIMES:
        having = [image for image in images if kind in image.times]
        if len({image.times[kind] for image in having}) < 2:
            continue
        if 2 * len(having) <= len(images):
            notes.append(f"{kind} is in {len(having)} of {len(images)} images, and not used")
            continue
        for image in images:
            if kind not in image.times:
                raise InvalidInput(
                    f"has no {kind}, by which the images of the series are ordered in time: {len(having)} of "
                    f"{len(images)} have one", image.file,
                )  # fmt: skip
        try:
            times = _frames_by(kind, images, slices, notes, where)
        except InvalidInput as error:
            fault, skipped = fault or error, skipped or kind
            continue
        if fault is not None:
            notes.append(f"{skipped} makes no frames of the images ({fault.message}); {kind} does")
        return kind, times
    if fault is not None:
        raise fault
    raise InvalidInput(
        f"is not a volume over time: nothing that its images have says when each was taken ({', '.join(TIMES)})", where
    )


def _frames_by(
    kind: str, images: List[Image], slices: List[List[Image]], notes: List[str], where: str
) -> List[float]:
    """The mean time of each frame. Sorts the images of each slice."""
    times = {id(image): image.times[kind] for image in images}
    if kind in (ACQUISITION, CONTENT):
        _pass_midnight(images, times, kind, notes)
    for place in slices:
        place.sort(key=lambda image: times[id(image)])
    _check_once(kind, slices, times)
    _check_whole(kind, slices, times, where)
    return _mean_times(kind, slices, times)


def _pass_midnight(images: List[Image], times: Dict[int, float], kind: str, notes: List[str]) -> None:
    """Times of day without dates, or with one date for all, go on after midnight: those before the longest
    pause, if it is longer than half a day, belong to the next day."""
    if len({time // _DAY for time in times.values()}) > 1:
        return
    moments = sorted(set(times.values()))
    pauses = np.diff(moments)
    if not len(pauses) or pauses.max() <= _DAY / 2:
        return
    last = moments[int(pauses.argmax())]
    for image in images:
        times[id(image)] += _DAY if times[id(image)] <= last else 0
    note = f"{kind} passes midnight, which no date says: times up to {_clock(last)} are those of the next day"
    if note not in notes:
        notes.append(note)


def _clock(time: float) -> str:
    return f"{int(time % _DAY // 3600):02d}:{int(time % 3600 // 60):02d}"


def _place(image: Image) -> str:
    return "(" + ", ".join(f"{value:.6g}" for value in image.position) + ")"


def _check_once(kind: str, slices: List[List[Image]], times: Dict[int, float]) -> None:
    """No place has two images at one time."""
    for place in slices:
        for before, image in zip(place, place[1:]):
            if times[id(image)] <= times[id(before)]:
                raise InvalidInput(
                    f"is a second image at the position {_place(image)} and {kind} {times[id(image)]:.6g}, beside "
                    f"{before.file}", image.file,
                )  # fmt: skip


def _check_whole(kind: str, slices: List[List[Image]], times: Dict[int, float], where: str) -> None:
    """Each place has as many images as the others; else says when one lacks."""
    most, least = max(slices, key=len), min(slices, key=len)
    if len(most) == len(least):
        return
    there = np.array([times[id(image)] for image in least])
    lacking = max((times[id(image)] for image in most), key=lambda time: float(np.abs(there - time).min()))
    raise InvalidInput(
        f"images at the position {_place(least[0])}: {len(least)}, at {_place(most[0])}: {len(most)}; at {kind} "
        f"{lacking:.6g} one is missing", where,
    )  # fmt: skip


def _mean_times(kind: str, slices: List[List[Image]], times: Dict[int, float]) -> List[float]:
    """The mean over the places of each frame. Images of a frame must be nearer to it than half the way to the
    next."""
    taken = np.array([[times[id(image)] for image in place] for place in slices])  # (places, frames)
    start = taken[0, 0]  # seconds since 1970 keep their fractions
    means = start + (taken - start).mean(axis=0)
    gaps = np.diff(means)
    half = np.minimum(np.append(gaps[:1], gaps), np.append(gaps, gaps[-1:])) / 2
    off = np.abs(taken - means)
    for place, frame in np.argwhere(off >= half):
        raise InvalidInput(
            f"its {kind} {taken[place, frame]:.6g} is {off[place, frame]:.6g} from that of frame {frame}, whose "
            f"neighbours are {2 * half[frame]:.6g} away: an image is missing or doubled, or the series is not one "
            "volume over time", slices[place][frame].file,
        )  # fmt: skip
    return [float(time) for time in means]
