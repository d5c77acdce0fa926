"""DICOM with pydicom: one series of images, classic or enhanced, as one volume over time."""

from __future__ import annotations

import os
from typing import Any, Dict, List, Sequence, Tuple

from t4d.errors import InvalidInput
from t4d.readers.dicom_images import EXTRA, images_of, layout_of
from t4d.readers.dicom_series import arrange
from t4d.readers.volume import Choice, Missing, Volume, extension_of, library, natural, through

OPTIONS = ("series",)

_SIGNATURE = 132  # bytes up to the end of "DICM"
_MOST_LISTED = 20


def has_signature(path: str) -> bool:
    try:
        with open(path, "rb") as file:
            return file.read(_SIGNATURE)[-4:] == b"DICM"
    except OSError:
        return False


def files_in(folder: str) -> List[str]:
    """Files of images in the folder or, if there are none, in those below it, in natural order."""
    found = []
    for place, _, names in os.walk(folder):
        for name in names:
            path = os.path.join(place, name)
            if name == "DICOMDIR" or not os.path.isfile(path):
                continue
            if has_signature(path) or extension_of(path) == ".dcm" or not os.access(path, os.R_OK):
                found.append(path)
        if found and place == folder:
            break
    return sorted(found, key=natural)


def read(paths: Sequence[str], choice: Choice) -> List[Volume]:
    """One volume of one series. ``choice.series`` is its SeriesInstanceUID or SeriesNumber."""
    pydicom = library("pydicom.pixels", EXTRA, paths[0], "DICOM") and library("pydicom", EXTRA, paths[0], "DICOM")
    where = paths[0]
    files = [file for path in paths for file in (files_in(path) if os.path.isdir(path) else [path])]
    series: Dict[str, List[Tuple[str, Any]]] = {}
    empty: List[str] = []
    for file in files:
        with through(file):
            header = pydicom.dcmread(file, stop_before_pixels=True, force=extension_of(file) == ".dcm")
            if "Rows" not in header:
                empty.append(file)
                continue
            series.setdefault(str(header.get("SeriesInstanceUID", "")), []).append((file, header))
    if not series:
        raise InvalidInput("holds no DICOM images", where)
    chosen = _chosen(series, choice.series, where)
    images, layouts = [], []
    for file, header in chosen:
        with through(file):
            layouts.append(layout_of(header, file))
            images += images_of(header, file)
    volume = arrange(images, layouts, [file for file, _ in chosen], where)
    if empty:
        volume.notes.append(f"files without an image: {len(empty)}, the first {empty[0]}")
    return [volume]


def _chosen(series: Dict[str, List[Tuple[str, Any]]], wanted: Any, where: str) -> List[Tuple[str, Any]]:
    def number(uid: str) -> str:
        found = series[uid][0][1].get("SeriesNumber")
        return "" if found is None else str(found)

    asked = "" if wanted is None else str(wanted)
    found = [uid for uid in series if not asked or asked in (uid, number(uid))]
    if len(found) == 1:
        return series[found[0]]
    lines = [
        f"{number(uid) or 'without a number'} '{files[0][1].get('SeriesDescription', '')}' of {len(files)} "
        f"file{'' if len(files) == 1 else 's'}, {uid}"
        for uid, files in sorted(series.items())
    ]
    more = f"; and {len(lines) - _MOST_LISTED} more" if len(lines) > _MOST_LISTED else ""
    listed = "; ".join(lines[:_MOST_LISTED]) + more
    if not asked:
        message = f"holds {len(series)} series, of which one can be read at a time: {listed}"
        raise Missing(message, where, "series", "NUMBER, or the UID of a series")
    raise Missing(f"holds {'several' if found else 'no'} series '{asked}'; there are: {listed}", where, "series", "NUMBER, or the UID of a series")
