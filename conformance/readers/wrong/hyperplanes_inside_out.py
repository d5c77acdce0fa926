#!/usr/bin/python3 -IS
# caught by: valid
"""Turns no triangle round, not for x and z either: these slices are inside out."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/../python")
import t4d_reader

right = t4d_reader.Hyperplane


def hyperplane(normal, offset):
    plane = right(normal, offset)
    plane.is_reversed = False
    return plane


t4d_reader.Hyperplane = hyperplane

sys.exit(t4d_reader.main(sys.argv[1:]))
