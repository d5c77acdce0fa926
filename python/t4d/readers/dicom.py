"""DICOM with pydicom: images of one series, classic or enhanced, as one volume over time (``dicom_series``).

Values are those after the modality LUT or the rescale; padding (PixelPaddingValue, PixelPaddingRangeLimit) is NaN.
"""

from __future__ import annotations

import datetime
import math
import os
import shlex
from typing import Any, Dict, Iterable, Iterator, List, Optional, Sequence, Tuple

import numpy as np
from numpy.typing import NDArray

from t4d.errors import InvalidInput, Unsupported
from t4d.readers import dicom_series
from t4d.readers.dicom_series import Image
from t4d.readers.volume import Choice, Missing, Volume, extension_of, library, listed, natural, through

OPTIONS = ("series",)

_SIGNATURE = 132  # bytes up to the end of "DICM"
_STORED = (
    "Rows Columns PhotometricInterpretation SamplesPerPixel BitsAllocated BitsStored HighBit PixelRepresentation"
).split()
"""How samples are stored, alike in all images of a series."""
# All other elements would fill the memory for series of many files.
_READ = [*_STORED, *(
    "SeriesInstanceUID SeriesNumber SeriesDescription NumberOfFrames SharedFunctionalGroupsSequence "
    "PerFrameFunctionalGroupsSequence ImagePositionPatient ImageOrientationPatient PixelSpacing ModalityLUTSequence "
    "RescaleSlope RescaleIntercept PixelPaddingValue PixelPaddingRangeLimit TemporalPositionIdentifier "
    "TemporalResolution TriggerTime FrameReferenceTime AcquisitionDateTime AcquisitionTime AcquisitionDate ContentTime "
    "ContentDate"
).split()]  # fmt: skip


def has_signature(path: str) -> bool:
    try:
        with open(path, "rb") as file:
            return file.read(_SIGNATURE)[-4:] == b"DICM"
    except OSError:
        return False


def files_in(folder: str, below: bool = False) -> Iterator[str]:
    """Files of images in the folder, and in those below it. One that cannot be read may be one."""
    for place, folders, names in os.walk(folder):
        for path in (os.path.join(place, name) for name in names if name != "DICOMDIR"):
            if os.path.isfile(path) and (
                extension_of(path) == ".dcm" or not os.access(path, os.R_OK) or has_signature(path)
            ):
                yield path
        folders[:] = sorted(folders, key=natural) if below else []


def _files(folder: str) -> List[str]:
    """The files of images in the folder itself."""
    files = sorted(files_in(folder), key=natural)
    if files:
        return files
    inner = os.path.dirname(next(files_in(folder, below=True)))
    said = f"holds no DICOM images, but a folder in it does: python3 -m t4d weave {shlex.quote(inner)}"
    raise InvalidInput(said, folder)


def _pydicom(where: str, module: str = "pydicom") -> Any:
    library("pydicom.pixels", "dicom", where, "DICOM")  # since version 3
    return library(module, "dicom", where, "DICOM")


def read(paths: Sequence[str], choice: Choice) -> List[Volume]:
    """One volume of one series. ``choice.series`` is its SeriesInstanceUID or SeriesNumber."""
    series: Dict[str, List[Tuple[str, Any]]] = {}
    empty: List[str] = []
    for file in (file for path in paths for file in (_files(path) if os.path.isdir(path) else [path])):
        with through(file):
            forced = extension_of(file) == ".dcm"
            header = _pydicom(file).dcmread(file, stop_before_pixels=True, force=forced, specific_tags=[*_READ])
            if "Rows" in header:
                series.setdefault(str(header.get("SeriesInstanceUID", "")), []).append((file, header))
            else:
                empty.append(file)
    if not series:
        raise InvalidInput("holds no DICOM images", paths[0])
    files = _chosen(series, choice.series, paths[0])
    first, header = files[0]
    with through(first):
        kind, span = _stored_as(header, first)
    size = int(header.Rows), int(header.get("Columns", 0))
    inverted = header.PhotometricInterpretation == "MONOCHROME1"
    images: List[Image] = []
    for file, header in files:
        with through(file):
            for name in _STORED:
                own, other = header.get(name), files[0][1].get(name)
                if own != other:
                    raise InvalidInput(f"its {name} is {own}, but {other} in {first} of the same series", file)
            images += _images(header, file)
    volume = dicom_series.arrange(images, paths[0])
    volume.array = _Planes(volume.array, size, span, _dtype(images, kind, span))
    volume.whole = kind.kind != "f"
    volume.padded = any(image.padding is not None for image in images)
    if inverted:
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
    said = f"holds {'several' if found else 'no'} series '{wanted}'; there are"
    said = f"holds {len(series)} series, of which one can be read at a time" if wanted is None else said
    raise Missing(f"{said}: {listed(lines, '; ')}", where, "series", "NUMBER, or the UID of a series")


