"""DICOM with pydicom: images of one series, classic or enhanced, as one volume over time (``dicom_series``).

Values are those after the modality LUT or the rescale; padding (PixelPaddingValue, PixelPaddingRangeLimit) is NaN.
"""

from __future__ import annotations

import dataclasses
import datetime
import math
import os
from typing import Any, Dict, Iterator, List, Optional, Sequence, Tuple

import numpy as np
from numpy.typing import NDArray

from t4d.errors import InvalidInput, Unsupported
from t4d.readers import dicom_series
from t4d.readers.dicom_series import Image
from t4d.readers.volume import MOST_LISTED, Choice, Missing, Volume, extension_of, library, natural, through

OPTIONS = ("series",)

_SIGNATURE = 132  # bytes up to the end of "DICM"
# All other elements would fill the memory for series of many files.
_READ = (
    "SeriesInstanceUID SeriesNumber SeriesDescription Rows Columns PhotometricInterpretation SamplesPerPixel "
    "BitsAllocated BitsStored HighBit PixelRepresentation NumberOfFrames SharedFunctionalGroupsSequence "
    "PerFrameFunctionalGroupsSequence ImagePositionPatient ImageOrientationPatient PixelSpacing ModalityLUTSequence "
    "RescaleSlope RescaleIntercept PixelPaddingValue PixelPaddingRangeLimit TemporalPositionIdentifier "
    "TemporalResolution TriggerTime FrameReferenceTime AcquisitionDateTime AcquisitionTime AcquisitionDate ContentTime "
    "ContentDate"
).split()


def has_signature(path: str) -> bool:
    try:
        with open(path, "rb") as file:
            return file.read(_SIGNATURE)[-4:] == b"DICM"
    except OSError:
        return False


def files_in(folder: str) -> Iterator[str]:
    """Files of images in the folder or, if there are none, in those below it. One that cannot be read may be one."""
    found = False
    for place, _, names in os.walk(folder):
        for path in (os.path.join(place, name) for name in names if name != "DICOMDIR"):
            if os.path.isfile(path) and (
                has_signature(path) or extension_of(path) == ".dcm" or not os.access(path, os.R_OK)
            ):
                found = True
                yield path
        if found and place == folder:
            return


def _pydicom(where: str, module: str = "pydicom") -> Any:
    library("pydicom.pixels", "dicom", where, "DICOM")  # since version 3
    return library(module, "dicom", where, "DICOM")


def read(paths: Sequence[str], choice: Choice) -> List[Volume]:
    """One volume of one series. ``choice.series`` is its SeriesInstanceUID or SeriesNumber."""
    files = [file for path in paths
             for file in (sorted(files_in(path), key=natural) if os.path.isdir(path) else [path])]  # fmt: skip
    series: Dict[str, List[Tuple[str, Any]]] = {}
    empty: List[str] = []
    for file in files:
        with through(file):
            forced = extension_of(file) == ".dcm"
            header = _pydicom(file).dcmread(file, stop_before_pixels=True, force=forced, specific_tags=[*_READ])
            if "Rows" in header:
                series.setdefault(str(header.get("SeriesInstanceUID", "")), []).append((file, header))
            else:
                empty.append(file)
    if not series:
        raise InvalidInput("holds no DICOM images", paths[0])
    images: List[Image] = []
    layouts: List[Tuple[str, _Layout]] = []
    for file, header in _chosen(series, choice.series, paths[0]):
        with through(file):
            layouts.append((file, _layout(header, file)))
            images += _images(header, file)
    for file, layout in layouts:
        if layout != layouts[0][1]:
            raise InvalidInput(f"has {layout}, but {layouts[0][0]} in the same series has {layouts[0][1]}", file)
    volume = dicom_series.arrange(images, paths[0])
    volume.array = _Planes(volume.array, layouts[0][1], _dtype(images, layouts[0][1]))
    volume.whole = layouts[0][1].kind != "f"
    volume.padded = any(image.padding is not None for image in images)
    if layouts[0][1].inverted:
        volume.notes.append("its samples are shown inverted (MONOCHROME1); they are taken as they are stored")
    if empty:
        volume.notes.append(f"files without an image: {len(empty)}, the first {empty[0]}")
    return [volume]


