"""Readers of frames, each a small module that asks a library of others: ``read(paths, choice)`` gives a volume
over time, or one for each frame. Libraries are imported when they are needed."""

from __future__ import annotations

import os
from typing import Any, Dict, List, Optional, Sequence, Tuple

from t4d.errors import FileError, InvalidInput
from t4d.readers import arrays, dicom, hdf5, itk, tiff, vtk, zarr
from t4d.readers.volume import Choice, Volume, WrongOption, extension_of, natural

_MODULES: Dict[str, Tuple[Any, str, Tuple[str, ...]]] = {
    "DICOM": (dicom, "DICOM files", (".dcm",)),
    "Zarr": (zarr, "Zarr", ()),
    "TIFF": (tiff, "TIFF files", (".tif", ".tiff", ".lsm")),
    "HDF5": (hdf5, "HDF5 files", (".h5", ".hdf5", ".hdf", ".he5", ".nc", ".nc4")),
    "medical": (itk, "medical images", (*itk.SIMPLEITK, *itk.NIBABEL)),
    "VTK": (vtk, "volumes of VTK", (".vti",)),
    "NumPy": (arrays, "NumPy arrays", (".npy",)),
}

PROGRAM = (".vdb", ".nrrd", ".nhdr", ".nii", ".nii.gz", ".hdr", ".npy", ".raw")
"""Extensions that the program reads itself."""


def kind_of(path: str) -> Optional[str]:
    """The kind of an input, by its name and its first bytes; None for what no reader knows."""
    if zarr.is_zarr(path):
        return "Zarr"
    if os.path.isdir(path):
        return _kind_of_folder(path)
    extension = extension_of(path)
    for kind, (_, _, extensions) in _MODULES.items():
        if extension in extensions:
            return kind
    if extension == ".pvd" and vtk.lists_volumes(path):
        return "VTK"
    return "DICOM" if dicom.has_signature(path) else None


def _kind_of_folder(folder: str) -> Optional[str]:
    names = sorted(os.listdir(folder))
    if any(extension_of(name) == ".vdb" for name in names):
        return None
    if dicom.files_in(folder):
        return "DICOM"
    kinds = {kind for kind in map(kind_of, _files(folder)) if kind}
    return kinds.pop() if len(kinds) == 1 else None


def _files(folder: str) -> List[str]:
    paths = [os.path.join(folder, name) for name in sorted(os.listdir(folder), key=natural)]
    return [path for path in paths if os.path.isfile(path)]


def read(paths: Sequence[str], choice: Choice) -> List[Volume]:
    """The volumes of paths: one over time, or one for each frame. Raises FileError, InvalidInput, Unsupported
    (also for a library that is missing), and WrongOption for a choice that is not for the input."""
    kinds = [kind_of(path) for path in paths]
    for path, kind in zip(paths, kinds):
        if kind is None:
            raise _unknown(path)
        if kind != kinds[0]:
            raise InvalidInput(f"{paths[0]} and {path} are not of one kind; give files of one format")
    module, what, _ = _MODULES[str(kinds[0])]
    choice.allow(*module.OPTIONS, what=what)
    notes = []
    if kinds[0] not in ("DICOM", "Zarr") and os.path.isdir(paths[0]):
        paths = [file for path in paths for file in (_files(path) if os.path.isdir(path) else [path])
                 if kind_of(file) == kinds[0]]  # fmt: skip
        notes.append(f"frames are in the order of the numbers in their names, from {paths[0]} to {paths[-1]}")
    volumes: List[Volume] = module.read(paths, choice)
    volumes[0].notes[:0] = notes
    return volumes


def _unknown(path: str) -> Exception:
    if not os.path.exists(path):
        return FileError(os.strerror(2), path)
    if extension_of(path) in PROGRAM:
        return InvalidInput("is read by the program alone: t4d.verbs.weave", path)
    what = "a folder that holds no frames of one kind" if os.path.isdir(path) else "of no kind that is known by its name"
    return InvalidInput(f"is {what}; frames are DICOM, Zarr, {', '.join(_extensions())}", path)


def _extensions() -> List[str]:
    return [extension for _, _, extensions in _MODULES.values() for extension in extensions[:3]]


def of_object(given: Any, where: str, choice: Choice) -> Volume:
    """The volume of something that is open: an array, or an image of SimpleITK, nibabel, zarr or h5py."""
    package = type(given).__module__.partition(".")[0]
    if package == "SimpleITK" or package == "nibabel" or hasattr(given, "dataobj"):
        choice.allow(what="images of medical libraries")
        return itk.of_simpleitk(given, where) if package == "SimpleITK" else itk.of_nibabel(given, where)
    if package == "zarr":
        choice.allow(*zarr.OPTIONS, what="Zarr")
        return zarr.of_node(given, where, choice)
    if package == "h5py" and hasattr(given, "dims"):
        choice.allow(*hdf5.OPTIONS, what="HDF5")
        return hdf5.of_array(given, where, choice)
    if not hasattr(given, "shape") or not hasattr(given, "__getitem__"):
        raise TypeError(
            f"frames is {given!r:.80}; expected a path, several, an array over time, or an image of SimpleITK or nibabel"
        )
    choice.allow(*arrays.OPTIONS, what="arrays")
    return arrays.of_array(given, where, choice)


__all__ = ["PROGRAM", "Choice", "Volume", "WrongOption", "kind_of", "of_object", "read"]