def _stored_as(header: Any, file: str) -> Tuple[np.dtype[Any], Tuple[float, float]]:
    """The type of stored samples, and the least and the largest whole number that it can be."""
    colours = str(header.get("PhotometricInterpretation", ""))
    if not colours.startswith("MONOCHROME") or header.get("SamplesPerPixel", 1) != 1:
        raise InvalidInput(f"has the colours '{colours}', expected grey values (MONOCHROME2)", file)
    bits = int(header.get("BitsAllocated", 0))
    stored = int(header.get("BitsStored", bits))
    high = int(header.get("HighBit", stored - 1))
    if bits not in (1, 8, 16, 32, 64) or not 0 < stored <= bits or high != stored - 1:
        raise InvalidInput(f"has samples of {bits} bits, of which {stored} count, up to bit {high}", file)
    kind = "ui"[int(header.PixelRepresentation)] if "PixelRepresentation" in header else "f" if bits >= 32 else "u"
    least = -(2.0 ** (stored - 1)) if kind == "i" else 0.0
    return np.dtype(f"{kind}{max(8, bits) // 8}"), (least, least + 2.0**stored - 1)


def _images(header: Any, file: str) -> Iterator[Image]:
    """The images of a file, with what its functional groups say of each."""
    count = int(header.get("NumberOfFrames", 1) or 1)
    groups = header.get("PerFrameFunctionalGroupsSequence")
    if not groups and count > 1:
        raise InvalidInput(
            f"holds {count} frames that have no positions of their own, such as films of ultrasound or X-rays have: it "
            "is not a volume over time", file,
        )  # fmt: skip
    if groups and count != len(groups):
        raise InvalidInput(f"has {count} frames, but describes {len(groups)}", file)
    own = [element for element in header if not element.keyword.endswith("FunctionalGroupsSequence")]
    said = {**_said(own), **_said(*header.get("SharedFunctionalGroupsSequence", [])[:1])}
    lut = header if "ModalityLUTSequence" in header else None
    for number, group in enumerate(groups or [[]]):
        yield _image({**said, **_said(group)}, lut, file, number if groups else -1)


def _said(*sets: Iterable[Any]) -> Dict[str, Any]:
    """What elements say that have a value, by their names; those in the first item of a sequence, too."""
    said: Dict[str, Any] = {}
    for element in (element for one in sets for element in one):
        if element.VR == "SQ":
            said.update(_said(*element.value[:1]))
        elif element.value not in (None, ""):
            said[element.keyword] = element.value
    return said


def _image(said: Dict[str, Any], lut: Any, file: str, number: int) -> Image:
    def numbers(name: str, count: int) -> Optional[NDArray[np.float64]]:
        found = np.array(said.get(name, ()), np.float64)
        return found if found.shape == (count,) and np.all(np.isfinite(found)) else None

    position, orientation = numbers("ImagePositionPatient", 3), numbers("ImageOrientationPatient", 6)
    spacing = numbers("PixelSpacing", 2)
    if position is None or orientation is None:
        where = "does not say where its image is in space (ImagePositionPatient and ImageOrientationPatient)"
        raise InvalidInput(where, file)
    if spacing is None or not np.all(spacing > 0):
        raise InvalidInput("does not say how far apart its samples are (PixelSpacing)", file)
    slope, intercept = (None if lut is not None else said.get(name) for name in ("RescaleSlope", "RescaleIntercept"))
    if (slope is None) != (intercept is None) or slope == 0:
        raise InvalidInput(f"scales its samples by '{slope}' and adds '{intercept}'", file)
    scale = (1.0, 0.0) if slope is None or intercept is None else (float(slope), float(intercept))
    return Image(file, number, position, orientation, spacing, scale, lut, _padding(said), _times(said))


