#!/usr/bin/python3 -IS
# caught by: valid
"""Makes a point for each edge that ends at a vertex with t = T."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/../python")
import t4d_reader

right = t4d_reader.cut_point


def cut_point(vertices, a, b, time):
    _, point = right(vertices, a, b, time)
    return (min(a, b), max(a, b)), point


t4d_reader.cut_point = cut_point

sys.exit(t4d_reader.main(sys.argv[1:]))
