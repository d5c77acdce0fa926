"""The components of a moving solid over time, as tables (``Mesh.tracks``)."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any, Dict, List, Tuple, Union

import numpy as np
from numpy.typing import NDArray

Table = Dict[str, Any]
"""Columns of one length: arrays, or lists of lists of ids."""


@dataclass(frozen=True)
class Tracks:
    """What ``t4d track`` finds: ``pandas.DataFrame(found.tracks)`` is a row for each track,
    ``networkx.DiGraph(found.links)`` the graph of them."""

    tracks: Table
    """``id``, ``body``, ``kind``, ``begin``, ``end``, ``begins``, ``ends``, ``from``, ``into``,
    ``largest_volume``."""
    samples: Table
    """``track``, ``time``, ``volume``, ``area``, ``x``, ``y``, ``z``, ``speed`` (NaN of the first),
    ``genus``, ``cavities``."""
    events: Table
    """``time``, ``event``, ``body``, ``x``, ``y``, ``z``, ``before``, ``after``, ``count``, ``euler``."""
    links: List[Tuple[int, int, Dict[str, Any]]]
    """From each track to those that it goes into, with the ``time`` and the ``event``."""
    length_unit: str = ""
    """"" if unknown."""
    time_unit: str = ""

    def parents(self) -> Dict[int, List[int]]:
        """The sampled tracks that each sampled track comes out of, if there are any. Where a track has no
        sample, because it begins and ends between two times, those that it comes out of take its place."""
        sampled = set(self.samples["track"].tolist())
        before: Dict[int, List[int]] = {}
        for one, into, _ in self.links:  # in the order of birth of ``one``
            before.setdefault(into, []).extend([one] if one in sampled else before.get(one, []))
        return {track: sorted(set(of)) for track, of in sorted(before.items()) if track in sampled and of}

    def napari(self) -> Tuple[NDArray[np.float64], Dict[str, NDArray[Any]], Dict[int, List[int]]]:
        """``data``, ``properties`` and ``graph`` of a layer of tracks of napari:
        ``viewer.add_tracks(data, properties=properties, graph=graph)``. A row of data is a sample: track,
        frame, z, y, x. Frames count the times of the samples, from 0; ``properties["time"]`` has them."""
        order = np.lexsort((self.samples["time"], self.samples["track"]))
        samples = {name: column[order] for name, column in self.samples.items()}
        frames = np.unique(samples["time"], return_inverse=True)[1].reshape(-1)
        data = np.column_stack([samples["track"], frames, samples["z"], samples["y"], samples["x"]])
        properties = {name: samples[name] for name in ("time", "volume", "area", "speed", "genus", "cavities")}
        return data.astype(np.float64), properties, self.parents()

    def save_geff(self, path: Union[str, "os.PathLike[str]"]) -> None:
        """Writes the graph as GEFF (Graph Exchange File Format), a Zarr group that must not exist yet: a node
        for each sample, with ``t``, ``z``, ``y``, ``x``, ``track``, ``volume`` and others, edges from
        sample to sample of a track and from track to track. Needs zarr."""
        from t4d import geff

        geff.save(self, os.fspath(path))


def _column(rows: List[Dict[str, Any]], name: str, kind: Any) -> NDArray[Any]:
    return np.array([row[name] for row in rows], dtype=kind)


def _point(rows: List[Dict[str, Any]], name: str) -> Table:
    points = np.array([row[name] for row in rows], dtype=np.float64).reshape(-1, 3)
    return {axis: points[:, i] for i, axis in enumerate("xyz")}


def tables(report: Dict[str, Any]) -> Tracks:
    """The tables of a report of ``t4d track --json``."""
    tracks = report["tracks"]
    samples = [{"track": track["id"], **sample} for track in tracks for sample in track["samples"]]
    events = report["events"]
    return Tracks(
        tracks={
            "id": _column(tracks, "id", np.int64),
            **{name: _column(tracks, name, np.str_) for name in ("body", "kind")},
            **{name: _column(tracks, name, np.float64) for name in ("begin", "end")},
            **{name: _column(tracks, name, np.str_) for name in ("begins", "ends")},
            **{name: [list(track[name]) for track in tracks] for name in ("from", "into")},
            "largest_volume": _column(tracks, "largest_volume", np.float64),
        },
        samples={
            "track": _column(samples, "track", np.int64),
            **{name: _column(samples, name, np.float64) for name in ("time", "volume", "area")},
            **_point(samples, "centroid"),
            **{name: _column(samples, name, np.float64) for name in ("speed", "genus")},
            "cavities": _column(samples, "cavities", np.int64),
        },
        events={
            "time": _column(events, "time", np.float64),
            **{name: _column(events, name, np.str_) for name in ("event", "body")},
            **_point(events, "place"),
            **{name: [list(event[name]) for event in events] for name in ("before", "after")},
            **{name: _column(events, name, np.int64) for name in ("count", "euler")},
        },
        links=[
            (track["id"], into, {"time": track["end"], "event": track["ends"]})
            for track in tracks
            for into in track["into"]
        ],
        length_unit=report["length_unit"],
        time_unit=report["time_unit"],
    )
