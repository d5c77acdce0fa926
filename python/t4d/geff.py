"""Writes tracks as GEFF, the Graph Exchange File Format (https://liveimagetrackingtools.org/geff), version 1."""

from __future__ import annotations

import os
import shutil
import tempfile
from typing import TYPE_CHECKING, Any, Dict, List, Tuple

import numpy as np
from numpy.typing import NDArray

from t4d.errors import FileError
from t4d.readers.units import unit_named
from t4d.readers.volume import library

if TYPE_CHECKING:
    from t4d.tracks import Tracks

_VERSION = "1.0"
# Names of units of OME-NGFF.
_UNITS = {
    "angstrom": "angstrom", "nm": "nanometer", "um": "micrometer", "mm": "millimeter", "cm": "centimeter",
    "m": "meter", "km": "kilometer", "inch": "inch", "ns": "nanosecond", "us": "microsecond",
    "ms": "millisecond", "s": "second", "min": "minute", "h": "hour", "d": "day",
}  # fmt: skip
_PROPERTIES = ("volume", "area", "genus", "cavities")


def _edges(found: "Tracks", track: NDArray[np.int64]) -> NDArray[np.uint64]:
    """(n, 2): from sample to sample. Samples are numbered in the order of track and time."""
    same = np.flatnonzero(track[1:] == track[:-1])
    first = {int(one): i for i, one in reversed(list(enumerate(track)))}
    last = {int(one): i for i, one in enumerate(track)}
    links = [(last[one], first[into]) for into, of in found.parents().items() for one in of]
    inner = np.column_stack([same, same + 1]).reshape(-1, 2)
    outer = np.array(links, dtype=np.int64).reshape(-1, 2)
    edges: NDArray[np.uint64] = np.concatenate([inner, outer]).astype(np.uint64)
    return edges


def _tracklets(edges: NDArray[np.uint64], count: int) -> NDArray[np.int64]:
    """The longest paths without a branch that nodes are on, from 0. Two tracks are one path where one goes into
    the other alone, as where something in between is left out."""
    into, out = (np.bincount(edges[:, side].astype(np.int64), minlength=count) for side in (1, 0))
    paths = np.arange(count)
    for a, b in edges[np.argsort(edges[:, 1], kind="stable")].tolist():  # no edge goes back to a lower number
        if out[a] == 1 and into[b] == 1:
            paths[b] = paths[a]
    numbers: NDArray[np.int64] = np.unique(paths, return_inverse=True)[1].reshape(-1).astype(np.int64)
    return numbers


def _properties(found: "Tracks") -> Tuple[Dict[str, NDArray[Any]], Dict[str, NDArray[np.bool_]]]:
    """The properties of nodes: values, and which are missing."""
    order = np.lexsort((found.samples["time"], found.samples["track"]))
    samples = {name: column[order] for name, column in found.samples.items()}
    values = {"t": samples["time"], **{axis: samples[axis] for axis in "zyx"}, "track": samples["track"]}
    values.update({name: samples[name] for name in _PROPERTIES})
    unknown = np.isnan(samples["speed"])
    values["speed"] = np.where(unknown, 0, samples["speed"])
    return values, {"speed": unknown}


def _metadata(found: "Tracks", values: Dict[str, NDArray[Any]]) -> Dict[str, Any]:
    axes: List[Dict[str, Any]] = []
    for name in "tzyx":
        axis: Dict[str, Any] = {"name": name, "type": "time" if name == "t" else "space"}
        unit = unit_named(found.time_unit if name == "t" else found.length_unit)
        if unit:
            axis["unit"] = _UNITS.get(unit, unit)
        if len(values[name]):
            axis.update({"min": float(values[name].min()), "max": float(values[name].max())})
        axes.append(axis)
    return {
        "geff_version": _VERSION,
        "directed": True,
        "axes": axes,
        "node_props_metadata": {
            name: {"identifier": name, "dtype": str(column.dtype)} for name, column in values.items()
        },
        "edge_props_metadata": {},
        "track_node_props": {"tracklet": "tracklet"},
    }


def save(found: "Tracks", path: str) -> None:
    """Saves tracks (see ``Tracks.save_geff``). The group appears whole or not at all."""
    zarr = library("zarr", "zarr", path, "GEFF")
    if os.path.lexists(path):
        raise FileError("exists already; name a new one", path)
    values, missing = _properties(found)
    edges = _edges(found, values["track"])
    values["tracklet"] = _tracklets(edges, len(values["track"]))
    parent = os.path.dirname(os.path.abspath(path))
    try:
        folder = tempfile.mkdtemp(prefix=".geff-", dir=parent)
    except OSError as error:
        raise FileError(error.strerror or str(error), path) from error
    try:
        root = zarr.open_group(folder, mode="w", zarr_format=2)
        ids = np.arange(len(values["track"]), dtype=np.uint64)
        arrays: Dict[str, NDArray[Any]] = {"nodes/ids": ids, "edges/ids": edges}
        arrays.update({f"nodes/props/{name}/values": column for name, column in values.items()})
        arrays.update({f"nodes/props/{name}/missing": column for name, column in missing.items()})
        root.require_group("edges/props")
        for name, array in arrays.items():
            root[name] = array
        root.attrs["geff"] = _metadata(found, values)
        os.chmod(folder, 0o755)
        os.rename(folder, path)
    except OSError as error:
        raise FileError(error.strerror or str(error), path) from error
    finally:
        shutil.rmtree(folder, ignore_errors=True)
