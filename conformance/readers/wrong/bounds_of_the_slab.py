#!/usr/bin/python3 -IS
# caught by: valid/blocks-with-layers-and-means
"""Takes the bounds of all cells for those of each block (S10)."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/..")
from edited import reader_with

reader = reader_with(("box([self.vertices[i] for i in block])",
                      "box(self.vertices)"))

sys.exit(reader.main(sys.argv[1:]))
