#!/usr/bin/python3 -IS
# caught by: plain
"""Counts the vertices of a layer in both slabs that share it."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/../python")
import t4d_writer

add = t4d_writer.Summary.add


def twice(self, slab, conn, bounds):
    first = self.begin is None
    add(self, slab, conn, bounds)
    if not first:
        self.vertices += conn.lower


t4d_writer.Summary.add = twice

t4d_writer.main(sys.argv[1:])
