"""HDF5 and NetCDF 4 with h5py: an array in a file, by its path."""

from __future__ import annotations

import json
from typing import Any, Dict, List, Sequence

import numpy as np

from t4d.errors import InvalidInput
from t4d.readers.coordinates import Coordinates, text_of, volume_of
from t4d.readers.volume import Choice, Missing, Volume, library, listed, through

OPTIONS = ("axes", "channel", "dataset")


def read(paths: Sequence[str], choice: Choice) -> List[Volume]:
    return [_read(path, choice) for path in paths]


class _Array:
    """An array in a file that is opened for each frame: any number of files may be frames."""

    def __init__(self, h5py: Any, path: str, array: Any) -> None:
        self._h5py, self._path, self._name = h5py, path, array.name
        self.shape, self.dtype, self.chunks = array.shape, array.dtype, array.chunks

    def __getitem__(self, at: Any) -> Any:
        with self._h5py.File(self._path, "r") as file:
            return file[self._name][at]


def _read(path: str, choice: Choice) -> Volume:
    h5py = library("h5py", "hdf5", path, "HDF5")
    with through(path):
        with open(path, "rb") as bytes_:
            if bytes_.read(3) == b"CDF":
                raise InvalidInput("is NetCDF 3, which is not HDF5; `nccopy -k nc4 IN OUT` converts it", path)
        with h5py.File(path, "r") as file:
            array = _array(h5py, file, choice, path)
            volume = of_array(array, path, choice)
            volume.array = _Array(h5py, path, array)
            if choice.dataset is None:
                volume.notes.append(f"'{array.name[1:]}' is used, the only volume in {path}")
            return volume


def _array(h5py: Any, file: Any, choice: Choice, path: str) -> Any:
    """The array that is chosen, or the only one of volumes in the file or the chosen group."""
    found: Dict[str, Any] = {}

    def visit(name: str, part: Any) -> None:
        if isinstance(part, h5py.Dataset) and len(part.shape or ()) >= 3 and part.dtype.kind in "biuf":
            found[part.name] = part

    chosen = file.get(choice.dataset or "/")
    if isinstance(chosen, h5py.Dataset):
        return chosen
    (file if chosen is None else chosen).visititems(visit)
    if len(found) == 1 and chosen is not None:
        return next(iter(found.values()))
    named = listed([f"{name[1:]} {part.shape}" for name, part in found.items()])
    several = f"has {len(found)} arrays, of which one is read"
    said = f"has no array '{choice.dataset}'" if chosen is None else several
    raise Missing(f"{said}: {named or 'none has three or four axes'}", path, "dataset", "PATH")


def of_array(array: Any, where: str, choice: Choice) -> Volume:
    """The volume of an array of a file that is open."""
    scales = [dim[0] if len(dim) else None for dim in array.dims]
    names = [dim.label or (dim[0].name.rpartition("/")[2] if len(dim) else "") for dim in array.dims]
    attributes = dict(array.attrs)
    if "axistags" in attributes and not any(names):  # of vigra and ilastik
        names = [str(axis.get("key", "")) for axis in json.loads(text_of(attributes["axistags"])).get("axes", [])]
    volume = volume_of(array, where, choice, names, attributes, [*map(_coordinates, scales)])
    sizes = np.ravel(attributes.get("element_size_um", ()))  # of Fiji, (z, y, x)
    if len(sizes) == 3 and not volume.spacing:
        volume.spacing, volume.length_unit = dict(zip("zyx", map(float, sizes))), "um"
    return volume


def _coordinates(scale: Any) -> Coordinates:
    """The coordinates of a dimension scale; those of NetCDF without values are only names."""
    if scale is None or text_of(scale.attrs.get("NAME")).startswith("This is a netCDF dimension but not"):
        return None
    return scale[()], dict(scale.attrs)
