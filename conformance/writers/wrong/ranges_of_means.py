#!/usr/bin/python3 -IS
# caught by: means
"""Takes a mean for a vertex of the interior that a block of cells needs, not its sources (N2)."""
import sys
from itertools import pairwise

sys.path.insert(0, __file__.rpartition("/")[0] + "/../python")
import t4d_writer


def ranges(self, vertices):
    for first, end in pairwise((0, self.lower, self.first_upper, self.vertices)):
        inside = [i for i in vertices if first <= i < end]
        yield from (min(inside), max(inside) + 1) if inside else (0, 0)


t4d_writer.Connectivity.ranges = ranges

t4d_writer.main(sys.argv[1:])
