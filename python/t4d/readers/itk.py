"""Medical images with SimpleITK (.mha, .mhd, .nrrd, .seq.nrrd) and with nibabel (.nii, .mgz, .mnc), and images of
both that are open. SimpleITK gives LPS, nibabel RAS."""

from __future__ import annotations

from typing import Any, List, Sequence

import numpy as np
from numpy.typing import NDArray

from t4d.errors import InvalidInput, Unsupported
from t4d.readers.units import unit_named
from t4d.readers.volume import Choice, Volume, extension_of, library, through

OPTIONS = ()

NIBABEL = (".nii", ".nii.gz", ".hdr", ".img", ".mgz", ".mgh", ".mnc")
SIMPLEITK = (".mha", ".mhd", ".nrrd", ".nhdr")
_STREAMED = (".mha", ".mhd")  # of which SimpleITK reads a part


def read(paths: Sequence[str], choice: Choice) -> List[Volume]:
    return [_read(path) for path in paths]


def _read(path: str) -> Volume:
    with through(path):
        if extension_of(path) in NIBABEL:
            try:
                return of_nibabel(library("nibabel", "itk", path, "a medical image").load(path), path)
            except Unsupported:
                pass  # SimpleITK reads most of them, too
        if path != path.encode(errors="replace").decode():  # ends the process there
            raise InvalidInput("has a name that is not UTF-8, with which SimpleITK cannot open it", path)
        sitk = library("SimpleITK", "itk", path, "a medical image")
        reader = sitk.ImageFileReader()
        reader.SetFileName(path)
        reader.ReadImageInformation()
        return _of_simpleitk(reader, _Samples(sitk, reader, reader.GetNumberOfComponents(), path), path)


def of_nibabel(image: Any, where: str) -> Volume:
    """A volume of nibabel: its samples are read, and scaled, when they are asked for."""
    if len(image.shape) not in (3, 4):
        raise InvalidInput(f"has {len(image.shape)} axes; expected x, y, z and perhaps t", where)
    time_first = len(image.shape) == 4 and type(image).__name__.startswith("Minc")
    axes = "txyz" if time_first else "xyzt"[: len(image.shape)]
    volume = Volume(where, image.dataobj, axes, length_unit="mm", space="RAS")
    volume.affine = np.asarray(image.affine, np.float64)
    stored = np.dtype(image.get_data_dtype())
    proxy = image.dataobj
    plain = isinstance(proxy, np.ndarray) or (getattr(proxy, "slope", 0), getattr(proxy, "inter", 0)) == (1, 0)
    volume.dtype = np.dtype(proxy.dtype) if plain else np.dtype(np.float64)
    volume.values = lambda samples: np.asarray(samples, volume.dtype)
    volume.whole = stored.kind in "iu"
    zooms = image.header.get_zooms()
    zooms = (*zooms[1:], zooms[0]) if time_first else zooms
    if len(zooms) > 3 and zooms[3] > 0:
        volume.frame_time = float(f"{zooms[3]:.7g}")  # of float32
        volume.time_unit = "ms" if extension_of(where) in (".mgz", ".mgh") else ""
    if hasattr(image.header, "get_xyzt_units"):
        length, time = image.header.get_xyzt_units()
        volume.length_unit = "" if length == "unknown" else unit_named(length)
        volume.time_unit = {"sec": "s", "msec": "ms", "usec": "us"}.get(time, "")
        if time in ("hz", "ppm", "rads"):
            raise InvalidInput(f"has a fourth axis in {time}, which is not time", where)
        if not int(image.header["qform_code"]) and not int(image.header["sform_code"]):
            volume.space, volume.affine = "", np.diag([*map(float, zooms[:3]), 1.0])
        volume.start_time = float(image.header["toffset"])
    return volume


def of_simpleitk(image: Any, where: str) -> Volume:
    """A volume of SimpleITK: of four dimensions, or of three with a component for each frame, as Slicer's
    sequences are, or of one frame."""
    sitk = library("SimpleITK", "itk", where, "an image of SimpleITK")
    return _of_simpleitk(image, _Samples(sitk, image, image.GetNumberOfComponentsPerPixel(), where, image), where)


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
            reader = self._sitk.ImageFileReader()
            reader.SetFileName(self._path)
            reader.SetExtractIndex([*(part.start for part in at[:0:-1]), at[0]])
            reader.SetExtractSize([*(part.stop - part.start for part in at[:0:-1]), 0])
            return np.asarray(self._sitk.GetArrayFromImage(reader.Execute()))
        if self._image is None:
            self._image = self._sitk.ReadImage(self._path)
        return np.array(self._sitk.GetArrayViewFromImage(self._image)[at])  # the view ends with the image


def _of_simpleitk(image: Any, samples: _Samples, where: str) -> Volume:
    said = {key: str(image.GetMetaData(key)) for key in image.GetMetaDataKeys()}
    dimension = image.GetDimension()
    vector = len(samples.shape) > dimension
    if dimension not in (3, 4) or (vector and dimension == 4):
        raise InvalidInput(f"has {dimension} dimensions; expected volumes over time", where)
    axes = ("tzyx" if dimension == 4 else "zyx") + ("t" if vector else "")
    volume = Volume(where, samples, axes, length_unit="mm", space="LPS", whole=samples.dtype.kind in "iu")
    sizes = np.array(image.GetSpacing())
    volume.affine = np.eye(4)
    volume.affine[:3, :3] = (np.array(image.GetDirection()).reshape(dimension, dimension) * sizes)[:3, :3]
    volume.affine[:3, 3] = image.GetOrigin()[:3]
    if dimension == 4 and (sizes[3], image.GetOrigin()[3]) != (1, 0):  # which say nothing
        volume.frame_time, volume.start_time = float(sizes[3]), float(image.GetOrigin()[3])
    if extension_of(where) in (".nrrd", ".nhdr") and "NRRD_space" not in said:
        volume.space = volume.length_unit = ""
    for number in range(4):  # the index values of a sequence of 3D Slicer
        values = said.get(f"axis {number} index values", "").split()
        if len(values) == volume.size("t") > 1 and said.get(f"axis {number} index type") == "numeric":
            volume.times = [float(value) for value in values]
            volume.time_unit = unit_named(said.get(f"axis {number} index unit", ""))
    return volume
