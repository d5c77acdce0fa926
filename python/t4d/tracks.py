"""The components of a moving solid over time, as tables (``Mesh.tracks``)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict, List, Tuple

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
    )
