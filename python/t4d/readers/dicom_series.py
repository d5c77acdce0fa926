"""The places of the images of a DICOM series in space and time."""

from __future__ import annotations

import dataclasses
from typing import Any, Dict, List, Optional, Tuple

import numpy as np
from numpy.typing import NDArray

from t4d.errors import InvalidInput
from t4d.readers.volume import Volume

# Positions are rounded when they are written as decimals.
_SAME_PLACE = 1e-3  # mm
_UNEVEN_SLICES = 0.01  # of the distance of two slices
_SAME_DIRECTION = 1e-4
_SKEW = 1e-3
_DAY = 86400.0

TIMES = (
    "TriggerTime", "TemporalPositionTimeOffset", "NominalPercentageOfCardiacPhase",
    "NominalPercentageOfRespiratoryPhase", "FrameReferenceTime", "AcquisitionTime", "ContentTime",
    "TemporalPositionIdentifier",
)  # fmt: skip
"""What may say when an image was taken, in the order in which it is asked."""

_OF_DAY = ("AcquisitionTime", "ContentTime")


@dataclasses.dataclass
class Image:
    """One plane of samples."""

    file: str
    number: int
    """Of the frame in its file, from 0; -1 if the file has one image alone."""
    position: NDArray[np.float64]
    """(3,), in mm, LPS."""
    orientation: NDArray[np.float64]
    """(6,): unit vectors along its rows and along its columns."""
    spacing: NDArray[np.float64]
    """(2,), in mm: between rows, and between columns."""
    scale: Tuple[float, float]
    """Slope and intercept."""
    lut: Any
    """A data set with the modality LUT; None without."""
    padding: Optional[Tuple[float, float]]
    """Stored values from the first to the second are no data."""
    times: Dict[str, float]
    """By the names of TIMES."""
    time: float = 0
    """That which orders the series."""

    @property
    def place(self) -> str:
        return "(" + ", ".join(f"{value:.6g}" for value in self.position) + ")"


def arrange(images: List[Image], where: str) -> Volume:
    """The volume of a series, whose array are the images of each frame, slice by slice. Images are sorted by their
    place along the normal of their planes and, at each place, by time. Raises InvalidInput, which names the file,
    for what is not one volume over time."""
    first = images[0]
    for image in images:
        _check_alike(image, first)
    row, column = (first.orientation[part] / np.linalg.norm(first.orientation[part]) for part in np.s_[:3, 3:])
    slices = _slices(images, np.cross(row, column), where)
    notes: List[str] = []
    kind, times = _times(images, slices, notes, where)
    affine = np.eye(4)
    affine[:3, 0], affine[:3, 1] = row * first.spacing[1], column * first.spacing[0]
    affine[:3, 2], affine[:3, 3] = _step(slices), slices[0][0].position
    frames = [[place[i] for place in slices] for i in range(len(times))]
    volume = Volume(where, frames, "tzyx", affine=affine, length_unit="mm", space="LPS", notes=notes)
    volume.names = [frame[0].file for frame in frames]
    if kind != TIMES[-1]:  # which is a number only: frames are 1 apart
        volume.times = [time - (times[0] if kind in _OF_DAY else 0) for time in times]
        volume.time_unit = "%" if "Percentage" in kind else "s"
    return volume


def _check_alike(image: Image, first: Image) -> None:
    row, column = image.orientation[:3], image.orientation[3:]
    if not np.all(np.abs([row @ row - 1, column @ column - 1, row @ column]) < 2 * _SKEW):
        raise InvalidInput("its ImageOrientationPatient is not two perpendicular unit vectors", image.file)
    if np.any(np.abs(image.orientation - first.orientation) > _SAME_DIRECTION):
        raise InvalidInput(
            f"its planes lie in another direction than those of {first.file}: ImageOrientationPatient is "
            f"{image.orientation.tolist()}, not {first.orientation.tolist()}; the series is not one volume over time",
            image.file,
        )
    if np.any(np.abs(image.spacing - first.spacing) > _SAME_DIRECTION * image.spacing):
        said = f"{image.spacing.tolist()}, not {first.spacing.tolist()}"
        raise InvalidInput(f"its PixelSpacing differs from that of {first.file}: {said}", image.file)


