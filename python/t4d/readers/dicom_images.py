"""Images of DICOM as pydicom reads them: where and when they were taken, and their samples.

Values are those after the modality LUT or the rescale; padding (PixelPaddingValue, PixelPaddingRangeLimit) is NaN.
"""

from __future__ import annotations

import dataclasses
import datetime
import math
from typing import Any, Dict, Iterator, List, Optional, Tuple

import numpy as np
from numpy.typing import NDArray

from t4d.errors import InvalidInput, Unsupported
from t4d.readers.volume import library, through

EXTRA = "dicom"


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
    slope: float
    intercept: float
    lut: Any
    """A data set with the modality LUT; None without."""
    padding: Optional[Tuple[float, float]]
    """Stored values from the first to the second are no data."""
    times: Dict[str, float]
    """Seconds, percent of a cycle or numbers, by the names of TIMES."""


@dataclasses.dataclass
class Layout:
    """How the samples of a file are stored."""

    columns: int
    rows: int
    bits: int
    stored: int
    kind: str
    """Of numpy: "u", "i" or "f"."""
    inverted: bool

    @property
    def dtype(self) -> np.dtype[Any]:
        return np.dtype(f"{self.kind}{max(8, self.bits) // 8}")

    @property
    def span(self) -> Tuple[float, float]:
        """The least and the largest whole number that can be stored."""
        if self.kind == "i":
            return -(2.0 ** (self.stored - 1)), 2.0 ** (self.stored - 1) - 1
        return 0, 2.0**self.stored - 1


TRIGGER, OFFSET, CARDIAC, RESPIRATORY, REFERENCE, ACQUISITION, CONTENT, POSITION = TIMES = (
    "TriggerTime", "TemporalPositionTimeOffset", "NominalPercentageOfCardiacPhase",
    "NominalPercentageOfRespiratoryPhase", "FrameReferenceTime", "AcquisitionTime", "ContentTime",
    "TemporalPositionIdentifier",
)  # fmt: skip
"""What may say when an image was taken, in the order in which it is asked."""


def layout_of(header: Any, file: str) -> Layout:
    photometric = str(header.get("PhotometricInterpretation", ""))
    if not photometric.startswith("MONOCHROME"):
        raise InvalidInput(f"has the colours '{photometric}', expected grey values (MONOCHROME2)", file)
    if header.get("SamplesPerPixel", 1) != 1:
        raise InvalidInput(f"has {header.SamplesPerPixel} samples a pixel, expected 1", file)
    bits = int(header.get("BitsAllocated", 0))
    kind = "ui"[int(header.PixelRepresentation)] if "PixelRepresentation" in header else "f" if bits >= 32 else "u"
    if bits not in (1, 8, 16, 32, 64):
        raise InvalidInput(f"has samples of {bits} bits; 1, 8, 16, 32 and 64 can be used", file)
    stored = int(header.get("BitsStored", bits))
    if not 0 < stored <= bits or int(header.get("HighBit", stored - 1)) != stored - 1:
        raise InvalidInput(
            f"has samples of {bits} bits, of which {stored} count, up to bit {header.get('HighBit')}; expected are the "
            "lowest", file,
        )  # fmt: skip
    return Layout(int(header.get("Columns", 0)), int(header.Rows), bits, stored, kind, photometric == "MONOCHROME1")


def images_of(header: Any, file: str) -> Iterator[Image]:
    """The images of a file, with what its functional groups say of each."""
    count = int(header.get("NumberOfFrames", 1) or 1)
    shared = [*header.get("SharedFunctionalGroupsSequence", [])][:1]
    groups = header.get("PerFrameFunctionalGroupsSequence")
    if not groups:
        if count > 1:
            raise InvalidInput(
                f"holds {count} frames that have no positions of their own, such as films of ultrasound or X-rays "
                "have: it is not a volume over time", file,
            )  # fmt: skip
        yield _image(_Found([*shared, header]), file, -1)
        return
    if count != len(groups):
        raise InvalidInput(f"has {count} frames, but describes {len(groups)}", file)
    for number, group in enumerate(groups):
        yield _image(_Found([group, *shared, header]), file, number)


