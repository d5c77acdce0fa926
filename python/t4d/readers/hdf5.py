"""HDF5 and NetCDF 4 with h5py: an array in a file, by its path."""

from __future__ import annotations

from typing import Any, Dict, List, Mapping, Sequence, Tuple

import numpy as np

from t4d.errors import InvalidInput
from t4d.readers.coordinates import Coordinates, coordinates_of, text_of
from t4d.readers.units import unit_named
from t4d.readers.volume import Choice, Missing, Volume, axes_of, axis_named, chosen_channel, library, through

EXTRA = "hdf5"
OPTIONS = ("axes", "channel", "dataset")

_MOST_LISTED = 20


def read(paths: Sequence[str], choice: Choice) -> List[Volume]:
    return [_read(path, choice) for path in paths]


class _Array:
    """An array in a file that is opened for each frame: any number of files may be frames."""

    def __init__(self, h5py: Any, path: str, array: Any) -> None:
        self._h5py = h5py
        self._path = path
        self._name = array.name
        self.shape, self.dtype, self.chunks = array.shape, array.dtype, array.chunks

    def __getitem__(self, at: Any) -> Any:
        with self._h5py.File(self._path, "r") as file:
            return file[self._name][at]


def _read(path: str, choice: Choice) -> Volume:
    h5py = library("h5py", EXTRA, path, "HDF5")
    with through(path):
        with open(path, "rb") as bytes_:
            begin = bytes_.read(4)
        if begin[:3] == b"CDF":
            raise InvalidInput("is NetCDF 3, which is not HDF5; `nccopy -k nc4 IN OUT` converts it", path)
        with h5py.File(path, "r") as file:
            array, notes = _array(h5py, file, choice, path)
            volume = of_array(array, path, choice, _Array(h5py, path, array))
            volume.notes += notes
            return volume


def _array(h5py: Any, file: Any, choice: Choice, path: str) -> Tuple[Any, List[str]]:
    """The array that is chosen, or the only one of volumes."""
    found: Dict[str, Any] = {}

    def visit(name: str, part: Any) -> None:
        if isinstance(part, h5py.Dataset) and len(part.shape or ()) >= 3 and part.dtype.kind in "biuf":
            found[name] = part

    file.visititems(visit)
    more = f", and {len(found) - _MOST_LISTED} more" if len(found) > _MOST_LISTED else ""
    listed = ", ".join(f"{name} {part.shape}" for name, part in [*found.items()][:_MOST_LISTED]) + more
    if choice.dataset is not None:
        chosen = file.get(choice.dataset)
        if isinstance(chosen, h5py.Dataset):
            return chosen, []
        within = [name for name in found if name.startswith(choice.dataset.strip("/") + "/")]
        if chosen is None or len(within) != 1:
            raise Missing(f"has no array '{choice.dataset}'; it has {listed or 'none'}", path, "dataset", "PATH")
        return found[within[0]], []
    if not found:
        raise InvalidInput("has no array of three or four axes", path)
    if len(found) > 1:
        raise Missing(f"has {len(found)} arrays, of which one is read: {listed}", path, "dataset", "PATH")
    ((name, only),) = found.items()
    return only, [f"'{name}' is used, the only volume in {path}"]


def of_array(array: Any, where: str, choice: Choice, stored: Any = None) -> Volume:
    """The volume of an array of a file that is open; ``stored`` reads its samples, by default itself."""
    names = [dim.label or _scale_name(dim) for dim in array.dims]
    attributes = dict(array.attrs)
    tags = text_of(attributes.get("axistags"))  # of vigra and ilastik
    if tags and not any(names):
        import json

        names = [str(axis.get("key", "")) for axis in json.loads(tags).get("axes", [])]
    axes, assumed = axes_of(array.shape, names, choice, where)
    volume = Volume(where, array if stored is None else stored, axes, axes_assumed=assumed)
    volume.channel = chosen_channel(volume.size("c"), choice, where)
    coordinates_of(volume, attributes, _coordinates(array, axes))
    sizes = np.ravel(attributes.get("element_size_um", ()))  # of Fiji, (z, y, x)
    if len(sizes) == 3 and not volume.spacing:
        volume.spacing, volume.length_unit = dict(zip("zyx", map(float, sizes))), "um"
    return volume


def _scale_name(dim: Any) -> str:
    return str(dim[0].name).rsplit("/", 1)[-1] if len(dim) else ""


def _coordinates(array: Any, axes: str) -> Coordinates:
    """The dimension scales of axes. Those of NetCDF without values are only names."""
    found: Dict[str, Tuple[Any, Mapping[str, Any]]] = {}
    for axis, dim in zip(axes, array.dims):
        if not len(dim) or text_of(dim[0].attrs.get("NAME")).startswith("This is a netCDF dimension but not"):
            continue
        if dim[0].shape == (array.shape[axes.index(axis)],):
            found[axis] = dim[0][:], dict(dim[0].attrs)
    return found


__all__ = ["EXTRA", "OPTIONS", "axis_named", "of_array", "read", "unit_named"]
