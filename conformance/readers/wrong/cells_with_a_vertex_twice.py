#!/usr/bin/python3 -IS
# caught by: invalid/N5-first-and-third
"""Compares each vertex of a cell with the next alone (N5)."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/..")
from edited import reader_with

reader = reader_with(("a != b and a != c and a != d and b != c and b != d and c != d",
                      "a != b and b != c and c != d and a != d"))

sys.exit(reader.main(sys.argv[1:]))
