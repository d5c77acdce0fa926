"""Volumes of VTK: .vti, and .pvd that lists them with their times, with vtk, which pyvista brings, too."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ElementTree
from typing import Any, List, Sequence, Tuple

import numpy as np
from numpy.typing import NDArray

from t4d.errors import InvalidInput
from t4d.readers.volume import Choice, Missing, Volume, chosen_channel, extension_of, library, through

EXTRA = "vtk"
OPTIONS = ("channel", "dataset")


def read(paths: Sequence[str], choice: Choice) -> List[Volume]:
    return [volume for path in paths for volume in (_collection(path, choice) if _listed(path) else [_read(path, choice)])]


def lists_volumes(path: str) -> bool:
    """Whether a .pvd lists .vti files."""
    try:
        return any(extension_of(name) == ".vti" for _, name in _steps(path))
    except (OSError, ElementTree.ParseError):
        return False


def _listed(path: str) -> bool:
    return extension_of(path) == ".pvd"


def _steps(path: str) -> List[Tuple[float, str]]:
    """Times and files of a .pvd."""
    steps = ElementTree.parse(path).getroot().iter("DataSet")
    return [(float(step.get("timestep", 0)), os.path.join(os.path.dirname(path), step.get("file", ""))) for step in steps]


def _collection(path: str, choice: Choice) -> List[Volume]:
    with through(path):
        steps = sorted(_steps(path))
    if len({time for time, _ in steps}) < len(steps):
        raise InvalidInput("lists several files of one time; a frame is one file", path)
    volumes = [_read(file, choice) for _, file in steps]
    for volume, (time, _) in zip(volumes, steps):
        volume.times = [time]
    return volumes


class _Data:
    """The samples (z, y, x, component) of a file, read when they are asked for."""

    def __init__(self, path: str, name: str, cells: bool, shape: Tuple[int, ...], dtype: np.dtype[Any]) -> None:
        self._path, self._name, self._cells = path, name, cells
        self.shape, self.dtype = shape, dtype

    def __getitem__(self, at: Any) -> NDArray[Any]:
        image = _image(self._path)
        data = image.GetCellData() if self._cells else image.GetPointData()
        numpy_support = library("vtkmodules.util.numpy_support", EXTRA, self._path, "a volume of VTK")
        values = numpy_support.vtk_to_numpy(data.GetArray(self._name))
        return np.asarray(values.reshape(self.shape)[at])


def _image(path: str) -> Any:
    if not os.path.isfile(path):
        raise FileNotFoundError(2, os.strerror(2), path)
    io = library("vtkmodules.vtkIOXML", EXTRA, path, "a volume of VTK")
    reader = io.vtkXMLImageDataReader()
    reader.SetFileName(path)
    reader.Update()
    if reader.GetErrorCode() or not reader.GetOutput().GetNumberOfPoints():
        raise InvalidInput("is no image of VTK that can be read", path)
    return reader.GetOutput()


def _read(path: str, choice: Choice) -> Volume:
    with through(path):
        image = _image(path)
        arrays = [(cells, data.GetArray(i)) for cells, data in ((False, image.GetPointData()), (True, image.GetCellData()))
                  for i in range(data.GetNumberOfArrays()) if data.GetArray(i)]  # fmt: skip
        names = [array.GetName() for _, array in arrays]
        found = [one for one in arrays if choice.dataset in (None, one[1].GetName())]
        if len(found) != 1:
            said = f"{'several' if found else 'no'} arrays" + (f" '{choice.dataset}'" if choice.dataset else "")
            raise Missing(f"has {said}; there are: {', '.join(names) or 'none'}", path, "dataset", "NAME")
        cells, array = found[0]
        numpy_support = library("vtkmodules.util.numpy_support", EXTRA, path, "a volume of VTK")
        dtype = numpy_support.vtk_to_numpy(array).dtype
        size = [n - 1 if cells and n > 1 else n for n in image.GetDimensions()]
        count = array.GetNumberOfComponents()
        volume = Volume(path, _Data(path, array.GetName(), cells, (*size[::-1], count), dtype), "zyxc")
        volume.channel = chosen_channel(count, choice, path)
        volume.affine = _affine(image, cells)
        volume.whole = dtype.kind in "iu"
        return volume


def _affine(image: Any, cells: bool) -> NDArray[np.float64]:
    """Of points, or of the middles of cells."""
    matrix = image.GetDirectionMatrix()
    turn = np.array([[matrix.GetElement(i, j) for j in range(3)] for i in range(3)])
    affine = np.eye(4)
    affine[:3, :3] = turn * np.array(image.GetSpacing())
    first = np.array(image.GetExtent()[::2]) + [0.5 if cells and n > 1 else 0 for n in image.GetDimensions()]
    affine[:3, 3] = np.array(image.GetOrigin()) + affine[:3, :3] @ first
    return affine
