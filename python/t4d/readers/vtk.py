"""Volumes of VTK: .vti, and .pvd that lists them with their times, with vtk, which pyvista brings, too."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ElementTree
from typing import Any, List, Sequence, Tuple

import numpy as np
from numpy.typing import NDArray

from t4d.errors import InvalidInput
from t4d.readers.volume import Choice, Missing, Volume, choose_channel, extension_of, library, through

OPTIONS = ("channel", "dataset")


def read(paths: Sequence[str], choice: Choice) -> List[Volume]:
    listed = [_steps(path) if extension_of(path) == ".pvd" else [(None, path)] for path in paths]
    volumes = []
    for time, path in (step for steps in listed for step in steps):
        volumes.append(_read(path, choice))
        volumes[-1].times = None if time is None else [time]
    return volumes


def lists_volumes(path: str) -> bool:
    """Whether a .pvd lists .vti files."""
    try:
        return any(extension_of(name) == ".vti" for _, name in _steps(path))
    except (OSError, ElementTree.ParseError, ValueError, InvalidInput):
        return False


def _steps(path: str) -> List[Tuple[Any, str]]:
    """Times and files of a .pvd, in order."""
    folder = os.path.dirname(path)
    steps = [*ElementTree.parse(path).getroot().iter("DataSet")]
    return sorted((float(step.get("timestep", 0)), _in_folder(folder, step.get("file", ""), path)) for step in steps)


def _in_folder(folder: str, name: str, where: str) -> str:
    file = os.path.join(folder, name)
    if not os.path.realpath(file).startswith(os.path.join(os.path.realpath(folder), "")):
        raise InvalidInput(f"names the file '{name}'; it must be in the same folder or below", where)
    return file


def _vtk(module: str, path: str) -> Any:
    return library(f"vtkmodules.{module}", "vtk", path, "a volume of VTK")


def _arrays(path: str) -> Tuple[Any, List[Tuple[bool, str, Any]]]:
    """The image of a file, and its arrays: whether of cells, names and samples."""
    reader = _vtk("vtkIOXML", path).vtkXMLImageDataReader()
    reader.SetFileName(path)
    if not os.path.isfile(path):
        raise FileNotFoundError(2, os.strerror(2), path)
    reader.Update()
    image = reader.GetOutput()
    if reader.GetErrorCode() or not image.GetNumberOfPoints():
        raise InvalidInput("is no image of VTK that can be read", path)
    found = []
    for cells, data in ((False, image.GetPointData()), (True, image.GetCellData())):
        size = [n - 1 if cells and n > 1 else n for n in image.GetDimensions()][::-1]
        for array in [data.GetArray(i) for i in range(data.GetNumberOfArrays()) if data.GetArray(i)]:
            values = _vtk("util.numpy_support", path).vtk_to_numpy(array)
            found.append((cells, str(array.GetName()), values.reshape(*size, array.GetNumberOfComponents())))
    return image, found


class _Data:
    """The samples (z, y, x, component) of an array of a file, read when they are asked for."""

    def __init__(self, path: str, of: Tuple[bool, str, Any]) -> None:
        self._path, self._of, self.shape, self.dtype = path, of[:2], of[2].shape, of[2].dtype

    def __getitem__(self, at: Any) -> NDArray[Any]:
        return next(np.array(values[at]) for *of, values in _arrays(self._path)[1] if tuple(of) == self._of)


def _read(path: str, choice: Choice) -> Volume:
    with through(path):
        image, arrays = _arrays(path)
        found = [array for array in arrays if choice.dataset in (None, array[1])]
        if len(found) != 1:
            said = f"{'several' if found else 'no'} arrays" + (f" '{choice.dataset}'" if choice.dataset else "")
            listed = ", ".join(name for _, name, _ in arrays) or "none"
            raise Missing(f"has {said}; there are: {listed}", path, "dataset", "NAME")
        volume = Volume(path, _Data(path, found[0]), "zyxc", whole=found[0][2].dtype.kind in "iu")
        choose_channel(volume, choice)
        matrix = image.GetDirectionMatrix()
        turn = np.array([[matrix.GetElement(i, j) for j in range(3)] for i in range(3)])
        volume.affine = np.eye(4)
        volume.affine[:3, :3] = turn * np.array(image.GetSpacing())
        middle = [0.5 if found[0][0] and n > 1 else 0 for n in image.GetDimensions()]  # of cells
        first = np.array(image.GetExtent()[::2]) + middle
        volume.affine[:3, 3] = np.array(image.GetOrigin()) + volume.affine[:3, :3] @ first
        return volume