def _slices(images: List[Image], normal: NDArray[np.float64], where: str) -> List[List[Image]]:
    """Images of each place along the normal, which are equally far apart on a straight line."""
    slices: List[List[Image]] = []
    begin = -np.inf
    for depth, _, image in sorted((float(normal @ image.position), i, image) for i, image in enumerate(images)):
        if depth - begin > _SAME_PLACE:
            slices.append([])
            begin = depth
        slices[-1].append(image)
    if len(slices) == 1:
        raise InvalidInput(f"is not a volume over time: its images, {len(images)} in all, are at one position", where)
    gaps = np.diff([float(normal @ place[0].position) for place in slices])
    usual = float(np.sort(gaps)[len(gaps) // 2])
    tolerance = _UNEVEN_SLICES * usual + _SAME_PLACE
    for i in np.flatnonzero(np.abs(gaps - usual) > tolerance):
        raise InvalidInput(
            f"is {gaps[i]:.6g} mm from the slice of {slices[i][0].file}, but other slices are {usual:.6g} mm apart: "
            "slices that are not equally far apart cannot be read", slices[i + 1][0].file,
        )  # fmt: skip
    for number, image in ((number, image) for number, place in enumerate(slices) for image in place):
        beside = float(np.linalg.norm(image.position - (slices[0][0].position + number * _step(slices))))
        if beside > tolerance:
            said = f"is {beside:.6g} mm beside the line on which the slices of the series are"
            raise InvalidInput(f"{said}: it is not one volume over time", image.file)
    return slices


def _step(slices: List[List[Image]]) -> NDArray[np.float64]:
    """The step from slice to slice, in mm."""
    step: NDArray[np.float64] = (slices[-1][0].position - slices[0][0].position) / (len(slices) - 1)
    return step


def _times(images: List[Image], slices: List[List[Image]], notes: List[str], where: str) -> Tuple[str, List[float]]:
    """What says when images were taken, and the time of each frame by it. It is the same for all images: one
    that lacks it is an error. Sorts the images of each slice by it."""
    if all(len(place) == 1 for place in slices):
        raise InvalidInput(f"has one frame only, of {len(slices)} slices; a 4D mesh needs two or more", where)
    fault: Optional[Tuple[str, InvalidInput]] = None
    for kind in TIMES:
        having = [image for image in images if kind in image.times]
        if len({image.times[kind] for image in having}) < 2:
            continue
        if 2 * len(having) <= len(images):
            notes.append(f"{kind} is in {len(having)} of {len(images)} images, and not used")
            continue
        for image in images:
            if kind not in image.times:
                said = f"{len(having)} of {len(images)} have one"
                raise InvalidInput(f"has no {kind}, which orders the images of the series in time: {said}", image.file)
            image.time = image.times[kind]
        if kind in _OF_DAY:
            _pass_midnight(images, kind, notes)
        try:
            times = _frames_of(slices, kind, where)
        except InvalidInput as error:
            fault = fault or (kind, error)
            continue
        if fault:
            notes.append(f"{fault[0]} makes no frames of the images ({fault[1].message}); {kind} does")
        return kind, times
    if fault:
        raise fault[1]
    said = f"nothing that its images have says when each was taken ({', '.join(TIMES)})"
    raise InvalidInput(f"is not a volume over time: {said}", where)


def _pass_midnight(images: List[Image], kind: str, notes: List[str]) -> None:
    """Times of day without dates, or with one date for all, go on after midnight: those before the longest
    pause, if it is longer than half a day, belong to the next day."""
    moments = sorted({image.time for image in images})
    pauses = np.diff(moments)
    if moments[0] // _DAY == moments[-1] // _DAY and pauses.max() > _DAY / 2:
        last = moments[int(pauses.argmax())]
        for image in images:
            image.time += _DAY if image.time <= last else 0
        notes.append(f"{kind} passes midnight, which no date says: its earliest times are those of the next day")


def _frames_of(slices: List[List[Image]], kind: str, where: str) -> List[float]:
    """Sorts the images of each slice by time. Each has as many as the others, and a time once. Returns the mean
    time of each frame, to which its images are nearer than half the way to the next."""
    for place in slices:
        place.sort(key=lambda image: image.time)
        for before, image in zip(place, place[1:]):
            if image.time <= before.time:
                said = f"is a second image at the position {image.place} and {kind} {image.time:.6g}"
                raise InvalidInput(f"{said}, beside {before.file}", image.file)
    most, least = max(slices, key=len), min(slices, key=len)
    if len(most) > len(least):
        there = np.array([image.time for image in least])
        lacking = max((image.time for image in most), key=lambda time: float(np.abs(there - time).min()))
        raise InvalidInput(
            f"images at the position {least[0].place}: {len(least)}, at {most[0].place}: {len(most)}; at {kind} "
            f"{lacking:.6g} one is missing", where,
        )  # fmt: skip
    taken = np.array([[image.time for image in place] for place in slices])  # (places, frames)
    means = taken[0, 0] + (taken - taken[0, 0]).mean(axis=0)  # seconds since 1970 keep their fractions
    gaps = np.diff(means)
    half = np.minimum(np.append(gaps[:1], gaps), np.append(gaps, gaps[-1:])) / 2
    for i, frame in np.argwhere(np.abs(taken - means) >= half):
        raise InvalidInput(
            f"its {kind} {taken[i, frame]:.6g} is {abs(taken[i, frame] - means[frame]):.6g} from that of frame "
            f"{frame}, whose neighbours are {2 * half[frame]:.6g} away: an image is missing or doubled, or the series "
            "is not one volume over time", slices[i][frame].file,
        )  # fmt: skip
    return [float(time) for time in means]
