#!/usr/bin/python3 -IS
# caught by: plain
"""Stores a layer again for the slab after it."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/../python")
import t4d_writer

part = t4d_writer.Writer.part


def always(self, name, number, payload):
    return part(self, name, (number, len(self.rows)) if name == b"LAYR" else number, payload)


t4d_writer.Writer.part = always

t4d_writer.main(sys.argv[1:])
