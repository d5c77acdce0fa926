#!/usr/bin/python3 -IS
# caught by: valid
"""Sums up the vertices that are stored: right bounds of means, but not in the checksum."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/../python")
import t4d_reader

right = t4d_reader.contents


def contents(slab):
    vertices, cells = right(slab)
    conn = slab.conn
    return vertices[:32 * conn.first_mean] + vertices[32 * conn.first_upper:], cells


t4d_reader.contents = contents

sys.exit(t4d_reader.main(sys.argv[1:]))
