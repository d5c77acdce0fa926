#!/usr/bin/python3 -IS
# caught by: valid
"""Turns every cell and every triangle inside out."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/../python")
import t4d_reader

right_cut = t4d_reader.cut
right_determinant = t4d_reader.determinant4


def cut(slab, time, at_last):
    points, triangles = right_cut(slab, time, at_last)
    return points, [(p, r, q) for p, q, r in triangles]


t4d_reader.cut = cut
t4d_reader.determinant4 = lambda a, b, c, d: -right_determinant(a, b, c, d)

sys.exit(t4d_reader.main(sys.argv[1:]))
