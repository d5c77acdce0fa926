#!/usr/bin/python3 -IS
# caught by: valid/blocks-with-layers-and-means
"""Takes the bounds of the sources of means for those of a block of cells (S10)."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/..")
from edited import reader_with

def needed_by(conn, block):
    means = range(conn.first_mean, conn.first_upper)
    return set().union(*(conn.sources[i - conn.first_mean] if i in means else (i,) for i in block))


reader = reader_with(("box([self.vertices[i] for i in block])",
                      "box([self.vertices[i] for i in needed_by(conn, block)])"))
reader.needed_by = needed_by

sys.exit(reader.main(sys.argv[1:]))
