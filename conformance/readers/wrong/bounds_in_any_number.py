#!/usr/bin/python3 -IS
# caught by: invalid/S10-one-of-two-blocks
"""Takes any number of bounds, if those that are there are right (S10)."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/..")
from edited import reader_with

reader = reader_with(("not bounds or list(bounds) == expected",
                      "all(x == y for x, y in zip(bounds, expected))"))

sys.exit(reader.main(sys.argv[1:]))
