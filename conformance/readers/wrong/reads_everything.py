#!/usr/bin/python3 -IS
# caught by: overwrite
"""Reads and checks the whole file before it answers a slice."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/../python")
import t4d_reader

right = t4d_reader.read_slabs_at


def read_slabs_at(file, time):
    t4d_reader.read_all(file, lambda slab: None)
    return right(file, time)


t4d_reader.read_slabs_at = read_slabs_at

sys.exit(t4d_reader.main(sys.argv[1:]))
