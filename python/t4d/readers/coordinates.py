"""Arrays with names and coordinates of axes as NetCDF, HDF5, Zarr and xarray have them, and with attributes that make
values of samples."""

from __future__ import annotations

from typing import Any, Dict, Mapping, Optional, Sequence, Tuple

import numpy as np
from numpy.typing import NDArray

from t4d.errors import InvalidInput
from t4d.readers.units import in_one_unit, unit_named
from t4d.readers.volume import Choice, Volume, axes_of, choose_channel

_UNEVEN = 1e-3  # of a step

Coordinates = Optional[Tuple[Any, Mapping[str, Any]]]
"""Values of an axis, and their attributes; None without."""


def volume_of(
    array: Any, where: str, choice: Choice, names: Sequence[str] = (), attributes: Mapping[str, Any] = {},
    coordinates: Sequence[Coordinates] = (),
) -> Volume:  # fmt: skip
    """The volume of an array with names ("" if unknown) and coordinates of its axes: places, times, units, missing
    values and scale. Raises InvalidInput for coordinates that are not even, and Missing as ``axes_of``."""
    axes, assumed = axes_of(array.shape, names, choice, where)
    volume = Volume(where, array, axes, axes_assumed=assumed)
    choose_channel(volume, choice)
    lengths: Dict[str, float] = {}
    origins: Dict[str, float] = {}
    units: Dict[str, str] = {}
    for axis, count, (values, about) in zip(axes, array.shape, (one or ((), {}) for one in coordinates)):
        unit = text_of(about.get("units"))
        if np.shape(values) != (count,):
            continue
        if axis == "t":
            _times(volume, np.asarray(values), unit)
        elif axis != "c":
            places = np.asarray(values, np.float64)
            step = (places[-1] - places[0]) / max(1, len(places) - 1)
            if np.any(np.abs(places - places[0] - step * np.arange(len(places))) > _UNEVEN * abs(step)):
                raise InvalidInput(f"its coordinates along {axis} are not evenly spaced", volume.where)
            lengths.update({axis: float(f"{step:.12g}")} if step else {})
            origins[axis], units[axis] = float(places[0]), unit_named(unit)
    volume.spacing, volume.length_unit = in_one_unit(lengths, units)
    volume.origin, _ = in_one_unit(origins, units)
    _values(volume, attributes)
    return volume


def _times(volume: Volume, values: NDArray[Any], unit: str) -> None:
    if values.dtype.kind in "mM":  # of numpy: datetime64, timedelta64
        since = values - values[0] if values.dtype.kind == "M" else values
        values, unit = since / np.timedelta64(1, "s"), "s"
    volume.times = [float(one) for one in values]
    volume.time_unit = unit_named(unit.partition(" since ")[0].strip())  # of CF: seconds since 2000-01-01


def _values(volume: Volume, attributes: Mapping[str, Any]) -> None:
    """Makes NaN of _FillValue and missing_value, and values by scale_factor and add_offset."""
    stored = np.dtype(volume.array.dtype)
    volume.whole = stored.kind in "iu"
    found = [np.ravel(attributes[name]) for name in ("_FillValue", "missing_value") if name in attributes]
    fills = np.concatenate(found) if found else np.array([])
    scale, offset = (float(np.ravel(attributes.get(n, d))[0]) for n, d in (("scale_factor", 1), ("add_offset", 0)))
    volume.padded = len(fills) > 0 and stored.kind in "iuf" and fills.dtype.kind in "iuf"
    exact = scale == 1 and offset == 0
    if not volume.padded and exact:
        return
    narrow = exact and stored.itemsize <= (4 if stored.kind == "f" else 2)
    volume.dtype = np.dtype(np.float32 if narrow else np.float64)

    def values(samples: NDArray[Any]) -> NDArray[Any]:
        made: NDArray[Any] = samples.astype(volume.dtype) if exact else samples * np.float64(scale) + offset
        made[np.isin(samples, fills.astype(stored))] = np.nan
        return made

    volume.values = values


def text_of(value: Any) -> str:
    """An attribute as text: bytes and arrays of one are common in HDF5."""
    one = np.ravel(value)[0] if isinstance(value, np.ndarray) and value.size == 1 else value
    return one.decode(errors="replace") if isinstance(one, bytes) else "" if one is None else str(one)