def _chosen(series: Dict[str, List[Tuple[str, Any]]], wanted: Any, where: str) -> List[Tuple[str, Any]]:
    about = {uid: files[0][1] for uid, files in sorted(series.items())}
    numbers = {uid: str(header.get("SeriesNumber", "")) for uid, header in about.items()}
    found = [uid for uid in about if wanted is None or str(wanted) in (uid, numbers[uid])]
    if len(found) == 1:
        return series[found[0]]
    lines = [
        f"{numbers[uid] or 'no number'} '{header.get('SeriesDescription', '')}' of {len(series[uid])} files, {uid}"
        for uid, header in about.items()
    ]
    more = f"; and {len(lines) - MOST_LISTED} more" if len(lines) > MOST_LISTED else ""
    said = f"holds {'several' if found else 'no'} series '{wanted}'; there are"
    said = f"holds {len(series)} series, of which one can be read at a time" if wanted is None else said
    listed = "; ".join(lines[:MOST_LISTED]) + more
    raise Missing(f"{said}: {listed}", where, "series", "NUMBER, or the UID of a series")


@dataclasses.dataclass
class _Layout:
    """How the samples of a file are stored."""

    columns: int
    rows: int
    bits: int
    stored: int
    kind: str
    """Of numpy: "u", "i" or "f"."""
    inverted: bool

    @property
    def span(self) -> Tuple[float, float]:
        """The least and the largest whole number that can be stored."""
        least = -(2.0 ** (self.stored - 1)) if self.kind == "i" else 0.0
        return least, least + 2.0**self.stored - 1

    def __str__(self) -> str:
        inverted = ", inverted (MONOCHROME1)" if self.inverted else ""
        kind = f"{self.kind}{max(8, self.bits) // 8}"
        return f"{self.columns} columns and {self.rows} rows of type {kind} with {self.stored} bits{inverted}"


def _layout(header: Any, file: str) -> _Layout:
    photometric = str(header.get("PhotometricInterpretation", ""))
    if not photometric.startswith("MONOCHROME") or header.get("SamplesPerPixel", 1) != 1:
        raise InvalidInput(f"has the colours '{photometric}', expected grey values (MONOCHROME2)", file)
    bits = int(header.get("BitsAllocated", 0))
    kind = "ui"[int(header.PixelRepresentation)] if "PixelRepresentation" in header else "f" if bits >= 32 else "u"
    stored = int(header.get("BitsStored", bits))
    high = int(header.get("HighBit", stored - 1))
    if bits not in (1, 8, 16, 32, 64) or not 0 < stored <= bits or high != stored - 1:
        raise InvalidInput(f"has samples of {bits} bits, of which {stored} count, up to bit {high}", file)
    return _Layout(int(header.get("Columns", 0)), int(header.Rows), bits, stored, kind, photometric == "MONOCHROME1")


def _images(header: Any, file: str) -> Iterator[Image]:
    """The images of a file, with what its functional groups say of each."""
    count = int(header.get("NumberOfFrames", 1) or 1)
    shared = [*header.get("SharedFunctionalGroupsSequence", [])][:1]
    groups = header.get("PerFrameFunctionalGroupsSequence")
    if not groups and count > 1:
        raise InvalidInput(
            f"holds {count} frames that have no positions of their own, such as films of ultrasound or X-rays have: it "
            "is not a volume over time", file,
        )  # fmt: skip
    if groups and count != len(groups):
        raise InvalidInput(f"has {count} frames, but describes {len(groups)}", file)
    for number, group in enumerate(groups or [None]):
        yield _image(_Found([group, *shared, header] if groups else [*shared, header]), file, number if groups else -1)


