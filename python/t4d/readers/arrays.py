"""Arrays over time that are open or are a .npy: of numpy, dask and the like, and of xarray with coordinates."""

from __future__ import annotations

from typing import Any, List, Sequence

import numpy as np

from t4d.readers.coordinates import coordinates_of
from t4d.readers.volume import Choice, Volume, axes_of, axis_named, choose_channel, through

OPTIONS = ("axes", "channel")


def read(paths: Sequence[str], choice: Choice) -> List[Volume]:
    def one(path: str) -> Volume:
        with through(path):
            return of_array(np.load(path, mmap_mode="r", allow_pickle=False), path, choice)

    return [one(path) for path in paths]


def of_array(array: Any, where: str, choice: Choice) -> Volume:
    """The volume of an array of three or four axes, or five with channels. Those of xarray name their axes."""
    names = [str(dim) for dim in getattr(array, "dims", None) or ()]
    axes, assumed = axes_of(array.shape, names, choice, where)
    volume = Volume(where, array.data if names else array, axes, axes_assumed=assumed)
    choose_channel(volume, choice)
    volume.whole = np.dtype(array.dtype).kind in "iu"
    if names:
        there = [dim for dim in names if axis_named(dim) and dim in array.coords]
        found = {axis_named(dim): (array.coords[dim].values, array.coords[dim].attrs) for dim in there}
        coordinates_of(volume, array.attrs, found)
    return volume
