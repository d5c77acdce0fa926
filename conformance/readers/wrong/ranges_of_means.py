#!/usr/bin/python3 -IS
# caught by: valid/blocks-with-layers-and-means
"""Takes a mean for a vertex of the interior that a block of cells needs, not its sources (N2)."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/..")
from edited import reader_with

reader = reader_with(("means = [i for i in vertices if self.first_mean <= i < self.first_upper]",
                      "means = []"))

sys.exit(reader.main(sys.argv[1:]))
