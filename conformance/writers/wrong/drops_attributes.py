#!/usr/bin/python3 -IS
# caught by: attributes
"""Leaves attributes of vertices out."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/../python")
import t4d_writer

init = t4d_writer.Writer.__init__


def without(self, mesh, stream):
    for layer in mesh["layers"]:
        layer["attributes"] = []
    for body in mesh["bodies"]:
        for slab in body["slabs"]:
            slab["interior_attributes"] = []
    init(self, mesh, stream)


t4d_writer.Writer.__init__ = without

t4d_writer.main(sys.argv[1:])
