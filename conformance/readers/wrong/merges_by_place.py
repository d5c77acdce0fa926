#!/usr/bin/python3 -IS
# caught by: valid
"""Takes points of a slice for one where they are at the same place."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/../python")
import t4d_reader

right = t4d_reader.cut


def cut(slabs, plane, at_last):
    points, triangles = right(slabs, plane, at_last)
    merged = [tuple(points[key] for key in triangle) for triangle in triangles]
    merged = [triangle for triangle in merged if len(set(triangle)) == 3]
    return {point: point for triangle in merged for point in triangle}, merged


t4d_reader.cut = cut

sys.exit(t4d_reader.main(sys.argv[1:]))
