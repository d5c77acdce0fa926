#!/usr/bin/python3 -IS
# caught by: valid
"""Turns every cell and every triangle inside out."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/../python")
import t4d_reader

right_cut = t4d_reader.cut
right_describe_slab = t4d_reader.describe_slab


def cut(slabs, plane, at_last):
    points, triangles = right_cut(slabs, plane, at_last)
    return points, [(p, r, q) for p, q, r in triangles]


def describe_slab(slab):
    hypervolume, description = right_describe_slab(slab)
    return -hypervolume, description


t4d_reader.cut = cut
t4d_reader.describe_slab = describe_slab

sys.exit(t4d_reader.main(sys.argv[1:]))
