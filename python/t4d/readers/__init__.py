"""Readers of frames, each a small module that asks a library of others: ``read(paths, choice)`` gives a volume
over time, or one for each frame. Libraries are imported when they are needed."""

from __future__ import annotations

import os
from typing import Any, Dict, List, Sequence, Tuple

from t4d.errors import FileError, InvalidInput
from t4d.readers import arrays, dicom, hdf5, itk, tiff, vtk, zarr
from t4d.readers.volume import Choice, Volume, extension_of, natural
from t4d.readers.zarr import shown as shown

_KINDS: Dict[str, Tuple[Any, Tuple[str, ...]]] = {
    "DICOM": (dicom, (".dcm",)),
    "Zarr": (zarr, ()),
    "TIFF": (tiff, (".tif", ".tiff")),
    "HDF5": (hdf5, (".h5", ".hdf5", ".hdf", ".nc", ".nc4")),
    "medical images": (itk, (*itk.SIMPLEITK, *itk.NIBABEL)),
    "volumes of VTK": (vtk, (".vti",)),
    "arrays": (arrays, (".npy",)),
}

PROGRAM = (".vdb", ".nrrd", ".nhdr", ".nii", ".nii.gz", ".hdr", ".npy", ".raw")
"""Extensions that the program reads itself."""


def kind_of(path: str) -> str:
    """The kind of an input, by its name and its first bytes; "" for what no reader knows."""
    if zarr.is_zarr(path):
        return "Zarr"
    if os.path.isdir(path):
        if any(extension_of(name) == ".vdb" for name in os.listdir(path)):
            return ""
        kinds = {"DICOM"} if any(dicom.files_in(path)) else {*map(kind_of, _files(path))} - {""}
        if not kinds and any(dicom.files_in(path, below=True)):
            return "DICOM"  # whose reader says where it is
        return kinds.pop() if len(kinds) == 1 else ""
    if extension_of(path) == ".pvd":
        return "volumes of VTK" if vtk.lists_volumes(path) else ""
    kinds_of = (kind for kind, (_, extensions) in _KINDS.items() if extension_of(path) in extensions)
    return next(kinds_of, "") or ("DICOM" if os.path.isfile(path) and dicom.has_signature(path) else "")


def _files(folder: str) -> List[str]:
    paths = [os.path.join(folder, name) for name in sorted(os.listdir(folder), key=natural)]
    return [path for path in paths if os.path.isfile(path)]


def read(paths: Sequence[str], choice: Choice) -> List[Volume]:
    """The volumes of paths: one over time, or one for each frame. Raises FileError, InvalidInput, Unsupported
    (also for a library that is missing), and WrongOption for a choice that is not for the input."""
    kinds = [kind_of(path) for path in paths]
    kind = kinds[0]
    for path, own in zip(paths, kinds):
        if not own:
            raise _unknown(path)
        if own != kind:
            raise InvalidInput(f"{paths[0]} and {path} are not of one kind; give files of one format")
        if "://" not in path and not os.path.exists(path):
            raise FileError(os.strerror(2), path)
        if "://" not in path and not os.path.isdir(path) and not os.path.isfile(path):
            raise InvalidInput("is not a regular file", path)
    module = _KINDS[kind][0]
    choice.allow(module.OPTIONS, kind)
    notes = []
    if kind not in ("DICOM", "Zarr") and os.path.isdir(paths[0]):
        paths = [path for folder in paths for path in _files(folder) if kind_of(path) == kind]
        notes = [order_note(paths)]
    volumes: List[Volume] = module.read(paths, choice)
    volumes[0].notes[:0] = notes
    return volumes


def order_note(paths: Sequence[str]) -> str:
    return f"frames are in the order of the numbers in their names, from {paths[0]} to {paths[-1]}"


def _unknown(path: str) -> Exception:
    if not os.path.exists(path):
        return FileError(os.strerror(2), path)
    if extension_of(path) in PROGRAM:
        return InvalidInput("is read by the program alone: t4d.verbs.weave", path)
    what = "a folder that holds no frames of one kind" if os.path.isdir(path) else "of no kind that its name tells"
    return InvalidInput(f"is {what}; frames are {', '.join(known())}", path)


def options_of(path: str) -> Tuple[str, ...]:
    """The options that choose among the samples of a path."""
    kind = kind_of(path)
    return tuple(_KINDS[kind][0].OPTIONS) if kind else ()


def known() -> List[str]:
    """The formats and extensions that can be read."""
    return ["DICOM", "Zarr", *(extension for _, extensions in _KINDS.values() for extension in extensions)]


def of_object(given: Any, where: str, choice: Choice) -> Volume:
    """The volume of something that is open: an array, or an image of SimpleITK, nibabel, zarr or h5py."""
    package = type(given).__module__.partition(".")[0]
    module = {"SimpleITK": itk, "zarr": zarr, "h5py": hdf5}.get(package, itk if hasattr(given, "dataobj") else arrays)
    if module is arrays and not (hasattr(given, "shape") and hasattr(given, "__getitem__")):
        expected = "a path, several, an array over time, or an image of SimpleITK or nibabel"
        raise TypeError(f"frames is {given!r:.80}; expected {expected}")
    choice.allow(module.OPTIONS, next(kind for kind, (one, _) in _KINDS.items() if one is module))
    if module is itk:
        return itk.of_simpleitk(given, where) if package == "SimpleITK" else itk.of_nibabel(given, where)
    if module is zarr:
        return zarr.of_node(given, where, choice)
    return hdf5.of_array(given, where, choice) if module is hdf5 else arrays.of_array(given, where, choice)
