#!/usr/bin/python3 -IS
# caught by: valid
"""Has other corners first in a cell: the same orientation, hypervolume and slices."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/../python")
import t4d_reader


class Conn(t4d_reader.Conn):
    def __init__(self, chunk, features):
        super().__init__(chunk, features)
        self.cells = [(b, c, a, d) for a, b, c, d in self.cells]


t4d_reader.Conn = Conn

sys.exit(t4d_reader.main(sys.argv[1:]))