class _Found:
    """What the first of some data sets says that says it, in a sequence of one item or itself."""

    def __init__(self, sets: List[Any]) -> None:
        self.sets = sets

    def __call__(self, name: str, sequence: str = "-") -> Any:
        places = [place for one in self.sets for place in (*[*one.get(sequence, [])][:1], one)]
        return next((place[name].value for place in places if name in place and place[name].value is not None), None)

    def number(self, name: str, sequence: str = "-") -> Optional[float]:
        found = self(name, sequence)
        return None if found in (None, "") else float(found)

    def numbers(self, name: str, sequence: str, count: int) -> Optional[NDArray[np.float64]]:
        found = self(name, sequence)
        numbers = np.array([] if found in (None, "") else found, np.float64)
        return numbers if numbers.shape == (count,) and np.all(np.isfinite(numbers)) else None


def _image(found: _Found, file: str, number: int) -> Image:
    position = found.numbers("ImagePositionPatient", "PlanePositionSequence", 3)
    orientation = found.numbers("ImageOrientationPatient", "PlaneOrientationSequence", 6)
    spacing = found.numbers("PixelSpacing", "PixelMeasuresSequence", 2)
    if position is None or orientation is None:
        said = "does not say where its image is in space (ImagePositionPatient and ImageOrientationPatient)"
        raise InvalidInput(said, file)
    if spacing is None or not np.all(spacing > 0):
        raise InvalidInput("does not say how far apart its samples are (PixelSpacing)", file)
    lut = found.sets[-1] if found("ModalityLUTSequence") else None
    slope, intercept = (
        None if lut is not None else found.number(name, "PixelValueTransformationSequence")
        for name in ("RescaleSlope", "RescaleIntercept")
    )  # fmt: skip
    if (slope is None) != (intercept is None) or slope == 0:
        raise InvalidInput(f"scales its samples by '{slope}' and adds '{intercept}'", file)
    scale = (1.0, 0.0) if slope is None or intercept is None else (slope, intercept)
    return Image(file, number, position, orientation, spacing, scale, lut, _padding(found), _times(found))


def _padding(found: _Found) -> Optional[Tuple[float, float]]:
    """The range of stored values that are no data. Some writers give signed values as unsigned ones."""
    ends = [end for end in map(found, ("PixelPaddingValue", "PixelPaddingRangeLimit")) if isinstance(end, (int, float))]
    if found("PixelPaddingValue") is None or not ends:
        return None
    if found("PixelRepresentation") == 1:
        bits = int(found("BitsAllocated"))
        ends = [end - 2**bits if end >= 2 ** (bits - 1) else end for end in ends]
    return float(min(ends)), float(max(ends))


def _times(found: _Found) -> Dict[str, float]:
    """By the names of dicom_series.TIMES: seconds, percent of a cycle, or numbers."""
    position, apart = found.number("TemporalPositionIdentifier"), found.number("TemporalResolution")
    offset = found.number("TemporalPositionTimeOffset", "TemporalPositionSequence")
    trigger = found.number("NominalCardiacTriggerDelayTime", "CardiacSynchronizationSequence")
    trigger = found.number("TriggerTime") if trigger is None else trigger
    reference = found.number("FrameReferenceTime")
    index = found.number("TemporalPositionIndex", "FrameContentSequence")
    taken = [found(f"{name}DateTime", "FrameContentSequence")
             for name in ("FrameAcquisition", "FrameReference", "Acquisition")]  # fmt: skip
    acquired = next((_moment(text) for text in taken if text), None)
    times = (
        None if trigger is None else trigger / 1000,
        (position - 1) * apart / 1000 if offset is None and position is not None and apart else offset,
        found.number("NominalPercentageOfCardiacPhase", "CardiacSynchronizationSequence"),
        found.number("NominalPercentageOfRespiratoryPhase", "RespiratorySynchronizationSequence"),
        None if reference is None else reference / 1000,
        _moment(found("AcquisitionTime"), found("AcquisitionDate")) if acquired is None else acquired,
        _moment(found("ContentTime"), found("ContentDate")),
        position if index is None else index,
    )
    return {name: t for name, t in zip(dicom_series.TIMES, times) if t is not None and math.isfinite(t)}


