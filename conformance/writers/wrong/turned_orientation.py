#!/usr/bin/python3 -IS
# caught by: plain
"""Swaps two vertices of every cell."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/../python")
import t4d_writer

init = t4d_writer.Connectivity.__init__


def turned(self, mesh):
    init(self, mesh | {"cells": [[b, a, c, d] for a, b, c, d in mesh["cells"]]})


t4d_writer.Connectivity.__init__ = turned

t4d_writer.main(sys.argv[1:])
