#!/usr/bin/python3 -IS
# caught by: invalid/S10-of-the-first-block
"""Does not look at the bounds of the first block of cells (S10)."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/..")
from edited import reader_with

reader = reader_with(("not bounds or list(bounds) == expected",
                      "not bounds or list(bounds[8:]) == expected[8:]"))

sys.exit(reader.main(sys.argv[1:]))
