"""Medical images with SimpleITK (.mha, .mhd, .nrrd, .seq.nrrd) and with nibabel (.nii, .mgz, .mnc), and images of
both that are open. SimpleITK gives LPS, nibabel RAS."""

from __future__ import annotations

from typing import Any, Dict, List, Sequence

import numpy as np
from numpy.typing import NDArray

from t4d.errors import InvalidInput, Unsupported
from t4d.readers.units import unit_named
from t4d.readers.volume import Choice, Volume, extension_of, library, through

EXTRA = "itk"
OPTIONS = ()

NIBABEL = (".nii", ".nii.gz", ".hdr", ".img", ".mgz", ".mgh", ".mnc")
SIMPLEITK = (".mha", ".mhd", ".nrrd", ".nhdr")
_STREAMED = (".mha", ".mhd")  # of which SimpleITK reads a part


def read(paths: Sequence[str], choice: Choice) -> List[Volume]:
    return [_read(path) for path in paths]


def _read(path: str) -> Volume:
    if extension_of(path) in NIBABEL:
        try:
            nibabel = library("nibabel", EXTRA, path, "a medical image")
        except Unsupported:
            return _of_simpleitk_file(path)
        with through(path):
            return of_nibabel(nibabel.load(path), path)
    return _of_simpleitk_file(path)


# nibabel ---------------------------------------------------------------------------------------


def of_nibabel(image: Any, where: str) -> Volume:
    """Of an image of nibabel: its samples are read, and scaled, when they are asked for."""
    axes = "xyzt"[: len(image.shape)]
    if len(image.shape) not in (3, 4):
        raise InvalidInput(f"has {len(image.shape)} axes; expected x, y, z and perhaps t", where)
    volume = Volume(where, image.dataobj, axes, affine=np.asarray(image.affine, np.float64), space="RAS")
    volume.dtype = _nibabel_type(image)
    volume.values = lambda samples: np.asarray(samples, volume.dtype)
    volume.whole = np.dtype(image.get_data_dtype()).kind in "iu"
    volume.length_unit = "mm"
    header = image.header
    if hasattr(header, "get_xyzt_units"):
        length, time = header.get_xyzt_units()
        volume.length_unit = "" if length == "unknown" else unit_named(length)
        volume.time_unit = {"sec": "s", "msec": "ms", "usec": "us"}.get(time, "")
        if time in ("hz", "ppm", "rads"):
            raise Unsupported(f"has a fourth axis in {time}, which is not time", where)
        if hasattr(header, "__getitem__") and not int(header["qform_code"]) and not int(header["sform_code"]):
            volume.space = ""
            volume.affine = np.diag([*header.get_zooms()[:3], 1]).astype(np.float64)
        volume.start_time = float(header["toffset"])
    zooms = image.header.get_zooms()
    if len(zooms) > 3 and zooms[3] > 0:
        volume.frame_time = float(f"{zooms[3]:.7g}")  # of float32
        if extension_of(where) in (".mgz", ".mgh"):
            volume.time_unit = "ms"
    return volume


def _nibabel_type(image: Any) -> np.dtype[Any]:
    proxy = image.dataobj
    slope, inter = getattr(proxy, "slope", 1.0), getattr(proxy, "inter", 0.0)
    stored = np.dtype(getattr(proxy, "dtype", image.get_data_dtype()))
    scaled = slope not in (None, 1.0) or inter not in (None, 0.0) or not hasattr(proxy, "slope")
    if not hasattr(proxy, "slope") and isinstance(proxy, np.ndarray):
        scaled = False
    return np.dtype(np.float64) if scaled else stored.newbyteorder("=")


# SimpleITK -------------------------------------------------------------------------------------


def _of_simpleitk_file(path: str) -> Volume:
    sitk = library("SimpleITK", EXTRA, path, "a medical image")
    with through(path):
        reader = sitk.ImageFileReader()
        reader.SetFileName(path)
        reader.ReadImageInformation()
        return _placed(reader, _Samples(sitk, reader, reader.GetNumberOfComponents(), path), path)


def of_simpleitk(image: Any, where: str) -> Volume:
    """Of an image of SimpleITK: of four dimensions, or of three with a component for each frame, as Slicer's
    sequences are, or of one frame."""
    sitk = library("SimpleITK", EXTRA, where, "an image of SimpleITK")
    return _placed(image, _Samples(sitk, image, image.GetNumberOfComponentsPerPixel(), where, image), where)


class _Samples:
    """The samples (t, z, y, x) or (z, y, x, component) of an image, or of a file, which is read when a frame is
    asked for: a frame of those that SimpleITK reads in parts, or all, which are kept."""

    def __init__(self, sitk: Any, about: Any, components: int, path: str, image: Any = None) -> None:
        self._sitk, self._path, self._image = sitk, path, image
        self._in_parts = image is None and components == 1 and extension_of(path) in _STREAMED
        self.shape = (*about.GetSize()[::-1], *([components] if components > 1 else []))
        one = sitk.Image([1, 1], about.GetPixelID(), components if components > 1 else 0)
        self.dtype = np.dtype(sitk.GetArrayViewFromImage(one).dtype)

    def __getitem__(self, at: Any) -> NDArray[Any]:
        if self._in_parts and len(at) == 4:
            frame, *rest = at
            reader = self._sitk.ImageFileReader()
            reader.SetFileName(self._path)
            reader.SetExtractIndex([*(part.start for part in rest[::-1]), frame])
            reader.SetExtractSize([*(part.stop - part.start for part in rest[::-1]), 0])
            return np.asarray(self._sitk.GetArrayFromImage(reader.Execute()))
        if self._image is None:
            self._image = self._sitk.ReadImage(self._path)
        return np.array(self._sitk.GetArrayViewFromImage(self._image)[at])  # the view ends with the image


def _placed(image: Any, samples: Any, where: str) -> Volume:
    said = {key: str(image.GetMetaData(key)) for key in image.GetMetaDataKeys()}
    dimension = image.GetDimension()
    vector = 1 if len(samples.shape) == dimension else samples.shape[-1]
    if dimension not in (3, 4) or (vector > 1 and dimension == 4):
        raise InvalidInput(f"has {dimension} dimensions and {vector} components; expected volumes over time", where)
    axes = ("tzyx" if dimension == 4 else "zyx") + ("t" if vector > 1 else "")
    volume = Volume(where, samples, axes, length_unit="mm", space="LPS")
    volume.whole = np.dtype(samples.dtype).kind in "iu"
    turn = np.array(image.GetDirection()).reshape(dimension, dimension)
    sizes = np.array(image.GetSpacing())
    affine = np.eye(4)
    affine[:3, :3], affine[:3, 3] = (turn * sizes)[:3, :3], image.GetOrigin()[:3]
    volume.affine = affine
    if dimension == 4:
        volume.frame_time = float(sizes[3]) if sizes[3] != 1 else None
        volume.start_time = float(image.GetOrigin()[3]) or None
    if extension_of(where) in (".nrrd", ".nhdr") and "NRRD_space" not in said:
        volume.space = volume.length_unit = ""
    _sequence(volume, said)
    return volume


def _sequence(volume: Volume, said: Dict[str, str]) -> None:
    """The index values of a sequence of 3D Slicer are its times."""
    for number in range(4):
        values = said.get(f"axis {number} index values", "").split()
        if len(values) == volume.size("t") > 1:
            try:
                volume.times = [float(value) for value in values]
            except ValueError:
                continue
            unit = said.get(f"axis {number} index unit", said.get("axis 0 index unit", ""))
            volume.time_unit = unit_named(unit)