class _Found:
    """What the first of some data sets says that says it, itself or in a sequence of one item."""

    def __init__(self, sets: List[Any]) -> None:
        self._sets = sets

    def __call__(self, name: str, sequence: str = "") -> Any:
        for one in self._sets:
            for place in [*one.get(sequence, [])][:1] if sequence in one and sequence else []:
                if place.get(name) is not None:
                    return place.get(name)
            if one.get(name) is not None:
                return one.get(name)
        return None

    def numbers(self, name: str, sequence: str, count: int) -> Optional[NDArray[np.float64]]:
        found = self(name, sequence)
        numbers = np.array([] if found in (None, "") else found, np.float64)
        return numbers if numbers.shape == (count,) and np.all(np.isfinite(numbers)) else None


def _image(found: _Found, file: str, number: int) -> Image:
    position = found.numbers("ImagePositionPatient", "PlanePositionSequence", 3)
    orientation = found.numbers("ImageOrientationPatient", "PlaneOrientationSequence", 6)
    spacing = found.numbers("PixelSpacing", "PixelMeasuresSequence", 2)
    if position is None or orientation is None:
        raise InvalidInput(
            "does not say where its image is in space (ImagePositionPatient and ImageOrientationPatient)", file
        )
    if spacing is None or not np.all(spacing > 0):
        raise InvalidInput("does not say how far apart its samples are (PixelSpacing)", file)
    slope = found("RescaleSlope", "PixelValueTransformationSequence")
    intercept = found("RescaleIntercept", "PixelValueTransformationSequence")
    lut = None
    if found("ModalityLUTSequence"):
        lut = found._sets[-1]
        slope = intercept = None
    if (slope is None) != (intercept is None) or slope == 0:
        raise InvalidInput(f"scales its samples by '{slope}' and adds '{intercept}'", file)
    return Image(
        file, number, position, orientation, spacing, float(1 if slope is None else slope), float(intercept or 0),
        lut, _padding(found), _times(found),
    )  # fmt: skip


def _padding(found: _Found) -> Optional[Tuple[float, float]]:
    """The range of stored values that are no data. Some writers give signed values as unsigned ones."""
    value = found("PixelPaddingValue")
    if not isinstance(value, (int, float)):
        return None
    limit = found("PixelPaddingRangeLimit")
    ends = [float(one) for one in (value, limit if isinstance(limit, (int, float)) else value)]
    if found("PixelRepresentation") == 1:
        bits = int(found("BitsAllocated"))
        ends = [one - 2.0**bits if one >= 2.0 ** (bits - 1) else one for one in ends]
    return min(ends), max(ends)


def _times(found: _Found) -> Dict[str, float]:
    position, apart = _number(found("TemporalPositionIdentifier")), _number(found("TemporalResolution"))
    delay = _number(found("NominalCardiacTriggerDelayTime", "CardiacSynchronizationSequence"))
    trigger = _number(found("TriggerTime")) if delay is None else delay
    offset = _number(found("TemporalPositionTimeOffset", "TemporalPositionSequence"))
    if offset is None and position is not None and apart:
        offset = (position - 1) * apart / 1000
    reference = _number(found("FrameReferenceTime"))
    index = _number(found("TemporalPositionIndex", "FrameContentSequence"))
    taken = [found(name, "FrameContentSequence") for name in ("FrameAcquisitionDateTime", "FrameReferenceDateTime")]
    acquired = [_moment(text) for text in (*taken, found("AcquisitionDateTime")) if text]
    times = {
        TRIGGER: None if trigger is None else trigger / 1000,
        OFFSET: offset,
        CARDIAC: _number(found("NominalPercentageOfCardiacPhase", "CardiacSynchronizationSequence")),
        RESPIRATORY: _number(found("NominalPercentageOfRespiratoryPhase", "RespiratorySynchronizationSequence")),
        REFERENCE: None if reference is None else reference / 1000,
        ACQUISITION: acquired[0] if acquired else _moment(found("AcquisitionTime"), found("AcquisitionDate")),
        CONTENT: _moment(found("ContentTime"), found("ContentDate")),
        POSITION: position if index is None else index,
    }
    return {name: time for name, time in times.items() if time is not None and math.isfinite(time)}


