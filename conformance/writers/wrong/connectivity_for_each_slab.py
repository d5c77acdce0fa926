#!/usr/bin/python3 -IS
# caught by: plain
"""Stores the cells again for every slab."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/../python")
import t4d_writer

part = t4d_writer.Writer.part


def always(self, name, number, payload):
    return part(self, name, (number, len(self.rows)) if name == b"CONN" else number, payload)


t4d_writer.Writer.part = always

t4d_writer.main(sys.argv[1:])