def _padding(said: Dict[str, Any]) -> Optional[Tuple[float, float]]:
    """The range of stored values that are no data. Some writers give signed values as unsigned ones."""
    ends = [said.get(name) for name in ("PixelPaddingValue", "PixelPaddingRangeLimit")]
    known = [end for end in ends if isinstance(end, (int, float))]
    if ends[0] is None or not known:
        return None
    if said.get("PixelRepresentation") == 1:
        bits = int(said["BitsAllocated"])
        known = [end - 2**bits if end >= 2 ** (bits - 1) else end for end in known]
    return float(min(known)), float(max(known))


def _times(said: Dict[str, Any]) -> Dict[str, float]:
    """Times by the names of dicom_series.TIMES: seconds, percent of a cycle, or numbers."""

    def number(*names: str) -> float:
        return next((float(said[name]) for name in names if name in said), math.nan)

    position = number("TemporalPositionIdentifier")
    apart = number("TemporalResolution") or math.nan
    taken = [f"{name}DateTime" for name in ("FrameAcquisition", "FrameReference", "Acquisition")]
    moment = next((_moment(said[name]) for name in taken if name in said), math.nan)
    times = (
        number("NominalCardiacTriggerDelayTime", "TriggerTime") / 1000,
        number("TemporalPositionTimeOffset") if "TemporalPositionTimeOffset" in said else (position - 1) * apart / 1000,
        number("NominalPercentageOfCardiacPhase"),
        number("NominalPercentageOfRespiratoryPhase"),
        number("FrameReferenceTime") / 1000,
        _moment(said.get("AcquisitionTime"), said.get("AcquisitionDate")) if math.isnan(moment) else moment,
        _moment(said.get("ContentTime"), said.get("ContentDate")),
        number("TemporalPositionIndex", "TemporalPositionIdentifier"),
    )
    return {name: time for name, time in zip(dicom_series.TIMES, times) if math.isfinite(time)}


def _moment(text: Any, date: Any = None) -> float:
    """Seconds of a date and time, YYYYMMDDHHMMSS.FFFFFF&ZZXX, or of HHMMSS.FFFFFF on a date or, without one, of
    1970-01-01; NaN for what is none."""
    valuerep = _pydicom("", "pydicom.valuerep")
    try:
        if len(str(text).split(".")[0]) >= 10:
            moment = valuerep.DT(str(text))
        else:
            day = valuerep.DA(str(date)) if date else datetime.date(1970, 1, 1)
            moment = datetime.datetime.combine(day, valuerep.TM(str(text).replace(":", "")))
    except (ValueError, TypeError):
        return math.nan
    return float((moment if moment.tzinfo else moment.replace(tzinfo=datetime.timezone.utc)).timestamp())


def _dtype(images: List[Image], kind: np.dtype[Any], span: Tuple[float, float]) -> np.dtype[Any]:
    """The smallest type that holds all values as they are; float64 for those that are scaled to fractions."""
    scales = {image.scale for image in images}
    luts = [image.lut for image in images if image.lut is not None]
    plain = scales == {(1.0, 0.0)} and not luts
    if kind.kind == "f" or not all(number == int(number) for scale in scales for number in scale):
        return kind if plain else np.dtype(np.float64)
    ends = [slope * end + intercept for slope, intercept in scales for end in span]
    ends += [end for lut in luts for end in (0.0, 2.0 ** int(lut.ModalityLUTSequence[0].LUTDescriptor[2]) - 1)]
    low, high = int(min(ends)), int(max(ends))
    if any(image.padding is not None for image in images):
        return np.dtype(np.float32 if max(-low, high) <= 2**24 else np.float64)
    fitting = np.min_scalar_type(min(low, -high - 1) if low < 0 else high)
    return kind if plain else fitting if fitting.itemsize <= 4 else np.dtype(np.float64)


class _Planes:
    """The samples (t, z, y, x) of images, each plane read when it is asked for."""

    def __init__(
        self, images: List[List[Image]], size: Tuple[int, int], span: Tuple[float, float], dtype: np.dtype[Any]
    ) -> None:
        """``images`` of each frame, slice by slice."""
        self._images, self._span, self.dtype = images, span, dtype
        self.shape = (len(images), len(images[0]), *size)

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
        paddings = [end for image in images for end in image.padding or ()]
        valid = all(self._span[0] <= end <= self._span[1] for end in paddings)
        given = {} if valid else {"correct_unused_bits": False}
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
