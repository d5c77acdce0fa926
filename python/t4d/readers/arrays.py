"""Arrays over time that are open or are a .npy: of numpy, dask and the like, and of xarray with coordinates."""

from __future__ import annotations

from typing import Any, List, Sequence

import numpy as np

from t4d.readers.coordinates import volume_of
from t4d.readers.volume import Choice, Volume, through

OPTIONS = ("axes", "channel")


def read(paths: Sequence[str], choice: Choice) -> List[Volume]:
    def one(path: str) -> Volume:
        with through(path):
            return of_array(np.load(path, mmap_mode="r", allow_pickle=False), path, choice)

    return [one(path) for path in paths]


def of_array(array: Any, where: str, choice: Choice) -> Volume:
    """The volume of an array of three or four axes, or five with channels. Those of xarray name their axes."""
    if not getattr(array, "dims", None):
        return volume_of(array, where, choice)
    there = [array.coords[dim] if dim in array.coords else None for dim in array.dims]
    coordinates = [None if one is None else (one.values, one.attrs) for one in there]
    return volume_of(array.data, where, choice, [*map(str, array.dims)], array.attrs, coordinates)
