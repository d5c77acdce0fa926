"""Coordinates of axes as NetCDF, HDF5 and xarray have them, and attributes that make values of samples."""

from __future__ import annotations

from typing import Any, Dict, Mapping, Tuple

import numpy as np
from numpy.typing import NDArray

from t4d.readers.units import in_one_unit, unit_named
from t4d.readers.volume import Volume, even_step

Coordinates = Mapping[str, Tuple[Any, Mapping[str, Any]]]
"""By axis: its values, one for each sample, and its attributes, such as units."""


def coordinates_of(volume: Volume, attributes: Mapping[str, Any], coordinates: Coordinates) -> None:
    """Puts what coordinates and attributes say into the volume: places, times, units, missing values, scale."""
    lengths: Dict[str, float] = {}
    origins: Dict[str, float] = {}
    units: Dict[str, str] = {}
    for axis, (values, about) in coordinates.items():
        unit = text_of(about.get("units"))
        if axis == "t":
            _times(volume, np.asarray(values), unit)
        elif axis != "c" and len(values):
            origins[axis], step = even_step(np.asarray(values), axis, volume.where)
            lengths.update({} if step is None else {axis: step})
            units[axis] = unit_named(unit)
    volume.spacing, volume.length_unit = in_one_unit(lengths, units)
    volume.origin, _ = in_one_unit(origins, units)
    values_of(volume, attributes)


def _times(volume: Volume, values: NDArray[Any], unit: str) -> None:
    if values.dtype.kind in "mM":  # of numpy: datetime64, timedelta64
        since = values - values[0] if values.dtype.kind == "M" else values
        volume.times = [float(one) for one in since / np.timedelta64(1, "s")]
        volume.time_unit = "s"
        return
    volume.times = [float(one) for one in values]
    volume.time_unit = unit_named(unit.partition(" since ")[0].strip())  # of CF: seconds since 2000-01-01


def values_of(volume: Volume, attributes: Mapping[str, Any]) -> None:
    """Makes NaN of _FillValue and missing_value, and values by scale_factor and add_offset."""
    stored = np.dtype(volume.array.dtype)
    if stored.kind not in "iuf":
        return
    volume.whole = stored.kind in "iu"
    fills = np.array([one for name in ("_FillValue", "missing_value") if name in attributes
                      for one in np.atleast_1d(attributes[name])])  # fmt: skip
    numeric = fills.dtype.kind in "iuf" and len(fills) > 0
    scale, offset = (float(np.ravel(attributes.get(n, d))[0]) for n, d in (("scale_factor", 1), ("add_offset", 0)))
    volume.padded = numeric or stored.kind == "f" and bool(fills.size)
    if not numeric and scale == 1 and offset == 0:
        return
    exact = scale == 1 and offset == 0
    narrow = stored.itemsize <= (4 if stored.kind == "f" else 2)
    volume.dtype = np.dtype(np.float32 if exact and narrow else np.float64)

    def values(samples: NDArray[Any]) -> NDArray[Any]:
        made: NDArray[Any] = samples.astype(volume.dtype)
        if not exact:
            made = made * scale + offset
        if numeric:
            made[np.isin(samples, fills.astype(stored))] = np.nan
        return made

    volume.values = values


def text_of(value: Any) -> str:
    """An attribute as text: bytes and arrays of one are common in HDF5."""
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.ravel()[0]
    return value.decode(errors="replace") if isinstance(value, bytes) else str(value) if value is not None else ""