def _moment(text: Any, date: Any = None) -> Optional[float]:
    """Seconds of a date and time, YYYYMMDDHHMMSS.FFFFFF&ZZXX, or of HHMMSS.FFFFFF on a date or, without one, of
    1970-01-01; None for what is none."""
    valuerep = _pydicom("", "pydicom.valuerep")
    try:
        if len(str(text).split(".")[0]) >= 10:
            moment = valuerep.DT(str(text))
        else:
            day = valuerep.DA(str(date)) if date else datetime.date(1970, 1, 1)
            moment = datetime.datetime.combine(day, valuerep.TM(str(text).replace(":", "")))
    except (ValueError, TypeError):
        return None
    return float((moment if moment.tzinfo else moment.replace(tzinfo=datetime.timezone.utc)).timestamp())


def _dtype(images: List[Image], layout: _Layout) -> np.dtype[Any]:
    """The smallest type that holds all values as they are; float64 for those that are scaled to fractions."""
    scales = {image.scale for image in images}
    luts = [image.lut for image in images if image.lut is not None]
    stored = np.dtype(f"{layout.kind}{max(8, layout.bits) // 8}")
    if layout.kind == "f" or not all(number == int(number) for scale in scales for number in scale):
        return stored if scales == {(1.0, 0.0)} and not luts else np.dtype(np.float64)
    ends = [slope * end + intercept for slope, intercept in scales for end in layout.span]
    ends += [end for lut in luts for end in (0.0, 2.0 ** int(lut.ModalityLUTSequence[0].LUTDescriptor[2]) - 1)]
    if any(image.padding is not None for image in images):
        return np.dtype(np.float32 if max(-min(ends), max(ends)) <= 2**24 else np.float64)
    if scales == {(1.0, 0.0)} and not luts:
        return stored
    limits = {name: np.iinfo(name) for name in ("u1", "i1", "u2", "i2", "u4", "i4")}
    fitting = (name for name, limit in limits.items() if limit.min <= min(ends) and max(ends) <= limit.max)
    return np.dtype(next(fitting, "f8"))


class _Planes:
    """The samples (t, z, y, x) of images, each plane read when it is asked for."""

    def __init__(self, images: List[List[Image]], layout: _Layout, dtype: np.dtype[Any]) -> None:
        """``images`` of each frame, slice by slice."""
        self._images, self._layout, self.dtype = images, layout, dtype
        self.shape = (len(images), len(images[0]), layout.rows, layout.columns)

    def __getitem__(self, at: Tuple[int, slice, slice, slice]) -> NDArray[Any]:
        images = self._images[at[0]][at[1]]
        found = np.empty((len(images), *self.shape[2:]), self.dtype)[:, at[2], at[3]]
        for file in dict.fromkeys(image.file for image in images):
            of_file = [i for i, image in enumerate(images) if image.file == file]
            with through(file):
                for i, plane in zip(of_file, self._stored(file, [images[i] for i in of_file])):
                    found[i] = self._values(plane[at[2], at[3]], images[i])
        return found

    def _stored(self, file: str, images: List[Image]) -> Iterator[NDArray[Any]]:
        """The planes of images of one file. Padding may have bits that do not count."""
        least, most = self._layout.span
        paddings = [end for image in images for end in image.padding or ()]
        given = {} if all(least <= end <= most for end in paddings) else {"correct_unused_bits": False}
        source = _pydicom(file).dcmread(file, force=True) if images[0].number < 0 else file
        numbers = [max(0, image.number) for image in images]
        try:
            yield from _pydicom(file, "pydicom.pixels").iter_pixels(source, indices=numbers, raw=True, **given)
        except (RuntimeError, NotImplementedError) as error:
            raise Unsupported(f"cannot be unpacked: {' '.join(str(error).split())}", file) from error

    def _values(self, plane: NDArray[Any], image: Image) -> NDArray[Any]:
        values = plane
        if image.lut is not None:
            values = _pydicom(image.file, "pydicom.pixels").apply_modality_lut(plane.astype(np.int64), image.lut)
        elif image.scale != (1, 0):
            values = plane.astype(np.float64) * image.scale[0] + image.scale[1]
        if image.padding is None:
            return values
        return np.where((plane >= image.padding[0]) & (plane <= image.padding[1]), np.nan, values)
