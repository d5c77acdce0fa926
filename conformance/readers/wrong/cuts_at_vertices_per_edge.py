#!/usr/bin/python3 -IS
# caught by: valid
"""Makes a point for each edge that ends at a vertex on the hyperplane."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/../python")
import t4d_reader

right = t4d_reader.cut_point


def cut_point(p, q, offset):
    _, point = right(p, q, offset)
    return (min(p[0], q[0]), max(p[0], q[0])), point


t4d_reader.cut_point = cut_point

sys.exit(t4d_reader.main(sys.argv[1:]))