def _number(value: Any) -> Optional[float]:
    return None if value is None or value == "" else float(value)


def _moment(text: Any, date: Any = None) -> Optional[float]:
    """Seconds of a date and time, YYYYMMDDHHMMSS.FFFFFF&ZZXX, or of HHMMSS.FFFFFF on a date or, without one, of
    1970-01-01; None for what is none."""
    if not text:
        return None
    valuerep = library("pydicom.valuerep", EXTRA, "", "DICOM")
    try:
        if len(str(text).split(".")[0]) >= 10:
            moment = valuerep.DT(str(text))
        else:
            day = valuerep.DA(str(date)) if date else datetime.date(1970, 1, 1)
            moment = datetime.datetime.combine(day, valuerep.TM(str(text).replace(":", "")))
    except (ValueError, TypeError):
        return None
    return float((moment if moment.tzinfo else moment.replace(tzinfo=datetime.timezone.utc)).timestamp())


class Planes:
    """The samples (t, z, y, x) of images, each plane read when it is asked for."""

    def __init__(self, images: List[List[Image]], layout: Layout, dtype: np.dtype[Any]) -> None:
        """``images`` of each frame, slice by slice."""
        self._images = images
        self._layout = layout
        self.dtype = dtype
        self.shape = (len(images), len(images[0]), layout.rows, layout.columns)

    def __getitem__(self, at: Tuple[int, slice, slice, slice]) -> NDArray[Any]:
        frame, slices, *rest = at
        images = self._images[frame][slices]
        planes: List[Any] = [None] * len(images)
        for file in dict.fromkeys(image.file for image in images):
            of_file = [i for i, image in enumerate(images) if image.file == file]
            with through(file):
                for i, plane in zip(of_file, self._stored([images[i] for i in of_file])):
                    planes[i] = self._values(plane, images[i])[tuple(rest)]
        return np.stack(planes)

    def _stored(self, images: List[Image]) -> Iterator[NDArray[Any]]:
        """The planes of images of one file."""
        pydicom = library("pydicom", EXTRA, images[0].file, "DICOM")
        file = images[0].file
        one = images[0].number < 0
        source = pydicom.dcmread(file, force=True) if one else file
        fits = all(i.padding is None or self._layout.span[0] <= min(i.padding) <= max(i.padding) <= self._layout.span[1]
                   for i in images)  # fmt: skip
        given = {} if fits else {"correct_unused_bits": False}
        numbers = [max(0, image.number) for image in images]
        try:
            planes = library("pydicom.pixels", EXTRA, file, "DICOM").iter_pixels(
                source, indices=numbers, raw=True, **given
            )
            yield from planes
        except (RuntimeError, NotImplementedError) as error:
            raise Unsupported(f"cannot be unpacked: {' '.join(str(error).split())}", file) from error

    def _values(self, plane: NDArray[Any], image: Image) -> NDArray[Any]:
        if plane.shape != self.shape[2:]:
            raise InvalidInput(f"has a plane of the shape {plane.shape}, expected {self.shape[2:]}", image.file)
        values = plane
        if image.lut is not None:
            pixels = library("pydicom.pixels", EXTRA, image.file, "DICOM")
            values = pixels.apply_modality_lut(plane.astype(np.int64), image.lut)
        elif image.slope != 1 or image.intercept != 0:
            values = plane.astype(np.float64) * image.slope + image.intercept
        values = values.astype(self.dtype)
        if image.padding is not None:
            least, most = image.padding
            values[(plane >= least) & (plane <= most)] = np.nan
        return values

