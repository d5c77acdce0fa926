"""Arrays over time that are open or are a .npy: of numpy, dask, zarr and h5py, and of xarray with coordinates."""

from __future__ import annotations

from typing import Any, List, Sequence

import numpy as np

from t4d.errors import InvalidInput
from t4d.readers.coordinates import coordinates_of
from t4d.readers.volume import Choice, Volume, axes_of, axis_named, chosen_channel, through

OPTIONS = ("axes", "channel")


def read(paths: Sequence[str], choice: Choice) -> List[Volume]:
    volumes = []
    for path in paths:
        with through(path):
            volumes.append(of_array(np.load(path, mmap_mode="r", allow_pickle=False), path, choice))
    return volumes


def of_array(array: Any, where: str, choice: Choice) -> Volume:
    """The volume of an array of three or four axes, or five with channels. Those of xarray name their axes."""
    dims = getattr(array, "dims", None)
    names = [str(dim) for dim in dims] if dims is not None and all(isinstance(dim, str) for dim in dims) else []
    axes, assumed = axes_of(array.shape, names, choice, where)
    if len(set(axes)) < len(axes) or not set("xy") <= set(axes) <= set("xyztc"):
        raise InvalidInput(f"has the axes '{axes}'; expected x, y and perhaps z, t and c", where)
    volume = Volume(where, array, axes, axes_assumed=assumed)
    if hasattr(array, "coords") and hasattr(array, "data"):
        volume.array = array.data
    volume.channel = chosen_channel(volume.size("c"), choice, where)
    volume.whole = np.dtype(array.dtype).kind in "iu"
    if names:
        found = {axis_named(dim): (array.coords[dim].values, array.coords[dim].attrs)
                 for dim in names if axis_named(dim) and dim in array.coords}  # fmt: skip
        coordinates_of(volume, array.attrs, found)
    return volume
