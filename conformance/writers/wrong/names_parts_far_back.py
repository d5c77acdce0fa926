#!/usr/bin/python3 -IS
# caught by: plain
"""Stores each part once, however far back it is where a slab names it again (S12)."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/../python")
import t4d_writer


def once(self, name, number, payload):
    if (name, number) not in self.offsets:
        self.offsets[name, number] = self.out.chunk(name, payload())
    return self.offsets[name, number]


t4d_writer.Writer.part = once

t4d_writer.main(sys.argv[1:])
