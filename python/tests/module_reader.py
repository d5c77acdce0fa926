#!/usr/bin/env python3
"""The module as a reader under test: its own reading and slicing behind the protocol of the Python
reader that was written from the specification alone, which lends its checksums and sums."""

import sys
from pathlib import Path

import numpy as np

import t4d

sys.path.insert(0, str(Path(__file__).parents[2] / "conformance/readers/python"))
import t4d_reader as by_page  # noqa: E402

TYPES = ["u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f4", "f8"]


def bounds(points):
    if len(points) == 0:
        return {"min": None, "max": None}
    return {
        "min": [float(x).hex() for x in points.min(axis=0)],
        "max": [float(x).hex() for x in points.max(axis=0)],
    }


def attribute(domain, name, values):
    return {
        "domain": domain,
        "name": name,
        "type": str(TYPES.index(values.dtype.str[1:]) + 1),
        "components": str(1 if values.ndim == 1 else values.shape[1]),
        "checksum": f"{by_page.crc32c(values.tobytes()):08x}",
    }


def determinants(rows):
    """Of (n, 4, 4), by minors: elimination divides by numbers whose inverse may be infinite."""
    def minors(a, b):
        pairs = (0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)
        return [a[:, i] * b[:, j] - a[:, j] * b[:, i] for i, j in pairs]

    upper, lower = minors(rows[:, 0], rows[:, 1]), minors(rows[:, 2], rows[:, 3])
    signs = 1, -1, 1, 1, -1, 1
    return sum(sign * u * v for sign, u, v in zip(signs, upper, reversed(lower)))


def describe(path):
    mesh = t4d.read(path, whole=True, max_cells=2**64 - 1)
    bodies = []
    for body in mesh:
        vertices_checksum = cells_checksum = 0
        count, hypervolume, slabs, boxes = 0, 0.0, [], []
        for slab in body.slabs():
            vertices, cells = slab.vertices, slab.cells
            vertices_checksum = by_page.crc32c(vertices.tobytes(), vertices_checksum)
            cells_checksum = by_page.crc32c(cells.tobytes(), cells_checksum)
            hypervolume += float(determinants(vertices[cells]).sum()) / 24
            count += len(vertices) - (len(slab.lower_layer) if slabs else 0)
            if len(vertices):
                boxes += [vertices.min(axis=0), vertices.max(axis=0)]
            slabs.append(
                {
                    "begin": slab.time_span[0].hex(),
                    "end": slab.time_span[1].hex(),
                    "vertices": str(len(vertices)),
                    "lower": str(len(slab.lower_layer)),
                    "upper": str(len(slab.upper_layer)),
                    "means": str(slab.mean_count),
                    "cells": str(len(cells)),
                    **bounds(vertices),
                    "attributes": [attribute(*each) for each in slab.attributes],
                }
            )
        begin, end = body.time_span
        bodies.append(
            {
                "name": body.names[0],
                "vertices": str(count),
                "cells": str(sum(int(slab["cells"]) for slab in slabs)),
                "begin": begin.hex(),
                "end": end.hex(),
                **bounds(np.array(boxes)[:, :3] if boxes else np.empty((0, 3))),
                "hypervolume": hypervolume.hex(),
                "vertices_checksum": f"{vertices_checksum:08x}",
                "cells_checksum": f"{cells_checksum:08x}",
                "slabs": slabs,
            }
        )
    return {"version": mesh.version, "features": mesh.features, "bodies": bodies}


def slice_at(path, plane):
    mesh = t4d.read(path, max_cells=2**64 - 1)
    bodies = []
    for body in mesh:
        begin, end = body.time_span
        if plane.normal == by_page.TIME and not begin <= plane.offset <= end:
            points, triangles = np.empty((0, 3)), np.empty((0, 3), dtype=np.uint32)
        else:
            points, triangles = body.slice(hyperplane=(*plane.normal, plane.offset))
        # Some of the kit's files are not closed: then volumes depend on the origin.
        a, b, c = (points[triangles[:, i]] for i in range(3))
        bodies.append(
            {
                "name": body.names[0],
                "points": str(len(points)),
                "triangles": str(len(triangles)),
                "volume": float((a * np.cross(b, c)).sum() / 6).hex(),
                "area": float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2).hex(),
                **bounds(points),
            }
        )
    return {"bodies": bodies}


def answer(path, verb, *plane):
    try:
        return 0, slice_at(path, *plane) if verb == "slice" else describe(path)
    except t4d.Error as error:
        return 1, str(error)
    except MemoryError:
        return 1, f"{path}: not enough memory"


if __name__ == "__main__":
    by_page.answer = answer
    sys.exit(by_page.main(sys.argv[1:]))
